"""Behaviour that all commands share: help, errors of one line, warnings, and files that are never
overwritten.
"""

import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from coarse_scan import coarse_scan
from command_line import refused, run
from repository import ROOT

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.cli.options import SECTIONS
from rockdamp.laboratory import uncertainty

WALL = ("--thickness", 0.3, "--height", 4.5)
CURVE = ("--a1", 0.04, "--b1", 0.85)
TEST_FILE = "my-free-rocking-1.csv"
OPTIONS = [
    param
    for command in main.commands.values()
    for param in command.params
    if isinstance(param, click.Option)
]


@pytest.fixture
def files(record, monkeypatch):
    """The working directory, with a record, a table of walls and a free-rocking test."""
    folder = record.parent
    monkeypatch.chdir(folder)
    shutil.copy(ROOT / "examples/my-walls.csv", folder / "walls.csv")
    shutil.copy(ROOT / "examples" / TEST_FILE, folder / "test.csv")
    return folder


def help_text(name):
    return CliRunner().invoke(main, [name, "--help"], terminal_width=100).stdout


# --- help --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(main.commands))
def test_examples_of_the_help_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(uncertainty, "MOTION_DRAWS", 16)  # for speed
    for folder in ("data", "examples"):
        shutil.copytree(ROOT / folder, folder)
    lines = help_text(name).split("Example:")[1].replace("\\\n", " ").splitlines()
    examples = [shlex.split(line) for line in lines if line.strip().startswith("rockdamp ")]
    assert examples
    for example in examples:
        with coarse_scan():
            result = CliRunner().invoke(main, example[1:])
        assert result.exit_code == 0, (example, result.output)
        outputs = [word for word in example if Path(word).suffix in (".nc", ".png", ".html")]
        assert all(Path(output).is_file() for output in outputs)


@pytest.mark.parametrize("name", list(main.commands))
def test_help_is_short(name):
    lines = help_text(name).splitlines()
    assert len(lines) <= 80
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize("name", list(main.commands))
def test_help_has_options_under_headings(name):
    """The headings stand in one order, and every option under one of them."""
    text = help_text(name)
    headings = [line.removesuffix(":") for line in text.splitlines() if line[:1].isupper()]
    sections = [heading for heading in headings if heading in SECTIONS]
    assert sections == [section for section in SECTIONS if section in sections]
    assert sections[-1] == "Output" and "Options:" not in text
    for param in main.commands[name].params:
        if isinstance(param, click.Option):
            assert param.opts[0] in text


@pytest.mark.parametrize(
    ("name", "section", "argument"),
    [("batch", "Wall:", "WALLS.csv"), ("calibrate", "Measured test:", "[FILES]...")],
)
def test_help_explains_the_files_that_a_command_reads(name, section, argument):
    lines = help_text(name).splitlines()
    (line,) = [number for number, text in enumerate(lines) if text.startswith(f"  {argument}  ")]
    assert lines.index(section) < line < lines.index("Output:")


def test_parameters_are_few():
    counts = {name: len(command.params) for name, command in main.commands.items()}
    assert sum(counts.values()) <= 150
    assert max(counts.values()) <= 36


def test_every_option_is_described():
    assert all(option.help for option in OPTIONS)


def test_without_a_command_the_commands_are_listed():
    result = run()
    assert result.exit_code == 0
    assert "Commands:" in result.stdout


def imported_modules(*arguments):
    """Modules that a run of the command imports, in a new process."""
    command = [sys.executable, "-X", "importtime", "-m", "rockdamp", *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return {line.rpartition("|")[2].strip() for line in result.stderr.splitlines()}


@pytest.mark.parametrize(
    ("arguments", "unneeded"),
    [
        (("respond", "--help"), "numpy numba scipy xarray pandas matplotlib"),
        (("wall", *WALL), "numba scipy xarray pandas matplotlib"),
        (("equivalent", "--restitution", 0.85, *CURVE), "xarray pandas matplotlib netCDF4"),
    ],
)
def test_command_imports_only_its_needs(arguments, unneeded):
    assert not set(unneeded.split()) & imported_modules(*arguments)


# --- errors ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "part"),
    [
        ("nonsense", "nonsense"),
        ("wall --thickness 3kg --height 3", "'3kg'"),
        ("wall --thickness 250 --height 3", "at most 100 m; 250 mm is 0.25 m"),
        ("wall --thickness 0.3", "--height"),
        ("wall --thickness 0.3 --height 4.5 --hight 3", "--hight"),
        ("wall --thickness 0.3 --height 4.5 --hinge-ratio strongest", "'strongest'"),
        ("wall --thickness 0.3 --height 2 --parapet --hinge-ratio 0.6", "hinge_ratio"),
        (
            "wall --thickness 0.3 --height 4.5 --overburden 12kN/m --overburden-ratio 1",
            "overburden_ratio",
        ),
        ("wall --thickness 0.3 --height 4.5 --b1 0.8", "preset (new, moderate or severe)"),
        ("wall --thickness 0.3 --height 4.5 --a1 0 --b1 0.8", "Error: a1 is 0"),
        ("wall --thickness 0.3 --height 4.5 --a1 0.06 --b1 1.3", "Error: b1 is 1.3"),
        ("wall --thickness 0.3 --height 4.5 --preset new --a3 0.1", "Error: a3 is 0.1"),
        ("wall --thickness 0.3 --height 4.5 --restitution 0.8", "--restitution"),
        ("equivalent --restitution 0,85 --preset new", "'0,85' has a decimal comma"),
        ("equivalent --restitution 0.85 --a1 0.04 --b1 0.85 --preset new", "preset"),
        ("equivalent --a1 0.04 --b1 0.85", "--restitution"),
        ("equivalent --damping-ratio 5 --preset new", "--damping-ratio is 5"),
        ("equivalent --walls none.csv", "none.csv does not exist"),
        ("decay --preset new", "--restitution"),
        ("decay --preset new --damping-model CQD --damping-ratio 0.1", "CQD"),
        ("decay --preset new --damping-model CDC4 --damping-ratio 0.1", "CDC4"),
        ("decay --preset new --damping-model CDC --restitution 0.8", "equivalent"),
        ("decay --preset new --damping-model CR --damping-ratio 0.8", "--restitution"),
        ("decay --preset new --compare --damping-ratio 0.8", "--compare"),
        ("decay --preset new --damping-model CDC,BAND --restitution 0.8", "--compare"),
        ("decay --preset new --compare --damping-model BAND0.4 --restitution 0.8", "a number"),
        ("decay --preset new --compare --damping-model CDC, --restitution 0.8", "''"),
        ("decay --preset new --restitution 0.8 --output no/such.nc", "'no' does not exist"),
        ("decay --preset new --restitution 0.8 --output decay.csv", ".nc"),
        ("respond --record none.csv --restitution 0.8", "none.csv"),
        ("respond --record pulse.csv --restitution 0.8 --unit kg", "unit"),
        ("respond --record pulse.csv --restitution 0.8 --storey 3", "--storeys"),
        ("respond --record pulse.csv --restitution 0.8 --plot pulse.csv", ".png"),
        ("respond --record pulse.csv --restitution 0.8 --tail 1e9", "from 0 to 600 s"),
        ("respond --record pulse.csv --restitution 0.8 --diaphragm-period 1e9", "period"),
        (
            "respond --record pulse.csv --restitution 0.8 --building-period 1e9 --storeys 3 --storey 3",
            "period",
        ),
        ("respond --record p*.csv --scale 1,2 --restitution 0.8 --plot a.png", "one scale"),
        ("respond --record pulse.csv --scale 2 --to-pga 1 --restitution 0.8", "--to-pga"),
        ("respond --record pulse.csv --one-sided --damping-ratio 0.1", "restitution"),
    ],
)
def test_mistake_is_one_line_and_nothing_is_written(command, part, record, monkeypatch):
    monkeypatch.chdir(record.parent)
    wall = "--thickness 0.3 --height 3 --preset new" if command.startswith("respond") else ""
    message = refused(*command.split(), *wall.split())
    assert len(message.splitlines()) == 1
    assert message.startswith("Error: ") and part in message
    assert list(record.parent.iterdir()) == [record]


RESPOND = "respond --thickness 0.3 --height 3 --preset new --restitution 0.8"


@pytest.mark.parametrize(
    ("command", "source"),
    [
        ("equivalent --walls walls.csv --output walls.csv", "walls.csv"),
        ("equivalent --walls walls.csv --output ./walls.csv", "walls.csv"),
        ("equivalent --walls link.csv --output walls.csv", "walls.csv"),
        ("batch walls.csv --record pulse.csv --pgv 0.1 --output walls.csv", "walls.csv"),
        ("batch walls.csv --record pulse.csv --pgv 0.1 --output pulse.csv", "pulse.csv"),
        (f"{RESPOND} --record pulse.csv --output pulse.csv", "pulse.csv"),
        (f"{RESPOND} --record p*.csv --output pulse.csv", "pulse.csv"),
        (f"{RESPOND} --record numbers.nc --step 0.01 --unit g --output numbers.nc", "numbers.nc"),
        (f"{RESPOND} --record numbers.png --step 0.01 --unit g --plot numbers.png", "numbers.png"),
        ("calibrate --free-rocking test.nc --thickness 1 --height 3 --output test.nc", "test.nc"),
        ("calibrate --free-rocking test.nc --thickness 1 --height 3 --plot test.png", "test.png"),
        (
            "calibrate --record numbers.nc --thickness 1 --height 3 --output numbers.nc",
            "numbers.nc",
        ),
    ],
)
def test_output_that_is_an_input_is_refused(command, source, files):
    for name in ("numbers.nc", "numbers.png"):
        Path(name).write_text("0\n0.1\n0\n", encoding="utf-8")
    shutil.copy("test.csv", "test.nc")
    Path("test.png").symlink_to("test.nc")
    Path("link.csv").symlink_to("walls.csv")
    before = Path(source).read_bytes()
    message = refused(*command.split())
    assert "choose another file" in message and source in message
    assert Path(source).read_bytes() == before


def test_every_output_option_is_marked():
    for option in OPTIONS:
        writes = option.opts[0] in ("--output", "--plot", "--report")
        assert option.is_output == writes, option.opts


def test_fault_of_the_program_is_not_bad_input(monkeypatch):
    def broken(*_, **__):
        raise ValueError("a fault")

    monkeypatch.setattr(rd, "equivalent", broken)
    assert isinstance(run("equivalent", "--restitution", 0.85, *CURVE).exception, ValueError)


# --- warnings ----------------------------------------------------------------------------------

CR = ("--restitution", 0.85)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("wall", "--thickness", 0.05, "--height", 3), "height/thickness"),
        (("wall", *WALL, "--overburden", 15), "the overburden is 15 N/m"),
        (("decay", *CURVE, "--damping-model", "CDR", "--damping-ratio", 0.85), "damping_ratio"),
        (("assess", *WALL, *CURVE, "--records", "pulse.csv", "--pga", 0.5), "--pga in m/s2 is 0.5"),
        (
            ("wall", "--thickness", 1.0, "--height", 3, *CURVE, "--restitution", 0.9),
            "restitution divided by that of the rule rigid",
        ),
        (
            ("respond", *WALL, *CURVE, *CR, "--scale", 0.05, "--record", "pulse.csv"),
            "largest peak divided by u1, where the plateau starts",
        ),
        (
            ("respond", *WALL, *CURVE, *CR, "--record", "cut.csv"),
            "velocity at the end divided by PGV",
        ),
        (("respond", *WALL, *CURVE, *CR, "--scale", 1e4, "--record", "weak.csv"), "PGA in g"),
    ],
)
def test_unusual_value_is_warned_of_once(command, name, record, monkeypatch):
    monkeypatch.chdir(record.parent)
    pulse = rd.read_record("pulse.csv")
    elapsed = pulse.elapsed
    motion = pulse.ground_acceleration
    header = {"synthetic": "yes"}
    rd.write_record("cut.csv", rd.Record(elapsed[:20], motion[:20], header=header))
    rd.write_record("weak.csv", rd.Record(elapsed, 1e-4 * motion, header=header))
    result = run(*command)
    warnings = [line for line in result.stderr.splitlines() if line.startswith("warning: ")]
    assert result.exit_code == 0
    assert len(warnings) == 1 and name in warnings[0]


def test_usual_values_are_not_warned_of(record):
    assert run("respond", *WALL, *CURVE, *CR, "--record", record).stderr == ""
