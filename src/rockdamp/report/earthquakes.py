"""The report's section on earthquakes: how far each damper is from restitution, and what was run."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from rockdamp.constants import RECOMMENDED_SOURCE, REFERENCE, VISCOUS_MODELS
from rockdamp.report.answer import with_interval
from rockdamp.storage.dataset import Datasets
from rockdamp.text import join_words, number, percent, plain

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


def section(data: Datasets) -> Markup | None:
    """Return the section as HTML, none without its datasets."""
    if any(name not in data for name in ("comparison", "earthquakes/walls")):
        return None
    compared, walls = data["comparison"], data["earthquakes/walls"]
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"number": number, "percent": percent, "plain": plain, "listed": join_words}
    environment.globals |= {"interval": with_interval, "each": _each}
    text = files("rockdamp.report").joinpath(TEMPLATE).read_text(encoding="utf-8")
    values = {
        **run(compared, walls),
        "compared": compared,
        "checks": [(text, data.get(name)) for name, text in CHECKS.items()],
        "strata": STRATA,
        "names": SOURCES,
        "leading": RECOMMENDED_SOURCE,
        "first": slice(1, None),
        "bands": [_band(compared, index) for index in range(compared.sizes["band"])],
        "exceptions": exceptions(data.get("earthquakes")),
        **_walls(compared, walls),
    }
    return Markup(environment.from_string(text).render(values))


# --- what was run -----------------------------------------------------------------------------------------------------


def run(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """Return how many walls, records and histories there are, and how certain their outcomes and peaks."""
    each = int(np.isfinite(walls["damping_ratio"].values).sum()) + walls.sizes["wall"] * walls.sizes["restitution"]
    uncertainty = compared["relative_uncertainty"]
    return {
        "few": int(compared["stations"]) < ENOUGH_STATIONS,
        "wall_count": walls.sizes["wall"],
        "restitutions": join_words(plain(value) for value in compared["restitution"].values),
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


def _each(statistics: Any, dim: str = "restitution") -> Iterator[Any]:
    """Yield a dataset, or a variable of it, at each e, or at each place of another dimension."""
    return (statistics.isel({dim: index}) for index in range(statistics.sizes[dim]))


def _band(compared: xr.Dataset, index: int) -> str:
    return f"{plain(compared['band_start'][index])} to {plain(compared['band_end'][index])}"


# --- walls ------------------------------------------------------------------------------------------------------------


def _walls(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    middle = walls.sizes["restitution"] // 2
    ratio = walls["damping_ratio"].isel(restitution=middle).sel(damping_model=list(VISCOUS_MODELS))
    sources = [str(source) for source in walls["damping_ratio_source"].values]
    pooled = compared["pooled"] == 1
    without = {source: ~pooled.sel(damping_ratio_source=source).values for source in sources}
    return {
        "walls": [(walls.isel(wall=index), ratio.isel(wall=index)) for index in range(walls.sizes["wall"])],
        "wall_e": plain(walls["restitution"][middle]),
        "models": VISCOUS_MODELS,
        "sources": [SOURCES.get(source, source) for source in sources],
        "apart": [
            (SOURCES.get(source, source), join_words(map(str, compared["wall"].values[missing])))
            for source, missing in without.items()
            if missing.any()
        ],
    }
