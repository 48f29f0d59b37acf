"""Numbers of the captions of the figures on earthquakes; a dash where a small study does not define one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from rockdamp.figures.natural import SOURCE, middle, standing
from rockdamp.figures.style import dampers
from rockdamp.report.numbers import number, of_models, percent, plain
from rockdamp.storage.dataset import Datasets
from rockdamp.vocabulary import REFERENCE

DASH = Markup("–")


def known(value: Any, digits: int = 3) -> Markup:
    """Return a number, a dash where there is none."""
    return number(value, digits) if np.isfinite(float(value)) else DASH


def fraction(value: Any) -> Markup:
    """Return a fraction as a percentage, a dash where there is none."""
    return percent(value) if np.isfinite(float(value)) else DASH


def span(values: Any, show: Callable[[Any], Markup] = lambda value: known(value, 2)) -> Markup:
    """Return the least and the greatest of some numbers, a dash where there is none."""
    low, high = (show(end) for end in (values.min(), values.max()))
    return low if low == high else Markup("{} to {}").format(low, high)


def _drawn(data: Datasets) -> xr.Dataset:
    """What the figures draw: the middle e, the damping ratios of least error."""
    return middle(data["comparison"]).sel(damping_ratio_source=SOURCE)


def _by_damper(statistics: xr.Dataset, show: Callable[[xr.Dataset], Markup]) -> Markup:
    return of_models({model: show(statistics.sel(damping_model=model)) for model in dampers(statistics)})


def fig_natural(data: Datasets) -> dict[str, Any]:
    drawn = _drawn(data)
    return {
        "records": int(drawn["records"]),
        "walls": int((drawn["pooled"] == 1).sum()),
        "scales": drawn.sizes["scale"],
        "restitution": plain(drawn["restitution"]),
        "medians": _by_damper(
            drawn.isel(band=0),
            lambda at: Markup("{} ± {}").format(known(at["median_ratio"]), known(at["log_dispersion"], 2)),
        ),
        "safe": _by_damper(drawn, lambda at: fraction(at["false_safe_rate"])),
        "collapse": _by_damper(drawn, lambda at: fraction(at["false_collapse_rate"])),
    }


def fig_natural_ratio(data: Datasets) -> dict[str, Any]:
    drawn = _drawn(data).isel(band=0)
    stand = standing(drawn).sortby("scale")
    return {
        "restitution": plain(drawn["restitution"]),
        "errors": _by_damper(drawn, lambda at: known(at["log_error"], 2)),
        "sensitivity": span(drawn["varied_log_error"]),
        "most": fraction(stand[0]),
        "fewest": fraction(stand[-1]),
    }


def fig_ida(data: Datasets) -> dict[str, Any]:
    drawn = _drawn(data)
    medians = drawn["fractile"].isel(probability=drawn.sizes["probability"] // 2)
    apart = abs(medians / medians.sel(damping_model=REFERENCE) - 1)

    def median_and_largest(at: xr.Dataset) -> Markup:
        off = apart.sel(damping_model=at["damping_model"])
        return Markup("{} and {}").format(fraction(off.median()), fraction(off.max()))

    return {
        "records": int(drawn["records"]),
        "scales": drawn.sizes["scale"],
        "restitution": plain(drawn["restitution"]),
        "apart": _by_damper(drawn, median_and_largest),
    }


def fig_fragility(data: Datasets) -> dict[str, Any]:
    drawn = _drawn(data)
    cr = drawn.sel(damping_model=REFERENCE)
    return {
        "restitution": plain(drawn["restitution"]),
        "medians": span(cr["wall_median_scale"]),
        "dispersions": span(cr["wall_dispersion"]),
        "ratios": _by_damper(drawn, lambda at: known(at["median_intensity_ratio"])),
    }


def fig_population(data: Datasets) -> dict[str, Any]:
    population = data["population"]
    index = population["sensitivity"].sel(damping_model=REFERENCE)
    order = np.argsort(-np.nan_to_num(index.values))[:3]
    cr = population.sel(damping_model=REFERENCE)
    return {
        "walls": population.sizes["wall"],
        "records": int(population["records"]),
        "intensities": population.sizes["intensity"],
        "median": known(cr["median_intensity"]),
        "dispersion": known(cr["dispersion"], 2),
        "ratios": _by_damper(
            population,
            lambda at: Markup("{} ({} to {})").format(
                *map(known, (at["median_intensity_ratio"], *at["median_intensity_ratio_interval"].values))
            ),
        ),
        "most": Markup(", ").join(
            Markup("{} ({}, {})").format(
                str(index["parameter"].values[i]).replace("_", " "),
                known(index[i], 2),
                known(population["total_sensitivity"][i], 2),
            )
            for i in order
        ),
    }
