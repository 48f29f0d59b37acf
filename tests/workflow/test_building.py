"""A build of the minimal config: every result, each by its name, the same bytes on one core as on two."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys

import pytest
import xarray as xr
import yaml
from minimal_build import DATASETS, OUTPUTS, RESULTS
from repository import ROOT

from rockdamp.figures import FIGURES

TARGETS = [
    *(
        "mechanism",
        "damping_force",
        "decay",
        "match",
        "equivalence",
        "coefficients",
        "response_lengths",
        "calibration",
    ),
    *(
        "validation",
        "bilinear",
        "convergence",
        "amplitude",
        "earthquakes",
        "comparison",
        "order",
        "loss_law",
    ),
    *("supports", "measured_rocking", "claims", "report", "paper", *FIGURES),
]


def test_the_minimal_config_builds_every_result_and_leaves_the_full_ones_alone(tree):
    assert {f"{RESULTS}/{name}" for name in OUTPUTS} <= set(tree.digests(RESULTS))
    outside = {name for name in tree.digests() if not name.startswith(RESULTS)}
    assert outside == {"results/decay/amplitude.nc"}
    assert (tree.place / "results/decay/amplitude.nc").read_text(
        encoding="utf-8"
    ) == "of the full config"


@pytest.mark.parametrize("name", DATASETS)
def test_a_dataset_says_with_which_values_and_code_it_was_made(tree, name):
    with xr.open_dataset(tree.place / RESULTS / name) as opened:
        assert json.loads(opened.attrs["config"])
        assert re.fullmatch(r"\d+\.\d+\.\d+\+[0-9a-f]{16}", opened.attrs["code_version"])
        if name == "equivalence.nc":
            assert json.loads(opened.attrs["config"])["curve.strength_ratio"] == 0.85


def test_after_a_build_nothing_is_left_to_do_and_every_stage_and_figure_can_be_asked_for_by_name(
    tree,
):
    assert tree.jobs(tree.snakemake("--dry-run", "all", *TARGETS)) == {}


def test_the_paper_needs_no_earthquakes_but_those_of_the_bilinear_curve(tree):
    jobs = tree.jobs(tree.snakemake("--dry-run", "--forceall", "paper"))
    assert {"bilinear", "claims", "paper_page", "fig8"} <= set(jobs)
    assert not [name for name in jobs if name.startswith(("earthquake", "order", "fig_"))]


def test_a_bad_value_ends_the_run_in_one_line_for_each_key(tree):
    run = tree.snakemake("--dry-run", overlay="wall: {thickness: -0.3}\nsolver: {stepp: 0.01}\n")
    text = run.stdout + run.stderr
    assert run.returncode != 0 and "Traceback" not in text
    assert "wall.thickness" in text and "solver.stepp" in text


@pytest.mark.long
def test_one_core_gives_the_same_bytes_as_two(tree):
    overlay = "results: results/again\n"
    names = ["decay/amplitude.nc", "match/amplitude.nc", "response_lengths.nc"]
    run = tree.snakemake(
        "--cores", "1", *(f"results/again/{name}" for name in names), overlay=overlay
    )
    assert run.returncode == 0, run.stderr
    again = tree.digests("results/again")
    shutil.rmtree(tree.place / "results/again")
    first = tree.digests(RESULTS)
    assert again == {f"results/again/{name}": first[f"{RESULTS}/{name}"] for name in names}


@pytest.mark.long
def test_a_failed_job_leaves_its_error_in_its_log_and_on_the_terminal(tree):
    (tree.place / "motion.csv").write_text("nothing", encoding="utf-8")
    run = tree.snakemake(
        "calibration", overlay="results: results/motion\nvalidation: {record: motion.csv}\n"
    )
    assert run.returncode != 0
    log = (tree.place / "logs/results/motion/calibration.log").read_text(encoding="utf-8")
    assert "motion.csv" in log.splitlines()[-1] and log.splitlines()[-1] in run.stdout + run.stderr
    assert not (tree.place / "results/motion/calibration.nc").exists()


def test_a_partial_run_after_a_change_of_the_config_leaves_the_rest(tree):
    before, overlay = tree.digests(RESULTS), "response_lengths: {step: 5}"
    run = tree.snakemake(overlay=overlay)
    assert run.returncode == 0, run.stderr
    after = tree.digests(RESULTS)
    changed = {
        name.removeprefix(f"{RESULTS}/") for name in after if before.get(name) != after[name]
    }
    judged = {"response_lengths.nc", "claims.csv"}  # by the response lengths
    assert changed - {"report.html", "paper.html"} <= judged and "response_lengths.nc" in changed
    assert tree.jobs(tree.snakemake("--dry-run", overlay=overlay)) == {}
    assert tree.snakemake().returncode == 0  # back to the first state, for the other tests
    assert tree.digests(RESULTS) == before


@pytest.mark.long
def test_a_truncated_dataset_is_refused_by_its_reader(tree):
    path = tree.place / RESULTS / "mechanism.nc"
    whole = path.read_bytes()
    os.truncate(path, len(whole) // 2)
    run = tree.snakemake("fig1")
    assert run.returncode != 0
    assert f"{RESULTS}/mechanism.nc" in run.stdout + run.stderr
    path.unlink()
    assert tree.snakemake().returncode == 0
    assert path.read_bytes() == whole


@pytest.mark.long
def test_a_build_that_was_killed_goes_on_after_unlock(tree):
    (tree.place / "killed.yaml").write_text("results: results/killed\n", encoding="utf-8")
    files = ["config/minimal.yaml", "killed.yaml"]
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--cores",
        "2",
        "mechanism",
        "--configfile",
        *files,
    ]
    surroundings = {
        "cwd": tree.place,
        "env": tree.environment,
        "stderr": subprocess.PIPE,
        "text": True,
    }
    process = subprocess.Popen(command, start_new_session=True, **surroundings)
    assert any("Select jobs to execute" in line for line in process.stderr)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    for more in ("--unlock", "--rerun-incomplete"):
        run = subprocess.run([*command, more], **surroundings)
        assert run.returncode == 0, run.stderr
    killed = tree.place / "results/killed"
    assert (killed / "mechanism.nc").read_bytes() == (
        tree.place / RESULTS / "mechanism.nc"
    ).read_bytes()
    shutil.rmtree(killed)


def test_the_profile_for_slurm_repeats_the_default_one():
    """Snakemake reads one of them: other triggers would rerun every job after a checkout."""
    default, slurm = (
        yaml.safe_load((ROOT / f"profiles/{name}/config.yaml").read_text(encoding="utf-8"))
        for name in ("default", "slurm")
    )
    assert {key: slurm[key] for key in default} == default


@pytest.mark.long
def test_a_job_may_not_read_a_value_that_its_rule_does_not_list(tree, edited):
    """Last, as the failed job takes its old result with it."""
    edited(
        "workflow/rules/paper.smk",
        '*settings("wall", "curve", "validation.wall")',
        '*settings("wall", "curve")',
    )
    run = tree.snakemake("mechanism")
    assert run.returncode != 0
    log = (tree.place / "logs" / RESULTS / "mechanism.log").read_text(encoding="utf-8")
    assert "AttributeError" in log and "validation" in log
    shutil.rmtree(tree.place / ".snakemake/incomplete", ignore_errors=True)
