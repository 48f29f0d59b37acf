"""Measured response: Fig. 8, the models against a test, and free rocking of blocks."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    POINTS,
    error_bars,
    handles,
    legend,
    look,
    panels,
)

TIME, DISPLACEMENT_MM, ACCELERATION = "time $t$ [s]", "$u$ [mm]", r"$\ddot u_g$ [m s$^{-2}$]"
MEASURED: dict[str, Any] = {"color": "#B0B0B0", "linewidth": 2.8}


def record_title(dataset: xr.Dataset) -> str:
    """Return the record's specimen or source, whether it is synthetic, and the factor on it."""
    specimen, source = (
        str(dataset.attrs.get(f"record_{key}", "not stated")) for key in ("specimen", "source")
    )
    name = source if specimen in ("none", "not stated") else specimen
    factor = float(dataset.get("scale_factor", 1.0))
    text = f"{record_name(dataset)}: {' '.join(name.split())}" + (
        f" (times {factor:g})" if factor != 1 else ""
    )
    return fill(text[0].upper() + text[1:], 120, max_lines=2).replace("$", r"\$")


def record_name(dataset: xr.Dataset) -> str:
    """Return what a record is called: a synthetic one was not measured."""
    return "SYNTHETIC record" if dataset.attrs.get("record_synthetic") == "yes" else "record"


def fig8(validation: xr.Dataset) -> Figure:
    """Draw the table's motion, and below it the displacement of the record and under each of the paper's models."""
    elapsed, measured = validation["elapsed"].values, 1000 * validation["measured"]
    figure, ((motion,), (response,)) = panels(2, 1, 108.0, sharex=True, height_ratios=[1.0, 2.6])
    motion.plot(elapsed, validation["ground_acceleration"], color="black", linewidth=0.8)
    response.plot(elapsed, measured, label=record_name(validation), **MEASURED)
    for model in ("CR", *PAPER_MODELS):
        computed = 1000 * validation["control_displacement"].sel(damping_model=model)
        response.plot(elapsed, computed, label=model, **look(model, marker=""))
    for axes in (motion, response):
        axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)
    # From the motion's first tenth to the last tenth of the decay, with some rest on both sides.
    shaken, rocking = (
        abs(values) >= 0.1 * abs(values).max()
        for values in (validation["ground_acceleration"], measured)
    )
    first, last = elapsed[shaken.values][0], elapsed[rocking.values][-1]
    margin = 0.1 * (last - first)
    motion.set(ylabel=ACCELERATION, xlim=(first - margin, last + margin))
    response.set(xlabel=TIME, ylabel="mid-height displacement $u$ [mm]")
    over_u_ins(response, validation)
    figure.align_ylabels()
    figure.suptitle(record_title(validation), fontsize=8)
    legend(figure, handles(response))
    return figure


def over_u_ins(axes: Any, dataset: xr.Dataset) -> None:
    """Give a panel in millimetres a second axis in u/u_ins."""
    u_ins = 1000 * float(dataset["instability_displacement"])
    axes.secondary_yaxis("right", functions=(lambda u: u / u_ins, lambda u: u * u_ins)).set_ylabel(
        DISPLACEMENT
    )


def fig_measured_rocking(measured: xr.Dataset) -> Figure:
    """Draw what free rocking says: exponent of the amplitude, likelihood of each damper, and e over Housner's."""
    figure, ((exponent, likelihood, restitution),) = panels(
        1, 3, 76.0, width_ratios=[1.0, 1.1, 1.1]
    )
    impacts = measured["impacts_used"]
    place = np.arange(impacts.size)
    # The exponent of each damper for a rigid block, to first order in the loss.
    for model, power in {"SDR": -0.5, "CR": 0.0, "CDC": 0.5}.items():
        exponent.axvline(power, **look(model, marker=""))
    gamma, interval = measured["amplitude_exponent"], measured["amplitude_exponent_interval"]
    error_bars(
        exponent, gamma.values, place, interval, upright=False, label="measured, 90 %", **POINTS
    )
    exponent.set(
        yticks=place,
        yticklabels=impacts.values,
        ylim=(place[-1] + 0.6, -0.6),
        xlim=(-0.75, 0.75),
        xticks=[-0.5, 0, 0.5],
    )
    exponent.set(
        xlabel=r"$\gamma$: loss $\propto$ energy$^\gamma$ [-]",
        ylabel="impacts used of each trial [-]",
    )
    behind = measured["log_likelihood"] - measured["log_likelihood"].sel(damping_model="power law")
    for model in ("CR", *PAPER_MODELS):
        likelihood.plot(impacts, behind.sel(damping_model=model), label=model, **look(model))
    likelihood.axhline(0, color=GREY, linewidth=0.8)
    likelihood.set(
        xlabel="impacts used of each trial [-]", ylabel=r"$\ln L$ less that of a power law [-]"
    )
    likelihood.set_xticks(impacts.values)
    slenderness, ratio = measured["geometry"], measured["restitution_over_housner"]
    low, high = measured["trial_over_housner_interval"].transpose("bound", ...).values
    restitution.fill_between(
        slenderness, low, high, color=PALE, linewidth=0, label="one trial, 90 %"
    )
    restitution.axhline(1.0, color=GREY, linewidth=0.8)
    error_bars(
        restitution,
        slenderness.values,
        ratio.values,
        measured["restitution_over_housner_interval"],
        **POINTS,
    )
    restitution.margins(x=0.05)
    restitution.xaxis.set_major_locator(MaxNLocator(integer=True))
    restitution.set(xlabel="$H/B$ of the block [-]", ylabel="$e$ over Housner's [-]")
    titles = {
        exponent: "(a) exponent of the amplitude",
        likelihood: "(b) dampers",
        restitution: "(c) restitution",
    }
    for axes, title in titles.items():
        axes.set_title(title)
    legend(figure, handles(likelihood, exponent, restitution))
    return figure
