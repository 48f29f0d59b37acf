"""The answer for one wall with one input changed at a time."""

import pytest

import rockdamp as rd
from rockdamp.assessment.sensitivity import sensitivity

WALL = rd.Wall(0.25, 3.0, overburden_ratio=0.5)
CURVE = rd.TrilinearCurve.preset("new")


@pytest.fixture(scope="module")
def table(wall, curve, answer, motions):
    rows = sensitivity(wall, curve, answer, motions)
    return {(row["input"], round(row["value"], 6)): row for row in rows}


def test_each_input_is_changed_either_way(table):
    assert len(table) == 8


@pytest.mark.parametrize(
    ("label", "value", "body", "shape", "e"),
    [
        ("restitution e", 0.8, WALL, CURVE, 0.8),
        (
            "hinge h₁/h",
            0.6,
            rd.Wall(0.25, 3.0, overburden_ratio=0.5, hinge_ratio=0.6),
            CURVE,
            0.85,
        ),
        ("a₁", 0.12, WALL, rd.TrilinearCurve(0.12, 0.72), 0.85),
        ("overburden O/W", 1.0, rd.Wall(0.25, 3.0, overburden_ratio=1.0), CURVE, 0.85),
    ],
    ids=["e", "hinge", "a1", "overburden"],
)
def test_a_row_is_the_answer_of_the_changed_wall(label, value, body, shape, e, table, motions):
    answer = rd.assess(body, shape, motions, pgv=0.8, restitution=e).sel(damping_model="CR")
    row = table[label, value]
    assert row["collapse_probability"] == answer["collapse_probability"].item()
    assert row["median"] == pytest.approx(answer["median_pgv"].item(), rel=1e-8)


def test_an_e_that_is_raised_ends_at_1(wall, curve, motions, answer):
    rows = sensitivity(wall, curve, answer.assign(restitution=0.98), motions[:4])
    (row,) = (row for row in rows if row["input"] == "restitution e" and row["value"] > 1)
    exact = rd.assess(wall, curve, motions[:4], pgv=0.8, restitution=1.0).sel(damping_model="CR")
    assert row["collapse_probability"] == exact["collapse_probability"].item()
