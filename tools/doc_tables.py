"""Write the tables of measured numbers into the documents, from the datasets of a full build.

`.venv/bin/python tools/doc_tables.py [PAGE ...]` after `make`; without a page, all pages. A table
stands between two comments. The first names a function of this file, which returns the table. The
figures of docs/figures are copied too.
"""

import re
import shutil
import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import chi2

from rockdamp.constants import RECOMMENDED_SOURCE, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.programs import REFERENCE_QUANTITY, REQUIREMENT
from rockdamp.report.tables import judge_assumption
from rockdamp.storage import dataset
from rockdamp.text import DASH, number, percent, plain

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"
BLOCK = re.compile(
    r"(?<=<!-- tools/doc_tables.py: )(?P<name>\w+) -->\n(?P<text>.*?)(?=<!-- end -->)", re.DOTALL
)
E = 0.85  # restitution of the tables that show a single one
SOLVER_STEP = 0.0025  # default step of the studies, in tau
ERRORS = {
    "log_error_median": "error of peaks, median",
    "log_error_90": "error of peaks, 90 % quantile",
    "missed_collapse_rate": "missed collapses",
    "added_collapse_rate": "added collapses",
}


@cache
def read(name: str) -> xr.Dataset:
    """Open a dataset of the full build."""
    return dataset.read(RESULTS / f"{name}.nc")


def read_comparison() -> xr.Dataset:
    """Open the comparison of dampers with CR at one restitution, for all bands together."""
    return read("comparison").sel(restitution=E, band=0)


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    names = list(head)
    head_line, *row_lines = [f"| {' | '.join(cells)} |" for cells in [names, *rows]]
    return "\n".join([head_line, "|" + "---|" * len(names), *row_lines])


def interval(row: xr.Dataset, name: str, write_number: Callable[..., str] = number) -> str:
    """Return a statistic with its interval: "0.144 (0.134 to 0.155)"."""
    low, high = (write_number(bound) for bound in row[f"{name}_interval"].values)
    return f"{write_number(row[name])} ({low} to {high})"


def percentages(row: xr.Dataset, names: Iterable[str]) -> list[str]:
    """Return statistics as percentages."""
    return [percent(row[name]) for name in names]


def signed(change: xr.DataArray) -> str:
    """Return a relative change in per cent, with its sign."""
    return f"{100 * float(change):+.1f}".replace("-0.0", "0.0").replace("+0.0", "0.0")


# --- docs/earthquakes.md --------------------------------------------------------------------------


def order() -> str:
    """Return the error of dampers against their force, and of CR with another e."""
    dampers = ("ECD", "ECD16", "ECD64", "BAND0.4", "BAND0.2", "BAND0.1", "CQD0.25")
    rows = []
    for damper in (*dampers, "e - 0.01", "e + 0.01"):
        row = read("order").sel(restitution=E, damper=damper)
        force_over_strength = number(row["crossing_force"].sel(wall="paper"), 2)
        median, *other_errors = ERRORS
        errors = [interval(row, median, percent), *percentages(row, other_errors)]
        step = plain(row["largest_step"]) if np.isfinite(row["largest_step"]) else DASH
        rows.append([damper, force_over_strength, *errors, step])
    return table(["damper", "force over F0", *ERRORS.values(), "largest ω₁h"], rows)


def earthquakes() -> str:
    """Return the difference of each damper from CR, with xi of least error."""
    study = read_comparison().sel(damping_ratio_source=RECOMMENDED_SOURCE)
    rows = []
    for model in VISCOUS_MODELS:
        row = study.sel(damping_model=model)
        cells = [
            interval(row, "median_ratio"),
            *percentages(row, ["log_error_median", "log_error_90"]),
            interval(row, "missed_collapse_rate", percent),
            interval(row, "added_collapse_rate", percent),
            interval(row, "median_intensity_ratio"),
        ]
        rows.append([model, *cells])
    head = ["damper", "median ratio of peaks", *ERRORS.values(), "ratio of collapse intensities"]
    return table(head, rows)


def sources() -> str:
    """Return the errors of each damper with each of the three damping ratios."""
    sources = [RECOMMENDED_SOURCE, "polynomial", "closed form"]
    study = read_comparison().sel(damping_ratio_source=sources)
    head = [f"error of peaks, {source}" for source in sources]
    head += [f"missed collapses, {source}" for source in sources]
    rows = []
    for model in VISCOUS_MODELS:
        row = study.sel(damping_model=model)
        medians = map(percent, row["log_error_median"])
        missed_rates = map(percent, row["missed_collapse_rate"])
        rows.append([model, *medians, *missed_rates])
    return table(["damper", *head], rows)


def loss_law() -> str:
    """Return the error of a constant e if the loss falls with the amplitude."""
    study = read("loss_law").sel(wall="all")
    limits = zip(study["band_start"], study["band_end"], strict=True)
    bands = [f"ratio of peaks, {low:g} to {high:g} u_ins" for low, high in limits]
    rows = []
    for exponent in study["loss_exponent"].values:
        for amplitude in study["reference_amplitude"].values:
            row = study.sel(loss_exponent=exponent, reference_amplitude=amplitude)
            peak_ratios = [f"{ratio:.2f}" for ratio in row["median_ratio"].values]
            intensity = interval(row, "median_intensity_ratio")
            rows.append([f"{exponent:g}", f"{amplitude:g} u_ins", intensity, *peak_ratios])
    return table(["g", "e measured at", "ratio of collapse intensities", *bands], rows)


# --- other pages ----------------------------------------------------------------------------------


def by_program() -> str:
    """Return which damper to use, by the coefficients that a program accepts."""
    study = read_comparison().sel(damping_ratio_source=RECOMMENDED_SOURCE)
    errors = ["log_error_median", "log_error_90", "missed_collapse_rate"]
    rows = []
    for model, requirement in REQUIREMENT.items():
        row = study.sel(damping_model=model)
        rows.append([requirement, model, REFERENCE_QUANTITY[model], *percentages(row, errors)])
    head = ["your program supports", "use", "frequency of ξ", "median error of the peak"]
    head += ["error exceeded by one peak in ten", "missed collapses"]
    return table(head, rows)


def closed_form() -> str:
    """Return the spread of xi over the amplitude, and the closed form's error at each e [%]."""
    study = read("amplitude")
    measures = {
        "closed form": "damping_ratio_energy",
        "peaks": "damping_ratio_peaks",
        "Err": "damping_ratio",
    }
    rows = []
    for model in study["damping_model"].values:
        row = study.sel(damping_model=model)
        cells = []
        for name in measures.values():
            spread = 100 * np.log(row[name].sel(restitution=E)).std()
            cells.append(f"{float(spread):.1f}")
        for name in ("damping_ratio_peaks", "damping_ratio"):
            difference = row["damping_ratio_energy"] / row[name] - 1
            largest = difference.isel(abs(difference).argmax(["release_amplitude"]))
            cells.append(" / ".join(signed(value) for value in largest))
        rows.append([model, *cells])
    head = ["damper", *(f"spread, {name}" for name in measures)]
    return table([*head, "closed form against peaks", "closed form against Err"], rows)


def rocking() -> str:
    """Return the likelihood of each damper below the best one, and the exponent of the loss."""
    study = read("measured_rocking")
    likelihood = study["log_likelihood"]
    differences = likelihood.max("damping_model") - likelihood
    rows = []
    for model in study["damping_model"].values:
        row = differences.sel(damping_model=model).values
        rows.append([model, *(f"{difference:.1f}" for difference in row)])
    gain = likelihood.sel(damping_model="power law") - likelihood.sel(damping_model=REFERENCE)
    tests = [f"{x:.1f} ({chi2.sf(x, 1):.2g})" for x in 2 * gain.values]
    rows.append(["one e (CR) against the power law: 2 Δln L (p)", *tests])
    bounds = study["amplitude_exponent_interval"].values
    exponents = []
    for value, (low, high) in zip(study["amplitude_exponent"].values, bounds, strict=True):
        exponents.append(f"{value:.2f} ({low:.2f} to {high:.2f})")
    rows.append(["exponent of the energy (90 % interval)", *exponents])
    counts = [f"{count} impacts" for count in study["impacts_used"].values]
    return table(["model", *counts], rows)


def assumed() -> str:
    """Return the effect of each assumption on the median intensity of collapse."""
    supports = read("supports")
    vertical = f"the other component times {float(supports['vertical_factor']):.2g}"
    has_floor = supports["diaphragm_period"].isin([0.1, 0.3, 0.6]).values
    alternatives = [
        ("a rigid floor at the top", f"a flexible {floor}", floor)
        for floor in supports["assumption"].values[has_floor].tolist()
    ]
    alternatives += [
        ("the effective mass of slender blocks", "own inertia of the bodies", "own inertia"),
        ("overburden without mass", "all of it is a mass", "overburden has mass, e unchanged"),
        ("e by the rule `measured`", "e by the rule `impulsive`", "e impulsive"),
        ("e by the rule `measured`", "e of Eq. (7)", "e of Eq. (7)"),
        ("no vertical motion", vertical, "vertical shaking"),
        (
            "an eccentricity that changes side with the wall (worse sign)",
            "one that stays on one side",
            "eccentric overburden, fixed side",
        ),
    ]
    rows = []
    for assumption, alternative, label in alternatives:
        case = supports.sel(assumption=label)
        rows.append([assumption, alternative, *describe_intensities(case)])
    law = read("loss_law").sel(loss_exponent=0.26)
    for amplitude in law["reference_amplitude"].values:
        alternative = f"the loss law of blocks, e measured at {amplitude:g} u_ins"
        case = law.sel(reference_amplitude=amplitude)
        rows.append(["one e at all amplitudes", alternative, *describe_intensities(case)])
    intensities = ["ratio of collapse intensities", "range over the walls"]
    return table(["we assume", "instead", *intensities, "our assumption is"], rows)


def describe_intensities(case: xr.Dataset) -> list[str]:
    """Return the ratio of the intensities of all walls and of single ones, and the side of 1."""
    all_walls = case.sel(wall="all")
    single_walls = case["median_intensity_ratio"].drop_sel(wall="all")
    limits = f"{number(single_walls.min())} to {number(single_walls.max())}"
    return [interval(all_walls, "median_intensity_ratio"), limits, judge_assumption(all_walls)]


def choices() -> str:
    """Return the change of xi of least error with other choices, on the paper's curve [%]."""
    lengths = read("response_lengths")["damping_ratio"].sel(restitution=E)
    releases = read("match/amplitude").sel(restitution=E)
    slender = read("match/slenderness").sel(restitution=E, slenderness=30)
    released = releases["damping_ratio"]
    ours = released.sel(release_amplitude=0.5)
    closed_form = releases["damping_ratio_energy"].sel(release_amplitude=0.5)
    ratios = {
        "response length τ = 6": lengths.sel(response_length=6) / ours,
        "response length τ = 12": lengths.sel(response_length=12) / ours,
        "equal length in seconds, h/t = 30": (
            slender["damping_ratio_fixed_seconds"] / slender["damping_ratio"]
        ),
        "release from 0.3 u_ins": released.sel(release_amplitude=0.3) / ours,
        "release from 0.7 u_ins": released.sel(release_amplitude=0.7) / ours,
        "closed form": closed_form / ours,
    }
    rows = []
    for choice, ratio in ratios.items():
        changes = (ratio.sel(damping_model=model) - 1 for model in VISCOUS_MODELS)
        rows.append([choice, *map(signed, changes)])
    return table(["changed choice", *VISCOUS_MODELS], rows)


def solver() -> str:
    """Return the orders of both schemes, and the error of the default one at the solver's step."""
    study = read("convergence")
    newmark_errors = study["solver_error"].sel(scheme="newmark")
    errors = newmark_errors.sel(step=SOLVER_STEP, method="nearest").max("excitation")
    rows = []
    for model in study["damping_model"].values:
        row = study.sel(damping_model=model)
        newmark_orders = row["convergence_order"].sel(scheme="newmark").values
        paper_orders = row["finest_convergence_order"].sel(scheme="paper").values
        error = f"{float(errors.sel(damping_model=model)):.1e}".replace("e-0", "e-")
        ours = [f"{order:.2f}" for order in newmark_orders]
        printed = [f"{order:.2f}" for order in paper_orders]
        rows.append([model, *ours, error, *printed])
    head = ["model", "order, free decay", "order, under load", "median error"]
    head += ["printed scheme, free decay", "printed scheme, under load"]
    return table(head, rows)


TABLES = {
    "order": order,
    "earthquakes": earthquakes,
    "sources": sources,
    "loss_law": loss_law,
    "by_program": by_program,
    "closed_form": closed_form,
    "rocking": rocking,
    "assumed": assumed,
    "choices": choices,
    "solver": solver,
}


def write(page: str) -> str:
    """Return the text of a page with its tables made again."""
    return BLOCK.sub(lambda block: f"{block['name']} -->\n{TABLES[block['name']]()}\n", page)


def pages() -> list[Path]:
    """Return the pages that have tables."""
    documents = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [page for page in documents if BLOCK.search(page.read_text(encoding="utf-8"))]


if __name__ == "__main__":
    arguments = [Path(argument) for argument in sys.argv[1:]]
    for page in arguments or pages():
        page.write_text(write(page.read_text(encoding="utf-8")), encoding="utf-8")
    for picture in (ROOT / "docs/figures").glob("fig_*.png"):
        shutil.copyfile(RESULTS / "figures" / picture.name, picture)
