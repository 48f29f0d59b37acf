"""Help whose examples run, completion, and what a command loads."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner
from command_line import run
from repository import ROOT

from rockdamp.cli import main
from rockdamp.constants import RELEASES, SMALL_RELEASE_OVERSTATES


def examples(command):
    text = run(command, "--help").stdout
    joined = text.split("Example:")[1].replace("\\\n", " ")
    return [shlex.split(line) for line in joined.splitlines() if line.strip().startswith("rockdamp ")]


@pytest.mark.no_cover
@pytest.mark.parametrize("name", list(main.commands))
def test_every_example_in_the_help_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("data", "results", "examples"):
        Path(folder).mkdir()
    shutil.copy(ROOT / "data/sin-03-00-synthetic.csv", "data")
    for example in ("my-walls.csv", "my-free-rocking-1.csv", "my-free-rocking-2.csv"):
        shutil.copy(ROOT / "examples" / example, "examples")
    found = examples(name)
    assert found
    for example in found:
        result = CliRunner().invoke(main, example[1:])
        assert result.exit_code == 0, (example, result.output)
        for word in example:
            if Path(word).suffix in (".nc", ".png", ".pdf"):
                assert Path(word).is_file()


@pytest.mark.parametrize("name", ["main", *main.commands])
def test_every_option_is_described(name):
    command = main if name == "main" else main.commands[name]
    assert command.help
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name


@pytest.mark.parametrize("name", ["wall", "equivalent", "decay", "respond", "assess", "batch"])
def test_help_says_at_which_amplitude_e_is_meant(name):
    told = " ".join(run(name, "--help").stdout.split())
    unsafe = f"one of 0.1 u_ins overstates the intensity of collapse by {SMALL_RELEASE_OVERSTATES}"
    assert f"of releases from {RELEASES} ({unsafe}, going by measured blocks)" in told


def test_commands_and_options_are_completed():
    complete = ShellComplete(main, {}, "rockdamp", "_ROCKDAMP_COMPLETE")
    assert [item.value for item in complete.get_completions([], "re")] == ["respond"]
    assert "--damping-model" in [item.value for item in complete.get_completions(["respond"], "--damping")]
    models = complete.get_completions(["respond", "--damping-model"], "C")
    assert [item.value for item in models] == ["CR", "CDC", "CDR"]
    assert [item.type for item in complete.get_completions(["respond", "--plot"], "pic")] == ["file"]


def loaded(*arguments):
    """Modules that a run of the command loads, in a new process."""
    code = (
        "import json, sys\n"
        "from rockdamp.cli import main\n"
        f"main({[str(argument) for argument in arguments]!r}, standalone_mode=False)\n"
        "print(json.dumps(sorted(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ)
    return set(json.loads(done.stderr.splitlines()[-1]))


def test_the_help_loads_nothing_heavy():
    for arguments in (["--help"], ["respond", "--help"]):
        assert not {"numpy", "numba", "scipy", "xarray", "pandas", "matplotlib"} & loaded(*arguments)


def test_equivalent_loads_only_what_it_computes_with():
    modules = loaded("equivalent", "--restitution", 0.85, "--a1", 0.04, "--b1", 0.85)
    assert "numba" in modules
    assert not {"xarray", "pandas", "matplotlib", "netCDF4", "tqdm", "scipy.optimize", "scipy.signal"} & modules
