"""What every job does around its call: it works with the sources whose version its result states, or not at all."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from repository import ROOT

from rockdamp.storage import provenance

MODULES = ("rockdamp.errors", "rockdamp.storage.dataset")


@pytest.fixture
def job(monkeypatch, tmp_path):
    """The context of a job, and a description of one whose sources are those of `MODULES`."""
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    import boundary

    described = SimpleNamespace(
        rule="one",
        threads=1,
        log=[str(tmp_path / "one.log")],
        input=SimpleNamespace(code=[str(path) for path in provenance.files_of(*MODULES)]),
        params=SimpleNamespace(version=provenance.code_version(*MODULES)),
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
