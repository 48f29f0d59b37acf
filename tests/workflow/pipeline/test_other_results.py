"""Results that another put in place: a job that reads one refuses it."""

import shutil

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
