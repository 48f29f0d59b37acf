"""Specimens of numbers as one of arrays, and single cases of it again."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.mechanics.specimen import Specimen

CURVE = rd.TrilinearCurve(0.04, 0.85, 0.9, "translated")
CR = rd.Damping("CR", 0.85)
SPECIMENS = {
    "wall": [
        Specimen(rd.Wall(0.3, 4.5, overburden_ratio=1.0), CURVE, rd.Damping("ECD", 0.05, order=2)),
        Specimen(rd.Wall(0.2, 3.0), CURVE, rd.Damping("ECD", 0.08, order=2)),
    ],
    "parapet": [Specimen(rd.Parapet(0.3, height), CURVE, CR) for height in (1.2, 1.5)],
    "one-sided wall": [
        Specimen(rd.OneSidedWall(rd.Parapet(0.8, height)), CURVE, CR) for height in (9.0, 12.0)
    ],
}


def numbers(specimen):
    """Return the parameters of a specimen in one flat list."""
    wall = getattr(specimen.wall, "mechanism", specimen.wall)
    parts = (wall, specimen.curve, specimen.damping)
    return [value for part in parts for value in vars(part).values()]


@pytest.mark.parametrize("kind", SPECIMENS)
def test_each_case_of_a_stack_is_its_specimen(kind):
    specimens = SPECIMENS[kind]
    stacked = Specimen.stack(specimens)
    assert stacked.shape == (2,)
    for index, specimen in enumerate(specimens):
        assert numbers(stacked.take(index)) == numbers(specimen)


def test_cases_are_taken_in_the_order_of_the_index():
    taken = Specimen.stack(SPECIMENS["wall"]).take(np.array([1, 0, 1]))
    assert taken.wall.thickness.tolist() == [0.2, 0.3, 0.2]
    assert taken.damping.value.tolist() == [0.08, 0.05, 0.08]


def test_a_number_stays_a_number():
    specimens = Specimen(rd.Wall([0.2, 0.3], 3.0), CURVE, CR)
    taken = specimens.take(np.array([1, 1, 0]))
    assert taken.wall.thickness.tolist() == [0.3, 0.3, 0.2]
    assert taken.wall.height.shape == taken.damping.shape == taken.curve.shape == ()


def test_an_array_of_one_case_is_that_of_all():
    specimens = Specimen(rd.Wall([0.2, 0.3], 3.0), CURVE, rd.Damping("CR", [0.85]))
    assert specimens.take(np.array([1])).damping.value.tolist() == [0.85]


@pytest.mark.parametrize(
    "other",
    [
        Specimen(rd.Parapet(0.3, 1.2), CURVE, CR),
        Specimen(rd.Wall(0.3, 4.5), rd.TrilinearCurve(0.04, 0.85), CR),
        Specimen(rd.Wall(0.3, 4.5), CURVE, rd.Damping("CDR", 0.05)),
        Specimen(rd.Wall(0.3, 4.5), CURVE, rd.Damping("ECD", 0.05)),
    ],
    ids=["wall", "softening", "damping model", "order"],
)
def test_specimens_of_two_kinds_are_not_stacked(other):
    damping = rd.Damping("ECD", 0.05, order=2) if other.damping.model == "ECD" else CR
    with pytest.raises(ValueError, match="2 kinds"):
        Specimen.stack([Specimen(rd.Wall(0.3, 4.5), CURVE, damping), other])
