"""Slips on the command line: a repeated or useless option is refused, an unlikely value warned of."""

import numpy as np
import pytest
from command_line import printed, run
from repository import ROOT

import rockdamp as rd

EXAMPLE = ROOT / "examples/my-walls.csv"
WALL = ("--thickness", "0.3", "--height", "4.5", "--preset", "new")


@pytest.fixture
def record(tmp_path):
    """Two seconds of a pulse of 3 m s-2, sampled at 100 Hz, that comes to rest."""
    elapsed = 0.01 * np.arange(200)
    motion = np.where(elapsed < 0.4, 3 * np.sin(2 * np.pi * elapsed / 0.4), 0.0)
    rd.write_record(tmp_path / "pulse.csv", rd.Record(elapsed, motion, header={"synthetic": "yes"}))
    return tmp_path / "pulse.csv"


@pytest.mark.parametrize("name", ["--thickness", "--damping-model", "--restitution"])
def test_an_option_of_one_value_that_is_given_twice_is_refused(record, name):
    given = ["--record", record, *WALL, "--damping-model", "CR", "--restitution", 0.85]
    result = run("respond", *given, name, given[given.index(name) + 1])
    assert result.exit_code == 2 and f"{name} is given 2 times; it must be given once" in result.stderr


def test_a_flag_or_an_option_of_many_values_may_be_given_twice(record):
    assert run("wall", *WALL, "--json", "--json").exit_code == 0
    assert run("assess", *WALL, "--records", "a.csv", "--records", "a.csv", "--pgv", 1).stderr.count("times") == 0


@pytest.mark.parametrize("named", ["pulse.csv", "p*.csv", "**/pulse.csv", "."])
@pytest.mark.parametrize("command", ["respond", "batch"])
def test_an_output_that_is_one_of_the_records_is_refused(record, monkeypatch, tmp_path_factory, command, named):
    link = tmp_path_factory.mktemp("elsewhere") / "link.csv"
    link.symlink_to(record)
    monkeypatch.chdir(record.parent)
    content = record.read_bytes()
    given = ("--records", named, "--pgv", 1, "--output", link)
    if command == "respond":
        given = (*WALL, "--restitution", 0.85, "--record", named, "--csv", link)
    result = run(command, *([EXAMPLE] if command == "batch" else []), *given)
    assert result.exit_code == 2 and f"{str(link)!r}, which --record" in result.stderr
    assert record.read_bytes() == content and link.is_symlink()


def test_a_parapet_with_a_hinge_is_refused():
    result = run("wall", "--thickness", 0.3, "--height", 2, "--parapet", "--hinge-ratio", 0.6)
    assert result.exit_code == 2 and "--hinge-ratio belongs to a wall; --parapet" in result.stderr


@pytest.mark.parametrize("command", ["respond", "decay"])
def test_restitution_alone_means_cr(record, command):
    given = (*WALL, *(("--record", record) if command == "respond" else ()), "--restitution", 0.85)
    assert printed(command, *given) == printed(command, *given, "--damping-model", "CR")


def test_a_response_states_the_motion_that_made_it(record):
    given = ("respond", "--record", record, *WALL, "--restitution", 0.85)
    once, twice = printed(*given), printed(*given, "--scale", -2)
    measures = rd.intensity_measures(rd.read_record(record))
    assert (once["pga"], once["pgv"]) == (measures.pga, measures.pgv) and once["duration"] == pytest.approx(1.99)
    assert (twice["pga"], twice["pgv"]) == (2 * measures.pga, 2 * measures.pgv)
    assert once["rocking_onset"] == float(rd.Wall(0.3, 4.5).rocking_onset(0.72))
    assert all(row["pga"] == measures.pga for row in printed(*given, "--compare"))
    text = run(*given).stdout
    assert "pga                           3 m s-2, which is 0.3059 g" in text and "pgv" in text and "duration" in text


def test_after_a_collapse_no_peak_is_printed_and_the_json_keeps_its_keys(record):
    given = ("respond", "--record", record, *WALL, "--restitution", 0.85, "--scale", 9)
    lines = dict(line.split(maxsplit=1) for line in run(*given).stdout.splitlines())
    assert lines["outcome"] == "collapsed" and lines["peak_ratio"].startswith("-") and lines["peak_elapsed"][0] == "-"
    assert printed(*given)["peak_ratio"] > 1
    table = run(*given, "--compare").stdout.split("\n\n")[1].splitlines()
    assert all(row.split()[2:5] == ["-", "-", "-"] for row in table[2:] if not row.startswith("-,"))
    assert "-, peak_ratio: a wall that collapsed has no peak" in table


def test_a_motion_that_does_not_rock_the_wall_is_told(record):
    result = run("respond", "--record", record, *WALL, "--restitution", 0.85, "--scale", 0.05)
    assert result.stderr.startswith(
        "warning: the wall does not rock: it stays below u1, a1 = 0.06 of u_ins; PGA is 0.15"
    )
    assert run("respond", "--record", record, *WALL, "--restitution", 0.85, "--scale", 1).stderr == ""


def test_a_wall_states_its_onset_of_rocking_each_e_with_its_reason_and_its_units():
    values, wall = printed("wall", *WALL), rd.Wall(0.3, 4.5)
    assert values["rocking_onset"] == pytest.approx(0.72 * float(wall.rigid_strength / wall.mass))
    assert values["rocking_onset_g"] == pytest.approx(values["rocking_onset"] / 9.80665)
    recommended = [row for row in values["restitutions"] if row["recommended"]]
    assert [row["restitution"] for row in recommended] == [0.9 * values["restitution"]]
    assert len(values["restitutions"]) == 3 and all(row["reason"] for row in values["restitutions"])
    assert values["units"]["weight"] == "N" and values["units"]["restitution"] == "1"
    assert set(values["units"]) == set(values) - {"restitutions", "units", "damping", "damping_restitution"}
    assert "which is 0.1371 g" in run("wall", *WALL).stdout and "(recommended)" in run("wall", *WALL).stdout
    rigid = printed("wall", *WALL[:4])["rocking_onset"]
    assert values["rocking_onset"] == pytest.approx(0.72 * rigid)


def test_a_wall_that_the_impulses_stop_is_said_to():
    rows = printed("wall", "--thickness", 0.3, "--height", 0.6)["restitutions"]
    assert [row["restitution"] > 0 for row in rows] == [True, True, False]
    assert rows[2]["reason"].endswith("they stop the wall, which does not rock on")


def test_imperial_units_are_those_of_the_handbooks():
    si, imperial = (printed("wall", *WALL, "--amplitude", 0.5, "--units", name) for name in ("si", "Imperial"))
    sizes = {"weight": 4.4482216152605, "effective_mass": 0.45359237, "rigid_stiffness": 175.12683524647636}
    sizes |= {"instability_displacement": 0.0254, "rocking_onset": 0.3048, "frequency_parameter": 1.0}
    for name, size in sizes.items():
        assert imperial[name] * size == pytest.approx(si[name], rel=1e-12)
    assert imperial["units"]["rigid_stiffness"] == "lbf in-1" and imperial["units"]["displacement"] == "in"
    assert imperial["periods"][0]["displacement"] * 0.0254 == pytest.approx(si["periods"][0]["displacement"])
    assert imperial["restitutions"] == si["restitutions"] and imperial["rocking_onset_g"] == si["rocking_onset_g"]


@pytest.mark.parametrize("text", ["1_0", "١", "1e-1_0"])
def test_what_python_alone_takes_for_a_number_is_none(text):
    for command in (
        ["wall", "--thickness", text, "--height", "30"],
        ["wall", "--thickness", "1", "--height", "30", "--overburden-ratio", text],
        ["equivalent", "--restitution", f"0.8:0.9:{text}", "--a1", "0.04", "--b1", "0.85"],
        ["equivalent", "--restitution", text, "--a1", "0.04", "--b1", "0.85"],
        ["assess", *WALL, "--records", "x.csv", "--pgv", "1", "--restitution", text],
        ["calibrate", "--record", "x.csv", *WALL[:4], "--posterior", "--seed", text],
    ):
        result = run(*command)
        assert result.exit_code == 2 and text in result.stderr.splitlines()[-1], command
