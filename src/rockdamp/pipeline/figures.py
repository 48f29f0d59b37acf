"""Read the table of figures, figures.yaml, without importing what takes long."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from importlib.resources import files

from rockdamp.storage import yaml_file
from rockdamp.storage.provenance import Sources


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


FIGURES = {
    name: Drawing(name=name, **entry)
    for name, entry in yaml_file.load(
        files("rockdamp").joinpath("pipeline/figures.yaml").read_text(encoding="utf-8")
    ).items()
}

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
