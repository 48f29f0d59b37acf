"""The pipeline, run as its users run it, on a copy of the tree whose path has a space and a letter beyond ASCII."""

import shutil

import pytest
from minimal_build import LOGS, RESULTS
from repository import ROOT
from workflow_tree import Tree


@pytest.fixture(scope="session")
def tree(tmp_path_factory, minimal):
    """A copy of the repository and of its minimal results; a test that changes it puts it back.

    The results are copied with Snakemake's notes on them, as `cp -r` would, with new times.
    """
    tree = Tree(tmp_path_factory.mktemp("pipeline") / "a träe")
    for built in (RESULTS, LOGS, ".snakemake/metadata"):
        shutil.copytree(ROOT / built, tree.place / built, copy_function=shutil.copy)
    full = tree.place / "results/decay/amplitude.nc"
    full.parent.mkdir(parents=True)
    full.write_text("of the full config", encoding="utf-8")
    run = tree.snakemake()
    assert run.returncode == 0, run.stdout + run.stderr
    return tree


@pytest.fixture
def edited(tree):
    """Write files of the copy, for the length of a test."""
    kept = {}

    def edit(name, old, new):
        path = tree.place / name
        kept.setdefault(path, path.read_text(encoding="utf-8") if path.exists() else None)
        text = kept[path] or ""
        assert old in text, (name, old)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    yield edit
    for path, text in kept.items():
        if text is None:
            shutil.rmtree(path.parent)  # that it was made in
        else:
            path.write_text(text, encoding="utf-8")
