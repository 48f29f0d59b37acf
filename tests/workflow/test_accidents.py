"""Accidents: damaged results and kills."""

import os
import shutil
import signal
import subprocess
import sys

import pytest
from minimal_build import RESULTS

pytestmark = pytest.mark.long


def test_a_truncated_dataset_is_refused_by_who_reads_it_and_built_again_once_it_is_deleted(tree):
    before = tree.digests(RESULTS)
    path = tree.place / RESULTS / "mechanism.nc"
    os.truncate(path, path.stat().st_size // 2)
    run = tree.snakemake("fig1")
    assert run.returncode != 0
    assert f"{RESULTS}/mechanism.nc" in run.stdout + run.stderr
    path.unlink()
    assert tree.snakemake().returncode == 0
    assert tree.digests(RESULTS) == before


def test_a_run_beside_another_or_after_a_kill_is_told_of_the_lock_and_goes_on_without_it(tree):
    overlay = tree.place / "killed.yaml"
    overlay.write_text("results: results/killed\n", encoding="utf-8")
    files = ["config/minimal.yaml", overlay.name]
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "mechanism", "--configfile", *files]
    process = subprocess.Popen(
        command, cwd=tree.place, env=tree.environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert any("Select jobs to execute" in line for line in process.stderr)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    second = subprocess.run(command, cwd=tree.place, env=tree.environment, capture_output=True, text=True)
    assert second.returncode != 0
    assert "Directory cannot be locked" in second.stderr and "--unlock" in second.stderr
    for more in (["--unlock"], ["--rerun-incomplete"]):
        run = subprocess.run([*command, *more], cwd=tree.place, env=tree.environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
    built = tree.digests("results/killed")
    shutil.rmtree(tree.place / "results/killed")
    assert built["results/killed/mechanism.nc"] == tree.digests(RESULTS)[f"{RESULTS}/mechanism.nc"]
