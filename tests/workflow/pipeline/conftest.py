"""The pipeline, run as its users run it, on a copy of the tree whose path has a space and a letter beyond ASCII."""

import shutil

import pytest
from minimal_build import LOGS, RESULTS
from repository import ROOT
from workflow_tree import Tree


@pytest.fixture(scope="session")
def tree(tmp_path_factory):
    """The minimal pipeline, built once; a test that changes the copy puts it back.

    What of it is built already is taken along with snakemake's notes on it, which tell what of that still holds.
    """
    tree = Tree(tmp_path_factory.mktemp("pipeline") / "a träe")
    for built in (RESULTS, LOGS, ".snakemake/metadata"):
        if (ROOT / RESULTS).is_dir() and (ROOT / built).is_dir():
            shutil.copytree(ROOT / built, tree.place / built)
    full = tree.place / "results/decay/amplitude.nc"
    full.parent.mkdir(parents=True)
    full.write_text("of the full config", encoding="utf-8")
    run = tree.snakemake()
    assert run.returncode == 0, run.stdout + run.stderr
    return tree


@pytest.fixture
def edited(tree):
    """Edit a file of the copy, for the length of a test."""
    kept = {}

    def edit(name, change):
        path = tree.place / name
        kept.setdefault(path, path.read_text(encoding="utf-8"))
        path.write_text(change(kept[path]), encoding="utf-8")

    yield edit
    for path, text in kept.items():
        path.write_text(text, encoding="utf-8")
