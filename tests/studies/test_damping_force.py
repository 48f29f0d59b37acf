"""The loops of the dampers, and rocking beside the tri-linear wall."""

import numpy as np

from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.studies import damping_force


def test_loops_hold_the_force_of_each_damper(config):
    found = damping_force.damping_force(config)
    curve = config.curve.make()
    xi = float(found["damping_ratio"].sel(damping_model="SDR"))
    one = found.sel(damping_model="SDR")
    secant = curve.secant(one["displacement"].values)
    expected = 2 * xi * secant / curve.initial_frequency * one["velocity"].values
    np.testing.assert_allclose(one["damping_force"], expected, rtol=1e-9, atol=1e-12)
    assert (found["damping_force"].sel(damping_model="CR") == 0).all()
    law = found["damping_ratio_law"]
    assert (law.sel(viscous_model="CDR")[1:] == 1).all()
    np.testing.assert_allclose(law.sel(viscous_model="SDR"), found["frequency_ratio"])
    np.testing.assert_allclose(law.sel(viscous_model="CDC")[1:], 1 / found["frequency_ratio"][1:])


def test_the_nearly_rigid_history_is_that_of_the_event_driven_solver(paper):
    """At the paper's step, as closely as docs/accuracy.md states."""
    found = damping_force.damping_force(paper)["rocking_displacement"].sel(rocking_model="tri-linear")
    rigid = paper.damping_force.rigid
    exact = exact_history(
        rigid.curve,
        Damping("CR", rigid.restitution),
        found["tau"].values,
        release_amplitude=rigid.release_amplitude,
    )
    assert float(np.abs(found.values - exact.displacement).max()) < 1.5e-5


def test_the_stiff_tri_linear_wall_rocks_like_a_rigid_one(config):
    """Fig. 4a: the first half cycle of the nearly rigid curve against the slender limit, within its own 1 %."""
    found = damping_force.damping_force(config)["rocking_displacement"].sel(tau=slice(0, 2.5))
    assert float(np.abs(found[0] - found[1]).max()) < 0.02
