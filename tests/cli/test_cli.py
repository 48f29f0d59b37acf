"""The command line: `wall`, `equivalent`, and what all commands share."""

import csv
import json

import numpy as np
import pytest
from command_line import printed, refused, run
from published_models import PUBLISHED_VISCOUS
from repository import ROOT

import rockdamp as rd
from rockdamp.constants import VISCOUS_MODELS
from rockdamp.mechanics.wall import SORRENTINO_RATIO

WALL = ("--thickness", 0.3, "--height", 4.5)
CURVE = ("--a1", 0.04, "--b1", 0.85)
WALLS = ROOT / "examples/my-walls.csv"
CONTRACT = ["weight", "effective_mass", "excitation_factor", "rigid_strength", "rigid_stiffness"]
CONTRACT += ["instability_displacement", "frequency_parameter"]
CONTRACT += ["restitution_rigid", "restitution_impulsive", "restitution_measured"]
HINGE = ["hinge_ratio", "weakest_hinge_ratio"]
OF_CURVE = ["initial_frequency", "initial_period", "rocking_onset_g", "restitutions", "units"]
OF_CURVE += ["damping_restitution", "damping_coefficient", "damping"]


# --- equivalent -----------------------------------------------------------------------------------------------------


def test_a_fit_of_another_plateau_is_said_to_be_one():
    said = "damping_ratio_fit is that of b1 = 0.85, not of 0.6"
    assert said in run("equivalent", "--restitution", 0.85, "--a1", 0.04, "--b1", 0.6).stderr
    assert "b1 =" not in run("equivalent", "--restitution", 0.85, "--a1", 0.04, "--b1", 0.85).stderr


def test_readme_shows_what_the_command_prints():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    _, command, table = text.partition("$ .venv/bin/rockdamp equivalent")
    arguments, *shown = table.partition("```")[0].splitlines()
    printed = run("equivalent", *arguments.split()).stdout.splitlines()
    assert command and shown[0] == printed[0] and len(printed) == 1 + len(VISCOUS_MODELS)
    published = [row for row in printed[1:] if row.split()[1] in PUBLISHED_VISCOUS]
    for told, row in zip(shown[1:], published, strict=True):
        assert told.split()[:2] == row.split()[:2]
        # Another processor may turn the last digits.
        assert np.array(told.split()[2:], float) == pytest.approx(np.array(row.split()[2:], float), rel=1e-4)


def test_equivalent_passes_every_option_on():
    stated = "--restitution 0.8 --a1 0.05 --b1 0.7 --a3 0.9 --softening translated --release 0.4 --response-length 12"
    rows = printed("equivalent", *stated.split())
    assert rows == rd.equivalent(
        0.8, rd.TrilinearCurve(0.05, 0.7, 0.9, "translated"), release_amplitude=0.4, response_length=12.0
    )


def test_ratios_of_a_table_of_walls_are_printed_written_or_given_as_json(tmp_path):
    output = tmp_path / "ratios.csv"
    rows = printed("equivalent", "--walls", WALLS, "--release", 0.6, "--output", output)
    assert [row["damping_model"] for row in rows] == list(VISCOUS_MODELS) * (len(rows) // len(VISCOUS_MODELS))
    written = list(csv.DictReader(output.read_text(encoding="utf-8").splitlines()))
    assert [row["damping_ratio"] for row in written] == [str(row["damping_ratio"]) for row in rows]
    table = run("equivalent", "--walls", WALLS, "--release", 0.6)
    assert table.stdout.splitlines()[0].split() == list(rows[0])
    alone = rd.equivalent(rows[0]["restitution"], rd.TrilinearCurve(0.13, 0.60), release_amplitude=0.6)
    assert [row["damping_ratio"] for row in rows[: len(alone)]] == [row["damping_ratio"] for row in alone]


def test_a_table_of_walls_stands_alone(tmp_path):
    for more, said in (
        (("--restitution", 0.85), "--restitution must be given with one wall, without --walls (whose table"),
        (("--response-length", 9), "--response-length must be given with one wall"),
    ):
        assert said in refused("equivalent", "--walls", WALLS, *more)
    assert "--output must be given with --walls" in refused("equivalent", *CURVE, "--output", tmp_path / "a.csv")
    empty = tmp_path / "walls.csv"
    empty.write_text("id,thickness,height\n", encoding="utf-8")
    assert "a wall must stand in each" in refused("equivalent", "--walls", empty)


# --- wall -----------------------------------------------------------------------------------------------------------


def test_wall_gives_the_wall_of_the_package_under_the_agreed_keys():
    values = printed("wall", *WALL, "--overburden-ratio", 2)
    made = rd.Wall(0.3, 4.5, overburden_ratio=2)
    assert list(values)[: len(CONTRACT)] == list(CONTRACT)
    assert {key: values[key] for key in (*CONTRACT, *HINGE)} == {
        key: float(getattr(made, key)) for key in (*CONTRACT, *HINGE)
    }
    weakest = printed("wall", *WALL, "--overburden-ratio", 2, "--hinge-ratio", "weakest")
    assert weakest["hinge_ratio"] == weakest["weakest_hinge_ratio"] == values["weakest_hinge_ratio"] < 0.7
    assert weakest["rigid_strength"] < values["rigid_strength"]
    assert "'strongest'" in refused("wall", *WALL, "--hinge-ratio", "strongest")


def test_wall_knows_parapets():
    result = run("wall", "--thickness", 0.3, "--height", 2, "--parapet", "--json")
    assert json.loads(result.stdout)["restitution_rigid"] == float(rd.Parapet(0.3, 2.0).restitution_rigid)
    text = run("wall", "--thickness", 0.3, "--height", 2, "--parapet").stdout
    assert "Housner" in text and "0.90" not in text


def test_the_walls_table_has_restitution_by_each_formula_and_periods():
    text = run("wall", *WALL, "--preset", "moderate").stdout
    made = rd.Wall(0.3, 4.5)
    for e in (made.restitution_rigid, made.restitution_impulsive, SORRENTINO_RATIO * made.restitution_rigid):
        assert f"{float(e):.5g}" in text
    lines = [line.split() for line in text.splitlines()]
    header = lines.index(["amplitude", "displacement", "rigid_period", "period"])
    half = next(line for line in lines[header:] if line[:1] == ["0.5"])
    period = rd.TrilinearCurve.preset("moderate").period(0.5) / made.frequency_parameter
    assert half[2:] == [f"{4 * np.arccosh(2) / float(made.frequency_parameter):.5g}", f"{float(period):.5g}"]


def test_the_walls_json_holds_the_periods_that_are_asked_for():
    values = printed("wall", *WALL, *CURVE, "--amplitude", "0.3,0.6")
    assert list(values) == [*CONTRACT, *HINGE, "rocking_onset", *OF_CURVE, "periods"]
    assert [row["amplitude"] for row in values["periods"]] == [0.3, 0.6]


def test_the_wall_s_dashpot_is_that_of_its_restitution():
    values, made = printed("wall", *WALL, *CURVE, "--restitution", 0.85), rd.Wall(*WALL[1::2])
    assert values["damping_restitution"] == 0.85 and list(values["damping_coefficient"]) == ["CDC"]
    xi = rd.equivalent(0.85, rd.TrilinearCurve(0.04, 0.85))[0]["damping_ratio"]
    c = 2 * xi * np.sqrt(0.85 / 0.04 * float(made.rigid_stiffness * made.effective_mass))
    assert values["damping_coefficient"]["CDC"] == pytest.approx(c, rel=1e-12)
    rows = printed("equivalent", "--restitution", 0.85, *CURVE, *WALL)
    assert rows[0]["damping_coefficient"] == pytest.approx(c, rel=1e-12) and rows[1]["damping_coefficient"] is None
    shown = run("wall", *WALL, *CURVE, "--restitution", 0.85).stdout
    assert f"{c:.5g}" in shown


def test_a_load_with_its_unit_is_the_ratio_that_is_printed():
    feet = ("--thickness", "13in", "--height", "13ft 6in", "--width", 2, "--density", "18kN/m3")
    made = rd.Wall(13 * 0.0254, 162 * 0.0254, width=2, density=18000 / 9.80665)
    for load, force in (("12kN/m", 24000.0), ("6000", 12000.0)):
        result = run("wall", *feet, "--overburden", load, "--json")
        ratio = force / float(made.weight)
        loaded = rd.Wall(made.thickness, made.height, width=2, density=made.density, overburden_ratio=ratio)
        assert f"overburden_ratio is {ratio:.4g}: " in result.stderr
        assert json.loads(result.stdout)["rigid_strength"] == pytest.approx(float(loaded.rigid_strength), rel=1e-5)
    both = refused("wall", *WALL, "--overburden", "12kN/m", "--overburden-ratio", 1)
    assert "--overburden and --overburden-ratio state the same" in both


# --- bad input ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, named",
    [
        (("equivalent", "--restitution", 1.85, *CURVE), "restitution is 1.85"),
        (("equivalent", *CURVE), "--restitution"),
        (("equivalent", "--restitution", 0.85, "--b1", 0.85), "--a1 is missing"),
        (("equivalent", "--restitution", 0.85, *CURVE, "--preset", "new"), "--preset stands for --a1 and --b1"),
        (("wall", *WALL, "--a3", 0.9), "--a3 must be given with --a1 and --b1, or --preset"),
        (("wall", *WALL, "--hinge-ratio", 1), "hinge_ratio is 1"),
        (("wall", "--thickness", "3kg", "--height", 4.5), "'3kg' must be a number in m"),
        (("nonsense",), "nonsense"),
    ],
)
def test_bad_input_ends_with_status_2_and_names_the_value(arguments, named):
    assert named in refused(*arguments)


def test_a_fault_of_the_program_is_not_taken_for_bad_input(monkeypatch):
    def broken(*_, **__):
        raise ValueError("a fault")

    monkeypatch.setattr("rockdamp.equivalence.equivalent.equivalent", broken)
    assert isinstance(run("equivalent", "--restitution", 0.85, *CURVE).exception, ValueError)


def test_the_onset_is_over_gravity_and_a_load_is_told_in_thousands_of_newtons():
    """By hand: 0.3 m x 3 m x 1 m of 1 800 kg m-3 weigh 15.89 kN, and 12 kN/m on it are 0.7553 of that."""
    values = printed("wall", *WALL[:2], "--height", 3, "--a1", 0.04, "--b1", 0.85)
    assert values["rocking_onset_g"] == pytest.approx(values["rocking_onset"] / 9.80665)
    result = run("wall", "--thickness", 0.3, "--height", 3, "--overburden", "12kN/m", "--density", 1800)
    assert "overburden_ratio is 0.7553: 12 kN over 15.89 kN of the wall" in result.stderr
