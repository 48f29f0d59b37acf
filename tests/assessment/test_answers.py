"""Damping ratios of a table of walls."""

import pytest

import rockdamp as rd
from rockdamp.assessment.answers import ratios
from rockdamp.assessment.table import read_walls

TABLE = """id,thickness,height,a1,b1,a3,softening,preset,restitution
north,0.25,3.0,0.06,0.7,0.95,translated,,0.9
bad,0.25,3.0,,,,,,0.85
south,0.25,3.0,,,,,moderate,0.9
low,0.25,3.0,0.04,0.85,0.4,,,0.9
late,0.25,3.0,0.04,0.012,,,,0.9
steep,0.25,3.0,0.06,0.7,0.95,steeper,,0.9
stiff,0.25,3.0,0.004,0.8,,,,0.9
"""
X0 = 0.5


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("walls") / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    by_wall = {}
    for row in ratios(read_walls(path), X0):
        by_wall.setdefault(row["id"], []).append(row)
    return by_wall


@pytest.mark.parametrize(
    "name, curve",
    [
        ("north", (0.06, 0.7, 0.95, "translated")),
        ("south", (0.13, 0.60)),
        ("steep", (0.06, 0.7, 0.95)),
        ("stiff", (0.004, 0.8)),
    ],
)
def test_each_wall_has_the_ratios_that_equivalent_finds_for_it_alone(found, name, curve):
    """Of every damper, ECD among them: the same search, to the last bit on one machine."""
    alone = rd.equivalent(0.9, rd.TrilinearCurve(*curve), release_amplitude=X0)
    assert [(row["damping_model"], row["damping_ratio"], row["error"]) for row in found[name]] == [
        (row["damping_model"], row["damping_ratio"], "") for row in alone
    ]
    assert [row["restitution"] for row in found[name]] == [0.9] * len(alone)


def test_the_ratio_has_the_least_error_and_not_the_peaks(found):
    told = {row["damping_model"]: row["damping_ratio"] for row in found["south"]}
    exact = float(rd.Damping.from_restitution(0.9, "ECD").value)
    assert 1.001 < told["ECD"] / exact < 1.05


def test_walls_keep_their_order_and_a_row_without_a_wall_has_its_error_once(found):
    assert list(found) == ["north", "bad", "south", "low", "late", "steep", "stiff"]
    (bad,), (low,) = found["bad"], found["low"]
    assert bad["error"].startswith("line 3: a1 is empty") and bad["damping_ratio"] is None
    assert low["error"] == "line 5: release_amplitude is 0.5; it must be greater than 0 and less than a3"


def test_a_wall_without_a_least_error_says_why_and_stops_no_other(found):
    for row in found["late"]:
        assert row["damping_ratio"] is None
        assert row["error"].startswith("line 6: response_length is 8; it must be longer than")
