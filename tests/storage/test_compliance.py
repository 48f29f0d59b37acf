"""The written files against the CF conventions, by the IOOS compliance-checker, and read by another library.

`make test-peers` runs this on whatever stands among the results, so build something first.
"""

import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from minimal_build import DATASETS, RESULTS
from repository import ROOT

from rockdamp.storage import dataset

pytestmark = pytest.mark.peers

PLACES = [ROOT / folder / name for folder in ("results", RESULTS) for name in DATASETS]
BUILT = [path for path in PLACES if path.exists()]


@pytest.fixture
def complaints():
    """Errors of the checker; its warnings ask for a history, which would hold the time of the build."""
    pytest.importorskip(
        "compliance_checker", reason="compliance-checker is absent: `make peers` installs it"
    )

    def errors(paths):
        command = [
            Path(sys.executable).with_name("compliance-checker"),
            "--test=cf:1.11",
            "--criteria=lenient",
            *paths,
        ]
        run = subprocess.run(command, capture_output=True, text=True)
        return "" if run.returncode == 0 else run.stdout + run.stderr

    return errors


@pytest.mark.skipif(not BUILT, reason="nothing is built in results/")
def test_no_dataset_of_a_build_has_an_error(complaints):
    assert complaints(BUILT) == ""


def test_what_the_command_line_writes_has_no_error(complaints, tmp_path):
    paths = []
    for kind in ("decay", "respond"):
        paths.append(tmp_path / f"{kind}.nc")
        shape = [
            "--a1",
            "0.04",
            "--b1",
            "0.85",
            "--damping-model",
            "CDR",
            "--damping-ratio",
            "0.05",
        ]
        wall = [
            "--record",
            ROOT / "data/sin-03-00-synthetic.csv",
            "--thickness",
            "0.1",
            "--height",
            "2.7",
        ]
        command = [
            sys.executable,
            "-m",
            "rockdamp",
            kind,
            *shape,
            *(wall if kind == "respond" else []),
        ]
        subprocess.run([*command, "--output", paths[-1]], check=True, capture_output=True)
    assert complaints(paths) == ""


@pytest.mark.skipif(not BUILT, reason="nothing is built in results/")
def test_h5netcdf_reads_the_same():
    for name in ("h5netcdf", "h5py"):
        pytest.importorskip(name, reason=f"{name} is absent: `make peers` installs it")
    for path in BUILT:
        with xr.open_dataset(path, engine="h5netcdf") as other:
            xr.testing.assert_identical(other.load(), dataset.read(path))
