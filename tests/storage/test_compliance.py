"""Written files against the CF conventions, by the IOOS compliance-checker, and by another reader.

`make test-peers` runs this on the datasets that are built, in results/ and results/minimal/.
"""

import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from minimal_build import DATASETS, PART_FILES, RESULTS
from repository import ROOT

pytestmark = pytest.mark.peers

PATHS = [ROOT / folder / name for folder in ("results", RESULTS) for name in DATASETS + PART_FILES]
BUILT = [path for path in PATHS if path.exists()]
needs_build = pytest.mark.skipif(not BUILT, reason="nothing is built in results/")

CURVE = ["--a1", "0.04", "--b1", "0.85", "--damping-model", "CDR", "--damping-ratio", "0.05"]
WALL = ["--thickness", "0.1", "--height", "2.7"]
RECORD = ["--record", ROOT / "data/sin-03-00-synthetic.csv"]
COMMANDS = {"decay": CURVE, "respond": [*CURVE, *WALL, *RECORD]}


@pytest.fixture
def find_errors():
    """Return the checker's errors; its warnings ask for a history, which would state a date."""
    reason = "compliance-checker is absent: `make peers` installs it"
    pytest.importorskip("compliance_checker", reason=reason)
    return run_checker


def run_checker(paths):
    checker = Path(sys.executable).with_name("compliance-checker")
    command = [checker, "--test=cf:1.11", "--criteria=lenient", *paths]
    check = subprocess.run(command, capture_output=True, text=True)
    return "" if check.returncode == 0 else check.stdout + check.stderr


@needs_build
def test_built_datasets_have_no_error(find_errors):
    assert find_errors(BUILT) == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_output_of_a_command_has_no_error(command, find_errors, tmp_path):
    path = tmp_path / "output.nc"
    options = [*COMMANDS[command], "--output", path]
    program = [sys.executable, "-m", "rockdamp", command, *options]
    subprocess.run(program, check=True, capture_output=True)
    assert find_errors([path]) == ""


@needs_build
@pytest.mark.parametrize("path", BUILT, ids=lambda path: str(path.relative_to(ROOT)))
def test_h5netcdf_reads_the_same(path):
    for library in ("h5netcdf", "h5py"):
        reason = f"{library} is absent: `make peers` installs it"
        pytest.importorskip(library, reason=reason)
    with (
        xr.open_dataset(path, engine="h5netcdf") as stored,
        xr.open_dataset(path, engine="netcdf4") as expected,
    ):
        xr.testing.assert_identical(stored.load(), expected.load())
