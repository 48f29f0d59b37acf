"""What every job does around its call: bad input is one line, and other datasets or sources end it."""

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import xarray as xr
from configs import stated
from repository import ROOT

from rockdamp.storage import provenance

ORIGIN = {"config_sha256": "c", "code_version": "v"}


@pytest.fixture
def boundary(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    import boundary

    yield boundary
    sys.modules.pop("boundary")


@pytest.fixture
def described(tmp_path, monkeypatch):
    """A description of a job as Snakemake hands it to a script."""
    monkeypatch.chdir(tmp_path)
    sources = provenance.Sources(("rockdamp.errors", "rockdamp.storage.dataset"), "convergence")
    return SimpleNamespace(
        rule="one",
        threads=1,
        log=["one.log"],
        input=SimpleNamespace(datasets=["made.nc"]),
        params=SimpleNamespace(
            sources=sources,
            version=sources.version(),
            attributes={"made.nc": ORIGIN},
        ),
    )


def test_a_job_runs_with_the_sources_that_its_result_states(boundary, described):
    with boundary.job(described):
        print("progress", file=sys.stderr)
    assert Path("one.log").read_text() == "progress\n"


def test_sources_that_were_edited_during_the_run_are_noticed_at_the_end_of_a_job(boundary, described, monkeypatch):
    with pytest.raises(SystemExit, match="1"), boundary.job(described):
        monkeypatch.setattr(provenance, "code_version", lambda *modules, dataset, without: "0.1.0+edited")
        monkeypatch.setenv("ROCKDAMP_RUN_BEGAN", "0")
    was = described.params.version
    assert Path("one.log").read_text().startswith(f"one: the sources are 0.1.0+edited, and they were {was} when this")


def test_without_an_edit_since_the_run_began_nothing_is_read_again(boundary, described, monkeypatch):
    monkeypatch.setattr(provenance, "edited_since", lambda moment: False)
    with boundary.job(described):
        monkeypatch.setattr(provenance, "code_version", None)


def test_bad_input_is_one_line_and_a_mistake_of_ours_a_traceback(boundary, described, capsys):
    for error in (OSError("no space left"), ZeroDivisionError("ours")):
        with pytest.raises(SystemExit, match="1"), boundary.job(described):
            raise error
        told = Path("one.log").read_text()
        assert told == capsys.readouterr().err
        assert (told == "one: no space left\n") == isinstance(error, OSError)


def test_progress_is_in_the_log_line_by_line_and_not_in_what_is_no_terminal(boundary, described, capsys):
    with boundary.job(described):
        sys.stderr.write("\r 50%")
        sys.stderr.write("\r100%")
    assert Path("one.log").read_text() == "50%\n100%\n" and capsys.readouterr().err == ""


def test_a_dataset_of_this_run_is_read(boundary, described):
    xr.Dataset({"x": 1.0}, attrs=ORIGIN).to_netcdf("made.nc")
    with boundary.job(described):
        (opened,) = boundary.open_datasets(described)
        assert opened["x"] == 1.0


@pytest.mark.parametrize("name", ORIGIN)
def test_a_dataset_of_another_config_or_version_is_not_read(boundary, described, name):
    xr.Dataset(attrs={**ORIGIN, name: "0"}).to_netcdf("made.nc")
    with pytest.raises(SystemExit, match="1"), boundary.job(described):
        boundary.open_datasets(described)
    expected = f"one: made.nc states {name} 0; that of this run is {ORIGIN[name]}; delete it and run again\n"
    assert Path("one.log").read_text() == expected


COMPUTE = """
import numpy as np
import xarray as xr

def compute(chunk, config, record, walls, chunks):
    told = f"{chunk} {config.convergence.lanes} {record.step:g} {float(walls.x)} {len(chunks)}"
    dims = ("scheme", "excitation", "damping_model")
    values = {"solver_error": ((*dims, "step"), np.ones((1, 1, 1, 1)))}
    values |= {name: (dims, np.ones((1, 1, 1))) for name in ("convergence_order", "finest_convergence_order")}
    coords = {"scheme": ["newmark"], "excitation": ["free"], "damping_model": ["CR"], "step": [1.0]}
    return xr.Dataset(values, coords, {"told": told})
"""


def test_a_stage_is_given_records_and_datasets_by_the_names_of_its_arguments(boundary, described, monkeypatch):
    Path("made_stage.py").write_text(COMPUTE)
    monkeypatch.syspath_prepend(Path.cwd())
    for name in ("a", "b", "c"):
        xr.Dataset({"x": 1.5}, attrs=ORIGIN).to_netcdf(f"{name}.nc")
    record = str(ROOT / "data/sin-03-00-synthetic.csv")
    described.input = {"record": record, "walls": "a.nc", "chunks": ["b.nc", "c.nc"]}
    described.output = ["made/result.nc"]
    described.wildcards = type("Wildcards", (list,), {"items": lambda self: [("chunk", "1")]})(["1"])
    described.config = stated(minimal=True)
    described.params = SimpleNamespace(
        **vars(described.params),
        function="made_stage.compute",
        kind="convergence",
        config={},
        config_keys=["convergence"],
        records=["record"],
        datasets=["walls", "chunks"],
    )
    described.params.attributes = {f"{name}.nc": ORIGIN for name in ("a", "b", "c")}
    runpy.run_path(str(ROOT / "workflow/scripts/dataset.py"), {"snakemake": described})
    with xr.open_dataset("made/result.nc") as made:
        told = made.attrs["told"].split()
    assert told[:2] == ["1", "64"] and 0 < float(told[2]) < 0.1 and told[3:] == ["1.5", "2"]
