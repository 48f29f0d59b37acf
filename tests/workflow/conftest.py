"""The pipeline on a copy of the tree, whose path has a blank and a letter beyond ASCII."""

import shutil

import pytest
from minimal_build import LOGS, RESULTS
from repository import ROOT
from workflow_tree import Tree


@pytest.fixture(scope="session")
def tree(tmp_path_factory, minimal):
    """A copy of the repository and of its minimal results; a test that changes it restores it.

    The results are copied with Snakemake's metadata, and with new times, as `cp -r` does. So
    nothing is to be built, as the tests find first.
    """
    tree = Tree(tmp_path_factory.mktemp("pipeline") / "a träe")
    for built in (RESULTS, LOGS, ".snakemake/metadata"):
        shutil.copytree(ROOT / built, tree.place / built, copy_function=shutil.copy)
    full = tree.place / "results/decay/amplitude.nc"
    full.parent.mkdir(parents=True)
    full.write_text("of the full config", encoding="utf-8")
    return tree


@pytest.fixture
def edit(tree):
    """Replace text in files of the copy during a test; a new file needs a new folder."""
    originals = {}

    def edit(name, old, new):
        path = tree.place / name
        if path not in originals:
            originals[path] = path.read_text(encoding="utf-8") if path.exists() else None
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        assert old in text, (name, old)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return path

    yield edit
    for path, text in originals.items():
        if text is None:
            shutil.rmtree(path.parent, ignore_errors=True)
        else:
            path.write_text(text, encoding="utf-8")
