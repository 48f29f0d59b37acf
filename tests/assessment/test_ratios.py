"""Damping ratios of a table of walls."""

import pytest

import rockdamp as rd
from rockdamp.assessment.ratios import ratios
from rockdamp.assessment.table import read_walls
from rockdamp.vocabulary import VISCOUS_MODELS

TABLE = """id,thickness,height,a1,b1,a3,softening,preset,restitution
north,0.25,3.0,0.06,0.7,0.95,translated,,0.9
bad,0.25,3.0,,,,,,0.85
south,0.25,3.0,,,,,moderate,0.9
low,0.25,3.0,0.04,0.85,0.4,,,0.9
squat,0.25,3.0,,,,,moderate,0.6
steep,0.25,3.0,0.06,0.7,0.95,steeper,,0.9
"""


@pytest.fixture
def found(tmp_path):
    path = tmp_path / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    by_wall = {}
    for row in ratios(read_walls(path), 0.5):
        by_wall.setdefault(row["id"], []).append(row)
    return by_wall


def test_each_wall_has_the_ratio_of_its_own_curve_by_each_model(found):
    north = rd.TrilinearCurve(0.06, 0.7, 0.95, "translated")
    assert list(found) == ["north", "bad", "south", "low", "squat", "steep"]
    for row, model in zip(found["north"], VISCOUS_MODELS, strict=True):
        assert row["damping_model"] == model and row["restitution"] == 0.9
        assert row["damping_ratio"] == float(rd.damping_ratio_table(north, model, 0.9)) and row["error"] == ""
    for name, curve in {
        "south": rd.TrilinearCurve.preset("moderate"),
        "steep": rd.TrilinearCurve(0.06, 0.7, 0.95),
    }.items():
        expected = [float(rd.damping_ratio_table(curve, model, 0.9)) for model in VISCOUS_MODELS]
        assert [row["damping_ratio"] for row in found[name]] == expected


def test_a_row_without_a_wall_or_not_released_below_a3_has_its_error_once(found):
    (bad,), (low,) = found["bad"], found["low"]
    assert bad["error"].startswith("line 3: a1 is empty") and bad["damping_ratio"] is None
    assert low["error"] == "line 5: release_amplitude is 0.5; it must be greater than 0 and less than a3"


def test_where_the_table_does_not_answer_the_row_says_why_and_exact_ratios_stand(found):
    told = {row["damping_model"]: (row["damping_ratio"], row["error"]) for row in found["squat"]}
    assert told["CDR"] == (None, "line 6: restitution (e) must be between 0.7 and 0.99, for the table")
    assert told["ECD"] == (float(rd.Damping.of_restitution(0.6).damping_ratio), "")
