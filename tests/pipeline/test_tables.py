"""The tables of stages and of figures: what they name is there, and nothing is missing from them."""

import inspect
import re
import subprocess
import sys
from importlib import import_module

import pytest

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES, each_study, reported, writes
from rockdamp.storage import glossary
from rockdamp.vocabulary import STUDIES

COMPUTED = [name for name, stage in STAGES.items() if stage.dataset]


def function_of(entry):
    module, _, name = entry.function.rpartition(".")
    return getattr(import_module(module), name)


def test_each_dataset_of_the_glossary_is_a_stage_or_written_by_the_command_line():
    datasets = glossary.read()["datasets"]
    assert [name for name, entry in datasets.items() if ("written_by" in entry) == (name in STAGES)] == []
    assert set(COMPUTED) <= set(datasets)


@pytest.mark.parametrize("name", [*STAGES, *FIGURES])
def test_what_a_stage_or_a_figure_is_given_is_written_by_a_stage(name):
    entry = STAGES.get(name) or FIGURES[name]
    for given in entry.inputs:
        assert [stage.name for stage in STAGES.values() if stage.dataset and writes(stage, given)], given


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_takes_its_inputs_in_their_order(name):
    given = inspect.signature(inspect.unwrap(function_of(FIGURES[name]))).parameters
    assert len(given) == len(FIGURES[name].inputs)


@pytest.mark.parametrize("name", COMPUTED)
def test_a_stage_takes_its_wildcards_the_config_its_record_and_its_inputs(name):
    stage = STAGES[name]
    own = [key for key in ("study", "share") if f"{{{key}}}" in stage.file]
    several = [one for one in stage.inputs if "{" in one and not own]
    given = [*own, "config", *filter(None, (stage.record, stage.test_series)), *stage.inputs]
    taken = inspect.signature(function_of(stage)).parameters
    rest = [name for name, one in taken.items() if one.kind is inspect.Parameter.VAR_POSITIONAL]
    assert len(taken) - len(rest) == len(given) - len(several)
    assert bool(rest) == bool(several)


@pytest.mark.parametrize("name", [name for name in COMPUTED if name != "earthquakes"])
def test_a_stage_runs_again_for_the_keys_that_its_settings_read_and_no_others(name):
    function = function_of(STAGES[name])
    parsed = re.findall(r"(\w+)\.of\(config\)", inspect.getsource(function))
    assert parsed
    read = [key for kind in parsed for key in function.__globals__[kind].keys()]
    study = "studies.{study}" if "{study}" in STAGES[name].file else "studies.amplitude"
    told = ["studies" if key == study else key for key in STAGES[name].config]
    assert [key for key in read if not any(f"{key}.".startswith(f"{one}.") for one in told)] == []
    assert [one for one in told if not any(f"{key}.".startswith(f"{one}.") for key in read)] == []


def test_what_only_joins_shares_runs_again_with_any_of_them():
    parts = [key for name in ("earthquake_walls", "earthquake_records") for key in STAGES[name].config]
    assert set(STAGES["earthquakes"].config) == set(parts)


def test_the_report_is_given_every_study_and_no_decays():
    assert {f"match/{study}" for study in STUDIES} <= set(reported())
    assert not {"decay/amplitude", "earthquakes/records-0", "population/walls"} & set(reported())


def test_a_fifth_study_stands_in_every_list(monkeypatch):
    monkeypatch.setitem(STUDIES, "hinge", "hinge_ratio")
    assert each_study("match/{study}")[-1] == "match/hinge" == reported()[reported().index("match/hinge")]
    assert writes(STAGES["decay"], "decay/hinge") and not writes(STAGES["decay"], "decay/height")


def test_what_the_snakefile_reads_at_every_start_takes_no_library_that_loads_for_long():
    script = "import sys; from rockdamp.motions import catalogue; from rockdamp.pipeline import verification"
    script += "; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"xarray", "numba", "matplotlib", "scipy"} & set(run.stdout.split())


def test_a_figure_of_the_paper_has_its_number_and_one_beyond_it_has_none():
    numbers = {name: figure.number for name, figure in FIGURES.items() if figure.number}
    assert list(numbers)[:5] == [f"fig{n}" for n in range(1, 6)]
    assert all(number == f"Fig. {name[3]}" or name == "fig6_error" for name, number in numbers.items())
    assert FIGURES["fig_convergence"].number == ""
