"""The page itself: what goes into its template, and writing it."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from rockdamp.report import tables
from rockdamp.storage.dataset import Datasets
from rockdamp.storage.files import replace_file

# Functions of a dataset, by the name that the template has for their result; a section without its dataset is left out.
TABLES = {
    "order": (tables.order, "order"),
    "programs": (tables.programs, "comparison"),
    "selection": (tables.selection, "comparison"),
    "ratios": (tables.ratios, "equivalence"),
    "supports": (tables.supports, "supports"),
    "loss_law": (tables.loss_law, "loss_law"),
    "rocking": (tables.measured_rocking, "measured_rocking"),
}


@dataclass(frozen=True)
class Content:
    """Everything that the report shows."""

    claims: Sequence[Mapping[str, str]]  # rows of claims.csv
    errata: Sequence[Mapping[str, str]]  # entries of data/errata.yaml
    figures: Mapping[str, bytes]  # PNG by name
    datasets: Datasets
    yield_displacement_ratio: float  # a1 of the reference curve
    documents: str = "../docs"  # the folder of the documents, relative to the page


def build(content: Content) -> str:
    """Return the report as HTML. The same content gives the same text."""
    environment = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["inline"] = tables.inline
    environment.globals["ratio_at"] = tables.ratio_at
    data = content.datasets
    values = {
        name: make(data[source]) if source in data else None
        for name, (make, source) in TABLES.items()
    }
    shaken = "comparison" in data and "earthquakes/walls" in data
    return environment.from_string(_text("report.html.j2")).render(
        **values,
        earthquakes=tables.earthquakes(data["comparison"], data["earthquakes/walls"])
        if shaken
        else None,
        e=[float(e) for e in data["comparison"]["restitution"]] if "comparison" in data else [],
        a1=content.yield_displacement_ratio,
        style=Markup(_text("report.css")),
        script=Markup(_text("page.js")),
        verdicts=tables.verdicts(content.claims),
        errata=content.errata,
        figures=_figures(content.figures),
        documents=content.documents,
        software=tables.software(),
    )


def write(content: Content, path: str | os.PathLike[str]) -> None:
    """Write the report, complete or not at all."""
    html = build(content)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with replace_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8", newline="\n")


def _text(name: str) -> str:
    """Read a file of this package; workflow/rules/report.smk names them all."""
    return files("rockdamp.report").joinpath(name).read_text(encoding="utf-8")


def _figures(pictures: Mapping[str, bytes]) -> dict[str, dict[str, Any]]:
    """Return what the page shows of each figure, by its name, in the order of the page."""
    # The header of a PNG has width and height.
    sizes = {
        name: [int.from_bytes(png[at : at + 4], "big") for at in (16, 20)]
        for name, png in pictures.items()
    }
    widest = max((width for width, _ in sizes.values()), default=1)
    return {
        name: {
            "image": f"data:image/png;base64,{base64.b64encode(pictures[name]).decode('ascii')}",
            "width": sizes[name][0],
            "height": sizes[name][1],
            "share": round(sizes[name][0] / widest, 3),
            "title": text["title"],
            "alternative": text["alternative"],
            "caption": Markup(text["caption"]),
        }
        for name, text in yaml.safe_load(_text("figures.yaml")).items()
        if name in pictures
    }
