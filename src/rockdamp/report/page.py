"""Build the page of the report from its template, and write it."""

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

from rockdamp.claims import HOLDS
from rockdamp.report import tables
from rockdamp.storage.dataset import Datasets
from rockdamp.storage.files import replace_file

# By name in the template: the function that gives the value, and the dataset that it takes.
# Without the dataset the value is None, and the template leaves the section out.
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
    """Everything that the report shows.

    Attributes
    ----------
    claims : sequence of dict
        Rows of claims.csv.
    errata : sequence of dict
        Entries of data/errata.yaml.
    figures : mapping of str to bytes
        PNG images by name.
    datasets : mapping of str to xarray.Dataset
        Datasets of the results by name.
    yield_displacement_ratio : float
        a1 of the reference curve, at which the sliders start. [-]
    documents : str
        Folder of the documents, relative to the page.
    folder : str
        Folder of the results. Only "results" is that of the default config.
    """

    claims: Sequence[Mapping[str, str]]
    errata: Sequence[Mapping[str, str]]
    figures: Mapping[str, bytes]
    datasets: Datasets
    yield_displacement_ratio: float
    documents: str = "../docs"
    folder: str = "results"


def build(content: Content) -> str:
    """Return the report as HTML. The same content gives the same text."""
    data = content.datasets
    values: dict[str, Any] = {"earthquakes": None, "e": []}
    for name, (make_table, source) in TABLES.items():
        values[name] = make_table(data[source]) if source in data else None
    if "comparison" in data:
        values["e"] = data["comparison"]["restitution"].values.tolist()
    if "comparison" in data and "earthquakes/walls" in data:
        values["earthquakes"] = tables.earthquakes(data["comparison"], data["earthquakes/walls"])
    template = make_environment().from_string(read_text("report.html.j2"))
    return template.render(
        **values,
        a1=content.yield_displacement_ratio,
        style=Markup(read_text("report.css")),
        script=Markup(read_text("page.js")),
        dampers=tables.dampers(),
        symbols=tables.symbols(),
        verdicts=tables.verdicts(content.claims),
        claims=len(content.claims),
        holding=sum(claim["verdict"] == HOLDS for claim in content.claims),
        errata=content.errata,
        figures=describe_figures(content.figures),
        documents=content.documents,
        folder=content.folder,
        software=tables.software(),
    )


def write(content: Content, path: str | os.PathLike[str]) -> None:
    """Write the report, complete or not at all."""
    html = build(content)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with replace_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8", newline="\n")


def make_environment() -> Environment:
    """Return the settings of the template: a name that it misses is an error."""
    environment = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["inline"] = tables.inline
    environment.globals["ratio_at"] = tables.ratio_at
    return environment


def read_text(name: str) -> str:
    """Read a file of this package; workflow/rules/report.smk names them all."""
    return files("rockdamp.report").joinpath(name).read_text(encoding="utf-8")


def png_size(png: bytes) -> tuple[int, int]:
    """Return width and height of an image from its header. [pixel]"""
    # A PNG starts with 16 bytes of signature, length and chunk name; both sizes follow.
    width = int.from_bytes(png[16:20], "big")
    height = int.from_bytes(png[20:24], "big")
    return width, height


def describe_figures(images: Mapping[str, bytes]) -> dict[str, dict[str, Any]]:
    """Return image, size and words of each figure, by its name, in the order of the page."""
    sizes = {name: png_size(png) for name, png in images.items()}
    widest = max((width for width, _ in sizes.values()), default=1)
    figures = {}
    for name, words in yaml.safe_load(read_text("figures.yaml")).items():
        if name not in images:
            continue
        width, height = sizes[name]
        encoded = base64.b64encode(images[name]).decode("ascii")
        figures[name] = {
            "image": f"data:image/png;base64,{encoded}",
            "width": width,
            "height": height,
            "share": round(width / widest, 3),
            "title": words["title"],
            "alternative": words["alternative"],
            "caption": Markup(words["caption"]),
        }
    return figures
