"""Modes of a building in shear, against finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh

from rockdamp import Building, Diaphragm, InputError


def finite_elements(count):
    """Frequencies and contributions at the nodes of linear elements, for GA = m' = H = 1."""
    elements = 400
    diagonal, beside = np.eye(elements), np.eye(elements, k=1) + np.eye(elements, k=-1)
    stiffness, inertia = (
        elements * (2 * diagonal - beside),
        (4 * diagonal + beside) / (6 * elements),
    )
    stiffness[-1, -1], inertia[-1, -1] = elements, 2 / (6 * elements)  # the free end
    square, vectors = eigh(stiffness, inertia)
    moved = inertia @ np.ones(elements)
    moved[0] += 1 / (6 * elements)  # of the node at the base
    return np.sqrt(square[:count]), (vectors * (vectors.T @ moved))[:, :count]


def test_periods_and_contributions_are_those_of_finite_elements():
    frequency, contribution = finite_elements(4)
    for storey in (1, 2, 4):
        modes = Building(period=1.0, storeys=4, storey=storey).modes
        assert 1 / modes.period == pytest.approx(frequency / frequency[0], rel=1e-4)
        below, above = contribution[[100 * storey - 101, 100 * storey - 1]]
        assert modes.contribution[1] == pytest.approx(above, abs=1e-4)
        assert modes.contribution[0] == pytest.approx(
            below if storey > 1 else np.zeros(4), abs=1e-4
        )


def test_over_many_modes_the_contributions_sum_to_the_motion_of_the_ground():
    modes = Building(period=2.0, storeys=60, storey=30).modes
    assert modes.contribution.sum(axis=1) == pytest.approx(np.ones(2), abs=0.02)


def test_modes_that_are_as_stiff_as_the_ground_are_left_out():
    modes = Building(period=0.25, storeys=6, storey=6).modes
    assert modes.period.size == 4 and modes.period[-1] >= 0.03
    rigid = Building(period=0.015, storeys=2, storey=1)
    assert rigid.modes.period.size == 0 and rigid.modes.contribution.shape == (2, 0)


@pytest.mark.parametrize(
    "change",
    [
        {"storey": 4},
        {"storey": 0},
        {"storeys": 3.5},
        {"damping_ratio": 5.0},
        {"period": 0.0},
        {"period": 21.0},
    ],
)
def test_buildings_and_floors_that_cannot_be_are_refused(change):
    (name,) = change
    with pytest.raises(InputError, match=name):
        Building(**({"period": 0.25, "storeys": 3, "storey": 3} | change))
    with pytest.raises(InputError, match="period of the diaphragm"):
        Diaphragm(-0.4)
