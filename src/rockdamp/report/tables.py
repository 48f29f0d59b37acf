"""The report's tables: their rows as text, from the datasets."""

from __future__ import annotations

import csv
import os
import platform
import re
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup, escape
from scipy.stats import chi2

from rockdamp.claims import FAILS, HOLDS, IN_PART, UNTESTED
from rockdamp.constants import (
    MODELS,
    PAPER_MODELS,
    RECOMMENDED_SOURCE,
    REFERENCE,
    VISCOUS_MODELS,
)
from rockdamp.equivalence.programs import REFERENCE_QUANTITY, REQUIREMENT
from rockdamp.figures.assumptions import describe_assumption
from rockdamp.figures.style import RESTITUTION
from rockdamp.mechanics.damping import DAMPERS
from rockdamp.text import DASH, count_noun, join_words, number, percent, plain

# A verdict has a sign and words besides its colour; failures come first.
VERDICT_MARKS = {
    FAILS: ("no", "✗"),
    IN_PART: ("partly", "◐"),
    UNTESTED: ("unknown", "–"),
    HOLDS: ("yes", "✓"),
}
RECOMMENDED_BAND = "BAND0.2"  # the damper to use, by its name in the dataset ``order``
ORDER_DAMPERS = ("ECD", "ECD16", "ECD64", "BAND0.4", RECOMMENDED_BAND, "BAND0.1", "CQD0.25")
ORDER_COLUMNS = {
    "Error of the peak, median": "log_error_median",
    "Error of the peak, 90th percentile": "log_error_90",
    "Peaks with an error above 5 %": "share_above",
    "Missed collapses": "missed_collapse_rate",
    "Added collapses": "added_collapse_rate",
}
PROGRAM_COLUMNS = ("log_error_median", "log_error_90", "missed_collapse_rate")
# Formulas as HTML; docs/theory.md derives those of ECD and BAND.
FORMULAS = {
    "CR": "u′ becomes e u′ whenever u crosses 0",
    "CDC": "C = 2 m<sub>eff</sub> ω<sub>1</sub> ξ",
    "CDR": "C = 2 m<sub>eff</sub> ω ξ, with ω = √(F/(m<sub>eff</sub> u))",
    "SDR": "C = 2 m<sub>eff</sub> (ω²/ω<sub>1</sub>) ξ",
    "ECD": "C = 2 m<sub>eff</sub> ω<sub>E</sub> ξ, with ω<sub>E</sub> = |F|/√(2 m<sub>eff</sub> V)",
    "BAND": "C = m<sub>eff</sub> (3 δ′/(4 c)) max(0, 1 − (u/(c u′))²), with δ′ ≈ π ξ",
}
SYMBOLS = {
    "e": "coefficient of restitution: ratio of the velocities after and before an impact",
    "ξ": "damping ratio of a viscous damper",
    "u, u<sub>ins</sub>": "displacement of the wall at its hinge; displacement at which a rigid"
    " wall becomes unstable",
    "u′ or v": "velocity of the wall at its hinge",
    "F, F<sub>0</sub>": "restoring force; restoring force of the rigid wall at u = 0",
    "a<sub>1</sub>": "end of the first, stiff branch of the force-displacement curve, divided"
    " by u<sub>ins</sub>",
    "b<sub>1</sub>": "height of the curve's plateau, divided by F<sub>0</sub>",
    "ω<sub>1</sub>": "initial frequency, that of the first branch",
    "m<sub>eff</sub>": "effective mass of the wall, Eq. (2)",
    "p, τ": "frequency parameter √(F<sub>0</sub>/(m<sub>eff</sub> u<sub>ins</sub>)); dimensionless"
    " time τ = p t",
    "V": "area under the curve from 0 to u",
    "c": "half of the time for which BAND acts, t<sub>c</sub>/ω<sub>1</sub> with t<sub>c</sub>"
    " = 0.2",
}


def read_rows(path: str | os.PathLike[str]) -> list[dict[str, str]]:
    """Read a table that the pipeline wrote."""
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))


def inline(text: str) -> Markup:
    """Return a cell's text as HTML: backticks as code, u_ins with its index, minus signs."""
    html = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
    html = re.sub(r"(?<![\w])-(?=\d)", "−", html)
    html = re.sub(r"(?<=\d)%", "&nbsp;%", html)
    return Markup(html.replace("u_ins", "u<sub>ins</sub>"))


def write_interval(cell: xr.Dataset, name: str, write: Callable[..., str] = number) -> str:
    """Write a statistic and its interval: "0.149 (0.138 to 0.160)"."""
    value = write(cell[name])
    bounds = cell[f"{name}_interval"].values
    if not np.isfinite(bounds).all():
        return value
    low, high = (write(bound) for bound in bounds)
    return Markup("{} <small>({} to {})</small>").format(value, low, high)


def write_range(values: Any) -> str:
    """Write the first and the last value: "0.3 to 0.5"."""
    return f"{plain(values[0])} to {plain(values[-1])}"


def verdicts(claims: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Return the verdicts, each with its mark and its claims."""
    groups = []
    for verdict, (kind, mark) in VERDICT_MARKS.items():
        members = [claim for claim in claims if claim["verdict"] == verdict]
        groups.append({"verdict": verdict, "kind": kind, "mark": mark, "claims": members})
    return groups


def dampers() -> list[dict[str, Any]]:
    """Return name, words and formula of each damping model."""
    return [
        {"model": model, "title": DAMPERS[model].title, "formula": Markup(FORMULAS[model])}
        for model in MODELS
    ]


def symbols() -> list[tuple[Markup, Markup]]:
    """Return symbols and their meanings."""
    return [(Markup(symbol), Markup(meaning)) for symbol, meaning in SYMBOLS.items()]


# --- dampers -----------------------------------------------------------------------------------


def order(study: xr.Dataset) -> dict[str, Any]:
    """Return errors and forces at the paper's e, and the numbers of the text beside them.

    There is a row for each damper of ORDER_DAMPERS, and for CR with each other e.
    """
    at_restitution = study.sel(restitution=RESTITUTION, method="nearest")
    names = at_restitution["damper"].values.tolist()
    has_other_restitution = at_restitution["damper_family"] == "restitution"
    other_restitutions = at_restitution["damper"].values[has_other_restitution].tolist()
    rows = []
    for name in (*ORDER_DAMPERS, *other_restitutions):
        if name not in names:
            continue
        row = at_restitution.sel(damper=name)
        force = row["crossing_force"].sel(wall="paper")
        errors = [write_interval(row, variable, percent) for variable in ORDER_COLUMNS.values()]
        rows.append(
            {
                "damper": f"CR, {name}" if name in other_restitutions else name,
                "is_recommended": name == RECOMMENDED_BAND,
                "force": number(force, 2),
                "errors": errors,
                "step": write_step(row["largest_step"]),
            }
        )
    band = at_restitution.sel(damper=RECOMMENDED_BAND)
    return {
        "rows": rows,
        "columns": list(ORDER_COLUMNS),
        "e": plain(at_restitution["restitution"]),
        "records": int(study["records"]),
        "share_above": percent(band["share_above"]),
        "missed_collapse_rate": percent(band["missed_collapse_rate"]),
        "added_collapse_rate": percent(band["added_collapse_rate"]),
        "half_step": percent(at_restitution["share_above"].sel(damper="half step")),
    }


def write_step(step: xr.DataArray) -> str:
    """Write the largest step of a damper; a dash if the study does not have one."""
    if not np.isfinite(step):
        return DASH
    return plain(step)


def programs(compared: xr.Dataset) -> list[dict[str, Any]]:
    """Return the dampers by what a program supports, with their errors at each e of the study."""
    errors = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    rows = []
    for model, offer in REQUIREMENT.items():
        row = errors.sel(damping_model=model)
        rows.append(
            {
                "offer": offer,
                "model": model,
                "title": DAMPERS[model].title,
                "refers_to": REFERENCE_QUANTITY[model].replace("w1", "ω1"),
                "errors": [list(map(percent, row[name].values)) for name in PROGRAM_COLUMNS],
            }
        )
    return rows


def selection(compared: xr.Dataset) -> str:
    """Return the histories over which the errors are computed, in words."""
    walls = int(compared["pooled"].sel(damping_ratio_source=RECOMMENDED_SOURCE).sum())
    low = plain(compared["band_start"][0])
    high = plain(compared["band_end"][0])
    records = int(compared["records"])
    return (
        f"{count_noun(walls, 'wall')} under {records} earthquake records, peaks of {low} to {high}"
        " u_ins under restitution"
    )


def ratios(fits: xr.Dataset) -> dict[str, Any]:
    """Return xi of least error for the sliders: axes e and a1, and rows by a1 of each model. [-]"""
    xi = fits["damping_ratio"].sortby(["yield_displacement_ratio", "restitution"])
    xi = xi.transpose("damping_model", "yield_displacement_ratio", "restitution")
    rows = {}
    for model in REQUIREMENT:
        values = xi.sel(damping_model=model).values
        if np.isfinite(values).all():
            rows[model] = values.round(6).tolist()
    return {
        "e": xi["restitution"].values.round(6).tolist(),
        "a1": xi["yield_displacement_ratio"].values.round(6).tolist(),
        "ratio": rows,
    }


def ratio_at(stored: Mapping[str, Any], model: str, e: float, a1: float) -> str:
    """Write xi, interpolated linearly in e and in a1, as the page's script does. [%]"""
    if model not in stored["ratio"]:
        return DASH
    by_a1 = [np.interp(e, stored["e"], row) for row in stored["ratio"][model]]
    return f"{100 * np.interp(a1, stored['a1'], by_a1):.2f}"


# --- earthquakes -------------------------------------------------------------------------------


def earthquakes(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """Return the extent of the study, and its tables: errors, errors by band, and walls."""
    e = compared["restitution"].values
    middle = e.size // 2
    viscous = compared.sel(
        damping_ratio_source=RECOMMENDED_SOURCE, damping_model=list(VISCOUS_MODELS)
    )
    errors = []
    for index, restitution in enumerate(e):
        for model in VISCOUS_MODELS:
            row = viscous.sel(damping_model=model).isel(restitution=index)
            errors.append((plain(restitution), model, list_errors(row)))
    by_band = []
    for model in VISCOUS_MODELS:
        row = viscous.sel(damping_model=model).isel(restitution=middle)
        by_band.append((model, [percent(value) for value in row["log_error_90"].values[1:]]))
    bands = zip(compared["band_start"].values, compared["band_end"].values, strict=True)
    stations = int(compared["stations"])
    return {
        "few": stations < 10,  # intervals over fewer mean nothing
        "stations": stations,
        "records": int(compared["records"]),
        "intensities": compared.sizes["velocity_ratio"],
        "e": join_words(map(plain, e)),
        "histories": f"{count_histories(compared, walls):,}".replace(",", "\u202f"),
        "converged": f"{100 * float(compared['converged_share']):.2f}",
        "errors": errors,
        "bands": [write_range(band) for band in bands],
        "middle": plain(e[middle]),
        "by_band": by_band,
        "walls": [list_wall(walls.isel(wall=index)) for index in range(walls.sizes["wall"])],
    }


def count_histories(compared: xr.Dataset, walls: xr.Dataset) -> int:
    """Return the number of histories: with each damping ratio, and with CR."""
    viscous = int(np.isfinite(walls["damping_ratio"]).sum())
    reference = walls.sizes["wall"] * walls.sizes["restitution"]
    runs = int(compared["records"]) * compared.sizes["velocity_ratio"]
    return runs * (viscous + reference)


def list_errors(row: xr.Dataset) -> list[str]:
    """Return the cells of one damper at one e."""
    all_peaks = row.isel(band=0)
    return [
        write_interval(all_peaks, "median_ratio"),
        percent(all_peaks["log_error_median"]),
        percent(all_peaks["log_error_90"]),
        write_interval(row, "missed_collapse_rate", percent),
        write_interval(row, "added_collapse_rate", percent),
        write_interval(row, "median_intensity_ratio"),
    ]


def list_wall(wall: xr.Dataset) -> list[str]:
    """Return the cells of one wall."""
    inputs = [
        "thickness",
        "slenderness",
        "overburden_ratio",
        "yield_displacement_ratio",
        "strength_ratio",
    ]
    derived = ["instability_displacement", "frequency_parameter", "initial_period"]
    return [
        str(wall["wall"].item()),
        "parapet" if wall["parapet"] == 1 else "wall",
        *(plain(wall[name]) for name in inputs),
        *(number(wall[name]) for name in derived),
    ]


# --- assumptions and measured trials -----------------------------------------------------------


def supports(study: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return for each assumption the ratio of the median intensities, and its side of 1."""
    rows = []
    for name in study["assumption"].values:
        case = study.sel(assumption=name, wall="all")
        ratio = write_interval(case, "median_intensity_ratio")
        rows.append((describe_assumption(str(name)), ratio, judge_assumption(case)))
    return rows


def judge_assumption(case: xr.Dataset) -> str:
    """Return whether an assumption is safe, unsafe or neither, by the interval of its ratio.

    Parameters
    ----------
    case : xarray.Dataset
        ``median_intensity_ratio_interval`` of the study of supports, or of the loss law, for one
        alternative and all walls: the intensity of collapse with the alternative divided by that
        with our assumption.
    """
    low, high = case["median_intensity_ratio_interval"].values
    if high < 1:
        return "unsafe"
    if low > 1:
        return "safe"
    return "neither"


def loss_law(study: xr.Dataset) -> dict[str, str] | None:
    """Return how far a constant e overstates the median intensity of collapse, by amplitude.

    It is None for a study with a single amplitude, which has nothing to compare.
    """
    if study.sizes["reference_amplitude"] < 2:
        return None
    excess = 1 / study["median_intensity_ratio"].sel(wall="all") - 1
    small_releases = excess.isel(reference_amplitude=0)
    other_releases = excess.isel(reference_amplitude=slice(1, None))
    amplitudes = study["reference_amplitude"].values
    return {
        "e": plain(study["restitution"]),
        "small": plain(amplitudes[0]),
        "good": write_range(amplitudes[1:]),
        "within": percent(abs(other_releases).max()),
        "overstates": f"{percent(small_releases.min())} to {percent(small_releases.max())}",
        "exponents": write_range(study["loss_exponent"].values),
    }


def measured_rocking(measured: xr.Dataset) -> dict[str, Any]:
    """Return the likelihoods of the paper's dampers in measured trials, and sentences on them."""
    models = [REFERENCE, *PAPER_MODELS]
    likelihood = measured["log_likelihood"].sel(damping_model=models)
    behind = likelihood.max("damping_model") - likelihood
    power_law = measured["log_likelihood"].sel(damping_model="power law")
    advantage = power_law - likelihood.sel(damping_model=REFERENCE)
    # Likelihood ratio test: the power law has one parameter more than CR.
    p = chi2.sf(2 * advantage.values, 1)
    impacts = [str(int(count)) for count in measured["impacts_used"].values]
    rejecting = [count for count, value in zip(impacts, p, strict=True) if value < 0.05]
    cdc, cdr, sdr = (likelihood.sel(damping_model=model, drop=True) for model in PAPER_MODELS)
    rows = []
    for model in models:
        rows.append((model, [number(x, 2) for x in behind.sel(damping_model=model).values]))
    exponent = write_extremes(measured["amplitude_exponent"])
    return {
        "impacts": impacts,
        "rows": rows,
        "p": [number(value, 2) for value in p],
        "trials": int(measured["trials"] - measured["duplicates"]),
        "sentences": [
            f"ln L of SDR exceeds that of both CDC and CDR by"
            f" {write_extremes(sdr - np.maximum(cdc, cdr))}, depending on the number of"
            " impacts used.",
            f"CDR exceeds CDC by {write_extremes(cdr - cdc)}.",
            f"The likelihood ratio test rejects a constant e at 5 % with"
            f" {join_words(rejecting) or 'no number of'} impacts used, in favour of the power law;"
            f" the best exponent of the power law is {exponent}.",
        ],
    }


def write_extremes(values: xr.DataArray) -> str:
    """Write the smallest and the largest value: "−4 to −1"."""
    return f"{number(values.min(), 2)} to {number(values.max(), 2)}"


def software() -> str:
    """Return the versions of Python and of the packages that compute the results."""
    names = ["rockdamp", "numpy", "scipy", "numba", "xarray", "netCDF4", "matplotlib", "snakemake"]
    packages = [f"{name} {version(name)}" for name in names]
    return join_words([f"Python {platform.python_version()}", *packages])
