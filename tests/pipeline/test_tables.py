"""The tables of stages and of figures: what they name is there, and nothing is missing from them."""

import inspect
import re
import subprocess
import sys
from importlib import import_module

import pytest
import yaml

from rockdamp.errors import InputError
from rockdamp.pipeline.tables import FIGURES, STAGES, all_stages, drawings, each_study, reported, writes
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


ENTRY = {"module": "figures.new", "inputs": ["match/amplitude"], "title": "New", "alternative": "Points."}


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        (ENTRY | {"inputs": ["slenderness"]}, "no stage writes; did you mean decay/slenderness or match/slenderness?"),
        (ENTRY | {"inputs": ["earthquake"]}, "no stage writes; did you mean earthquakes?"),
        (ENTRY | {"datasets": []}, "has datasets; its fields are module, inputs, title, alternative"),
        ({"module": "figures.new", "data": []}, "lacks inputs, title, alternative and has data; its fields"),
    ],
)
def test_an_error_names_what_is_wrong_with_a_figure_s_entry(monkeypatch, entry, error):
    monkeypatch.setattr(yaml, "safe_load", lambda text: {"fig_new": entry})
    with pytest.raises(InputError, match=re.escape(error)):
        drawings()


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ({"inputs": ["mechanisms"]}, "stages.yaml: new has the input 'mechanisms', which no stage writes"),
        ({"function": "rockdamp.new", "entry": 1}, "stages.yaml: new has entry; its fields are title, file"),
    ],
)
def test_an_error_names_what_is_wrong_with_a_stage_s_entry(monkeypatch, entry, error):
    monkeypatch.setattr(glossary, "read", lambda: {"datasets": {"new": {"title": "New"}}})
    monkeypatch.setattr(yaml, "safe_load", lambda text: {"new": {"file": "new.nc"} | entry})
    with pytest.raises(InputError, match=re.escape(error)):
        all_stages()


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_takes_its_inputs_in_their_order(name):
    given = inspect.signature(inspect.unwrap(function_of(FIGURES[name]))).parameters
    assert len(given) == len(FIGURES[name].inputs)


@pytest.mark.parametrize("name", COMPUTED)
def test_a_stage_takes_its_wildcards_the_config_and_its_inputs_by_their_names(name):
    stage = STAGES[name]
    wildcards = [key for key in ("study", "chunk") if f"{{{key}}}" in stage.file]
    taken = list(inspect.signature(function_of(stage)).parameters)
    assert taken[len(wildcards)] == "config"
    assert set(taken[len(wildcards) + 1 :]) == {*stage.records, *stage.inputs}


READ = re.compile(r"(?<!\.)\bconfig\.(\w+)")
OF_A_STUDY = {"study": {"studies", "wall", "curve", "release_amplitude"}}  # what config.study(name) reads


@pytest.mark.parametrize("module", sorted({stage.function.rpartition(".")[0] for stage in STAGES.values()}))
def test_the_stages_of_a_module_name_the_sections_that_it_reads(module):
    """That a stage reads no key beyond those, the build sees: it is given no others."""
    stages = [stage for stage in STAGES.values() if stage.function.startswith(f"{module}.") and stage.dataset]
    read = set(READ.findall(inspect.getsource(import_module(module))))
    read |= set().union(*(OF_A_STUDY[name] for name in read & OF_A_STUDY.keys())) - {"study"}
    named = {re.split(r"[.]", key)[0] for stage in stages for key in stage.config}
    assert read - {"study"} <= named


def test_what_only_joins_chunks_runs_again_with_any_of_them():
    parts = [key for name in ("earthquake_walls", "earthquake_records") for key in STAGES[name].config]
    assert set(STAGES["earthquakes"].config) == set(parts)


def test_the_report_is_given_every_study_and_no_decays():
    assert {f"match/{study}" for study in STUDIES} <= set(reported(STAGES.values()))
    assert not {"decay/amplitude", "earthquakes/records-0"} & set(reported(STAGES.values()))


def test_a_fifth_study_stands_in_every_list(monkeypatch):
    monkeypatch.setitem(STUDIES, "hinge", "hinge_ratio")
    assert each_study("match/{study}")[-1] == "match/hinge"
    assert "match/hinge" in reported(STAGES.values())
    assert writes(STAGES["decay"], "decay/hinge") and not writes(STAGES["decay"], "decay/height")


def test_what_the_snakefile_reads_at_every_start_takes_no_library_that_loads_for_long():
    script = "import sys; from rockdamp.motions import catalogue; from rockdamp.pipeline import origins"
    script += "; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"xarray", "numba", "matplotlib", "scipy"} & set(run.stdout.split())


def test_a_figure_of_the_paper_has_its_number_and_one_beyond_it_has_none():
    numbers = {name: figure.number for name, figure in FIGURES.items() if figure.number}
    assert list(numbers)[:5] == [f"fig{n}" for n in range(1, 6)]
    assert all(number == f"Fig. {name[3]}" or name == "fig6_error" for name, number in numbers.items())
    assert FIGURES["fig_convergence"].number == ""
