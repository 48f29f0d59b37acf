"""The page itself: what goes into its template, and writing it."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import yaml
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from scipy.stats import chi2

from rockdamp.arrays import Array
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.errors import InputError
from rockdamp.report import earthquakes, tables
from rockdamp.report.answer import answer, shown_ratio
from rockdamp.storage.dataset import Datasets
from rockdamp.storage.files import replace_file
from rockdamp.text import join_words, number

# Files of this package that the page is made of; workflow/rules/report.smk names them too.
TEXTS = "figures.yaml"  # titles, alternatives and captions of the figures, in the order of the page
TEMPLATE = "report.html.j2"
STYLE = "report.css"
SCRIPT = "page.js"
ROCKING = "fig_measured_rocking"  # what measured free rocking says of each damper
BRIDGE = "fig_order"  # the figure that comes first: error against force


@dataclass(frozen=True)
class Content:
    """Everything that the report shows, in the order of the page."""

    claims: Sequence[Mapping[str, str]]  # rows of claims.csv
    errata: Sequence[Mapping[str, str]]  # entries of data/errata.yaml
    figures: Mapping[str, bytes]  # PNG by name
    datasets: Datasets
    assumptions: str  # docs/assumptions.md
    citation: str  # CITATION.cff
    yield_displacement_ratio: float  # a1 of the reference curve
    documents: str = "../docs"  # the folder of the documents, from that of the page


def build(content: Content) -> str:
    """Return the report as HTML. The same content gives the same text."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    environment.filters["inline"] = tables.inline
    template = environment.from_string(_text(TEMPLATE))
    pictures = {figure["name"]: figure for figure in _figures(content)}
    short = answer(content.datasets, content.yield_displacement_ratio)
    return template.render(
        style=Markup(_text(STYLE)),
        script=Markup(_text(SCRIPT)),
        verdicts=tables.judged(content.claims),
        errata=content.errata,
        bridge=pictures.pop(BRIDGE, None),
        rocking=pictures.pop(ROCKING, None),
        measurement=measurement(content.datasets),
        figures=list(pictures.values()),
        answer=short,
        shown_ratio=shown_ratio,
        documents=content.documents,
        earthquakes=earthquakes.section(content.datasets),
        assumptions=Markup(tables.prose(content.assumptions)),
        citation=tables.citation(content.citation),
        software=tables.software(),
        datasets=content.datasets,
    )


def write(content: Content, path: str | os.PathLike[str]) -> None:
    """Write the report, complete or not at all."""
    html = build(content)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with replace_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8", newline="\n")


def _text(name: str) -> str:
    return files("rockdamp.report").joinpath(name).read_text(encoding="utf-8")


def measurement(datasets: Datasets) -> dict[str, Any] | None:
    """Return what the section on measured free rocking shows, none without its dataset."""
    measured = datasets.get("measured_rocking")
    if measured is None:
        return None
    models = [REFERENCE, *PAPER_MODELS]
    likelihood = measured["log_likelihood"].sel(damping_model=models)
    behind = likelihood.max("damping_model") - likelihood
    of_law = measured["log_likelihood"].sel(damping_model="power law")
    p = chi2.sf(2 * (of_law - likelihood.sel(damping_model=REFERENCE)).values, 1)
    return {
        "impacts": [int(count) for count in measured["impacts_used"].values],
        "rows": [(model, [number(value, 2) for value in behind.sel(damping_model=model).values]) for model in models],
        "p": [number(value, 2) for value in p],
        "sentences": of_trials(measured, p),
        "trials": int(measured["trials"] - measured["duplicates"]),
    }


def of_trials(measured: xr.Dataset, p: Array) -> list[str]:
    """Say in four sentences what measured trials tell of the paper's dampers and of one e."""
    cdc, cdr, sdr = (measured["log_likelihood"].sel(damping_model=model, drop=True) for model in PAPER_MODELS)
    exponent = measured["amplitude_exponent"]
    rejected = [str(int(count)) for count, low in zip(measured["impacts_used"], p < 0.05, strict=True) if low]

    def extremes(values: xr.DataArray) -> str:
        return f"{number(values.min(), 2)} to {number(values.max(), 2)}"

    return [
        f"ln L of CDR less that of SDR is {extremes(cdr - sdr)}, from one number of impacts used to another.",
        f"ln L of SDR less the larger of the other two is {extremes(sdr - np.maximum(cdc, cdr))}.",
        f"ln L exceeds that of CDC by {extremes(cdr - cdc)} under CDR and by {extremes(sdr - cdc)} under SDR.",
        "The likelihood ratio rejects one e in favour of the power law at 5 % with"
        f" {join_words(rejected) if rejected else 'no number of'} impacts used, and the best exponent is"
        f" {extremes(exponent)}.",
    ]


def _figures(content: Content) -> list[dict[str, Any]]:
    texts = yaml.safe_load(_text(TEXTS))
    sizes = {name: _size(name, png) for name, png in content.figures.items()}
    widest = max((width for width, _ in sizes.values()), default=1)
    return [
        {
            "name": name,
            "image": f"data:image/png;base64,{base64.b64encode(content.figures[name]).decode('ascii')}",
            "width": sizes[name][0],
            "height": sizes[name][1],
            "share": round(sizes[name][0] / widest, 3),
            "number": text["title"].rpartition(": ")[0] if "Fig. " in text["title"] else "",
            "title": text["title"],
            "alternative": text["alternative"],
            "caption": Markup(text["caption"]),
        }
        for name, text in texts.items()
        if name in content.figures
    ]


def _size(name: str, png: bytes) -> tuple[int, int]:
    """Return width and height, which a PNG states in its header. [pixels]"""
    if png[12:16] != b"IHDR":
        raise InputError(f"the PNG of {name} cannot be read; delete it and run again")
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
