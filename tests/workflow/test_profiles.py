"""The profiles: what they hand to snakemake, and a dry run on a cluster that need not be there."""

import pytest
import workflow_tree
import yaml
from repository import ROOT


def stated(name):
    return yaml.safe_load((ROOT / f"profiles/{name}/config.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ("default", "slurm"))
def test_snakemake_knows_every_key_of_a_profile(name):
    from snakemake.cli import get_argument_parser

    taken = vars(get_argument_parser(profiles=[str(ROOT / "profiles" / name)]).parse_args([]))
    assert {key.replace("-", "_") for key in stated(name)} <= {key for key, value in taken.items() if value is not None}


def test_a_cluster_is_told_time_and_memory_of_a_job_and_takes_its_processors_from_the_rule():
    resources = stated("slurm")["default-resources"]
    assert {"runtime", "mem_mb"} <= set(resources)
    assert "cpus_per_task" not in resources


def test_the_profile_of_a_cluster_repeats_what_the_other_says():
    """Snakemake reads one of them: another trigger would run everything again after each checkout."""
    default, slurm = stated("default"), stated("slurm")
    assert {"rerun-triggers", "max-checksum-file-size"} <= set(default)
    assert {key: slurm[key] for key in default} == default


@pytest.mark.long
def test_the_earthquakes_are_planned_for_slurm_as_it_is_for_one_machine(tmp_path):
    tree = workflow_tree.Tree(tmp_path / "tree")
    plans = [
        tree.snakemake("earthquakes", "--dry-run", *profile)
        for profile in ((), ("--workflow-profile", "profiles/slurm"))
    ]
    for run in plans:
        assert run.returncode == 0, run.stdout + run.stderr
    here, there = (run.stdout.partition("Job stats:")[2].partition("Reasons:")[0] for run in plans)
    assert "earthquake_records" in here
    assert there.rpartition("Job stats:")[2] == here.rpartition("Job stats:")[2]
