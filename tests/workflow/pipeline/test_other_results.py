"""A result that its rule did not make in this tree counts as missing, whatever Snakemake remembers of it."""

import os
import shutil
import subprocess
import sys

import pytest
import xarray as xr
from minimal_build import RESULTS
from pipeline_graph import jobs_after

pytestmark = pytest.mark.workflow


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


def verified(tree, *arguments):
    command = [sys.executable, "-m", "rockdamp", "verify", RESULTS, "--configfile", "config/minimal.yaml", *arguments]
    return subprocess.run(command, cwd=tree.place, env=tree.environment, capture_output=True, text=True)


def disguised(path, change):
    """Change a file, and set its times back to what they were."""
    before = path.stat()
    change(path)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def another_dataset(path):
    with xr.open_dataset(path) as opened:
        other = opened.load()
    other.attrs["config_sha256"] = "0" * 64
    other.to_netcdf(path)


CHANGES = {
    "equivalence.nc": another_dataset,
    "coefficients.csv": lambda path: path.write_text(path.read_text().replace("0.", "nan", 1)),
    "figures/fig1.png": lambda path: os.truncate(path, path.stat().st_size // 2),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_file_that_another_put_in_place_is_built_again(kept, name):
    before = kept.digests(RESULTS)
    disguised(kept.place / RESULTS / name, CHANGES[name])
    said = verified(kept)
    assert said.returncode == 1 and f"{RESULTS}/{name} is not what was written, by its digest\n" in said.stdout
    stage = os.path.splitext(os.path.basename(name))[0]
    assert kept.planned() == jobs_after(stage)
    run = kept.snakemake("coefficients", "fig1", "--rerun-triggers", "mtime")
    assert run.returncode == 0, run.stderr
    assert kept.digests(RESULTS)[f"{RESULTS}/{name}"] == before[f"{RESULTS}/{name}"]


def test_a_changed_config_is_noticed_without_anything_that_snakemake_remembers(kept):
    # Without its metadata Snakemake judges by times alone, and another test may have built an input again.
    assert kept.snakemake("--touch", "--forceall").returncode == 0
    shutil.rmtree(kept.place / ".snakemake/metadata")
    assert kept.planned() == {}
    overlay = "curve: {cracked_stiffness_ratio: 0.05}"
    jobs = kept.planned(overlay)
    assert {"decay_study", "windows", "loops", "mechanism"} <= set(jobs)
    run = kept.snakemake("--dry-run", "--rerun-triggers", "mtime", overlay=overlay)
    assert "Nothing to be done" not in run.stdout + run.stderr
    assert kept.planned() == {}


def test_all_results_of_a_build_are_verified_and_what_is_not_of_it_is_named(kept):
    said = verified(kept)
    assert (said.returncode, said.stdout) == (0, ""), said.stdout + said.stderr
    assert said.stderr.endswith(f"{RESULTS}: all results are of this tree\n")
    run = kept.snakemake("verify")
    assert run.returncode == 0, run.stderr
    (kept.place / RESULTS / "thesis.txt").touch()
    run = kept.snakemake("verify")
    assert run.returncode != 0
    assert f"verify: {RESULTS}/thesis.txt is of no rule of this config\n" in run.stderr
