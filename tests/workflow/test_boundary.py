"""What every job does around its call: it works with the sources whose version its result states, or not at all."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from repository import ROOT

from rockdamp.pipeline import soundness
from rockdamp.storage import dataset, notes, provenance


class Named(SimpleNamespace):
    """Files with names, as Snakemake gives them to a script."""

    def __iter__(self):
        for files in vars(self).values():
            yield from [files] if isinstance(files, str) else files


MODULES = ("rockdamp.errors", "rockdamp.storage.dataset")


@pytest.fixture
def job(monkeypatch, tmp_path):
    """The context of a job, and a description of one whose sources are those of `MODULES`."""
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    import boundary

    monkeypatch.chdir(tmp_path)
    config, states = {"results": "results", "figures": {}}, soundness.STATES / "results"
    made = soundness.Result("made", ("made.nc",), "0.1.0+made", provenance.config_digest({}), "calibration")
    one = soundness.Result("one", ("one.csv",), provenance.code_version(*MODULES), provenance.config_digest({}))
    soundness.tell("results", states, config, [made, one])
    described = SimpleNamespace(
        rule="one",
        threads=1,
        log=["one.log"],
        config=config,
        input=Named(code=[str(path) for path in provenance.files_of(*MODULES)], state=str(states / "one.json")),
        output=["results/one.csv"],
        params=SimpleNamespace(version=one.code_version),
    )
    yield boundary.job, described
    sys.modules.pop("boundary")


def test_a_job_runs_with_the_sources_that_its_result_states(job):
    context, described = job
    with context(described):
        done = True
    assert done and Path(described.log[0]).read_text() == ""


def test_a_job_with_other_sources_stops_before_it_begins(job):
    context, described = job
    now, described.params.version = described.params.version, "0.1.0+0123456789abcdef"
    begun = False
    with pytest.raises(SystemExit, match="1"), context(described):
        begun = True
    assert not begun
    (line,) = Path(described.log[0]).read_text().splitlines()
    assert line.startswith(f"one: the sources are {now}, and 0.1.0+0123456789abcdef when this run began; leave them")


def test_sources_that_change_while_a_job_runs_are_noticed_at_its_end(job, monkeypatch):
    context, described = job
    with pytest.raises(SystemExit, match="1"), context(described):
        monkeypatch.setattr(provenance, "version_of", lambda paths: "0.1.0+edited")
    assert "the sources are 0.1.0+edited" in Path(described.log[0]).read_text()


# --- what it reads and leaves -----------------------------------------------------------------------------------------


@pytest.fixture
def made(job):
    """A dataset that another job made, which this one reads."""
    _, described = job
    fitted = xr.Dataset(
        {name: (tuple(entry["dims"]), np.zeros([1] * len(entry["dims"]))) for name, entry in VARIABLES.items()}
    )
    path = "results/made.nc"
    dataset.write(fitted.assign_coords(parameter=["a1"]), path, "calibration", config={}, code_version="0.1.0+made")
    noted(path)
    described.input.datasets = [path]
    return Path(path)


VARIABLES = {name: entry for name, entry in dataset.variables("calibration").items() if name != "parameter"}


def noted(path):
    given = {"code_version": "0.1.0+made", "config_sha256": provenance.config_digest({}), "files": [path], "inputs": {}}
    notes.write("results", "made", **given)


def test_a_job_leaves_a_note_of_what_it_made_and_of_what(job, made):
    context, described = job
    with context(described) as given:
        assert given.open(str(made)).sizes["parameter"] == 1
        Path("results/one.csv").write_text("1", encoding="utf-8")
    note = notes.read("results", "one")
    assert note["files"] == {"./one.csv": notes.digest("results/one.csv")}
    assert note["inputs"] == {"./made.nc": notes.digest(made)}
    assert note["code_version"] == described.params.version


def test_a_job_that_fails_leaves_no_note(job):
    context, described = job
    with pytest.raises(SystemExit, match="1"), context(described):
        raise OSError("no space left")
    assert notes.read("results", "one") == {}


def test_a_result_that_was_changed_since_is_not_read(job, made):
    context, described = job
    made.write_bytes(made.read_bytes() + b"1")
    begun = False
    with pytest.raises(SystemExit, match="1"), context(described):
        begun = True
    assert not begun
    said = Path("one.log").read_text()
    assert said == "one: results/made.nc is not what its rule wrote, by its digest; delete it and run again\n"


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda found: found.attrs.update(config_sha256="0"), "states config_sha256 0; that of this run is 44136fa355"),
        (lambda found: found.attrs.update(code_version="0"), "states code_version 0; that of this run is 0.1.0+made"),
        (lambda found: found.update({"more": 1.0}), "is not what its rule writes (calibration: not in the registry"),
    ],
)
def test_a_dataset_of_another_kind_config_or_version_is_not_read(job, made, change, expected):
    context, described = job
    found = dataset.open(made)
    change(found)
    found.to_netcdf(made)
    noted(made)
    with pytest.raises(SystemExit, match="1"), context(described) as given:
        given.open(str(made))
    said = Path("one.log").read_text()
    assert said.startswith(f"one: results/made.nc {expected}") and said.endswith("; delete it and run again\n")
