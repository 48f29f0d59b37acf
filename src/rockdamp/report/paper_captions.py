"""Numbers of the captions of the paper's figures, each by a function with the figure's name, and of its schemes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from rockdamp.figures.equivalence import PAPER_AMPLITUDES, REFERENCE_AMPLITUDE, REFERENCE_CRACKED_STIFFNESS
from rockdamp.figures.ladder import RIGHT, amplitudes, ladders, off
from rockdamp.figures.style import nearest, numbers, present
from rockdamp.figures.validation import is_synthetic
from rockdamp.report.numbers import listed, number, of_models, percent, plain, ranges
from rockdamp.storage.dataset import Datasets
from rockdamp.vocabulary import PAPER_MODELS, REFERENCE


def _per_model(values: xr.DataArray, show: Callable[[Any], str] = number) -> Markup:
    return of_models({str(model): show(values.sel(damping_model=model)) for model in values["damping_model"].values})


def _at(data: xr.DataArray, **wanted: float) -> xr.DataArray:
    return data.isel({name: nearest(numbers(data.to_dataset(name="_"), name), value) for name, value in wanted.items()})


def fig1(data: Datasets) -> dict[str, Any]:
    wall = data["mechanism"]
    return {
        "thickness": plain(wall["thickness"]),
        "height": plain(wall["height"]),
        "hinge_ratio": plain(wall["hinge_ratio"]),
        "u_ins": number(1000 * wall["instability_displacement"]),
    }


def fig2(data: Datasets) -> dict[str, Any]:
    curves = data["mechanism"]
    study, softer = curves.sel(curve_name="tri-linear"), curves.sel(curve_name="steeper")
    stages = [
        f"{name}: {plain(curve['cracked_stiffness_ratio'])}, {plain(curve['plateau_ratio'])}"
        for name in ("new", "moderate", "severe")
        for curve in [curves.sel(curve_name=name)]
    ]
    return {
        "a1": plain(study["cracked_stiffness_ratio"]),
        "b1": plain(study["plateau_ratio"]),
        "a3": plain(softer["ultimate_ratio"]),
        "stages": "; ".join(stages),
    }


def fig3(data: Datasets) -> dict[str, Any]:
    loops = data["loops"]
    peak = abs(loops["damping_force"]).max("tau")
    return {
        "restitution": plain(loops["restitution"]),
        "release": plain(loops["release_amplitude"]),
        "ratios": _per_model(loops["damping_ratio"].dropna("damping_model")),
        "forces": _per_model(peak.sel(damping_model=loops["viscous_model"].values.tolist()), percent),
    }


def fig4(data: Datasets) -> dict[str, Any]:
    loops = data["loops"]
    rocking, both = loops["rocking_displacement"], loops["displacement"].sel(damping_model=["CR", "CDR"])
    difference = ((rocking - rocking.sel(rocking_model="tri-linear")) ** 2).mean("tau") ** 0.5
    apart = (both.diff("damping_model") ** 2).mean() ** 0.5
    return {
        "rocking_restitution": plain(loops["rocking_restitution"]),
        "slender": number(difference.sel(rocking_model="slender"), 2),
        "large": number(difference.sel(rocking_model="large rotation"), 2),
        "length": plain(loops["tau"].max()),
        "restitution": plain(loops["restitution"]),
        "ratio": number(loops["damping_ratio"].sel(damping_model="CDR")),
        "apart": number(apart, 2),
    }


def fig5(data: Datasets) -> dict[str, Any]:
    ratio = data["match/amplitude"]["damping_ratio"]
    values = numbers(data["match/amplitude"], "release_amplitude")
    chosen = sorted(values[index] for index in present(values, PAPER_AMPLITUDES))
    at = _at(ratio, restitution=float(data["loops"]["restitution"]))
    low, high = (at.sel(release_amplitude=value) for value in (chosen[0], chosen[-1]))
    changes = {
        str(model): f"{number(low.sel(damping_model=model))} to {number(high.sel(damping_model=model))}"
        for model in ratio["damping_model"].values
    }
    return {
        "restitution": plain(at["restitution"]),
        "low": plain(chosen[0]),
        "high": plain(chosen[-1]),
        "changes": of_models({model: Markup(text) for model, text in changes.items()}),
        "window": plain(data["match/amplitude"]["window"]),
        **_bends(data["match/amplitude"]),
    }


JUMP = 10.0  # of ln(ξ/δ) over that of e: faster than a minimum moves


def _bends(study: xr.Dataset) -> dict[str, Any]:
    """The largest step of ξ/δ from one e to the next, which would be a jump where another minimum of Err took over."""
    study = study.sortby("restitution")
    share = study["damping_ratio"] / -np.log(study["restitution"])
    steps = abs(share.diff("restitution") / share)
    bend = abs(share.diff("restitution", 2) / share)
    bend = bend.assign_coords(restitution=study["restitution"].values[1:-1])  # the middle of three
    at = bend.isel(bend.argmax(...))
    return {
        "largest_step": percent(steps.max()),
        "jumps": float((steps / study["restitution"].diff("restitution")).max()) > JUMP,
        "bend_model": str(at["damping_model"].item()),
        "bend_release": plain(at["release_amplitude"]),
        "bend_restitution": plain(at["restitution"]),
    }


def _spread(values: xr.DataArray, dim: str) -> xr.DataArray:
    return (values.max(dim) - values.min(dim)) / values.mean(dim)


def fig6(data: Datasets) -> dict[str, Any]:
    slenderness, overburden, cracked = (
        data[f"match/{name}"] for name in ("slenderness", "overburden", "cracked_stiffness")
    )
    walls = ((slenderness, "slenderness"), (overburden, "overburden_ratio"))
    alike = max(float(_spread(study["damping_ratio"], dim).max()) for study, dim in walls)
    seconds = max(float(_spread(study["damping_ratio_fixed_seconds"], dim).max()) for study, dim in walls)
    b1 = cracked["plateau_ratio"].values
    shown = cracked["damping_ratio"].isel(cracked_stiffness_ratio=np.isclose(b1, b1[0]))
    a1 = numbers(shown.to_dataset(name="_"), "cracked_stiffness_ratio")
    at = _at(shown, restitution=float(data["loops"]["restitution"]))
    ends = (at.isel(cracked_stiffness_ratio=index) for index in (0, -1))
    first, last = ends
    changes = {
        str(model): Markup("{} to {}").format(
            number(first.sel(damping_model=model)), number(last.sel(damping_model=model))
        )
        for model in shown["damping_model"].values
    }
    return {
        "alike": percent(alike),
        "seconds": percent(seconds),
        "slenderness": f"{plain(slenderness['slenderness'].min())} to {plain(slenderness['slenderness'].max())}",
        "overburden": f"{plain(overburden['overburden_ratio'].min())} to {plain(overburden['overburden_ratio'].max())}",
        "a1_low": plain(a1[0]),
        "a1_high": plain(a1[-1]),
        "restitution": plain(at["restitution"]),
        "changes": of_models(changes),
    }


def fig6_error(data: Datasets) -> dict[str, Any]:
    study = data["match/amplitude"]
    release = numbers(study, "release_amplitude")
    study = study.isel(release_amplitude=nearest(release, REFERENCE_AMPLITUDE))
    error = study["error"].sel(damping_model=list(PAPER_MODELS))
    lowest = error["damping_model"].values[error.argmin("damping_model").values]
    e = numbers(study, "restitution")
    return {
        "release": plain(study["release_amplitude"]),
        "lowest": listed(
            Markup("{} at e = {}").format(model, ranges(e, lowest == model))
            for model in PAPER_MODELS
            if (lowest == model).any()
        ),
        "window": plain(study["window"]),
        "largest": _per_model(study["rms_error"].max("restitution"), lambda value: number(value, 2)),
    }


def fig7(data: Datasets) -> dict[str, Any]:
    fits = data["equivalence"]
    index = nearest(numbers(fits, "cracked_stiffness_ratio"), REFERENCE_CRACKED_STIFFNESS)
    at = fits.isel(
        cracked_stiffness_ratio=index,
        restitution=nearest(numbers(fits, "restitution"), float(data["loops"]["restitution"])),
    )
    return {
        "r_squared": f"{np.floor(1e4 * float(fits['r_squared'].min())) / 1e4:.4f}",
        "residual": number(fits["largest_residual"].max(), 2),
        "b1": plain(fits["plateau_ratio"]),
        "errors": _by_range(fits["largest_relative_error"]),
        "delta_errors": _by_range(fits["delta_largest_relative_error"]),
        "restitution": plain(at["restitution"]),
        "a1": plain(at["cracked_stiffness_ratio"]),
        "fits": _per_model(at["damping_ratio_fit"]),
        "giannini_masiani": number(at["giannini_masiani"]),
    }


def _by_range(errors: xr.DataArray) -> Markup:
    """The largest error of all models and a1 in each range of e that holds values: "4 % (e up to 0.9)"."""
    largest = errors.max(("damping_model", "cracked_stiffness_ratio")).dropna("restitution_range")
    return listed(
        Markup("{} (e up to {})").format(percent(error), plain(end))
        for end, error in zip(largest["restitution_range"].values, largest.values, strict=True)
    )


def fig8(data: Datasets) -> dict[str, Any]:
    test = data["validation"]
    about = {
        "synthetic": is_synthetic(test),
        "specimen": str(test.attrs.get("record_specimen", "not stated")),
        "restitution": plain(test["restitution"]),
        "ladder": test.sizes["record"] > 1,
    }
    if about["ladder"]:
        return {**about, **_ladder(test)}
    test = test.isel(record=0)
    return {
        **about,
        "peak": number(1000 * test["measured_peak_displacement"]),
        "peak_ratios": _per_model(test["peak_ratio_to_measured"], lambda value: number(value, 2)),
        "half_cycles": int((test["half_cycle_free"] == 1).sum()),
        "decay_misfits": _per_model(1000 * test["decay_peak_misfit"], lambda value: number(value, 2)),
    }


def _ladder(test: xr.Dataset) -> dict[str, Any]:
    """What is right of each model on which rung of the first ladder, and how far it hangs on what made the records."""
    test_ladders = ladders(test)
    (maker, first), *_ = test_ladders.items()
    of_reference = {name: off(rungs, "peak").sel(damping_model=REFERENCE) for name, rungs in test_ladders.items()}
    own = [f"{value:.2f}" for value in of_reference.pop(maker).values]
    return {
        "maker": maker,
        "amplitudes": listed(f"{amplitude:.2f}" for amplitude in amplitudes(first)),
        "right": percent(RIGHT),
        "peaks": _right_at(first, "peak"),
        "decrements": _right_at(first, "decrement"),
        "reference": REFERENCE,
        "reference_peaks": listed(own),
        "lowest": own[0],
        "other_peaks": listed(
            f"{float(values.min()):.2f} to {float(values.max()):.2f} ({name})" for name, values in of_reference.items()
        ),
    }


def _right_at(rungs: xr.Dataset, quantity: str) -> Markup:
    """Name each model with the amplitudes at which a quantity of it is right: "CR at 0.50 and 0.88, CDC at none"."""
    near = abs(off(rungs, quantity) - 1) <= RIGHT
    reached = amplitudes(rungs)
    return listed(
        Markup("{} at {}").format(model, listed(f"{value:.2f}" for value in reached[right]) or "none")
        for model, right in zip(near["damping_model"].values, near.transpose("damping_model", ...).values, strict=True)
    )


def fig_orders(data: Datasets) -> dict[str, Any]:
    orders = data["orders"]
    own, printed = (orders.sel(scheme=name) for name in ("newmark", "paper"))
    frozen = printed["finest_order"].sel(damping_model=["CR", "CDR", "SDR", "ECD"])
    constant = printed["finest_order"].sel(damping_model="CDC")
    span = {
        name: f"{float(values.min()):.2f} to {float(values.max()):.2f}"
        for name, values in (("own", own["order"]), ("frozen", frozen), ("constant", constant))
    }
    return {**span, "finest": plain(orders["step"].min())}
