"""Modes of a building in shear, against finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh

from rockdamp import Building, Diaphragm, InputError

ELEMENTS = 400


def finite_elements(count):
    """Return frequencies and contributions at the nodes of linear elements, for GA = m' = H = 1."""
    diagonal = np.eye(ELEMENTS)
    neighbour = np.eye(ELEMENTS, k=1) + np.eye(ELEMENTS, k=-1)
    stiffness = ELEMENTS * (2 * diagonal - neighbour)
    inertia = (4 * diagonal + neighbour) / (6 * ELEMENTS)
    # The free end.
    stiffness[-1, -1] = ELEMENTS
    inertia[-1, -1] = 2 / (6 * ELEMENTS)
    squares, vectors = eigh(stiffness, inertia)
    pushed = inertia @ np.ones(ELEMENTS)
    pushed[0] += 1 / (6 * ELEMENTS)  # by the node at the base
    contribution = vectors * (vectors.T @ pushed)
    return np.sqrt(squares[:count]), contribution[:, :count]


@pytest.mark.parametrize("storey", [1, 2, 4])
def test_modes_against_finite_elements(storey):
    frequency, contribution = finite_elements(4)
    modes = Building(period=1.0, storeys=4, storey=storey).modes
    assert 1 / modes.period == pytest.approx(frequency / frequency[0], rel=1e-4)
    floor = ELEMENTS // 4 * storey - 1
    assert modes.contribution[1] == pytest.approx(contribution[floor], abs=1e-4)
    if storey == 1:
        lower_floor = np.zeros(4)
    else:
        lower_floor = contribution[floor - ELEMENTS // 4]
    assert modes.contribution[0] == pytest.approx(lower_floor, abs=1e-4)


def test_contributions_of_many_modes_sum_to_one():
    modes = Building(period=2.0, storeys=60, storey=30).modes
    assert modes.contribution.sum(axis=1) == pytest.approx(np.ones(2), abs=0.02)


def test_modes_above_33_hz_are_left_out():
    modes = Building(period=0.25, storeys=6, storey=6).modes
    assert modes.period.size == 4
    assert modes.period[-1] >= 0.03


def test_rigid_building_has_no_modes():
    modes = Building(period=0.015, storeys=2, storey=1).modes
    assert modes.period.size == 0
    assert modes.contribution.shape == (2, 0)


def test_default_damping_ratio_is_five_per_cent():
    assert Building(0.25, 3, 3).damping_ratio == Diaphragm(0.4).damping_ratio == 0.05


BAD_BUILDINGS = [
    ("storey", 4),
    ("storey", 0),
    ("storeys", 3.5),
    ("storeys", 101),
    ("damping_ratio", 0.0),
    ("damping_ratio", 1.0),
    ("period", 0.0),
    ("period", 21.0),
]


@pytest.mark.parametrize(("name", "value"), BAD_BUILDINGS)
def test_bad_building_is_refused(name, value):
    arguments = {"period": 0.25, "storeys": 3, "storey": 3}
    with pytest.raises(InputError, match=name):
        Building(**(arguments | {name: value}))


def test_bad_diaphragm_is_refused():
    with pytest.raises(InputError, match="period of the diaphragm"):
        Diaphragm(-0.4)
