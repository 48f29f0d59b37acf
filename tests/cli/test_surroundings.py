"""The command line in bad surroundings: full disks, wrong variables, Ctrl-C, and names that a terminal would obey."""

import json
import os
import signal
import subprocess
import sys

import pytest
from click.testing import CliRunner
from repository import ROOT

from rockdamp.cli import main

RECORD = ROOT / "data/sin-03-00-synthetic.csv"
DECAY = ["decay", "--preset", "moderate", "--damping-model", "CDR", "--damping-ratio", "0.05"]


@pytest.mark.parametrize(
    "arguments", [["--help"], ["equivalent", "--restitution", "0.85", "--preset", "new", "--json"]]
)
def test_output_to_a_full_disk_is_one_line(arguments):
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [sys.executable, "-m", "rockdamp", *arguments], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert (run.returncode, run.stderr) == (2, "Error: standard output: No space left on device\n")


@pytest.mark.parametrize("value", ["0", "x", "999999"])
def test_a_wrong_number_of_threads_is_named(monkeypatch, value):
    monkeypatch.setenv("NUMBA_NUM_THREADS", value)
    result = CliRunner().invoke(main, DECAY)
    assert result.exit_code == 2
    assert f"NUMBA_NUM_THREADS is {value!r} in the environment; it must be a whole number" in result.stderr


def test_a_date_that_is_none_is_named(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "x")
    result = CliRunner().invoke(main, DECAY)
    assert result.exit_code == 2
    assert "SOURCE_DATE_EPOCH is 'x' in the environment; it must be a whole number of seconds" in result.stderr


def test_an_interval_of_bars_that_is_none_is_named(monkeypatch):
    monkeypatch.setenv("TQDM_MININTERVAL", "x")
    result = CliRunner().invoke(main, DECAY)
    assert result.exit_code == 2
    assert "TQDM_MININTERVAL is 'x' in the environment; it must be a number of seconds" in result.stderr


def test_a_backend_that_is_none_matters_to_no_picture_in_a_file(tmp_path):
    plot = tmp_path / "decay.png"
    command = [sys.executable, "-m", "rockdamp", *DECAY, "--plot", str(plot)]
    run = subprocess.run(command, env={**os.environ, "MPLBACKEND": "junk"}, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert plot.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "arguments",
    [
        ["wall", "--thickness", "x" * 5000, "--height", "3"],
        ["wall", "--thickness", "1 " * 2500, "--height", "3"],
        ["equivalent", "--restitution", "0.85", "--preset", "x" * 5000],
        [
            "respond",
            "--record",
            "x" * 5000,
            "--thickness",
            "0.3",
            "--height",
            "3",
            "--preset",
            "new",
            "--restitution",
            "0.85",
        ],
        ["x" * 5000],
    ],
)
def test_a_value_of_thousands_of_characters_is_cut_off(arguments):
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2 and len(result.stderr) < 1000 and "..." in result.stderr


# Work that swallows exceptions, as imports and the deletion of objects do.
STUBBORN = """
import sys, time
from pathlib import Path
from rockdamp import __main__, cli
from rockdamp.storage.files import replace_file

def command(**_):
    with replace_file(Path(sys.argv[1], "answer.nc")):
        print("begun", flush=True)
        try:
            time.sleep(60)
        except BaseException:
            print("it goes on")

cli.main = command
__main__.main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_work_whatever_it_is_at(tmp_path, number):
    process = subprocess.Popen(
        [sys.executable, "-c", STUBBORN, tmp_path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begun\n"
    process.send_signal(number)
    assert process.communicate(timeout=30) == ("", "Aborted!\n")
    assert process.returncode == -number


def test_what_is_said_beside_the_answer_does_not_touch_it_where_standard_error_is_closed(tmp_path):
    command = f"exec {sys.executable} -m rockdamp assess --thickness 1.5 --height 3 --preset new --pga 30"
    command += f" --records {RECORD} --json --plot {tmp_path}/plot.png 2>&-"
    run = subprocess.run(["sh", "-c", command], stdout=subprocess.PIPE, text=True)
    assert run.returncode == 0 and json.loads(run.stdout)["intensity_measure"] == "PGA"
    assert (tmp_path / "plot.png").read_bytes()[:4] == b"\x89PNG"


def test_a_name_that_a_terminal_would_obey_is_shown_as_it_is(tmp_path):
    name = "a\x1b[2J\x9b\udcff.csv"
    wall = ["--thickness", "0.3", "--height", "3"]
    result = CliRunner().invoke(main, ["calibrate", "--record", str(tmp_path / name), *wall])
    assert result.exit_code == 2
    assert "a\\x1b[2J\\x9b\\udcff.csv" in result.stderr
    assert "\x1b" not in result.stderr and "\x9b" not in result.stderr
