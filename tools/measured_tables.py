"""Write the measured numbers into the pages of docs that are named below, from the datasets of a full build,
and copy the figures that the documents show. It writes the tables that the package ships too.

`.venv/bin/python tools/measured_tables.py`, after `make`. Each table stands between two comments, of which the first
names it; the words around the tables hold no measured number.
"""

import math
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from assumption_tables import assumed
from order_tables import by_band, orders
from rocking_tables import (
    rocking,
    rocking_blocks,
    rocking_choices,
    rocking_curves,
    rocking_errors,
    rocking_restitution,
)
from table_text import interval, models, percent, power, share, table

from rockdamp.claims.verdicts import spans
from rockdamp.figures.style import dampers, nearest
from rockdamp.report.answer import by_program as programs
from rockdamp.report.answer import selection
from rockdamp.report.earthquake_criterion import by_source
from rockdamp.report.earthquakes import SOURCES, STRATA, recommended
from rockdamp.report.tables import VERDICTS
from rockdamp.storage import dataset
from rockdamp.text import number
from rockdamp.vocabulary import RECOMMENDED_SOURCE, STUDIES, VISCOUS_MODELS

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"
SHIPPED = ROOT / "src/rockdamp/equivalence"
DOCS = (
    "accuracy",
    "earthquakes",
    "theory",
    "howto/the-damper-in-your-program",
    "assumptions",
    "measured",
)
PAGES = (*(f"docs/{name}.md" for name in DOCS), "README.md")
PICTURES = (
    "figures/fig_order.png",
    "figures/fig_measured_rocking.png",
)
BLOCK = re.compile(r"(?<=<!-- tools/measured_tables.py: )(?P<name>\w+) -->\n(?P<text>.*?)(?=<!-- end -->)", re.DOTALL)

STEP = 0.0025  # of the solver, in tau
THOUSANDTH = 1e-3

Data = dict[str, xr.Dataset]

INPUTS = ("convergence", "equivalence", "response_lengths", "comparison", "recommendation")
INPUTS += (
    "measured_rocking",
    "earthquakes/check",
    "earthquakes/walls",
    "earthquakes/orders",
    "amplitude",
    "loss_law",
    "supports",
)


def solver(data: Data) -> str:
    """Orders of both schemes, and the error of the default one at the solver's step."""
    head = [
        "model",
        "order, free",
        "order, forced",
        "median error",
        "printed, free",
        "printed, forced",
    ]
    default, printed = (data["convergence"].sel(scheme=scheme) for scheme in ("newmark", "paper"))
    rows = [
        [
            model,
            *(f"{float(order):.2f}" for order in one["convergence_order"]),
            power(one["solver_error"].isel(step=nearest(one["step"].values.tolist(), STEP)).max()),
            *(f"{float(order):.2f}" for order in printed["finest_convergence_order"].sel(damping_model=model)),
        ]
        for model, one in models(default)
    ]
    return table(head, rows)


def ratios(data: Data) -> str:
    """Uncertainties of the published damping ratios, and which are the largest."""
    matches = {parameter: data[f"match/{study}"] for study, parameter in STUDIES.items()}
    uncertain = {
        parameter: match["damping_ratio_uncertainty"] / match["damping_ratio"] for parameter, match in matches.items()
    }
    rows = []
    for model in VISCOUS_MODELS:
        of_model = np.concatenate([each.sel(damping_model=model).values.ravel() for each in uncertain.values()])
        rows.append([model, f"{100 * (of_model < THOUSANDTH).mean():.1f} %", percent(of_model.max())])
    exceptions = [
        f"- {model}, e = {e:.2f}, {parameter.replace('_', ' ')} {value:g}: {percent(uncertainty)}"
        for parameter, each in uncertain.items()
        for (model, value, e), uncertainty in each.to_series().items()
        if uncertainty >= THOUSANDTH
    ]
    head = ["model", "uncertainty below 0.1 %", "largest uncertainty"]
    return "\n".join([table(head, rows), "", "Uncertainties of 0.1 % or more:", "", *(exceptions or ["- none"])])


def fits(data: Data) -> str:
    """Largest relative errors of both fits of xi(e), by model and range of e."""
    equivalence = data["equivalence"]
    ends = equivalence["restitution_range"].values.tolist()
    kinds = (("xi(e)", "largest_relative_error"), ("in delta", "delta_largest_relative_error"))
    head = ["model", "least R²", *(f"{kind}, e up to {end:.2f}" for kind, _ in kinds for end in ends)]
    rows = [
        [model, f"{math.floor(1e4 * float(one['r_squared'].min())) / 1e4:.4f}"]
        + [percent(one[name].sel(restitution_range=end).max()) for _, name in kinds for end in ends]
        for model, one in models(equivalence)
    ]
    last = max(equivalence["restitution"].values.tolist())
    return f"{table(head, rows)}\n\nEach range begins beyond the one before; e ends at {last:.2f}."


def earthquakes(data: Data) -> str:
    """Which damper to use, and how far each damper is from CR at the middle e, with ξ of the least error."""
    compared, chosen = data["comparison"], recommended(data["recommendation"])
    first = f"**Use {chosen[0].model}.**" if chosen else "No damper has the least error at every e, or near to it."
    one = compared.isel(restitution=compared.sizes["restitution"] // 2).sel(damping_ratio_source=RECOMMENDED_SOURCE)
    small_change = one["varied_log_error"].isel(band=0).max()
    columns = {
        "median ratio of peaks": "median_ratio",
        "error": "log_error",
        "more than the least": "log_error_excess",
        "collapses missed": "false_safe_rate",
        "collapses added": "false_collapse_rate",
        "ratio of median intensities": "median_intensity_ratio",
    }
    rows = [
        [model, *(interval(at.isel(band=0), name) for name in columns.values())]
        for model, at in models(one)
        if model != "CR"
    ]
    return (
        f"{first}\n\n{table(['model', *columns], rows)}\n\nAll for e = {float(one['restitution']):g} and ξ of the "
        f"{SOURCES[RECOMMENDED_SOURCE]}, with 95 % intervals. The small-change error of CR is there "
        f"{number(small_change, 2)}.{by_band(data, chosen)}"
    )


def sources(data: Data) -> str:
    """Errors and missed collapses of each damper with each of the three damping ratios, at every e."""
    compared = data["comparison"]
    told = by_source(compared, data["earthquakes/walls"], dampers(compared), SOURCES)
    at_e = [f"e = {e:g}" for e in compared["restitution"].values.tolist()]
    head = ["model", *(f"error, {e}" for e in at_e), *(f"collapses missed, {e}" for e in at_e)]
    rows = [[model, *(cell[part] for part in (0, 1) for cell in cells)] for model, cells in told["by_source"]]
    said = f"Each cell has the three ξ: {'; '.join(told['source_order'])}.\n\n{table(head, rows)}"
    if why := told["reason"]:
        said += f"\n\nWhere the closed form errs less, it is by at most {why['loss']} of the error. "
        if why["missed_more"]:
            said += (
                f"The price: at e = {why['e']}\n{why['model']} misses {why['missed']} of the collapses with the least "
                f"error, and {why['missed_closed']} with the closed form. "
            )
        said += f"For {why['exact']}\nthe closed form is exact on any wall; both ξ differ by at most {why['apart']} "
        said += "on these walls."
    return said


def checks(data: Data) -> str:
    """How the histories of the study compare with the event-driven solver, by stratum."""
    head = ["histories", "in all", "solved again", "end otherwise", "beyond the bound", "median difference", "largest"]
    rows = []
    shares = ("otherwise_share", "beyond_bound_share", "median_difference", "largest_difference")
    for stratum, one in models(data["earthquakes/check"], "stratum"):
        counts = [str(int(one[key])) for key in ("study_count", "checked_count")]
        rows.append([STRATA[stratum], *counts, *(share(one[key]) for key in shares)])
    return table(head, rows)


def closed_form(data: Data) -> str:
    """Spreads of the damping ratio over the amplitude, and the closed form's largest differences by e, in %."""
    study = data["amplitude"]
    measures = {"closed form": "damping_ratio_energy", "peaks": "damping_ratio_peaks", "Err": "damping_ratio"}
    rows = []
    for model, one in models(study):
        ratio = one.isel(restitution=one.sizes["restitution"] // 2)
        spreads = [100 * float(np.log(ratio[name]).std()) for name in measures.values()]
        away = [100 * (one["damping_ratio_energy"] / one[measures[name]] - 1) for name in ("peaks", "Err")]
        largest = [" / ".join(_largest(at_e) for at_e in each.transpose("restitution", ...)) for each in away]
        rows.append([model, *(f"{spread:.1f}" for spread in spreads), *largest])
    head = ["model", *(f"spread, {name}" for name in measures), "closed form less peaks", "closed form less Err"]
    return table(head, rows)


def _largest(percents: xr.DataArray) -> str:
    """Return the value furthest from zero, as text with its sign; a zero has none."""
    text = f"{percents.values.ravel()[np.abs(percents).values.argmax()]:+.1f}"
    return "0.0" if float(text) == 0 else text


def loss_law(data: Data) -> str:
    """What a constant e costs if the loss falls with the amplitude: collapse with intervals, and peaks by band."""
    study = data["loss_law"].isel(wall=0)
    edges = zip(study["band_start"].values.tolist(), study["band_end"].values.tolist(), strict=True)
    head = ["g", "e is that of", "median intensity of collapse", "collapses gone", "collapses added"]
    head += [f"{low:g}-{high:g}" for low, high in edges]
    rows = []
    for g in study["loss_exponent"].values.tolist():
        for at in study["reference_amplitude"].values.tolist():
            one = study.sel(loss_exponent=g, reference_amplitude=at)
            cells = [
                interval(one, name) for name in ("median_intensity_ratio", "false_safe_rate", "false_collapse_rate")
            ]
            rows.append([f"{g:g}", f"{at:g} u_ins", *cells, *(f"{float(ratio):.2f}" for ratio in one["median_ratio"])])
    return table(head, rows)


def by_program(data: Data) -> str:
    """Which damper to use by what a program takes, at the middle e."""
    middle = data["recommendation"].sizes["restitution"] // 2
    e = float(data["recommendation"]["restitution"][middle])
    head = ["your program takes", "use", "ξ refers to", "peak error", "collapses missed"]
    rows = [
        [row["offer"], row["model"], row["refers_to"], row["error"][middle], row["missed"][middle]]
        for row in programs(data)
    ]
    return (
        f"{table(head, rows)}\n\nUse the first that your program can take. Against restitution with e = {e:g}, with ξ "
        f"of the {SOURCES[RECOMMENDED_SOURCE]}.\nThe same histories for all: "
        f"{selection(data)}."
    )


def response_length(data: Data) -> str:
    """How sharply the paper's range of e picks a length of the response, and which other releases would pick."""
    response_lengths = data["response_lengths"]
    inferred, wrong = float(response_lengths["inferred_response_length"]), response_lengths["misclassified"]
    others, near = wrong.drop_sel(response_length=inferred), response_lengths["near_misclassified"]
    ends = [f"{float(end):g}" for end in (near["near_response_length"][0], near["near_response_length"][-1])]
    lengths, least = response_lengths["response_length"].values.tolist(), int(near.min())
    none, few = (spans(near <= most, "").strip() for most in (least, least + 2))
    head = [
        "released from u0/u_ins =",
        *(f"{release:g}" for release in response_lengths["release_amplitude"].values.tolist()),
    ]
    rows = [
        [name, *(f"{value:g}" for value in response_lengths[variable].values.tolist())]
        for name, variable in (
            ("length implied, in tau", "inferred_response_length_of_release"),
            ("e at which it fails", "misclassified_of_release"),
        )
    ]
    return (
        f"It is {int(wrong.sel(response_length=inferred))} at {inferred:g} and at least {int(others.min())} at every"
        f" other length from {lengths[0]:g} to {lengths[-1]:g} in steps of {lengths[1] - lengths[0]:g}.\n"
        f"Between {ends[0]} and {ends[1]}, in tenths, it is {least} at {none} and at most {least + 2} at {few}.\n\n"
        f"{table(head, rows)}"
    )


def verdicts(data: Data) -> str:
    """How many claims of the paper got each verdict."""
    given = data["claims"]["verdict"].values
    return table(("verdict", "claims"), ((verdict, str(int((given == verdict).sum()))) for verdict in VERDICTS))


_FIRST = (solver, ratios, fits, earthquakes, sources, loss_law, checks, orders, closed_form)
_ROCKING = (rocking, rocking_curves, rocking_errors, rocking_choices, rocking_restitution, rocking_blocks)
_LAST = (
    by_program,
    assumed,
    response_length,
    *_ROCKING,
    verdicts,
)
TABLES: dict[str, Callable[[Data], str]] = {function.__name__: function for function in (*_FIRST, *_LAST)}


def written(page: str, data: Data) -> str:
    """Return the text of a page with its tables made anew."""

    def anew(block: re.Match[str]) -> str:
        return f"{block['name']} -->\n{TABLES[block['name']](data)}\n"

    return BLOCK.sub(anew, page)


def false_safe(compared: xr.Dataset) -> str:
    """Return the shares of collapses that each damper misses, as the package ships them: ratios of least error."""
    rates = compared["false_safe_rate"].sel(damping_ratio_source=RECOMMENDED_SOURCE).drop_sel(damping_model="CR")
    rows = rates.transpose("restitution", "damping_model").to_series().round(6).reset_index()
    return str(rows.to_csv(index=False, lineterminator="\n"))


def read(results: Path) -> Data:
    """Open the datasets that the tables are made of."""
    names = [*INPUTS, *(f"match/{study}" for study in STUDIES)]
    opened = {name: dataset.open(results / f"{name}.nc") for name in names}
    return {**opened, "claims": pd.read_csv(results / "claims.csv").to_xarray()}


if __name__ == "__main__":
    if len(sys.argv) > 2 or sys.argv[1:2] in (["-h"], ["--help"]):
        sys.exit("usage: measured_tables.py [FOLDER OF THE RESULTS]")
    results = Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS
    opened = read(results)
    for page in map(ROOT.joinpath, PAGES):
        page.write_text(written(page.read_text(encoding="utf-8"), opened), encoding="utf-8")
    (SHIPPED / "false_safe.csv").write_text(false_safe(opened["comparison"]), encoding="utf-8")
    for picture in (results / name for name in PICTURES):
        shutil.copyfile(picture, ROOT / "docs/figures" / picture.name)
