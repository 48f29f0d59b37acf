"""What a program asks for in the place of a damping ratio."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.equivalence.programs import dashpot


def test_a_dashpot_damps_the_first_branch_by_its_ratio_and_none_stands_for_a_coefficient_that_changes():
    """C is twice the ratio times the root of stiffness and mass, both in physical units."""
    wall, curve = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=2.0), rd.TrilinearCurve(0.04, 0.85)
    stiffness = curve.strength_ratio * wall.rigid_strength / (0.04 * wall.instability_displacement)
    expected = 2 * 0.03 * np.sqrt(stiffness * wall.effective_mass)
    assert dashpot(wall, curve, "CDC", 0.03) == pytest.approx(float(expected))
    assert dashpot(wall, curve, "CDR", 0.03) is None
