"""Blows on a wall: a ground motion so short that it gives a velocity and nothing else, whose response is known.

A blow of peak ground velocity PGV gives a wall at rest the velocity lambda PGV/(p u_ins) = s, the study's scale, and
until the first impact no damper of impacts takes energy: V(peak) = s^2/2.
"""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.config import GeometricGrid
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.record import Record
from rockdamp.studies import earthquakes, event_driven_check

STEP = 0.001  # s, of the record: a thousandth of the walls' periods and less
SIZE = 50.0  # m s-2
PGV = SIZE * STEP
SCALES = GeometricGrid(start=0.3, stop=0.6, count=2)
SCALE = SCALES.values()
E = 0.85


@pytest.fixture(scope="module")
def config():
    full = configured({"earthquakes": {"tail": 1.0}})
    church = [named for named in full.earthquakes.walls if named.name == "church"]
    of_blows = {"walls": church, "restitution": [E], "velocity_ratio": SCALES}
    return changed(full, {f"earthquakes.{name}": value for name, value in of_blows.items()})


@pytest.fixture(scope="module")
def named(config):
    return config.earthquakes.walls[0]


def blows(*at, size=SIZE):
    """A triangle of one sample at each of some samples; those at negative places to the other side."""
    acceleration = np.zeros(max(map(abs, at)) + 2)
    acceleration[np.abs(at)] = size * np.sign(at)
    return Record(STEP * np.arange(acceleration.size), acceleration)


@pytest.fixture(scope="module")
def motion():
    return GroundMotion("blow", "blow", "own", blows(2))


@pytest.fixture(scope="module")
def study(config, motion):
    """What one record gives; every damper at the damping ratio of 5 %."""
    ratio = np.full((1, 1, len(earthquakes.MODELS), len(earthquakes.SOURCES)), 0.05)
    ratio[:, :, 0] = np.nan
    ended = earthquakes.run(config, np.array([E]), ratio, motion)
    return ended.squeeze(["record", "wall", "restitution"])


def energy(curve, peak):
    """V over that of the velocity s."""
    return np.asarray(curve.energy(peak)) / (SCALE**2 / 2)


# --- the study of walls and records ----------------------------------------------------------------------------------


def test_a_blow_of_some_scale_gives_that_velocity_and_the_peak_comes_in_the_rest_after_it(study, named):
    cr = study["peak"].sel(damping_model="CR").isel(damping_ratio_source=0)
    np.testing.assert_allclose(energy(named.curve, cr.values), 1.0, rtol=0.01)
    assert (study["peak"].sel(damping_model=list(earthquakes.VISCOUS_MODELS)) < cr).all()


def test_a_lower_e_leaves_less_after_an_impact_and_a_higher_one_more(named):
    """A second blow, in the direction of the motion after the first impact, makes the largest peak."""
    p, curve = float(named.wall.frequency_parameter), named.curve
    velocity = 0.5
    first = float(np.interp(velocity**2 / 2, curve.energy(x := np.linspace(0, 1, 1001)), x))
    there_and_back = int(0.5 * float(curve.period(first)) / p / STEP)
    record = blows(2, -(there_and_back + 100))  # u'' = ... + a: the second blow is to where the wall is going
    factor = np.array([velocity * p * float(named.wall.instability_displacement) / (1.5 * PGV)])
    case = earthquakes.WallUnderRecord.from_record(named.wall, curve, record, factor, step=0.05, tail=1.0)
    e = np.array([E])
    varied = dict(zip(earthquakes.VARIATIONS, case.run_variations(e, 0.05)["varied_peak"][0, 0], strict=True))
    peak = case(Damping("CR", e), earthquakes.HALVINGS).peak.item()
    assert peak > 1.1 * first
    assert varied["lower e"] < 0.99 * peak < 1.01 * peak < varied["higher e"]


@pytest.mark.parametrize("record_step", [0.0049, 0.005, 0.0101, 0.02])
def test_no_step_is_longer_than_the_one_asked_for_and_none_is_needlessly_short(named, record_step):
    record = Record(record_step * np.arange(5), np.array([0.0, 1.0, 0.0, 0.0, 0.0]))
    for longest in (0.025, 0.013):
        lengths = {"step": longest, "tail": 0.0}
        case = earthquakes.WallUnderRecord.from_record(named.wall, named.curve, record, np.ones(1), **lengths)
        frequency = float(named.wall.frequency_parameter * named.curve.initial_frequency)
        coarsest = frequency * record_step / case.load.substeps
        finest = coarsest / 2**earthquakes.HALVINGS
        assert finest <= longest * (1 + 1e-12)
        one_less = frequency * record_step / max(case.load.substeps - 1, 1) / 2**earthquakes.HALVINGS
        assert case.load.substeps == 1 or one_less > longest


# --- the check, event by event ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["CR", "CDR"])
def test_the_check_s_peak_is_the_last_turn_where_the_history_ends_after_it(named, motion, model):
    """The first peak is the only turn: the rest ends before the wall is back at zero."""
    p = float(named.wall.frequency_parameter)
    of_scale = SCALE[1] * p * float(named.wall.instability_displacement) / (1.5 * PGV)
    case = xr.Dataset({"damping_model": model, "restitution": E, "damping_ratio": 1e-6, "scale_factor": of_scale})
    first = float(np.interp(SCALE[1] ** 2 / 2, named.curve.energy(x := np.linspace(0, 1, 1001)), x))
    quarter = float(named.curve.period(first)) / 4 / p
    peak, collapsed = event_driven_check.solve_exactly(case, motion, named, tail=1.9 * quarter)
    assert not collapsed
    assert energy(named.curve, peak)[1] == pytest.approx(1.0, rel=0.01)
