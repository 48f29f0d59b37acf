"""`wall` and `equivalent`: the numbers are those of the package, and the tables name them."""

import csv

import numpy as np
import pytest
from command_line import printed, refused, run

import rockdamp as rd
from rockdamp.cli.printing import cell
from rockdamp.equivalence.programs import missed_collapses

WALL = ("--thickness", 0.3, "--height", 4.5)
CURVE = ("--a1", 0.04, "--b1", 0.85)
BUILT = rd.Wall(0.3, 4.5)
DROP = rd.TrilinearCurve(0.04, 0.85)
CONSTANTS = (
    "weight effective_mass excitation_factor rigid_strength rigid_stiffness"
    " instability_displacement frequency_parameter restitution_rigid restitution_impulsive"
    " restitution_measured"
).split()


@pytest.mark.parametrize(
    ("options", "built"),
    [
        ((), BUILT),
        (
            ("--overburden-ratio", 2, "--hinge-ratio", "weakest"),
            rd.Wall(0.3, 4.5, overburden_ratio=2, hinge_ratio="weakest"),
        ),
        (
            ("--overburden", "12kN/m"),
            rd.Wall(0.3, 4.5, overburden_ratio=12000 / float(BUILT.weight)),
        ),
        (("--parapet", "--width", 2), rd.Parapet(0.3, 4.5, width=2)),
        (("--thickness", "300mm", "--height", "14ft 9in"), rd.Wall(0.3, 177 * 0.0254)),
        (("--density", "18kN/m3"), rd.Wall(0.3, 4.5, density=18000 / 9.80665)),
    ],
)
def test_wall_gives_the_constants_of_the_package(options, built):
    values = printed("wall", *WALL, *options)
    expected = {name: pytest.approx(float(getattr(built, name))) for name in CONSTANTS}
    assert {name: values[name] for name in CONSTANTS} == expected
    onset = built.rigid_strength / (1.5 * built.effective_mass)
    assert values["rocking_onset"] == pytest.approx(float(onset))


@pytest.fixture(scope="module")
def damping():
    return printed("wall", *WALL, *CURVE, "--restitution", 0.85)


def test_wall_gives_the_damping_of_a_program(damping):
    xi = rd.equivalent(0.85, DROP)[0]["damping_ratio"]
    w1 = np.sqrt(0.85 / 0.04 * float(BUILT.rigid_stiffness / BUILT.effective_mass))
    alpha = damping["rayleigh_alpha_m"]
    assert damping["initial_frequency"] == pytest.approx(w1)
    assert alpha == pytest.approx(2 * xi * w1)
    assert damping["damping_coefficient"] == pytest.approx(alpha * damping["effective_mass"])


def test_wall_prints_c_of_the_given_width(damping):
    text = run("wall", *WALL, *CURVE, "--restitution", 0.85, "--width", 2).stdout
    assert f"CDC for 2 m of wall: C = {2 * damping['damping_coefficient']:.4g} N s/m" in text


def test_wall_gives_the_period_by_amplitude(damping):
    p = float(BUILT.frequency_parameter)
    assert damping["periods"][2] == pytest.approx(
        {
            "amplitude": 0.5,
            "rigid_period": 4 * np.arccosh(2) / p,
            "period": float(DROP.period(0.5) / p),
        }
    )


def test_wall_prints_tables_with_captions(damping):
    text = run("wall", *WALL, *CURVE, "--restitution", 0.85).stdout
    assert text.startswith("Wall 0.3 x 4.5 m")
    for caption in (
        "Constants of 1 m of wall:",
        "Coefficient of restitution e",
        "If you use another program",
    ):
        assert caption in text
    assert f"rayleigh {damping['rayleigh_alpha_m']:.4g} 0 0 0" in text
    (cdc,) = (line for line in text.splitlines() if line.startswith("   CDC "))
    assert cdc.endswith(f" {100 * missed_collapses(0.85)[1]['CDC']:.2g} %")
    assert "missed collapses are those of the study of eight walls, not of this wall" in text


@pytest.mark.parametrize(
    ("value", "text"),
    [(1204.4, "1204"), (999.4, "999"), (-0.0, "0"), (1.5e6, "1.5e+06"), (np.nan, "-")],
)
def test_number_of_a_table_has_three_digits(value, text):
    assert cell(value) == text


def test_wall_prints_no_ratio_for_band(damping):
    """Its formula takes e; the other dampers that a program may have are ranked."""
    text = run("wall", *WALL, *CURVE, "--restitution", 0.85).stdout
    rows = {line.split()[0]: line for line in text.splitlines() if line.split()}
    assert rows["BAND"].split()[:6] == ["BAND", "-", "none:", "takes", "e", "and"]
    ratios = {row["damping_model"]: row["damping_ratio"] for row in damping["damping"]}
    assert ratios["BAND"] == pytest.approx(-np.log(0.85) / np.pi)
    for model in ("CDR", "SDR"):
        assert rows[model].split()[1] == f"{ratios[model]:.3g}"
    assert "(not recommended)" in rows["SDR"] and "(not recommended)" in rows["ECD"]


@pytest.mark.parametrize("width", [1, 2.5])
def test_constants_name_the_width_of_the_wall(width):
    text = run("wall", *WALL, "--width", width).stdout
    assert f"Constants of {width} m of wall:" in text


def test_parapet_has_one_row_of_restitution():
    lines = run("wall", *WALL, "--parapet").stdout.splitlines()
    (row,) = [line for line in lines if "Housner" in line]
    e = float(rd.Parapet(0.3, 4.5).restitution_measured)
    assert row.split()[:3] == ["every", "rule", f"{e:.3g}"]


def test_mass_on_the_wall_leaves_the_rule_impulsive_unknown():
    heavy = (*WALL, "--overburden-ratio", 2, "--overburden-mass", 1)
    assert printed("wall", *heavy)["restitution_impulsive"] is None
    assert "not known" in run("wall", *heavy).stdout
    assert "impulsive" in refused("wall", *heavy, *CURVE, "--restitution", "impulsive")


OPTIONS = "--a1 0.05 --b1 0.7 --a3 0.9 --softening translated --release 0.4".split()


def test_equivalent_gives_the_ratios_of_the_package():
    rows = printed("equivalent", "--restitution", "0.8,0.853", *OPTIONS)
    curve = rd.TrilinearCurve(0.05, 0.7, 0.9, "translated")
    assert rows == rd.equivalent([0.8, 0.853], curve, release_amplitude=0.4)


def test_equivalent_gives_the_restitution_of_a_ratio():
    xi = printed("equivalent", "--restitution", 0.853, *OPTIONS)[-1]["damping_ratio"]
    row = printed("equivalent", "--damping-ratio", xi, *OPTIONS)[-1]
    assert row["damping_model"] == "BAND"
    assert row["restitution"] == pytest.approx(0.853, abs=1e-4)


def test_equivalent_says_which_damper_has_the_smallest_error():
    lines = run("equivalent", "--restitution", 0.85, *CURVE).stdout.splitlines()
    assert lines[0].startswith("Damping ratio xi equivalent to e")
    assert lines[1].split()[:3] == ["e", "damper", "xi"]
    assert lines[1].endswith(
        "rms error [u/u_ins]  xi by the closed form  xi by the polynomial (b1 = 0.85)"
    )
    assert lines[-1].startswith("BAND has the smallest error. Use the column xi")


def test_equivalent_of_a_table_has_the_ratios_of_each_wall(tmp_path):
    table = tmp_path / "walls.csv"
    output = tmp_path / "out.csv"
    text = "id,thickness,height,preset,restitution\na,0.25,3,moderate,0.8\n"
    table.write_text(text, encoding="utf-8")
    rows = printed("equivalent", "--walls", table, "--release", 0.6, "--output", output)
    expected = rd.equivalent(0.8, rd.TrilinearCurve.preset("moderate"), release_amplitude=0.6)
    assert rows == [{"id": "a", **row, "error": None} for row in expected]
    with open(output, encoding="utf-8", newline="") as file:
        stored = [float(row["damping_ratio"]) for row in csv.DictReader(file)]
    assert stored == [row["damping_ratio"] for row in expected]


def test_equivalent_refuses_a_table_without_a_good_row(tmp_path):
    table = tmp_path / "walls.csv"
    table.write_text("id,thickness,height,preset\nb,x,3,new\n", encoding="utf-8")
    assert "no wall has a damping ratio; b: thickness: 'x'" in refused(
        "equivalent", "--walls", table
    )


def test_equivalent_gives_one_sided_walls_and_bad_rows_an_error(tmp_path):
    table = tmp_path / "walls.csv"
    table.write_text(
        "id,thickness,height,preset,restitution,one_sided\n"
        "facade,0.5,6,new,0.5,yes\nwall,0.25,3,new,0.85,\nbad,x,3,new,,\n",
        encoding="utf-8",
    )
    rows = printed("equivalent", "--walls", table)
    errors = {row["id"]: row["error"] for row in rows}
    assert list(errors) == ["facade", "wall", "bad"]
    assert errors["wall"] is None and "'x'" in errors["bad"]
    assert errors["facade"].startswith("a one-sided wall has no damping ratio")
    ratios = [row["damping_ratio"] for row in rows if row["id"] != "wall"]
    assert ratios == [None, None]
    lines = run("equivalent", "--walls", table).stdout.splitlines()
    assert lines[0].startswith("facade: a one-sided wall has no damping ratio")
    assert [line.split()[0] for line in lines[4:-1]] == 5 * ["wall"]
