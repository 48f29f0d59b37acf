"""What each damper predicts for a block: the power law of its exponent, impacts of a rigid body, event by event."""

import numpy as np
import pytest

from rockdamp.laboratory.trials import NearlyRigid, by_solver, dampings, losses_by_impact
from rockdamp.laboratory.velocity_ratios import power_law
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history

LOSS = np.array([0.01, 0.03, 0.08])
BLOCK = NearlyRigid(0.01, 0.5)


@pytest.mark.parametrize("model", ["CR", "ECD", "BAND"])
def test_what_loses_the_same_at_any_amplitude_predicts_one_ratio(model):
    ratio = by_solver(BLOCK, model, 8)(LOSS).ratio
    np.testing.assert_allclose(np.log(ratio), -np.broadcast_to(LOSS, (8, 3)), atol=3e-4)


@pytest.mark.parametrize(("model", "exponent"), [("CDC", 0.5), ("CDR", 0.0), ("SDR", -0.5)])
def test_the_paper_s_dampers_follow_their_power_law_to_first_order_in_the_loss(model, exponent):
    """On a rigid block from a small release, where the force hardly changes."""
    block, loss = NearlyRigid(0.002, 0.1), np.array([0.002, 0.004])
    found, law = by_solver(block, model, 6)(loss), power_law(loss, exponent, 6)
    np.testing.assert_allclose(np.log(found.ratio) / np.log(law.ratio), 1.0, atol=0.05)
    np.testing.assert_allclose(found.log_energy, law.log_energy, rtol=0.05)


@pytest.mark.parametrize("model", ["CR", "CDR", "SDR"])
def test_the_losses_are_those_of_the_event_driven_solver(model):
    several = dampings(BLOCK, model)
    damping = several.map(lambda values: values[25:26])
    found = losses_by_impact(BLOCK, damping, 5)[0]
    one = damping.map(lambda values: values[0])
    exact = exact_history(BLOCK.curve, one, [20.0], release_amplitude=0.5)
    peaks = np.abs(np.concatenate([[0.5], exact.turning_displacement[:5]]))
    np.testing.assert_allclose(found, -0.5 * np.diff(np.log(BLOCK.curve.energy(peaks))), atol=3e-4)


def test_a_decay_that_ends_has_lost_all():
    heavy = Damping("SDR", np.array([3.0]))
    assert losses_by_impact(BLOCK, heavy, 4)[0, -1] == 3.0
