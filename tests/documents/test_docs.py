"""The documents: they build without a warning, read without a network, and show the workflow as it is."""

import os
import re
import subprocess
import sys

import nbformat
import pytest
import yaml
from repository import ROOT

import rockdamp
from rockdamp.motions import catalogue

NOTEBOOK = ROOT / "docs/notebooks/explore.ipynb"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The documents as HTML; every broken reference and link within them is an error."""
    folder = tmp_path_factory.mktemp("site")
    options = ["-W", "--keep-going", "--quiet", "-D", "nb_execution_mode=off", "-d", str(folder / "doctrees")]
    run = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, "-b", "html", "docs", str(folder / "html")],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return folder / "html"


def test_no_page_loads_anything_from_the_network(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 15
    for page in pages:
        html = page.read_text(encoding="utf-8")
        loaded = re.findall(r'<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)="([^"]+)"', html)
        assert not [address for address in loaded if re.match(r"(?:https?:)?//", address)], page


def test_formulas_are_markup_that_browsers_draw(site):
    html = (site / "theory.html").read_text(encoding="utf-8")
    assert html.count("<math ") > 100
    assert "\\frac" not in html and "\\int" not in html


def test_every_key_of_the_config_is_on_its_page_with_its_value(site):
    page = (site / "reference/config.html").read_text(encoding="utf-8")
    text = re.sub(r"<[^>]+>", "", page)

    def keys(config, path=()):
        for name, value in config.items():
            yield from keys(value, (*path, name)) if isinstance(value, dict) else [(*path, name)]

    for path in keys(yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))):
        assert ".".join(path) in text, path


def test_every_command_and_public_name_is_on_its_page(site):
    from rockdamp.cli import main

    python, shell = ((site / f"reference/{page}.html").read_text(encoding="utf-8") for page in ("python", "cli"))
    assert all(f'id="rockdamp.{name}"' in python for name in rockdamp.__all__)
    assert all(f'id="rockdamp-{name}"' in shell for name in main.commands)


def test_the_notebook_is_kept_without_outputs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in notebook.cells)


def test_readme_s_first_screen_counts_the_records():
    first = (ROOT / "README.md").read_text(encoding="utf-8").partition("\nOn a machine")[0]
    records = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))["records"]
    assert f"Under {len(catalogue.record_names(records))} earthquake records" in " ".join(first.split())
