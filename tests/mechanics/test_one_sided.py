"""Walls that rock to one side: their restitution, and what they are made of."""

import pytest

import rockdamp as rd


def test_restitution_of_a_facade_is_sorrentinos():
    # 0.478 at h/t = 8 by hand: sin^2 = 1/65.
    facade = rd.OneSidedWall(rd.Parapet(thickness=0.5, height=4.0))
    assert facade.restitution_measured == pytest.approx(1.05 * (1 - 1.5 / 65) ** 2 * (1.5 * 64 / 65 - 1))
    assert facade.restitution_measured == pytest.approx(0.478, abs=5e-4)


def test_it_is_made_of_a_wall_or_a_parapet():
    with pytest.raises(rd.InputError, match="mechanism"):
        rd.OneSidedWall(rd.TrilinearCurve.preset("new"))
