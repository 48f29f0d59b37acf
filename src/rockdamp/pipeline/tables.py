"""Read the tables of stages and figures, with the titles of datasets from storage/glossary.yaml.

The Snakefile reads them at every start, so this imports nothing that takes long.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from importlib.resources import files
from operator import attrgetter
from typing import Any

import yaml

from rockdamp.config import Config
from rockdamp.errors import InputError
from rockdamp.storage import glossary
from rockdamp.storage.provenance import NUMBERS_IN_WORDS, Sources
from rockdamp.vocabulary import STUDIES


@dataclass(frozen=True, kw_only=True)
class Stage:
    """An entry of the table of stages; stages.yaml says what each field means."""

    name: str
    title: str
    file: str
    rule: str
    function: str = ""
    inputs: Mapping[str, str] = field(default_factory=dict)
    config: Sequence[str] = ()
    also: Sequence[str] = ()
    chunks_of: str = ""
    per_chunk: str = ""
    priority: int = 0
    records: Mapping[str, str] = field(default_factory=dict)
    trials: str = ""
    motions: str = ""
    optional: bool = False
    intermediate: bool = False

    @property
    def sources(self) -> Sources:
        """What it depends on: the module of its function, what reads and writes datasets, and its dataset's texts."""
        modules = self.function.rpartition(".")[0], "rockdamp.storage.dataset"
        return Sources(modules, self.name if self.dataset else "", NUMBERS_IN_WORDS)

    @property
    def dataset(self) -> str:
        """Its file without suffix, ``match/{study}``; empty where it writes no dataset."""
        return self.file.removesuffix(".nc") if self.file.endswith(".nc") else ""

    @property
    def datasets(self) -> list[str]:
        """The datasets that it is given, by their files without suffix."""
        return list(self.inputs.values())

    def chunks(self, config: Config, count: Callable[[Sequence[str]], int]) -> range:
        """Return the numbers that {chunk} stands for in its file; `count` returns how many motions a list names."""
        if not self.chunks_of:
            return range(1)
        return range(-(-count(attrgetter(self.chunks_of)(config)) // attrgetter(self.per_chunk)(config)))


def _checked(place: str, kind: type[Any], entry: Mapping[str, Any]) -> Any:
    """Return an entry of a table; an error names the fields that it lacks, or that there are not."""
    known = {each.name: each.default is each.default_factory is MISSING for each in fields(kind)}
    lacks = [name for name, needed in known.items() if needed and name not in entry]
    other = [name for name in entry if name not in known]
    if lacks or other:
        wrong = " and ".join([f"lacks {', '.join(lacks)}"] * bool(lacks) + [f"has {', '.join(other)}"] * bool(other))
        raise InputError(f"{place} {wrong}; its fields are {', '.join(name for name in known if name != 'name')}")
    return kind(**entry)


def _require_datasets(place: str, inputs: Iterable[str], known: Collection[str]) -> None:
    """Refuse an input that no stage writes."""
    for name in inputs:
        if name not in known:
            inside = [each for each in known if each.endswith(f"/{name}")]
            near = inside or difflib.get_close_matches(name, known, n=1)
            meant = f"; did you mean {' or '.join(near)}?" if near else ""
            raise InputError(f"{place} has the input {name!r}, which no stage writes{meant}")


def all_stages() -> dict[str, Stage]:
    """Read the table of stages. Raise `InputError` where an entry has other fields, or inputs that no stage writes."""
    table = yaml.safe_load(files("rockdamp").joinpath("pipeline/stages.yaml").read_text(encoding="utf-8"))
    datasets = glossary.read()["datasets"]

    def stage(name: str, entry: dict[str, Any]) -> Stage:
        title = datasets[name]["title"] if entry["file"].endswith(".nc") else entry["title"]
        given = entry.get("inputs", {})
        inputs = given if isinstance(given, dict) else {dataset: dataset for dataset in given}
        whole = {"rule": name, "title": title, **entry, "name": name, "inputs": inputs}
        return _checked(f"stages.yaml: {name}", Stage, whole)

    stages = {name: stage(name, entry) for name, entry in table.items()}
    known = {name for each in stages.values() for name in (each.dataset, *each_study(each.dataset))}
    for name, each in stages.items():
        _require_datasets(f"stages.yaml: {name}", each.datasets, known)
    return stages


def built(config: Config) -> dict[str, Stage]:
    """Return the stages."""
    stages: dict[str, Stage] = {}
    for name, stage in STAGES.items():
        there = {stage.dataset for stage in stages.values()}
        known = there | _each(there)
        inputs = {argument: dataset for argument, dataset in stage.inputs.items() if dataset in known}
        stages[name] = replace(stage, inputs=inputs)
    return stages


def _each(datasets: Iterable[str]) -> set[str]:
    return {name for dataset in datasets for name in each_study(dataset)}


def each_study(dataset: str) -> list[str]:
    """Return the names that ``match/{study}`` stands for; any other name stands for itself."""
    return [dataset.replace("{study}", study) for study in STUDIES] if "{study}" in dataset else [dataset]


STAGES = all_stages()


def writes(stage: Stage, dataset: str) -> bool:
    """Say whether a stage writes a dataset, named as an input is: ``match/amplitude`` or ``match/{study}``."""
    return dataset in (stage.dataset, *each_study(stage.dataset))


def reported(stages: Iterable[Stage]) -> list[str]:
    """Return the names of the datasets that the report shows, of these stages."""
    shown = [stage.dataset for stage in stages if stage.dataset and not stage.intermediate]
    return [name for dataset in shown for name in each_study(dataset)]


# --- figures ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """An entry of the table of figures; figures.yaml says what each field means."""

    name: str
    module: str
    inputs: Sequence[str]
    title: str
    alternative: str

    @property
    def function(self) -> str:
        """Full name of the function that draws it."""
        return f"rockdamp.{self.module}.{self.name}"

    @property
    def sources(self) -> Sources:
        """What it depends on: its module, what saves figures, and what reads datasets."""
        return Sources((f"rockdamp.{self.module}", "rockdamp.figures.output", "rockdamp.storage.dataset"))

    @property
    def number(self) -> str:
        """Its name in the paper, ``Fig. 7``; empty for a figure beyond the paper."""
        return self.title.rpartition(": ")[0] if "Fig. " in self.title else ""


def drawings() -> dict[str, Drawing]:
    """Read the table of figures. Raise `InputError` where an entry has other fields, or inputs that no stage writes."""
    table = yaml.safe_load(files("rockdamp").joinpath("pipeline/figures.yaml").read_text(encoding="utf-8"))
    known = [name for stage in STAGES.values() for name in each_study(stage.dataset)]
    figures = {
        name: _checked(f"figures.yaml: {name}", Drawing, {**entry, "name": name}) for name, entry in table.items()
    }
    for name, figure in figures.items():
        _require_datasets(f"figures.yaml: {name}", figure.inputs, known)
    return figures


FIGURES = drawings()

# What the report is made by: the captions stand in the modules of the figures.
REPORT = Sources(
    (
        *("rockdamp.report", "rockdamp.storage.dataset"),
        *dict.fromkeys(f"rockdamp.{figure.module}" for figure in FIGURES.values()),
    )
)


def drawn(datasets: Collection[str]) -> dict[str, Drawing]:
    """Return the figures of which all datasets are there."""
    return {name: figure for name, figure in FIGURES.items() if set(figure.inputs) <= set(datasets)}
