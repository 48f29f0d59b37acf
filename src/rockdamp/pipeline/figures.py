"""Read the table of figures, figures.yaml, without importing what takes long."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from importlib.resources import files

from rockdamp.storage import yaml_file


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
        return f"{self.modules[0]}.{self.name}"

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules whose sources it depends on."""
        return f"rockdamp.{self.module}", "rockdamp.figures.output", "rockdamp.storage.dataset"

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
REPORT_MODULES = ("rockdamp.report", *dict.fromkeys(figure.modules[0] for figure in FIGURES.values()))


def drawn(datasets: Collection[str]) -> dict[str, Drawing]:
    """Return the figures of which all datasets are there."""
    return {name: figure for name, figure in FIGURES.items() if set(figure.inputs) <= set(datasets)}
