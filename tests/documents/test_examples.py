"""Every example in a docstring, the README, the documents' first page and the notebook, run as it stands."""

import doctest
import inspect
import os
import re
import shlex
import subprocess
import sys
from importlib import import_module
from pkgutil import walk_packages

import nbformat
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from configs import configured
from nbclient import NotebookClient
from repository import ROOT
from rounded_texts import alike

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.storage import dataset
from rockdamp.studies import decays, polynomial_fits
from rockdamp.studies.matches import match

MODULES = ["rockdamp", *sorted(module.name for module in walk_packages(rd.__path__, "rockdamp."))]
MODULES = [name for name in MODULES if not name.endswith(".__main__")]  # which would run


class Checker(doctest.OutputChecker):
    """Numbers count as values."""

    def check_output(self, want, got, optionflags):
        return alike(want, got) or super().check_output(want, got, optionflags)


@pytest.mark.no_cover
@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_print_what_they_say(name):
    runner = doctest.DocTestRunner(Checker(), optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder().find(import_module(name)):
        assert runner.run(example).failed == 0


@pytest.mark.parametrize("name", [name for name in rd.__all__ if inspect.isfunction(getattr(rd, name))])
def test_every_public_function_has_an_example(name):
    assert doctest.DocTestFinder(recurse=False).find(getattr(rd, name), name)[0].examples


@pytest.fixture(scope="module")
def small_results(tmp_path_factory):
    """A folder `results` with the datasets that README and the notebook open, of the minimal config."""
    config = configured({"response_lengths": {"stop": 12}}, minimal=True)
    folder = tmp_path_factory.mktemp("pages") / "results"
    matched = {}
    for study in ("amplitude", "cracked_stiffness"):
        matched[study] = match(study, config, decays.study(study, config))
        dataset.write(matched[study], folder / f"match/{study}.nc", "match", config={}, code_version="test")
    fits = polynomial_fits.fit(config, matched["cracked_stiffness"])
    dataset.write(fits, folder / "equivalence.nc", "equivalence", config={}, code_version="test")
    return folder


PAGES = ("README.md", "docs/index.md")


@pytest.mark.no_cover
def test_the_commands_of_the_first_pages_run(tmp_path, monkeypatch):
    """Each `rockdamp ...` of README and of the documents' first page, beside the shipped data and examples."""
    monkeypatch.chdir(tmp_path)
    for folder in ("data", "examples"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    for page in PAGES:
        text = (ROOT / page).read_text(encoding="utf-8").replace("\\\n", " ")
        commands = re.findall(r"(?:^|[`$] ?)\.venv/bin/rockdamp ([^`\n]+)", text, re.MULTILINE)
        assert commands, page
        for command in commands:
            result = CliRunner().invoke(main, shlex.split(command))
            assert result.exit_code == 0, (page, command, result.output)


def python_blocks():
    for page in PAGES:
        blocks = re.findall(
            r"^```python\n(.*?)^```$", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
        )
        yield from (pytest.param(block, id=f"{page} {number}") for number, block in enumerate(blocks, 1))


@pytest.mark.no_cover
@pytest.mark.parametrize("block", list(python_blocks()))
def test_the_python_of_a_page_runs(block, small_results):
    """In an interpreter of its own, where nothing is imported yet."""
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", block],
        cwd=small_results.parent,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    if "print" in block:
        assert re.search(r"\d\.\d+", run.stdout)


def test_the_notebook_runs_on_the_datasets(small_results, monkeypatch):
    """In `docs/notebooks` beside a `results` folder, as its readers run it; what it draws is checked to be figures."""
    place = small_results.parent / "docs/notebooks"
    place.mkdir(parents=True, exist_ok=True)
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    monkeypatch.setenv("PYTHONWARNINGS", "error::FutureWarning")
    notebook = nbformat.read(ROOT / "docs/notebooks/explore.ipynb", as_version=4)
    NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(place)}}).execute()
    drawn = [
        output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})
    ]
    assert len(drawn) == 2


def test_raw_channels_become_a_record(tmp_path):
    """The noise of 100 Hz is gone, the wall is relative to the table, and zeros are those of the rest."""
    elapsed = np.arange(1024) / 256
    shaken = np.sin(4 * np.pi * elapsed) * np.exp(-(((elapsed - 2) / 0.4) ** 2))
    noise = 0.01 * np.sin(200 * np.pi * elapsed)
    channels = {"t": elapsed, "a": 0.5 * shaken + noise + 0.012, "wall": 30 * shaken + 5, "table": 10 * shaken + 3.1}
    pd.DataFrame(channels).to_csv(tmp_path / "raw.csv", index=False)
    files = [str(tmp_path / name) for name in ("raw.csv", "test.csv")]
    subprocess.run([sys.executable, str(ROOT / "examples/raw_channels.py"), *files], check=True)
    record = rd.read_record(files[1])
    np.testing.assert_allclose(record.elapsed, elapsed, atol=1e-12)
    inside = slice(50, -50)
    np.testing.assert_allclose(record.ground_acceleration[inside], 0.5 * 9.80665 * shaken[inside], atol=1e-3)
    np.testing.assert_allclose(record.displacement[inside], 0.02 * shaken[inside], atol=1e-6)


ESM = "STATION_CODE: X\nSAMPLING_INTERVAL_S: 0.010000\nUNITS: cm/s^2\n0.0\n-150.0\n25.0\n"
KNET = (
    "Origin Time       2011/03/11 14:46:00\nSampling Freq(Hz) 100Hz\nScale Factor      2000(gal)/8000000\nMemo.\n"
    "    1000     4000\n   -2000\n"
)
V2 = (
    "Corrected accelerogram\n    3 points of accel data equally spaced at  .010 sec, in cm/sec2. (UNITS)\n"
    "     .000  -150.000    25.000\n    3 points of veloc data equally spaced at  .010 sec, in cm/sec.\n 1.0 2.0 3.0\n"
)


@pytest.mark.parametrize(
    ("name", "text", "expected", "written"),
    [
        ("a.ASC", ESM, [0.0, -1.5, 0.25], "a.csv"),
        ("a.V2", V2, [0.0, -1.5, 0.25], "a.V2.csv"),
        ("a.EW", KNET, [0.0, 0.0075, -0.0075], "a.EW.csv"),  # a mean of 1000 counts, each 2.5e-6 m s-2
    ],
)
def test_records_of_networks_are_converted(tmp_path, name, text, expected, written):
    (tmp_path / name).write_text(text, encoding="utf-8")
    command = [sys.executable, str(ROOT / "examples/convert_records.py"), str(tmp_path / name)]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    record = rd.read_record(tmp_path / written)
    np.testing.assert_allclose(record.ground_acceleration, expected, atol=1e-15)
    assert record.step == pytest.approx(0.01)
    other = text.replace("UNITS", "UNIT").replace("Scale", "Scales").replace("3 points", "4 points")
    (tmp_path / name).write_text(other, encoding="utf-8")
    refused = subprocess.run(command, capture_output=True, check=False, text=True)
    assert refused.returncode == 1 and ("no record of ESM" in refused.stderr or "states 4" in refused.stderr)


def test_a_record_that_was_cut_off_is_told(tmp_path):
    (tmp_path / "a.ASC").write_text(f"NDATA: 4\n{ESM}", encoding="utf-8")
    command = [sys.executable, str(ROOT / "examples/convert_records.py"), str(tmp_path / "a.ASC")]
    assert "3 accelerations and states 4" in subprocess.run(command, capture_output=True, text=True).stderr
