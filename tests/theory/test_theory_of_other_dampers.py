"""docs/theory.md, sections 4 and 7: what others had, and what dampers that are exact in free decay do under a load."""

import numpy as np
import pytest
import sympy as sp

from rockdamp.constants import RECOMMENDED
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history

CURVE = TrilinearCurve(0.04, 0.85)


def test_ecd_meets_chiellini_s_condition_on_any_curve():
    """d/dx (f/C) = k C, with f = V' of any potential V; and no other power of V does."""
    x, xi = sp.symbols("x xi", positive=True)
    potential = sp.Function("V", positive=True)(x)
    force = sp.diff(potential, x)

    def k(power):
        coefficient = 2 * xi * force / (2 * potential) ** power
        return sp.simplify(sp.diff(force / coefficient, x) / coefficient)

    half = sp.Rational(1, 2)
    assert sp.simplify(k(half) - 1 / (4 * xi**2)) == 0  # a residual of zero, whatever V
    assert all(sp.simplify(sp.diff(k(half + change), x)) != 0 for change in (-half / 3, half / 4))


def test_the_first_peaks_of_three_dampers_under_a_half_sine():
    """p = 2 sin(pi tau/0.7) up to tau = 0.7, on the paper's curve at e = 0.85."""
    step = 0.7 / 256
    load = 2 * np.sin(np.pi * np.linspace(0, 1, 257))
    for model, peak in zip(("CR", RECOMMENDED, "ECD"), (0.400, 0.397, 0.331), strict=True):
        damping = Damping.from_restitution(0.85, model)
        run = exact_history(CURVE, damping, [2.0], load=load, sampling=step)
        assert run.turning_displacement[0] == pytest.approx(peak, abs=6e-4)
