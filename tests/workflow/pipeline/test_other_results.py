"""Results that another put in place, or damaged: a job that reads one refuses it, and `rockdamp verify` names it."""

import shutil
import subprocess
import sys

import pytest
import xarray as xr
from minimal_build import RESULTS

pytestmark = pytest.mark.long


@pytest.fixture
def kept(tree):
    """Put the results and Snakemake's notes on them back, with their times."""
    copy = tree.place.with_name("kept")
    for name in (RESULTS, ".snakemake/metadata"):
        shutil.copytree(tree.place / name, copy / name)
    yield tree
    for name in (RESULTS, ".snakemake/metadata"):
        shutil.rmtree(tree.place / name, ignore_errors=True)
        shutil.copytree(copy / name, tree.place / name)
    shutil.rmtree(copy)


def verified(tree):
    command = [sys.executable, "-m", "rockdamp", "verify", RESULTS, "--configfile", "config/minimal.yaml"]
    return subprocess.run(command, cwd=tree.place, env=tree.environment, capture_output=True, text=True)


def another_dataset(path):
    with xr.open_dataset(path) as opened:
        other = opened.load()
    other.attrs["config_sha256"] = "0" * 64
    other.to_netcdf(path)


def test_a_job_that_would_read_a_dataset_of_another_config_ends_in_a_line(kept):
    another_dataset(kept.place / RESULTS / "equivalence.nc")
    run = kept.snakemake("coefficients")
    assert run.returncode != 0
    assert f"coefficients: {RESULTS}/equivalence.nc states config_sha256 {'0' * 64}; that of this run is " in run.stderr
    assert not (kept.place / RESULTS / "coefficients.csv").exists()


def test_all_results_of_a_build_are_verified_and_files_of_no_rule_are_named(kept):
    told = verified(kept)
    assert (told.returncode, told.stdout) == (0, ""), told.stdout + told.stderr
    assert told.stderr.endswith(f"{RESULTS}: all results are of this tree\n")
    (kept.place / RESULTS / "thesis.txt").touch()
    told = verified(kept)
    assert (told.returncode, told.stdout) == (1, f"{RESULTS}/thesis.txt is not a result of this config\n")
