"""Write the tables of measured numbers into the documents, from the datasets of a full build.

`.venv/bin/python tools/doc_tables.py [PAGE ...]` after `make`; without a page, all pages. A table stands between two
comments. The first names a function of this file, which returns the table. The figures of docs/figures are copied too.
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
from rockdamp.storage import dataset
from rockdamp.text import DASH, number, percent, plain

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"
BLOCK = re.compile(
    r"(?<=<!-- tools/doc_tables.py: )(?P<name>\w+) -->\n(?P<text>.*?)(?=<!-- end -->)", re.DOTALL
)
E = 0.85  # the restitution of tables with one
STEP = 0.0025  # of the solver, in tau
ERRORS = ("log_error_median", "log_error_90", "missed_collapse_rate", "added_collapse_rate")
ERROR_HEAD = (
    "error of peaks, median",
    "error of peaks, 90 % quantile",
    "missed collapses",
    "added collapses",
)


@cache
def read(name: str) -> xr.Dataset:
    """Open a dataset of the full build."""
    return dataset.read(RESULTS / f"{name}.nc")


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    first, *rest = (list(line) for line in (head, *rows))
    return "\n".join(f"| {' | '.join(line)} |" for line in (first, ["---"] * len(first), *rest))


def interval(row: xr.Dataset, name: str, show: Callable[..., str] = number) -> str:
    """Return a statistic with its interval: "0.144 (0.134 to 0.155)"."""
    low, high = (show(bound) for bound in row[f"{name}_interval"].values)
    return f"{show(row[name])} ({low} to {high})"


def signed(change: xr.DataArray) -> str:
    """Return a relative change in per cent, with its sign."""
    return f"{100 * float(change):+.1f}".replace("-0.0", "0.0").replace("+0.0", "0.0")


# --- docs/earthquakes.md ---------------------------------------------------------------------------------------------


def order() -> str:
    """Error against force of the dampers at the crossing, and CR with another e."""
    rows = []
    for damper in (
        "ECD",
        "ECD16",
        "ECD64",
        "BAND0.4",
        "BAND0.2",
        "BAND0.1",
        "CQD0.25",
        "e - 0.01",
        "e + 0.01",
    ):
        row = read("order").sel(restitution=E, damper=damper)
        force_over_strength = number(row["crossing_force"].sel(wall="paper"), 2)
        errors = [interval(row, ERRORS[0], percent), *(percent(row[name]) for name in ERRORS[1:])]
        step = plain(row["largest_step"]) if np.isfinite(row["largest_step"]) else DASH
        rows.append([damper, force_over_strength, *errors, step])
    return table(["damper", "force over F0", *ERROR_HEAD, "largest ω₁h"], rows)


def earthquakes() -> str:
    """Return how far each damper is from CR, with xi of least error."""
    study = read("comparison").sel(restitution=E, damping_ratio_source=RECOMMENDED_SOURCE, band=0)
    rows = [
        [
            model,
            interval(row, "median_ratio"),
            *(percent(row[name]) for name in ERRORS[:2]),
            *(interval(row, name, percent) for name in ERRORS[2:]),
            interval(row, "median_intensity_ratio"),
        ]
        for model in VISCOUS_MODELS
        for row in [study.sel(damping_model=model)]
    ]
    return table(
        ["damper", "median ratio of peaks", *ERROR_HEAD, "ratio of collapse intensities"], rows
    )


def sources() -> str:
    """Errors of each damper with each of the three damping ratios."""
    sources = [RECOMMENDED_SOURCE, "polynomial", "closed form"]
    study = read("comparison").sel(restitution=E, band=0, damping_ratio_source=sources)
    rows = [
        [
            model,
            *(
                percent(value)
                for name in (ERRORS[0], ERRORS[2])
                for value in study[name].sel(damping_model=model)
            ),
        ]
        for model in VISCOUS_MODELS
    ]
    quantities = ("error of peaks", "missed collapses")
    head = [f"{quantity}, ξ: {source}" for quantity in quantities for source in sources]
    return table(["damper", *head], rows)


def loss_law() -> str:
    """Return what a constant e costs if the loss falls with the amplitude: collapse, and peaks by band."""
    study = read("loss_law").sel(wall="all")
    bands = [
        f"{low:g} to {high:g}"
        for low, high in zip(study["band_start"], study["band_end"], strict=True)
    ]
    rows = [
        [
            f"{g:g}",
            f"{at:g} u_ins",
            interval(row, "median_intensity_ratio"),
            *(f"{ratio:.2f}" for ratio in row["median_ratio"].values),
        ]
        for g in study["loss_exponent"].values
        for at in study["reference_amplitude"].values
        for row in [study.sel(loss_exponent=g, reference_amplitude=at)]
    ]
    head = ["g", "e measured at", "ratio of collapse intensities"]
    return table([*head, *(f"ratio of peaks, {band} u_ins" for band in bands)], rows)


# --- other pages -----------------------------------------------------------------------------------------------------


def by_program() -> str:
    """Return which damper to use by what a program accepts."""
    study = read("comparison").sel(restitution=E, damping_ratio_source=RECOMMENDED_SOURCE, band=0)
    rows = [
        [accepted, model, REFERENCE_QUANTITY[model], *(percent(row[name]) for name in ERRORS[:3])]
        for model, accepted in REQUIREMENT.items()
        for row in [study.sel(damping_model=model)]
    ]
    errors = ["typical error of the peak", "one peak in ten errs by more than", "collapses missed"]
    return table(["your program supports", "use", "ξ refers to", *errors], rows)


def closed_form() -> str:
    """Spreads of xi over the amplitude, and the largest differences of the closed form at each e, in %."""
    study = read("amplitude")
    measures = {
        "closed form": "damping_ratio_energy",
        "peaks": "damping_ratio_peaks",
        "Err": "damping_ratio",
    }
    rows = []
    for model in study["damping_model"].values:
        row = study.sel(damping_model=model)
        spreads = [100 * np.log(row[name].sel(restitution=E)).std() for name in measures.values()]
        cells = [f"{float(spread):.1f}" for spread in spreads]
        for name in ("peaks", "Err"):
            difference = row["damping_ratio_energy"] / row[measures[name]] - 1
            largest = difference.isel(abs(difference).argmax(["release_amplitude"]))
            cells.append(" / ".join(signed(value) for value in largest))
        rows.append([model, *cells])
    head = ["damper", *(f"spread, {name}" for name in measures)]
    return table([*head, "closed form against peaks", "closed form against Err"], rows)


def rocking() -> str:
    """Return how far ln L of each damper is below the best, one e against the power law, and the exponent."""
    study = read("measured_rocking")
    likelihood, counts = study["log_likelihood"], study["impacts_used"].values
    behind = likelihood.max("damping_model") - likelihood
    models = study["damping_model"].values
    rows = [
        [model, *(f"{value:.1f}" for value in behind.sel(damping_model=model).values)]
        for model in models
    ]
    twice = (
        2
        * (
            likelihood.sel(damping_model="power law") - likelihood.sel(damping_model=REFERENCE)
        ).values
    )
    rows.append(
        [
            "one e (CR) against the power law: 2 Δln L (p)",
            *(f"{x:.1f} ({chi2.sf(x, 1):.2g})" for x in twice),
        ]
    )
    exponents = zip(
        study["amplitude_exponent"].values, study["amplitude_exponent_interval"].values, strict=True
    )
    cells = (f"{value:.2f} ({low:.2f} to {high:.2f})" for value, (low, high) in exponents)
    rows.append(["exponent of the energy (90 % interval)", *cells])
    return table(["model", *(f"{count} impacts" for count in counts)], rows)


def rocking_blocks() -> str:
    """Restitution over Housner's and the spread of a trial's ln e, by slenderness."""
    rows = []
    for slenderness, row in read("measured_rocking").groupby("geometry"):
        low, high = row["restitution_over_housner_interval"].squeeze().values
        over, spread = (
            float(row["restitution_over_housner"].squeeze()),
            float(row["trial_deviation"].squeeze()),
        )
        trials = int(row["geometry_trials"].squeeze())
        rows.append(
            [
                f"{slenderness:g}",
                f"{trials}",
                f"{over:.3f} ({low:.3f} to {high:.3f})",
                f"{spread:.3f}",
            ]
        )
    return table(
        ["H/B", "trials", "e over Housner's e (90 % interval)", "standard deviation of ln e"], rows
    )


def assumed() -> str:
    """Return the intensity of collapse with another assumption over that with ours, and which side ours is on."""
    supports, loss = read("supports"), read("loss_law").sel(loss_exponent=0.26)
    rule, vertical = (
        "e by the rule `measured`",
        f"the other component times {float(supports['vertical_factor']):.2g}",
    )
    has_floor = supports["diaphragm_period"].isin([0.1, 0.3, 0.6]).values
    floors = supports["assumption"].values[has_floor].tolist()
    changes = [
        *(("a rigid floor at the top", f"a {floor}", floor) for floor in floors),
        ("the mass of slender blocks", "own inertia of the bodies", "own inertia"),
        ("overburden without mass", "all of it is a mass", "overburden has mass, e unchanged"),
        (rule, "e by the rule `impulsive`", "e impulsive"),
        (rule, "e of Eq. (7)", "e of Eq. (7)"),
        ("no vertical motion", vertical, "vertical shaking"),
        ("the worse sign of the eccentricity", "a fixed side", "eccentric overburden, fixed side"),
    ]
    cases = [(ours, other, supports.sel(assumption=name)) for ours, other, name in changes]
    cases += [
        (
            "one e at all amplitudes",
            f"the measured law, e measured at {at:g} u_ins",
            loss.sel(reference_amplitude=at),
        )
        for at in loss["reference_amplitude"].values
    ]
    rows = []
    for ours, other, case in cases:
        whole, walls = case.sel(wall="all"), case["median_intensity_ratio"].drop_sel(wall="all")
        low, high = whole["median_intensity_ratio_interval"].values
        side = "unsafe" if high < 1 else "safe" if low > 1 else "neither"
        ends = f"{number(walls.min())} to {number(walls.max())}"
        rows.append([ours, other, interval(whole, "median_intensity_ratio"), ends, side])
    head = [
        "we assume",
        "instead",
        "ratio of collapse intensities",
        "range over the walls",
        "our assumption is",
    ]
    return table(head, rows)


def choices() -> str:
    """Return how much another choice changes xi of least error on the paper's curve, in %."""
    lengths = read("response_lengths")["damping_ratio"].sel(restitution=E)
    amplitudes, walls = (
        read("match/amplitude").sel(restitution=E),
        read("match/slenderness").sel(restitution=E),
    )
    released, half = amplitudes["damping_ratio"], amplitudes.sel(release_amplitude=0.5)
    slender = walls.sel(slenderness=30)
    changed = {
        f"response length τ = {tau}": lengths.sel(response_length=tau) / half["damping_ratio"]
        for tau in (6, 12)
    }
    changed["equal length in seconds, h/t = 30"] = (
        slender["damping_ratio_fixed_seconds"] / slender["damping_ratio"]
    )
    for x0 in (0.3, 0.7):
        changed[f"release from {x0} u_ins"] = (
            released.sel(release_amplitude=x0) / half["damping_ratio"]
        )
    changed["closed form"] = half["damping_ratio_energy"] / half["damping_ratio"]
    rows = [
        [what, *(signed(ratio.sel(damping_model=model) - 1) for model in VISCOUS_MODELS)]
        for what, ratio in changed.items()
    ]
    return table(["changed choice", *VISCOUS_MODELS], rows)


def solver() -> str:
    """Orders of both schemes, and the error of the default one at the solver's step."""
    study = read("convergence")
    error = (
        study["solver_error"]
        .sel(scheme="newmark")
        .sel(step=STEP, method="nearest")
        .max("excitation")
    )
    default, printed = study["convergence_order"], study["finest_convergence_order"]
    rows = [
        [
            model,
            *(
                f"{order:.2f}"
                for order in default.sel(scheme="newmark", damping_model=model).values
            ),
            f"{float(error.sel(damping_model=model)):.1e}".replace("e-0", "e-"),
            *(f"{order:.2f}" for order in printed.sel(scheme="paper", damping_model=model).values),
        ]
        for model in study["damping_model"].values
    ]
    return table(
        [
            "model",
            "order, free decay",
            "order, under load",
            "median error",
            "printed scheme, free decay",
            "printed scheme, under load",
        ],
        rows,
    )


TABLES = {
    function.__name__: function
    for function in (order, earthquakes, sources, loss_law, by_program)
    + (closed_form, rocking, rocking_blocks, assumed, choices, solver)
}


def write(page: str) -> str:
    """Return the text of a page with its tables made again."""
    return BLOCK.sub(lambda block: f"{block['name']} -->\n{TABLES[block['name']]()}\n", page)


def pages() -> list[Path]:
    """Return the pages that have tables."""
    every = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [page for page in every if BLOCK.search(page.read_text(encoding="utf-8"))]


if __name__ == "__main__":
    for page in [Path(argument) for argument in sys.argv[1:]] or pages():
        page.write_text(write(page.read_text(encoding="utf-8")), encoding="utf-8")
    for picture in (ROOT / "docs/figures").glob("fig_*.png"):
        shutil.copyfile(RESULTS / "figures" / picture.name, picture)
