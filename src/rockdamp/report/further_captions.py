"""Numbers of the captions of what goes beyond the paper: accuracy, dispersion over the amplitude, pulses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from rockdamp.figures.code_damping import TESTED, released_as_the_paper, restitution_of
from rockdamp.figures.damper_order import at_middle, at_shown
from rockdamp.figures.dispersion import BEST, REFERENCE_RESTITUTION
from rockdamp.figures.identification import confusion
from rockdamp.figures.style import nearest, numbers
from rockdamp.mechanics.half_cycle_loss import log_decrement
from rockdamp.report.earthquake_captions import known
from rockdamp.report.numbers import listed, number, of_models, percent, plain
from rockdamp.storage.dataset import Datasets
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER

TITLES = {BEST: "best n"}


def _range(values: xr.DataArray, digits: int = 2) -> Markup:
    """Least and greatest of some fractions as percentages."""
    low, high = (percent(float(value), digits) for value in (values.min(), values.max()))
    return high if low == high else Markup("{} to {}").format(low, high)


def _by_model(values: xr.DataArray, show: Callable[[xr.DataArray], str], dim: str = "damping_model") -> Markup:
    return of_models(
        {TITLES.get(str(model), str(model)): show(values.sel({dim: model})) for model in values[dim].values}
    )


def fig_dispersion(data: Datasets) -> dict[str, Any]:
    dispersion = data["dispersion"]
    at_e = dispersion.isel(restitution=nearest(numbers(dispersion, "restitution"), REFERENCE_RESTITUTION))
    return {
        "restitution": plain(at_e["restitution"]),
        "curves": int(dispersion.sizes["case"]),
        "low": plain(dispersion["release_share"].min()),
        "high": plain(dispersion["release_share"].max()),
        "spreads": _by_model(at_e["spread_peaks"], _range),
    }


def fig_exponent(data: Datasets) -> dict[str, Any]:
    dispersion = data["dispersion"]
    best, spread = dispersion["map_best_exponent"], dispersion["map_spread"]
    return {
        "low": f"{float(best.min()):.2f}",
        "high": f"{float(best.max()):.2f}",
        "a1_low": plain(dispersion["map_cracked_stiffness_ratio"].min()),
        "a1_high": plain(dispersion["map_cracked_stiffness_ratio"].max()),
        "left": percent(spread.sel(damping_model=BEST).max()),
        "others": _by_model(spread.sel(damping_model=["CDC", "CDR", "SDR"]), _range),
    }


def fig_closed_form(data: Datasets) -> dict[str, Any]:
    dispersion = data["dispersion"]
    at_e = dispersion.isel(restitution=nearest(numbers(dispersion, "restitution"), REFERENCE_RESTITUTION))
    closed = at_e["damping_ratio_energy"]

    def largest(measure: str) -> Markup:
        away = abs(closed / at_e[measure] - 1)
        return _by_model(away, lambda values: percent(values.max()))

    return {
        "restitution": plain(at_e["restitution"]),
        "curves": int(dispersion.sizes["case"]),
        "peaks": largest("damping_ratio_peaks"),
        "errors": largest("damping_ratio"),
    }


def fig_identification(data: Datasets) -> dict[str, Any]:
    found = data["identification"]
    identified, draws = int(found["identified_records"]), int(found.sizes["draw"])

    def held(level: float) -> Markup:
        at = found.sel(level=level)
        return Markup("{} ± {} (of {})").format(_range(at["coverage"]), percent(at["coverage_error"]), percent(level))

    own = {
        str(maker): number(shares.sel(damping_model=maker).mean(), 2)
        for maker, shares in confusion(found).groupby("record_made_by")
        if maker in found["damping_model"].values
    }
    return {
        "identified": identified,
        "draws": draws,
        "refused": draws - identified,
        "held": listed(held(float(level)) for level in found["level"].values),
        "own": of_models(own),
    }


def fig_pulses(data: Datasets) -> dict[str, Any]:
    pulses = data["pulses"]
    at_e = pulses.isel(restitution=pulses.sizes["restitution"] // 2, damping_ratio_source=0)
    fell = at_e["reference_collapsed"] == 1
    load = at_e["load_ratio"].where(fell.any(("pulse", "pulse_frequency")))
    otherwise = ((at_e["collapsed"] == 1) != fell).mean(("pulse", "pulse_frequency", "load_ratio"))
    medians = {
        str(model): Markup("{} ± {}").format(
            f"{float(at_e['median_ratio_all'].sel(damping_model=model)):.2f}",
            f"{float(at_e['log_dispersion_all'].sel(damping_model=model)):.2f}",
        )
        for model in at_e["damping_model"].values
    }
    return {
        "restitution": plain(at_e["restitution"]),
        "release": plain(at_e["release_amplitude"]),
        "runs": int(at_e["reference_collapses"]) + int(at_e["reference_survivals"]),
        "medians": of_models(medians),
        "shapes": "a Ricker pulse and one cycle of a sine",
        "lowest": known(load.min()),
        "otherwise": _by_model(otherwise, percent),
        "collapses": int(at_e["reference_collapses"]),
        "survivals": int(at_e["reference_survivals"]),
        "false_safe": _by_model(at_e["false_safe"], lambda value: str(int(value))),
        "false_collapse": _by_model(at_e["false_collapse"], lambda value: str(int(value))),
    }


def fig_order(data: Datasets) -> dict[str, Any]:
    by_order, earthquakes = data["damper_order"], at_middle(data["natural/orders"])
    at_e, order = at_shown(by_order), by_order["order"]
    within = at_e["pulse_log_error"] <= at_e["varied_pulse_log_error"].max("variation")
    error = at_e["curve_rms_error"]
    return {
        "change": plain(by_order["restitution_change"]),
        "earthquake_restitution": plain(earthquakes["restitution"]),
        "earthquake_order": known(earthquakes["smallest_order"]),
        "recommended": known(data["natural/orders"]["recommended_order"]),
        "pulse_order": known(order.where(within).min()),
        "restitution": plain(at_e["restitution"]),
        "lowest": plain(order[0]),
        "highest": plain(order[-1]),
        "zero": number(error[0], 2),
        "last": number(error[-1], 2),
        "fitted": _by_model(at_e["fitted_rms_error"], lambda value: number(value, 2)),
        "peaks": percent(at_e["peak_error"].max(), 1),
        "record": listed(
            Markup("{}&nbsp;mm (m&nbsp;=&nbsp;{})").format(
                number(1e3 * by_order["record_peak"].sel(order=m), 4), plain(m)
            )
            for m in order.values
        ),
        "record_reference": number(1e3 * by_order["record_reference_peak"], 4),
    }


def fig_code_damping(data: Datasets) -> dict[str, Any]:
    match, level = released_as_the_paper(data["match/amplitude"]), 0.05
    lowest, mean, highest = TESTED
    stands_for = {model: restitution_of(match, model, level) for model in PAPER_MODELS}
    return {
        "level": percent(level, 1),
        "model": RECOMMENDED,
        "exact": f"{float(np.exp(-log_decrement(level, RECOMMENDED_ORDER))):.3f}",
        "mean": plain(mean),
        "lowest": plain(lowest),
        "highest": plain(highest),
        "others": of_models({model: known(e, 3) for model, e in stands_for.items()}),
        "release": plain(match["release_amplitude"]),
        "ratios": _by_model(match["damping_ratio"].interp(restitution=mean), lambda ratio: percent(ratio, 2)),
    }


def fig_accuracy(data: Datasets) -> dict[str, Any]:
    accuracy = data["accuracy"]
    orders = accuracy["order"]
    shares = accuracy["share_within_thousandth"]
    largest = accuracy["uncertainty_quantile"].isel(quantile=int(np.argmax(accuracy["quantile"].values)))
    return {
        "step": plain(accuracy["solver_step"]),
        "difference": number(accuracy["largest_difference"].max(), 2),
        "order_low": f"{float(orders.min()):.2f}",
        "order_high": f"{float(orders.max()):.2f}",
        "shares": _by_model(shares, lambda value: percent(value, 3), "viscous_model"),
        "largest": _by_model(largest, lambda value: percent(value), "viscous_model"),
        "sample": int(accuracy.sizes["sample"]),
        "checked": percent(abs(accuracy["sample_difference"]).max()),
    }


def fig_rigid(data: Datasets) -> dict[str, Any]:
    accuracy = data["accuracy"]
    away = abs(accuracy["rocking_difference"]).max(["hinge_ratio", "rocking_release_amplitude"])
    slenderness = accuracy["slenderness"].values
    ends = {"squat": int(np.argmin(slenderness)), "slender": int(np.argmax(slenderness))}
    values: dict[str, Any] = {"restitution": plain(accuracy["rocking_restitution"])}
    for name, index in ends.items():
        apart = away.isel(slenderness=index)
        values[name] = plain(slenderness[index])
        values[f"{name}_time"] = percent(apart.sel(rocking_feature="first impact"))
        values[f"{name}_peaks"] = percent(apart.sel(rocking_feature="peaks"))
        values[f"{name}_p"] = percent(apart.sel(rocking_feature="p"))
    return values
