"""Measured response: Fig. 8, the models against a test, and free rocking of blocks."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rockdamp.arrays import Array
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
    zero_line,
)

TIME = "time $t$ [s]"
DISPLACEMENT_MM = "$u$ [mm]"
ACCELERATION = r"$\ddot u_g$ [m s$^{-2}$]"
MEASURED: dict[str, Any] = {"color": "#B0B0B0", "linewidth": 2.8}

# Exponent of the energy in the relative loss of a rigid block, to first order in the loss.
LOSS_EXPONENTS = {"SDR": -0.5, "CR": 0.0, "CDC": 0.5}


def record_title(dataset: xr.Dataset) -> str:
    """Return the record's specimen or source, whether it is synthetic, and the factor on it."""
    title = record_name(dataset)
    for key in ("record_specimen", "record_source"):
        name = " ".join(str(dataset.attrs.get(key, "not stated")).split())
        if name not in ("none", "not stated"):
            title += f": {name}"
            break
    factor = float(dataset.get("scale_factor", 1.0))
    if factor != 1:
        title += f" (times {factor:g})"
    lines = fill(title[0].upper() + title[1:], 120, max_lines=2)
    return lines.replace("$", r"\$")


def record_name(dataset: xr.Dataset) -> str:
    """Return the word for a record: a synthetic one was not measured."""
    is_synthetic = dataset.attrs.get("record_synthetic") == "yes"
    return "SYNTHETIC record" if is_synthetic else "record"


def over_u_ins(axes: Axes, dataset: xr.Dataset) -> None:
    """Give a panel in millimetres a second axis in u/u_ins."""
    u_ins = 1000 * float(dataset["instability_displacement"])

    def from_millimetres(u: Any) -> Any:
        return u / u_ins

    def to_millimetres(x: Any) -> Any:
        return x * u_ins

    second = axes.secondary_yaxis("right", functions=(from_millimetres, to_millimetres))
    second.set_ylabel(DISPLACEMENT)


# --- Fig. 8 ------------------------------------------------------------------------------------


def fig8(validation: xr.Dataset) -> Figure:
    """Draw the table's motion, and the displacement in the record and with the paper's models."""
    elapsed = validation["elapsed"].values
    record = 1000 * validation["measured"]
    ground = validation["ground_acceleration"]
    figure, ((motion,), (response,)) = panels(2, 1, 108.0, sharex=True, height_ratios=[1.0, 2.6])
    motion.plot(elapsed, ground, color="black", linewidth=0.8)
    response.plot(elapsed, record, label=record_name(validation), **MEASURED)
    for model in ("CR", *PAPER_MODELS):
        displacement = 1000 * validation["control_displacement"].sel(damping_model=model)
        response.plot(elapsed, displacement, label=model, **look(model, marker=""))
    for axes in (motion, response):
        zero_line(axes)
    # From the motion's first tenth to the last tenth of the decay, with some rest on both sides.
    first = elapsed[is_large(ground.values)][0]
    last = elapsed[is_large(record.values)][-1]
    margin = 0.1 * (last - first)
    motion.set(ylabel=ACCELERATION, xlim=(first - margin, last + margin))
    response.set(xlabel=TIME, ylabel="displacement at the hinge $u$ [mm]")
    over_u_ins(response, validation)
    figure.align_ylabels()
    figure.suptitle(record_title(validation), fontsize=8)
    legend(figure, handles(response))
    return figure


def is_large(values: Array) -> Array:
    """Return true where a history is at least a tenth of its largest value."""
    return abs(values) >= 0.1 * abs(values).max()


# --- free rocking of blocks --------------------------------------------------------------------


def fig_measured_rocking(measured_rocking: xr.Dataset) -> Figure:
    """Draw exponent of the energy, likelihood of each damper, and e divided by Housner's."""
    figure, grid = panels(1, 3, 76.0, width_ratios=[1.0, 1.1, 1.1])
    exponent, likelihood, restitution = grid[0]
    draw_exponent(exponent, measured_rocking)
    draw_likelihood(likelihood, measured_rocking)
    draw_restitution(restitution, measured_rocking)
    legend(figure, handles(likelihood, exponent, restitution))
    return figure


def draw_exponent(axes: Axes, study: xr.Dataset) -> None:
    """Draw the exponent of the energy by the number of impacts, and those of the dampers."""
    impacts = study["impacts_used"]
    place = np.arange(impacts.size)
    for model, power in LOSS_EXPONENTS.items():
        axes.axvline(power, **look(model, marker=""))
    gamma = study["amplitude_exponent"].values
    interval = study["amplitude_exponent_interval"]
    error_bars(
        axes, gamma, place, interval, upright=False, label="measured, 90 % interval", **POINTS
    )
    axes.set(yticks=place, yticklabels=impacts.values, ylim=(place[-1] + 0.6, -0.6))
    axes.set(xlim=(-0.75, 0.75), xticks=[-0.5, 0, 0.5], title="(a) exponent of the energy")
    axes.set_xlabel(r"$\gamma$: relative loss $\propto$ energy$^\gamma$ [-]")
    axes.set_ylabel("impacts used of each trial [-]")


def draw_likelihood(axes: Axes, study: xr.Dataset) -> None:
    """Draw the log likelihood of each damper, minus that of the power law."""
    impacts = study["impacts_used"]
    likelihood = study["log_likelihood"]
    relative = likelihood - likelihood.sel(damping_model="power law")
    for model in ("CR", *PAPER_MODELS):
        axes.plot(impacts, relative.sel(damping_model=model), label=model, **look(model))
    axes.axhline(0, color=GREY, linewidth=0.8)
    axes.set_xticks(impacts.values)
    axes.set(title="(b) dampers", xlabel="impacts used of each trial [-]")
    axes.set_ylabel(r"$\ln L$ minus that of the power law [-]")


def draw_restitution(axes: Axes, study: xr.Dataset) -> None:
    """Draw measured e divided by that of Housner, with the range of single trials."""
    slenderness = study["geometry"]
    low, high = study["trial_over_housner_interval"].transpose("bound", ...).values
    axes.fill_between(
        slenderness, low, high, color=PALE, linewidth=0, label="one trial, 90 % interval"
    )
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    ratio = study["restitution_over_housner"].values
    interval = study["restitution_over_housner_interval"]
    error_bars(axes, slenderness.values, ratio, interval, **POINTS)
    axes.margins(x=0.05)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(title="(c) restitution", xlabel="$H/B$ of the block [-]")
    axes.set_ylabel("$e$ / $e$ of Housner [-]")
