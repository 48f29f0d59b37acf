"""The documents as a site: it builds without a warning, needs no network, and has every key,
command and name.
"""

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


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The documents as HTML; every broken reference and link within them is an error."""
    folder = tmp_path_factory.mktemp("site")
    options = [
        "-W",
        "--keep-going",
        "--quiet",
        "-D",
        "nb_execution_mode=off",
        "-d",
        str(folder / "doctrees"),
    ]
    command = [sys.executable, "-m", "sphinx", *options, "-b", "html", "docs", str(folder / "html")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    run = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return folder / "html"


def find_keys(config, path=()):
    for name, value in config.items():
        yield from (
            find_keys(value, (*path, name))
            if isinstance(value, dict)
            else [".".join((*path, name))]
        )


def test_the_site_is_whole_without_a_network(site):
    for page in site.rglob("*.html"):
        loaded = re.findall(
            r'<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)="([^"]+)"', page.read_text("utf-8")
        )
        assert not [address for address in loaded if re.match(r"(?:https?:)?//", address)], page
    theory, python, shell, config = (
        (site / f"{page}.html").read_text("utf-8")
        for page in ("theory", "reference/python", "reference/cli", "reference/config")
    )
    assert theory.count("<math ") > 50 and "\\frac" not in theory
    assert all(f'id="rockdamp.{name}"' in python for name in rockdamp.__all__)
    assert all(f'id="rockdamp-{name}"' in shell for name in main.commands)
    text = re.sub(r"<[^>]+>", "", config)
    assert all(
        key in text
        for key in find_keys(yaml.safe_load((ROOT / "config/default.yaml").read_text("utf-8")))
    )


def test_the_notebook_runs(tmp_path, request, monkeypatch):
    tree = make_tree(tmp_path / "tree")
    link_results(tree, ROOT / "results" if FULL else request.getfixturevalue("minimal"))
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    monkeypatch.setenv("PYTHONWARNINGS", "error::FutureWarning")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    place = {"metadata": {"path": str(tree.place / "docs/notebooks")}}
    NotebookClient(notebook, timeout=120, kernel_name="python3", resources=place).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
