"""The minimal config with every list at its shortest: whatever the config accepts must build."""

import copy
import shutil

import pytest
import yaml
from configs import merge_files
from repository import ROOT

from rockdamp.config.rules import parse_config
from rockdamp.errors import InputError

SHORTEST = (ROOT / "tests/data/shortest.yaml").read_text(encoding="utf-8")
VALUES = merge_files(yaml.safe_load(SHORTEST), minimal=True)


def find_lists(values, *path):
    """Return the paths of the lists in nested values."""
    paths = []
    for key, value in values.items():
        if isinstance(value, dict):
            paths += find_lists(value, *path, key)
        elif isinstance(value, list):
            paths.append((*path, key))
    return paths


@pytest.fixture(autouse=True)
def in_the_project(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_shortest_lists_are_accepted():
    parse_config(VALUES, ROOT)


@pytest.mark.parametrize("path", find_lists(VALUES), ids=".".join)
def test_shorter_list_is_refused(path):
    values = copy.deepcopy(VALUES)
    section = values
    for key in path[:-1]:
        section = section[key]
    section[path[-1]].pop()
    with pytest.raises(InputError):
        parse_config(values, ROOT)


@pytest.mark.long
def test_shortest_lists_build(tree):
    process = tree.snakemake("--keep-going", overlay=SHORTEST)
    assert process.returncode == 0, process.stdout + process.stderr
    shutil.rmtree(tree.place / "results/shortest")
