"""The command line on a full disk, and beside a notebook's backend."""

import os
import subprocess
import sys

import pytest

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


def test_a_backend_that_is_none_matters_to_no_picture_in_a_file(tmp_path):
    plot = tmp_path / "decay.png"
    command = [sys.executable, "-m", "rockdamp", *DECAY, "--plot", str(plot)]
    run = subprocess.run(command, env={**os.environ, "MPLBACKEND": "junk"}, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert plot.read_bytes().startswith(b"\x89PNG")
