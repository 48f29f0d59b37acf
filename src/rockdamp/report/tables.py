"""The report's tables: their rows as text, from the datasets."""

from __future__ import annotations

import csv
import os
import platform
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup, escape
from scipy.stats import chi2

from rockdamp.claims import FAILS, HOLDS, IN_PART, UNTESTED
from rockdamp.constants import PAPER_MODELS, RECOMMENDED_SOURCE, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.programs import REFERENCE_QUANTITY, REQUIREMENT
from rockdamp.figures.style import RESTITUTION
from rockdamp.mechanics.dampers import DAMPERS
from rockdamp.text import DASH, count_noun, join_words, number, percent, plain

# How each verdict is marked, by shape and word as well as colour; what fails comes first.
MARKS = {
    FAILS: ("no", "✗"),
    IN_PART: ("partly", "◐"),
    UNTESTED: ("unknown", "–"),
    HOLDS: ("yes", "✓"),
}
BAND = "BAND0.2"  # the damper to use, by its name in the dataset ``order``
SHOWN = (
    "ECD",
    "ECD16",
    "ECD64",
    "BAND0.4",
    BAND,
    "BAND0.1",
    "CQD0.25",
)  # and CR with another e after them
ORDER_COLUMNS = {
    "|ln r|, median": "log_error_median",
    "|ln r|, 90 %": "log_error_90",
    "|ln r| > 5 %": "share_above",
    "collapses missed": "missed_collapse_rate",
    "collapses added": "added_collapse_rate",
}
PROGRAM_COLUMNS = ("log_error_median", "log_error_90", "missed_collapse_rate")


def read_rows(path: str | os.PathLike[str]) -> list[dict[str, str]]:
    """Read a table that the pipeline wrote."""
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))


def inline(text: str) -> Markup:
    """Return a cell's text as HTML: what stands between backticks as code, u_ins with its index, minus as a minus."""
    html = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
    html = re.sub(r"(?<![\w])-(?=\d)", "−", html)
    html = re.sub(r"(?<=\d)%", "&nbsp;%", html)
    return Markup(html.replace("u_ins", "u<sub>ins</sub>"))


def interval(cell: xr.Dataset, name: str, write: Any = number) -> str:
    """Write a statistic and its interval: "0.149 (0.138 to 0.160)"."""
    bounds = cell[f"{name}_interval"].values
    if not np.isfinite(bounds).all():
        return str(write(cell[name]))
    return Markup("{} <small>({} to {})</small>").format(
        write(cell[name]), *(write(bound) for bound in bounds)
    )


def verdicts(claims: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Return the verdicts, each with its mark and its claims."""
    return [
        {
            "verdict": name,
            "kind": kind,
            "mark": mark,
            "claims": [claim for claim in claims if claim["verdict"] == name],
        }
        for name, (kind, mark) in MARKS.items()
    ]


# --- dampers ---------------------------------------------------------------------------------------------------------


def order(study: xr.Dataset) -> dict[str, Any]:
    """Return error against force at one e: a row for each damper of the table, and for CR with another e."""
    one_restitution = study.sel(restitution=RESTITUTION, method="nearest")
    studied = one_restitution["damper"].values.tolist()
    changed = [name for name in studied if name.startswith("e ")]
    rows = [
        {
            "damper": f"CR, {name}" if name in changed else name,
            "force": number(row["crossing_force"].sel(wall="paper"), 2),
            "errors": [interval(row, variable, percent) for variable in ORDER_COLUMNS.values()],
            "step": plain(row["largest_step"]) if np.isfinite(row["largest_step"]) else DASH,
        }
        for name in (*SHOWN, *changed)
        if name in studied
        for row in [one_restitution.sel(damper=name)]
    ]
    band = one_restitution.sel(damper=BAND)
    return {
        "rows": rows,
        "columns": list(ORDER_COLUMNS),
        "e": plain(one_restitution["restitution"]),
        "records": int(study["records"]),
        **{
            name: percent(band[name])
            for name in ("share_above", "missed_collapse_rate", "added_collapse_rate")
        },
        "half_step": percent(one_restitution["share_above"].sel(damper="half step")),
    }


def programs(compared: xr.Dataset) -> list[dict[str, Any]]:
    """Return the dampers by what a program takes: what xi refers to, and the errors at each e of the study."""
    leading = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    return [
        {
            "offer": offer,
            "model": model,
            "title": DAMPERS[model].title,
            "refers_to": REFERENCE_QUANTITY[model],
            "errors": [
                list(map(percent, leading[name].sel(damping_model=model).values))
                for name in PROGRAM_COLUMNS
            ],
        }
        for model, offer in REQUIREMENT.items()
    ]


def selection(compared: xr.Dataset) -> str:
    """Say over which histories the errors are: the same for every damper of the tables."""
    walls = int(compared["pooled"].sel(damping_ratio_source=RECOMMENDED_SOURCE).sum())
    peaks = f"{plain(compared['band_start'][0])} to {plain(compared['band_end'][0])}"
    records = f"{int(compared['records'])} earthquake records"
    return f"{count_noun(walls, 'wall')} under {records}, peaks of {peaks} u_ins under restitution"


def ratios(fits: xr.Dataset) -> dict[str, Any]:
    """Return xi of least error over a1 and e, for the sliders: rows by a1. [-]"""
    xi = fits["damping_ratio"].sortby(["yield_displacement_ratio", "restitution"])
    xi = xi.transpose("damping_model", "yield_displacement_ratio", "restitution")
    found = {model: xi.sel(damping_model=model).values for model in REQUIREMENT}
    return {
        "e": xi["restitution"].values.round(6).tolist(),
        "a1": xi["yield_displacement_ratio"].values.round(6).tolist(),
        "ratio": {
            model: values.round(6).tolist()
            for model, values in found.items()
            if np.isfinite(values).all()
        },
    }


def ratio_at(stored: Mapping[str, Any], model: str, e: float, a1: float) -> str:
    """Write xi, interpolated linearly in e and in a1, as the page's script does. [%]"""
    if model not in stored["ratio"]:
        return DASH
    by_a1 = [np.interp(e, stored["e"], row) for row in stored["ratio"][model]]
    return f"{100 * np.interp(a1, stored['a1'], by_a1):.2f}"


# --- earthquakes -----------------------------------------------------------------------------------------------------


def earthquakes(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """Return what was run, and three tables: errors and collapses, errors by band of the peak, and the walls."""
    leading = compared.sel(
        damping_ratio_source=RECOMMENDED_SOURCE, damping_model=list(VISCOUS_MODELS)
    )
    models = [leading.sel(damping_model=model) for model in VISCOUS_MODELS]
    e = compared["restitution"].values
    middle = e.size // 2
    each = (
        int(np.isfinite(walls["damping_ratio"]).sum())
        + walls.sizes["wall"] * walls.sizes["restitution"]
    )
    bands = [
        f"{plain(low)} to {plain(high)}"
        for low, high in zip(compared["band_start"], compared["band_end"], strict=True)
    ]
    return {
        "few": int(compared["stations"]) < 10,  # intervals over fewer mean nothing
        "stations": int(compared["stations"]),
        "records": int(compared["records"]),
        "intensities": compared.sizes["velocity_ratio"],
        "e": join_words(map(plain, e)),
        "histories": f"{int(compared['records']) * compared.sizes['velocity_ratio'] * each:,}".replace(
            ",", "\u202f"
        ),
        "converged": f"{100 * float(compared['converged_share']):.2f}",
        "errors": [
            (
                plain(one_restitution),
                str(row["damping_model"].item()),
                _errors(row.isel(restitution=index)),
            )
            for index, one_restitution in enumerate(e)
            for row in models
        ],
        "bands": bands,
        "middle": plain(e[middle]),
        "by_band": [
            (
                str(row["damping_model"].item()),
                [number(value) for value in row["log_error_90"].values[1:]],
            )
            for row in (model.isel(restitution=middle) for model in models)
        ],
        "walls": [_wall(walls.isel(wall=index)) for index in range(walls.sizes["wall"])],
    }


def _errors(row: xr.Dataset) -> list[str]:
    whole = row.isel(band=0)
    return [
        interval(whole, "median_ratio"),
        number(whole["log_error_median"]),
        number(whole["log_error_90"]),
        interval(row, "missed_collapse_rate", percent),
        interval(row, "added_collapse_rate", percent),
        interval(row, "median_intensity_ratio"),
    ]


def _wall(wall: xr.Dataset) -> list[str]:
    kind = "parapet" if wall["parapet"] == 1 else "wall"
    inputs = (
        "thickness",
        "slenderness",
        "overburden_ratio",
        "yield_displacement_ratio",
        "strength_ratio",
    )
    derived = ("instability_displacement", "frequency_parameter", "initial_period")
    return [
        str(wall["wall"].item()),
        kind,
        *(plain(wall[name]) for name in inputs),
        *(number(wall[name]) for name in derived),
    ]


# --- assumptions and measured trials ---------------------------------------------------------------------------------


def supports(study: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return for each assumption the median intensity of collapse over the usual one's, and on which side that is."""
    rows = []
    for name in study["assumption"].values:
        case = study.sel(assumption=name, wall="all")
        low, high = case["median_intensity_ratio_interval"].values
        side = "unsafe" if high < 1 else "safe" if low > 1 else "neither"
        rows.append((str(name), interval(case, "median_intensity_ratio"), side))
    return rows


def loss_law(study: xr.Dataset) -> dict[str, str]:
    """Return by how much a constant e overstates the median intensity of collapse, by the amplitude of its releases."""
    whole = study.sel(wall="all")
    over = 1 / whole["median_intensity_ratio"] - 1
    at, g = whole["reference_amplitude"].values, whole["loss_exponent"].values
    small = over.isel(reference_amplitude=0)
    return {
        "e": plain(study["restitution"]),
        "small": plain(at[0]),
        "good": f"{plain(at[1])} to {plain(at[-1])}",
        "within": percent(abs(over.isel(reference_amplitude=slice(1, None))).max()),
        "overstates": f"{percent(small.min())} to {percent(small.max())}",
        "exponents": f"{plain(g[0])} to {plain(g[-1])}",
    }


def measured_rocking(measured: xr.Dataset) -> dict[str, Any]:
    """Return the likelihoods of the paper's dampers in measured trials, and four sentences on them."""
    models = [REFERENCE, *PAPER_MODELS]
    likelihood = measured["log_likelihood"].sel(damping_model=models)
    behind = likelihood.max("damping_model") - likelihood
    power_law = measured["log_likelihood"].sel(damping_model="power law")
    p = chi2.sf(2 * (power_law - likelihood.sel(damping_model=REFERENCE)).values, 1)
    cdc, cdr, sdr = (likelihood.sel(damping_model=model, drop=True) for model in PAPER_MODELS)
    impacts = [str(int(count)) for count in measured["impacts_used"].values]
    rejected = join_words(count for count, value in zip(impacts, p, strict=True) if value < 0.05)

    def extremes(values: xr.DataArray) -> str:
        return f"{number(values.min(), 2)} to {number(values.max(), 2)}"

    return {
        "impacts": impacts,
        "rows": [
            (model, [number(value, 2) for value in behind.sel(damping_model=model).values])
            for model in models
        ],
        "p": [number(value, 2) for value in p],
        "trials": int(measured["trials"] - measured["duplicates"]),
        "sentences": [
            f"ln L of CDR is {extremes(cdr - sdr)} relative to SDR, over the numbers of impacts used.",
            f"ln L of SDR exceeds the larger of the other two by {extremes(sdr - np.maximum(cdc, cdr))}.",
            f"ln L exceeds that of CDC by {extremes(cdr - cdc)} under CDR and by {extremes(sdr - cdc)} under SDR.",
            f"The likelihood ratio test rejects a constant e at 5 % with {rejected or 'no number of'} impacts used, in"
            f" favour of the power law; the best exponent is {extremes(measured['amplitude_exponent'])}.",
        ],
    }


def software() -> str:
    """Return the versions of Python and of what the results stand on."""
    names = ("rockdamp", "numpy", "scipy", "numba", "xarray", "netCDF4", "matplotlib", "snakemake")
    return join_words(
        [f"Python {platform.python_version()}", *(f"{name} {version(name)}" for name in names)]
    )
