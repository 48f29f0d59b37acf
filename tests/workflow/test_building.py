"""A build of the minimal config: its results and targets, refusals, folders, and failures."""

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
    "mechanism",
    "damping_force",
    "decay",
    "match",
    "equivalence",
    "coefficients",
    "response_lengths",
    "calibration",
    "validation",
    "bilinear",
    "convergence",
    "amplitude",
    "earthquakes",
    "comparison",
    "order",
    "loss_law",
    "supports",
    "measured_rocking",
    "claims",
    "report",
    "paper",
    *FIGURES,
]


# --- the build ------------------------------------------------------------------------------------


def test_minimal_config_builds_every_result(tree):
    assert {f"{RESULTS}/{name}" for name in OUTPUTS} <= set(tree.digests(RESULTS))


def test_minimal_build_leaves_the_full_results(tree):
    others = {name for name in tree.digests() if not name.startswith(RESULTS)}
    assert others == {"results/decay/amplitude.nc"}
    text = (tree.place / "results/decay/amplitude.nc").read_text(encoding="utf-8")
    assert text == "of the full config"


@pytest.mark.parametrize("name", DATASETS)
def test_dataset_states_values_and_code(tree, name):
    with xr.open_dataset(tree.place / RESULTS / name) as stored:
        assert json.loads(stored.attrs["config"])
        assert re.fullmatch(r"\d+\.\d+\.\d+\+[0-9a-f]{16}", stored.attrs["code_version"])


def test_dataset_states_the_values_that_it_depends_on(tree):
    with xr.open_dataset(tree.place / RESULTS / "equivalence.nc") as stored:
        config = json.loads(stored.attrs["config"])
    assert config["curve.strength_ratio"] == 0.85
    assert not [key for key in config if key.startswith("earthquakes")]


def test_every_target_is_up_to_date_after_a_build(tree):
    assert tree.jobs(tree.snakemake("--dry-run", "all", *TARGETS)) == {}


def test_paper_needs_no_study_of_earthquakes(tree):
    jobs = tree.jobs(tree.snakemake("--dry-run", "--forceall", "paper"))
    assert {"bilinear", "claims", "paper_page", "fig8"} <= set(jobs)
    assert not [name for name in jobs if name.startswith(("earthquake", "order", "fig_"))]


# --- refusals -------------------------------------------------------------------------------------

REFUSED = {
    "value": ("wall: {thickness: -0.3}", "wall.thickness"),
    "ground motion": ("records: [absent.csv]", "records: no file or record matches 'absent.csv'"),
}


@pytest.mark.parametrize(("overlay", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_config_is_refused_in_a_built_tree(tree, overlay, message):
    """tests/config/test_rules.py has every rule."""
    process = tree.snakemake("--dry-run", overlay=overlay)
    text = process.stdout + process.stderr
    assert process.returncode != 0
    assert message in text
    assert "Traceback" not in text


def test_blank_in_the_path_of_python_is_refused(tree):
    """Snakemake starts jobs by this path in a shell, without quotes."""
    place = tree.place / "blank folder"
    place.symlink_to(sys.prefix)
    command = [place / "bin/python", "-m", "snakemake", "--dry-run", "fig1"]
    process = subprocess.run(
        command, cwd=tree.place, env=tree.environment, capture_output=True, text=True
    )
    place.unlink()
    assert process.returncode != 0
    assert "blanks" in process.stdout + process.stderr
    assert "Traceback" not in process.stdout + process.stderr


def test_blank_in_the_path_stops_make(tmp_path):
    place = tmp_path / "a b"
    place.mkdir()
    shutil.copy(ROOT / "Makefile", place)
    process = subprocess.run(["make", "help"], cwd=place, capture_output=True, text=True)
    assert process.returncode != 0
    (line,) = process.stderr.splitlines()
    assert "has a blank" in line


# --- other folders --------------------------------------------------------------------------------

MODULE = """
configfile: "{root}/config/default.yaml"
configfile: "{root}/config/minimal.yaml"


module rockdamp:
    snakefile:
        "{root}/Snakefile"
    config:
        config


use rule * from rockdamp as rockdamp_*


rule mine:
    default_target: True
    input:
        "results/minimal/mechanism.nc",
        "results/minimal/measured_rocking.nc",
    output:
        "mine.txt",
    shell:
        "ls {{input}} > {{output}}"
"""


def test_workflow_is_a_module_of_another(tree, tmp_path):
    (tmp_path / "Snakefile").write_text(MODULE.format(root=ROOT), encoding="utf-8")
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--nocolor"]
    process = subprocess.run(
        command, cwd=tmp_path, env=tree.environment, capture_output=True, text=True
    )
    assert tree.jobs(process) == {
        "rockdamp_mechanism": 1,
        "rockdamp_measured_rocking": 1,
        "mine": 1,
    }


def test_results_are_built_in_another_directory(tree, tmp_path):
    """Files that are not there, such as the record of this dataset, are those of the project."""
    process = tree.snakemake("--directory", tmp_path, "calibration")
    assert process.returncode == 0, process.stderr
    name = f"{RESULTS}/calibration.nc"
    assert (tmp_path / name).read_bytes() == (tree.place / name).read_bytes()


# --- runs that change or fail ---------------------------------------------------------------------


@pytest.mark.long
def test_one_core_gives_the_same_bytes_as_two(tree):
    names = ["decay/amplitude.nc", "match/amplitude.nc", "response_lengths.nc"]
    files = [f"results/again/{name}" for name in names]
    process = tree.snakemake("--cores", "1", *files, overlay="results: results/again\n")
    assert process.returncode == 0, process.stderr
    again = tree.digests("results/again")
    shutil.rmtree(tree.place / "results/again")
    first = tree.digests(RESULTS)
    assert again == {f"results/again/{name}": first[f"{RESULTS}/{name}"] for name in names}


@pytest.mark.long
def test_failed_job_leaves_its_error_and_no_result(tree):
    (tree.place / "motion.csv").write_text("nothing", encoding="utf-8")
    overlay = "results: results/motion\nvalidation: {record: motion.csv}\n"
    process = tree.snakemake("calibration", overlay=overlay)
    assert process.returncode != 0
    log = (tree.place / "logs/results/motion/calibration.log").read_text(encoding="utf-8")
    error = log.splitlines()[-1]
    assert "motion.csv" in error
    assert error in process.stdout + process.stderr
    assert not (tree.place / "results/motion/calibration.nc").exists()


def test_change_of_a_value_leaves_the_other_results(tree):
    first = tree.digests(RESULTS)
    process = tree.snakemake(overlay="earthquakes: {check: {histories: 5}}")
    assert process.returncode == 0, process.stderr
    second = tree.digests(RESULTS)
    differing = {name for name in second if first.get(name) != second[name]}
    assert f"{RESULTS}/earthquakes/check.nc" in differing
    assert differing <= {f"{RESULTS}/{name}" for name in ("earthquakes/check.nc", "report.html")}
    assert tree.snakemake().returncode == 0  # the first state again, for the other tests
    assert tree.digests(RESULTS) == first


@pytest.mark.long
def test_truncated_dataset_is_refused_by_its_reader(tree):
    path = tree.place / RESULTS / "mechanism.nc"
    content = path.read_bytes()
    os.truncate(path, len(content) // 2)
    process = tree.snakemake("fig1")
    assert process.returncode != 0
    assert f"{RESULTS}/mechanism.nc" in process.stdout + process.stderr
    path.unlink()
    assert tree.snakemake().returncode == 0
    assert path.read_bytes() == content


@pytest.mark.long
def test_killed_build_goes_on_after_unlock(tree):
    (tree.place / "killed.yaml").write_text("results: results/killed\n", encoding="utf-8")
    files = ["config/minimal.yaml", "killed.yaml"]
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "2", "mechanism"]
    command = [*snakemake, "--configfile", *files]
    options = {"cwd": tree.place, "env": tree.environment, "text": True}
    process = subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE, **options)
    assert any("Select jobs to execute" in line for line in process.stderr)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    for option in ("--unlock", "--rerun-incomplete"):
        process = subprocess.run([*command, option], capture_output=True, **options)
        assert process.returncode == 0, process.stderr
    built = (tree.place / "results/killed/mechanism.nc").read_bytes()
    assert built == (tree.place / RESULTS / "mechanism.nc").read_bytes()
    shutil.rmtree(tree.place / "results/killed")


def test_profile_for_slurm_repeats_the_default_one():
    """Snakemake reads one of them: other triggers would rerun every job after a checkout."""
    profiles = {}
    for name in ("default", "slurm"):
        text = (ROOT / f"profiles/{name}/config.yaml").read_text(encoding="utf-8")
        profiles[name] = yaml.safe_load(text)
    assert profiles["default"].items() <= profiles["slurm"].items()


@pytest.mark.long
def test_job_may_not_read_a_value_that_its_rule_does_not_list(tree, edit):
    """Last, as the failed job takes its old result with it."""
    edit("workflow/rules/paper.smk", '"wall", "curve", "validation.wall")', '"wall", "curve")')
    process = tree.snakemake("mechanism")
    assert process.returncode != 0
    log = (tree.place / "logs" / RESULTS / "mechanism.log").read_text(encoding="utf-8")
    assert "AttributeError" in log and "validation" in log
    shutil.rmtree(tree.place / ".snakemake/incomplete", ignore_errors=True)
