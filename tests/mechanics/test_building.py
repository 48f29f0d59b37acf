"""Modes of a building in shear, against finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh

from rockdamp import Building, Diaphragm, InputError, InputWarning
from rockdamp.mechanics.building import RIGID_PERIOD


def finite_elements(count):
    """Frequencies and contributions at the nodes of linear elements, for GA = m' = H = 1."""
    elements = 400
    diagonal, beside = np.eye(elements), np.eye(elements, k=1) + np.eye(elements, k=-1)
    stiffness, inertia = elements * (2 * diagonal - beside), (4 * diagonal + beside) / (6 * elements)
    stiffness[-1, -1], inertia[-1, -1] = elements, 2 / (6 * elements)  # the free end
    square, vectors = eigh(stiffness, inertia)
    moved = inertia @ np.ones(elements)
    moved[0] += 1 / (6 * elements)  # of the node at the base
    return np.sqrt(square[:count]), (vectors * (vectors.T @ moved))[:, :count]


@pytest.mark.parametrize("storey", [1, 2, 4])
def test_periods_and_contributions_are_those_of_finite_elements(storey):
    frequency, contribution = finite_elements(4)
    modes = Building(period=1.0, storeys=4, storey=storey).modes
    assert 1 / modes.period == pytest.approx(frequency / frequency[0], rel=1e-4)
    below, above = contribution[[100 * storey - 101, 100 * storey - 1]]
    assert modes.contribution[1] == pytest.approx(above, abs=1e-4)
    assert modes.contribution[0] == pytest.approx(below if storey > 1 else np.zeros(4), abs=1e-4)


def test_over_many_modes_the_contributions_sum_to_the_motion_of_the_ground():
    modes = Building(period=2.0, storeys=60, storey=30).modes
    assert modes.contribution.sum(axis=1) == pytest.approx(np.ones(2), abs=0.02)


def test_modes_that_are_as_stiff_as_the_ground_are_left_out():
    modes = Building(period=0.25, storeys=6, storey=6).modes
    assert modes.period.size == 4 and modes.period[-1] >= RIGID_PERIOD
    with pytest.warns(InputWarning):
        rigid = Building(period=0.5 * RIGID_PERIOD, storeys=2, storey=1)
    assert rigid.modes.period.size == 0 and rigid.modes.contribution.shape == (2, 0)
    assert Building(period=0.25, storeys=3, storey=1).modes.contribution[0] == pytest.approx(np.zeros(3), abs=1e-15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"storey": 4}, "storey is 4; it must be at most 3, the storeys of the building"),
        ({"storey": 0}, "storey is 0; it must be a whole number, at least 1"),
        ({"damping_ratio": 5.0}, "was it in per cent \\(0.05\\)"),
        ({"period": 0.0}, "period of the building is 0.0; it must be greater than 0"),
    ],
)
def test_buildings_that_cannot_be_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        Building(**({"period": 0.25, "storeys": 3, "storey": 3} | change))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"period": 3.0}, "was it a frequency in Hz \\(0.333 s\\)"),
        ({"period": 250.0}, "was it in milliseconds \\(0.25 s\\)"),
        ({"damping_ratio": 0.5}, "usual is 0.005 to 0.2; was it in per cent"),
        ({"damping_ratio": 0.0005}, "usual is 0.005 to 0.2; was it 0.05"),
    ],
)
def test_unlikely_buildings_are_questioned(change, words):
    with pytest.warns(InputWarning, match=words):
        Building(**({"period": 0.25, "storeys": 3, "storey": 3} | change))


def test_unlikely_floors_are_questioned_as_buildings_are():
    with pytest.warns(InputWarning, match=r"diaphragm period is 400 s; .*was it in milliseconds \(0.4 s\)"):
        Diaphragm(400)
    with pytest.warns(InputWarning, match="diaphragm damping is 0.4; .*were period and damping swapped"):
        Diaphragm(0.05, 0.4)
