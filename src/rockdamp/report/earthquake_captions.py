"""Numbers of the captions of the figures on earthquakes; a dash where a small study does not define one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from rockdamp.figures.natural import SOURCE, middle
from rockdamp.figures.style import dampers
from rockdamp.report.numbers import number, of_models, percent, plain
from rockdamp.vocabulary import REFERENCE

Data = Mapping[str, xr.Dataset]
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


def _drawn(data: Data) -> xr.Dataset:
    """What the figures draw: the middle e, the damping ratios of least error."""
    return middle(data["comparison"]).sel(damping_ratio_source=SOURCE)


def _by_damper(one: xr.Dataset, show: Callable[[xr.Dataset], Markup]) -> Markup:
    return of_models({model: show(one.sel(damping_model=model)) for model in dampers(one)})


def fig_natural(data: Data) -> dict[str, Any]:
    one = _drawn(data)
    return {
        "records": int(one["records"]),
        "walls": int((one["pooled"] == 1).sum()),
        "scales": one.sizes["scale"],
        "restitution": plain(one["restitution"]),
        "medians": _by_damper(
            one.isel(band=0),
            lambda at: Markup("{} ± {}").format(known(at["median_ratio"]), known(at["log_dispersion"], 2)),
        ),
        "safe": _by_damper(one, lambda at: fraction(at["false_safe_rate"])),
        "collapse": _by_damper(one, lambda at: fraction(at["false_collapse_rate"])),
    }


def fig_natural_ratio(data: Data) -> dict[str, Any]:
    one = _drawn(data).isel(band=0)
    return {
        "restitution": plain(one["restitution"]),
        "errors": _by_damper(one, lambda at: known(at["log_error"], 2)),
        "sensitivity": span(one["varied_log_error"]),
    }


def fig_ida(data: Data) -> dict[str, Any]:
    one = _drawn(data)
    medians = one["fractile"].isel(probability=one.sizes["probability"] // 2)
    apart = abs(medians / medians.sel(damping_model=REFERENCE) - 1)

    def told(at: xr.Dataset) -> Markup:
        off = apart.sel(damping_model=at["damping_model"])
        return Markup("{} and {}").format(fraction(off.median()), fraction(off.max()))

    return {
        "records": int(one["records"]),
        "scales": one.sizes["scale"],
        "restitution": plain(one["restitution"]),
        "apart": _by_damper(one, told),
    }


def fig_fragility(data: Data) -> dict[str, Any]:
    one = _drawn(data)
    cr = one.sel(damping_model=REFERENCE)
    return {
        "restitution": plain(one["restitution"]),
        "medians": span(cr["wall_median_intensity"]),
        "dispersions": span(cr["wall_dispersion"]),
        "ratios": _by_damper(one, lambda at: known(at["median_intensity_ratio"])),
    }


def fig_population(data: Data) -> dict[str, Any]:
    one = data["population"]
    index = one["sensitivity"].sel(damping_model=REFERENCE)
    order = np.argsort(-np.nan_to_num(index.values))[:3]
    cr = one.sel(damping_model=REFERENCE)
    return {
        "walls": one.sizes["wall"],
        "records": int(one["records"]),
        "intensities": one.sizes["intensity"],
        "median": known(cr["median_intensity"]),
        "dispersion": known(cr["dispersion"], 2),
        "ratios": _by_damper(
            one,
            lambda at: Markup("{} ({} to {})").format(
                *map(known, (at["median_intensity_ratio"], *at["median_intensity_ratio_interval"].values))
            ),
        ),
        "most": Markup(", ").join(
            Markup("{} ({})").format(str(index["parameter"].values[i]).replace("_", " "), known(index[i], 2))
            for i in order
        ),
    }
