"""The documents as a site: a whole build, pages without network, and complete references."""

import os
import re
import subprocess
import sys

import nbformat
import pytest
import yaml
from nbclient import NotebookClient
from page_blocks import FULL, link_results, make_tree
from repository import ROOT

import rockdamp
from rockdamp.cli import main

NOTEBOOK = ROOT / "docs/notebooks/explore.ipynb"
LOADED = re.compile(r'<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)="([^"]+)"')


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the site; any broken reference or link within it is an error."""
    folder = tmp_path_factory.mktemp("site")
    options = ["-W", "--keep-going", "--quiet", "-b", "html", "-D", "nb_execution_mode=off"]
    folders = ["-d", folder / "doctrees", "docs", folder / "html"]
    run = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, *folders],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return folder / "html"


def read_page(site, name):
    return (site / f"{name}.html").read_text(encoding="utf-8")


def find_keys(config, prefix=""):
    """Return the full names of the keys in nested values."""
    keys = []
    for name, value in config.items():
        if isinstance(value, dict):
            keys += find_keys(value, f"{prefix}{name}.")
        else:
            keys.append(prefix + name)
    return keys


def test_pages_load_nothing_from_the_network(site):
    for path in site.rglob("*.html"):
        for address in LOADED.findall(path.read_text(encoding="utf-8")):
            assert not re.match(r"(?:https?:)?//", address), path


def test_formulas_are_in_mathml(site):
    theory = read_page(site, "theory")
    assert theory.count("<math ") > 50
    assert "\\frac" not in theory


def test_reference_has_every_public_name(site):
    text = read_page(site, "reference/python")
    assert [name for name in rockdamp.__all__ if f'id="rockdamp.{name}"' not in text] == []


def test_reference_has_every_command(site):
    text = read_page(site, "reference/cli")
    assert [name for name in main.commands if f'id="rockdamp-{name}"' not in text] == []


def test_reference_has_every_key_of_the_config(site):
    text = re.sub(r"<[^>]+>", "", read_page(site, "reference/config"))
    config = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))
    assert [key for key in find_keys(config) if key not in text] == []


@pytest.fixture
def tree(tmp_path, request):
    """A copy of the tree with the results of a build."""
    tree = make_tree(tmp_path / "tree")
    link_results(tree, ROOT / "results" if FULL else request.getfixturevalue("minimal"))
    return tree


def test_notebook_runs_and_draws_two_figures(tree, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    monkeypatch.setenv("PYTHONWARNINGS", "error::FutureWarning")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    place = {"metadata": {"path": str(tree.place / "docs/notebooks")}}
    NotebookClient(notebook, timeout=120, kernel_name="python3", resources=place).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
