"""The report's section on earthquakes: which damper to use instead of restitution, when, and when not.

The words are in a template; which of them are printed follows from the numbers, and those from the datasets.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from rockdamp.config import Config
from rockdamp.figures.style import dampers
from rockdamp.report import earthquake_criterion as criterion
from rockdamp.storage.dataset import Datasets
from rockdamp.studies.recommendation import MULTIPLE, TOLERANCE
from rockdamp.text import listed, number, percent, plain, span
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER, RECOMMENDED_SOURCE, REFERENCE

TEMPLATE = "earthquakes.html.j2"
SOURCES = {"polynomial": "polynomials", "least error": "least error", "closed form": "closed form"}
ENOUGH_STATIONS = 10  # intervals over fewer mean nothing
CHECKS = {
    "earthquakes/check": "Histories of the study, solved again event by event",
}
STRATA = {
    "far": "survives, peak below 0.5 u_ins",
    "near": "survives, 0.5 to 0.8 u_ins",
    "edge": "survives, 0.8 u_ins and more",
    "just collapsed": "collapses, and not at the next lower intensity",
    "unconverged": "outcome depends on the step",
}
VARIATIONS = {
    "step": "step four times as long",
    "impact": "impact at the end of the step",
    "lower e": "e lower by {}",
    "higher e": "e higher by {}",
}


class Choice(NamedTuple):
    """A damper and the source of its damping ratio."""

    model: str
    source: str


def section(data: Datasets, config: Config) -> Markup | None:
    """Return the section as HTML, none without its datasets."""
    if any(name not in data for name in ("comparison", "recommendation", "earthquakes/walls")):
        return None
    compared, advice, walls = (data[name] for name in ("comparison", "recommendation", "earthquakes/walls"))
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"number": number, "percent": percent, "plain": plain, "listed": listed}
    environment.globals |= {"interval": with_interval, "each": _each}
    text = files("rockdamp.report").joinpath(TEMPLATE).read_text(encoding="utf-8")
    change = plain(config.earthquakes.restitution_change)
    values = {
        **run(compared, walls),
        "compared": compared,
        "checks": [(text, data.get(name)) for name, text in CHECKS.items()],
        "strata": STRATA,
        "names": SOURCES,
        "exceptions": exceptions(data.get("earthquakes")),
        **_sensitivity(compared, advice, change),
        **_recommendation(compared, advice),
        **criterion.by_source(compared, walls, dampers(compared), SOURCES),
        **_orders(data.get("earthquakes/orders"), advice),
        **_walls(compared, walls),
        "change": change,
        "fit_plateau": plain(float(config.curve.strength_ratio)),
        "limit": MULTIPLE,
        "multiple": plain(MULTIPLE),
        "tolerance": plain(TOLERANCE),
        "middle": compared.sizes["restitution"] // 2,
        "steps": list(map(_at, _each(compared), _each(advice))),
    }
    return Markup(environment.from_string(text).render(values))


# --- numbers ----------------------------------------------------------------------------------------------------------


def with_interval(cell: xr.Dataset, name: str, rate: bool = False) -> str:
    """Return a statistic and its interval: "0.149 (0.138 to 0.160)"."""
    show = percent if rate else number
    bounds = cell[f"{name}_interval"].values
    if not np.isfinite(bounds).all():
        return show(cell[name])
    return Markup("{} <small>({} to {})</small>").format(show(cell[name]), *(show(bound) for bound in bounds))


def _e(at_e: xr.Dataset) -> str:
    return plain(at_e["restitution"])


def _cell(statistics: xr.Dataset, choice: Choice) -> xr.Dataset:
    return statistics.sel(damping_model=choice.model, damping_ratio_source=choice.source)


def _choices(statistics: xr.Dataset) -> list[Choice]:
    return [
        Choice(model, str(source))
        for model in dampers(statistics)
        for source in statistics["damping_ratio_source"].values
    ]


def marked(advice: xr.Dataset, name: str) -> list[Choice]:
    """Return the choices at which a variable of the recommendation is 1."""
    return [choice for choice in _choices(advice) if int(_cell(advice, choice)[name]) == 1]


def recommended(advice: xr.Dataset) -> tuple[Choice, list[Choice]] | None:
    """Return the damper and source to use, and those that are as good; none where no damper is recommended."""
    use = marked(advice, "recommended")
    return (use[0], marked(advice, "as_good")) if use else None


def grouped(choices: Sequence[Choice]) -> str:
    """Name dampers with the sources of their ratios: "CDR (polynomials, closed form)"."""
    by_model: dict[str, list[str]] = {}
    for model, source in choices:
        by_model.setdefault(model, []).append(SOURCES.get(source, source))
    return listed(f"{model} (ξ: {', '.join(sources)})" for model, sources in by_model.items())


# --- what was run, and each e -----------------------------------------------------------------------------------------


def run(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """Return how many walls, records and histories there are, and how certain their outcomes and peaks."""
    each = int(np.isfinite(walls["damping_ratio"].values).sum()) + walls.sizes["wall"] * walls.sizes["restitution"]
    uncertainty = compared["relative_uncertainty"]
    return {
        "few": int(compared["stations"]) < ENOUGH_STATIONS,
        "wall_count": walls.sizes["wall"],
        "restitutions": listed(plain(value) for value in compared["restitution"].values),
        "histories": f"{int(compared['records']) * compared.sizes['velocity_ratio'] * each:,}".replace(",", "\u202f"),
        "converged": f"{100 * float(compared['converged_share']):.2f}",
        "uncertainty": [
            (percent(part, 3), percent(value))
            for part, value in zip(uncertainty["share"], uncertainty, strict=True)
            if part < 1
        ],
    }


def exceptions(earthquakes: xr.Dataset | None) -> list[xr.Dataset]:
    """Return the histories whose bound is larger than their peak, that of the largest ratio first."""
    if earthquakes is None:
        return []
    peak = earthquakes["peak"]
    over = earthquakes["peak_uncertainty"] / peak
    again = (over["damping_model"] == REFERENCE) & (over["damping_ratio_source"] != over["damping_ratio_source"][0])
    histories = xr.Dataset({"peak": peak, "over": over.where(~again)}).stack(history=over.dims)
    named = histories.isel(history=np.flatnonzero(histories["over"] > 1))
    return [named.isel(history=index) for index in np.argsort(-named["over"].values, kind="stable")]


def _at(at_e: xr.Dataset, advice: xr.Dataset) -> dict[str, Any]:
    """Return the table of one e, and which damper errs least there."""
    least, near = (marked(advice, name) for name in ("least_error", "not_told_apart"))
    marks = dict.fromkeys(near, "not significantly more") | dict.fromkeys(least, "least")
    rows = [{"choice": choice, "mark": marks.get(choice, ""), "cell": _cell(at_e, choice)} for choice in _choices(at_e)]
    table: dict[str, Any] = {"e": _e(at_e), "rows": rows, "least": None}
    if least:
        table["least"] = grouped(least)
        table["least_error"] = with_interval(_cell(advice, least[0]), "log_error")
        table["near"] = grouped([choice for choice in near if choice not in least])
    return table


# --- the small-change error of CR -------------------------------------------------------------------------------------


def _sensitivity(compared: xr.Dataset, advice: xr.Dataset, change: str) -> dict[str, Any]:
    return {
        "sensitivity_rows": [
            (VARIATIONS.get(name, name).format(change), list(_each(compared.sel(variation=name))))
            for name in map(str, compared["variation"].values)
        ],
        "last_band": _band(compared, -1),
        "every_band": _band(compared, 0),
    }


def _each(statistics: Any, dim: str = "restitution") -> Iterator[Any]:
    """Yield a dataset, or a variable of it, at each e, or at each place of another dimension."""
    return (statistics.isel({dim: index}) for index in range(statistics.sizes[dim]))


def _band(compared: xr.Dataset, index: int) -> str:
    return f"{plain(compared['band_start'][index])} to {plain(compared['band_end'][index])}"


# --- which damper -----------------------------------------------------------------------------------------------------


def _recommendation(compared: xr.Dataset, advice: xr.Dataset) -> dict[str, Any]:
    recommendation = recommended(advice)
    if recommendation is None:
        return {"use": None}
    first, others = recommendation
    same = [choice.source for choice in (first, *others) if choice.model == first.model]
    leading = Choice(first.model, RECOMMENDED_SOURCE)
    cell, sensitivity = _cell(compared, leading), advice["sensitivity"]
    holds = _cell(advice, leading)["holds"].astype(bool)
    bands = xr.Dataset({"error": cell["log_error"], "least": sensitivity, "holds": holds}).isel(band=slice(1, None))
    names = [_band(compared, band) for band in range(1, compared.sizes["band"])]
    share = holds.isel(band=slice(1, None)).mean("restitution").values
    over = (cell["log_error"] / sensitivity).isel(band=0)
    return {
        "use": first.model,
        "as_good": " or the ".join(SOURCES.get(source, source) for source in same),
        "others": grouped([choice for choice in others if choice.model != first.model]),
        "times": span(over),
        "amplitudes": [(name, list(_each(band))) for name, band in zip(names, _each(bands, "band"), strict=True)],
        "never": listed(np.compress(share == 0, names)),
        "sometimes": listed(np.compress((share > 0) & (share < 1), names)),
        "everywhere": listed(np.compress(share == 1, names)),
        "factor": span(cell["log_dispersion"].isel(band=-1), lambda value: number(np.exp(value), 2)),
        "sizes": criterion.sizes(compared, cell),
        "tail_share": span(cell["tail_share"].isel(band=0), percent),
        "false_answers": list(zip(_each(cell), _each(advice), strict=True)),
        "refused": _refused(compared, advice),
        "odd_walls": _odd_walls(compared, leading),
    }


def _orders(orders: xr.Dataset | None, advice: xr.Dataset) -> dict[str, Any]:
    """Say which order is enough wall by wall, and of halves of the stations, beside the change of e that decides."""
    if orders is None:
        return {"by_wall": None}
    found = float(advice["recommended_order"]) if "recommended_order" in advice else np.nan
    return {
        "by_wall": criterion.by_wall(orders),
        "marks": criterion.MARKS,
        "order": RECOMMENDED_ORDER,
        "enough_order": plain(found) if np.isfinite(found) else None,
        "order_e": [plain(e) for e in orders["restitution"].values],
        "loss_change": criterion.changes(orders)[DECISIVE_CHANGE],
        "splits": criterion.splits(orders),
    }


def _refused(compared: xr.Dataset, advice: xr.Dataset) -> list[dict[str, Any]]:
    """List the dampers that, at some e, hold from no source of their ratio."""
    refused = []
    for model in dampers(compared):
        at_all = advice.sel(damping_model=model)
        error, least = at_all["log_error"].min("damping_ratio_source"), advice["sensitivity"].isel(band=0)
        beyond = ~at_all["holds"].isel(band=0).any("damping_ratio_source").values
        if beyond.any():
            refused.append(
                {
                    "model": model,
                    "at": listed(plain(e) for e in compared["restitution"].values[beyond]),
                    "times": span((error / least)[beyond]),
                }
            )
    return refused


def _odd_walls(compared: xr.Dataset, choice: Choice) -> str:
    """Name the walls and e where the damper's median of collapse differs significantly from that of CR."""
    bounds = _cell(compared, choice)["wall_median_intensity_ratio_interval"]
    outside = (bounds.sel(bound="lower") > 1) | (bounds.sel(bound="upper") < 1)
    return listed(
        f"{wall} (e = {', '.join(plain(e) for e in compared['restitution'].values[at])})"
        for wall in compared["wall"].values
        if (at := outside.sel(wall=wall).transpose("restitution").values).any()
    )


# --- walls ------------------------------------------------------------------------------------------------------------


def _walls(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    middle = walls.sizes["restitution"] // 2
    ratio = walls["damping_ratio"].isel(restitution=middle).sel(damping_model=dampers(walls))
    sources = [str(source) for source in walls["damping_ratio_source"].values]
    pooled = compared["pooled"] == 1
    without = {source: ~pooled.sel(damping_ratio_source=source).values for source in sources}
    return {
        "walls": [(walls.isel(wall=index), ratio.isel(wall=index)) for index in range(walls.sizes["wall"])],
        "wall_e": plain(walls["restitution"][middle]),
        "models": dampers(walls),
        "sources": [SOURCES.get(source, source) for source in sources],
        "apart": [
            (SOURCES.get(source, source), listed(map(str, compared["wall"].values[missing])))
            for source, missing in without.items()
            if missing.any()
        ],
    }
