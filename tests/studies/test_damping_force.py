"""Loops of damping forces, their laws by the frequency, and rocking like a rigid wall."""

import numpy as np
import pytest

from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.damping_force import damping_force


@pytest.fixture(scope="module")
def forces(config):
    return damping_force(config)


def test_loop_has_the_force_of_its_damper(forces, config):
    curve = config.curve.make()
    sdr = forces.sel(damping_model="SDR")
    xi = float(sdr["damping_ratio"])
    x = sdr["displacement"].values
    coefficient = 2 * xi * curve.force(x) / x / curve.initial_frequency
    expected = coefficient * sdr["velocity"].values
    np.testing.assert_allclose(sdr["damping_force"], expected, rtol=1e-9, atol=1e-12)


def test_restitution_has_no_damping_force(forces):
    assert (forces["damping_force"].sel(damping_model="CR") == 0).all()


def test_laws_by_the_frequency_are_those_of_fig_3(forces):
    law = forces["damping_ratio_law"]
    w = forces["frequency_ratio"]
    assert (law.sel(viscous_model="CDR")[1:] == 1).all()
    np.testing.assert_allclose(law.sel(viscous_model="SDR"), w)
    np.testing.assert_allclose(law.sel(viscous_model="CDC")[1:], 1 / w[1:])


def test_energy_frequency_has_no_law(forces):
    assert forces["damping_ratio_law"].sel(viscous_model="ECD").isnull().all()


def test_stiff_wall_rocks_like_a_rigid_one(forces):
    """Fig. 4a: the first half cycle against the slender limit, within its 1 % of a1."""
    rocking = forces["rocking_displacement"].sel(tau=slice(0, 2.5))
    stiff = rocking.sel(rocking_model="tri-linear")
    slender = rocking.sel(rocking_model="slender")
    assert float(np.abs(stiff - slender).max()) < 0.02


def test_nearly_rigid_history_is_the_exact_one(paper):
    """The error at the paper's step is 1e-5."""
    rocking = damping_force(paper)["rocking_displacement"].sel(rocking_model="tri-linear")
    rigid = paper.damping_force.rigid
    exact = exact_history(
        rigid.curve,
        Damping("CR", rigid.restitution),
        rocking["tau"].values,
        release_amplitude=rigid.release_amplitude,
    )
    error = float(np.abs(rocking.values - exact.displacement).max())
    assert error == pytest.approx(1e-5, rel=0.5)
