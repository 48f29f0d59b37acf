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
from rocking_tables import rocking, rocking_blocks, rocking_restitution
from table_text import interval, models, percent, power, share, table

from rockdamp.claims import VERDICTS
from rockdamp.claims.ratios import spans
from rockdamp.constants import RECOMMENDED_SOURCE, STUDIES, VISCOUS_MODELS
from rockdamp.report.tables import programs, selection
from rockdamp.storage import dataset
from rockdamp.text import number

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
SOURCES = {"polynomial": "polynomials", "least error": "least error", "closed form": "closed form"}
STRATA = {
    "far": "survives, peak below 0.5 u_ins",
    "near": "survives, 0.5 to 0.8 u_ins",
    "edge": "survives, 0.8 u_ins and more",
    "just collapsed": "collapses, and not at the next lower intensity",
    "unconverged": "outcome depends on the step",
}
THOUSANDTH = 1e-3

Data = dict[str, xr.Dataset]

INPUTS = ("convergence", "equivalence", "response_lengths", "comparison", "order")
INPUTS += (
    "measured_rocking",
    "earthquakes/check",
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
            power(one["solver_error"].sel(step=STEP, method="nearest").max()),
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
    """How far each damper is from CR at the middle e, with ξ of the least error."""
    compared = data["comparison"]
    one = compared.isel(restitution=compared.sizes["restitution"] // 2).sel(damping_ratio_source=RECOMMENDED_SOURCE)
    head = ["model", "median ratio of peaks", "abs(ln r), median", "abs(ln r), 90 %", "collapses missed"]
    head += ["collapses added", "ratio of median intensities", "error"]
    rows = [
        [
            model,
            interval(whole, "median_ratio"),
            *(number(whole[name], 2) for name in ("log_error_median", "log_error_90")),
            *(
                interval(whole, name)
                for name in ("missed_collapse_rate", "added_collapse_rate", "median_intensity_ratio")
            ),
            interval(whole, "log_error"),
        ]
        for model, at in models(one)
        if model != "CR"
        for whole in [at.isel(band=0)]
    ]
    said = f"All for e = {float(one['restitution']):g} and ξ of the {SOURCES[RECOMMENDED_SOURCE]}, with 95 % intervals."
    return f"{table(head, rows)}\n\n{said}"


def sources(data: Data) -> str:
    """Medians of abs(ln r) and missed collapses of each damper with each of the three damping ratios, at every e."""
    order = [RECOMMENDED_SOURCE, *(source for source in SOURCES if source != RECOMMENDED_SOURCE)]
    compared = data["comparison"].isel(band=0).sel(damping_ratio_source=order)
    at_e = [f"e = {e:g}" for e in compared["restitution"].values.tolist()]
    head = ["model", *(f"abs(ln r), median, {e}" for e in at_e), *(f"collapses missed, {e}" for e in at_e)]
    columns = {"log_error_median": lambda value: number(value, 2), "missed_collapse_rate": share}
    rows = [
        [
            model,
            *(
                "; ".join(map(show, cell))
                for name, show in columns.items()
                for cell in one[name].transpose("restitution", ...)
            ),
        ]
        for model, one in models(compared)
        if model != "CR"
    ]
    return f"Each cell has the three ξ: {'; '.join(SOURCES[source] for source in order)}.\n\n{table(head, rows)}"


# Median and 90 % of abs(ln r), collapses missed and added in %, of a trial with another kernel, before the study was
# written: by e and damper, under the 44 components of the far-field set and, where it has them, under all 100.
EXPECTED = {
    0.75: {
        "ECD16": ("0.0120, 0.0356; 1.2, 1.1", "0.0120, 0.0348; 0.97, 0.89"),
        "ECD64": ("0.0041, 0.0132; 0.35, 0.6", "–"),
        "BAND0.4": ("0.0089, 0.0295; 1.2, 1.05", "–"),
        "BAND0.2": ("0.0027, 0.0090; 0.3, 0.5", "0.0028, 0.0092; 0.34, 0.37"),
        "BAND0.1": ("0.0011, 0.0042; 0.5, 0.2", "–"),
        "CQD0.25": ("0.0065, 0.0306; 0.5, 0.6", "–"),
        "e - 0.01": ("0.0159, 0.0457; 1.5, 1.1", "0.0140, 0.0431; –"),
        "e + 0.01": ("0.0166, 0.0477; 1.2, 2.0", "0.0146, 0.0434; –"),
    },
    0.85: {
        "ECD16": ("0.0064, 0.0246; 1.2, 1.1", "0.0067, 0.0237; 1.21, 0.97"),
        "ECD64": ("0.0020, 0.0079; 0.7, 1.0", "0.0021, 0.0080; 0.65, 0.54"),
        "BAND0.4": ("0.0053, 0.0216; 1.2, 1.0", "0.0062, 0.0218; 1.24, 0.87"),
        "BAND0.2": ("0.0016, 0.0066; 0.65, 0.8", "0.0017, 0.0069; 0.61, 0.50"),
        "BAND0.1": ("0.0007, 0.0036; 0.5, 0.5", "0.0007, 0.0031; 0.38, 0.41"),
        "CQD0.25": ("0.0081, 0.0345; 0.8, 1.1", "–"),
        "e - 0.01": ("0.0218, 0.0790; 2.1, 2.2", "0.0202, 0.0719; 2.0, 1.6"),
        "e + 0.01": ("0.0233, 0.0992; 1.3, 2.7", "0.0214, 0.0863; 1.2, 2.3"),
    },
}


def order(data: Data) -> str:
    """Error over force of dampers about the crossing, beside what a trial expected."""
    study = data["order"]
    measures = ("log_error_median", "log_error_90", "share_above", "missed_collapse_rate", "added_collapse_rate")
    head = ["e", "damper", "force over F0", "abs(ln r), median", "abs(ln r), 90 %", "above 0.05", "missed", "added"]
    head += ["largest w1 h", "expected, 44 records", "expected, 100 records"]
    rows = []
    for e, expected in EXPECTED.items():
        for damper in ("ECD", *expected):
            one = study.sel(restitution=e, damper=damper)
            force = number(one["crossing_force"].sel(wall="paper"), 2)
            cells = [interval(one, name) for name in measures]
            step = f"{float(one['largest_step']):g}" if np.isfinite(one["largest_step"]) else "–"
            rows.append([f"{e:g}", damper, force, *cells, step, *expected.get(damper, ("–", "–"))])
    return table(head, rows)


def force(data: Data) -> str:
    """The same in short, at e = 0.85."""
    study = data["order"].sel(restitution=0.85)
    rows = [
        [
            f"{name.replace('BAND', 'BAND, t_c = ')}" if name[0] != "e" else f"restitution itself, {name}",
            number(one["crossing_force"].sel(wall="paper"), 2),
            *(percent(one[measure]) for measure in ("log_error_median", "log_error_90", "missed_collapse_rate")),
        ]
        for name in ("ECD16", "BAND0.4", "BAND0.2", "BAND0.1", "e - 0.01", "e + 0.01")
        for one in [study.sel(damper=name)]
    ]
    head = ["damper", "force over F0", "abs(ln r), median", "abs(ln r), 90 %", "collapses missed"]
    return table(head, rows)


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


COLLAPSE = ("median_intensity_ratio", "missed_collapse_rate", "added_collapse_rate")


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
                interval(one, name)
                for name in ("median_intensity_ratio", "missed_collapse_rate", "added_collapse_rate")
            ]
            rows.append([f"{g:g}", f"{at:g} u_ins", *cells, *(f"{float(ratio):.2f}" for ratio in one["median_ratio"])])
    return table(head, rows)


def by_program(data: Data) -> str:
    """Which damper to use by what a program takes, at the middle e."""
    compared = data["comparison"]
    middle = compared.sizes["restitution"] // 2
    head = ["your program takes", "use", "ξ refers to", "abs(ln r), median", "abs(ln r), 90 %", "collapses missed"]
    rows = [
        [row["offer"], row["model"], row["refers_to"], *(error[middle] for error in row["errors"])]
        for row in programs(compared)
    ]
    e = float(compared["restitution"][middle])
    return (
        f"{table(head, rows)}\n\nUse the first that your program can take. Against restitution with e = {e:g}, with ξ "
        f"of the {SOURCES[RECOMMENDED_SOURCE]}.\nThe same histories for all: {selection(compared)}."
    )


def response_length(data: Data) -> str:
    """How sharply the paper's range of e picks a length of the response, and which other releases would pick."""
    response_lengths = data["response_lengths"]
    inferred, wrong = float(response_lengths["inferred_response_length"]), response_lengths["misclassified"]
    others, near = wrong.drop_sel(response_length=inferred), response_lengths["near_misclassified"]
    ends = [f"{float(end):g}" for end in (near["near_response_length"][0], near["near_response_length"][-1])]
    lengths, least = response_lengths["response_length"].values.tolist(), int(near.min())
    none, few = (spans(near <= most) for most in (least, least + 2))
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


_FIRST = (solver, ratios, fits, order, earthquakes, sources, loss_law, checks, closed_form)
_ROCKING = (rocking, rocking_restitution, rocking_blocks)
_LAST = (by_program, assumed, response_length, *_ROCKING, force, verdicts)
TABLES: dict[str, Callable[[Data], str]] = {function.__name__: function for function in (*_FIRST, *_LAST)}


def written(page: str, data: Data) -> str:
    """Return the text of a page with its tables made anew."""

    def anew(block: re.Match[str]) -> str:
        return f"{block['name']} -->\n{TABLES[block['name']](data)}\n"

    return BLOCK.sub(anew, page)


def missed_collapses(compared: xr.Dataset) -> str:
    """Return the shares of collapses that each damper misses, as the package ships them: ratios of least error."""
    rates = compared["missed_collapse_rate"].sel(damping_ratio_source=RECOMMENDED_SOURCE).drop_sel(damping_model="CR")
    rates = rates.rename("missed_collapse_rate").transpose("restitution", "damping_model")
    rows = rates.to_series().round(6).reset_index()
    return str(rows.to_csv(index=False, lineterminator="\n"))


def read(results: Path) -> Data:
    """Open the datasets that the tables are made of."""
    names = [*INPUTS, *(f"match/{study}" for study in STUDIES)]
    opened = {name: dataset.read(results / f"{name}.nc") for name in names}
    return {**opened, "claims": pd.read_csv(results / "claims.csv").to_xarray()}


if __name__ == "__main__":
    if len(sys.argv) > 2 or sys.argv[1:2] in (["-h"], ["--help"]):
        sys.exit("usage: measured_tables.py [FOLDER OF THE RESULTS]")
    results = Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS
    opened = read(results)
    for page in map(ROOT.joinpath, PAGES):
        page.write_text(written(page.read_text(encoding="utf-8"), opened), encoding="utf-8")
    (SHIPPED / "missed_collapses.csv").write_text(missed_collapses(opened["comparison"]), encoding="utf-8")
    for picture in (results / name for name in PICTURES):
        shutil.copyfile(picture, ROOT / "docs/figures" / picture.name)
