"""The profiles: what they hand to snakemake, and a dry run on a cluster that need not be there."""

import pytest
import workflow_tree
import yaml
from repository import ROOT

PROFILES = ("default", "slurm")


def stated(name):
    read = yaml.safe_load((ROOT / f"profiles/{name}/config.yaml").read_text(encoding="utf-8"))
    return {key: value for key, value in read.items() if not key.startswith("__")}  # what Snakemake is not handed


@pytest.mark.parametrize("name", PROFILES)
def test_snakemake_knows_every_key_of_a_profile_and_takes_its_value(name):
    from snakemake.cli import get_argument_parser

    taken = vars(get_argument_parser(profiles=[str(ROOT / "profiles" / name)]).parse_args([]))
    settings = stated(name)
    assert settings
    for key, value in settings.items():
        given = taken[key.replace("-", "_")]
        if isinstance(value, dict):
            assert set(value) <= set(given), key
        else:
            assert str(given) == str(value), key


def test_a_cluster_is_told_time_and_memory_of_a_job_and_takes_its_processors_from_the_rule():
    resources = stated("slurm")["default-resources"]
    assert {"runtime", "mem_mb"} <= set(resources)
    assert "cpus_per_task" not in resources


def test_both_profiles_agree_on_what_is_no_matter_of_the_place():
    default, slurm = stated("default"), stated("slurm")
    assert {key: slurm[key] for key in default if key != "keep-going"} == {
        key: value for key, value in default.items() if key != "keep-going"
    }


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
