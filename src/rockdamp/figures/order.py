"""Error against force: dampers that act about the crossing, and what they do there."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import (
    DISPLACEMENT,
    LOOK,
    PALE,
    RESTITUTION,
    handles,
    legend,
    log_ticks,
    look,
    panels,
)


def fig_order(order: xr.Dataset) -> Figure:
    """Draw the error over the force at the crossing, and force and velocity about the first crossing of a decay."""
    figure, ((median, quantile), (force, velocity)) = panels(2, 2, 136.0)
    study = order.sel(restitution=RESTITUTION, method="nearest")
    title = f"{int(order['records'])} records, $e = {float(study['restitution']):g}$"
    for axes, name, words in (
        (median, "log_error_median", "(a) median"),
        (quantile, "log_error_90", "(b) 90 % quantile"),
    ):
        _errors(axes, study, name)
        axes.set(title=f"{words}, {title}", ylabel=f"{words[4:]} of $|\\ln r|$ [-]")
    _crossing(force, velocity, order)
    force.set_title(
        f"(c) damping force at the first crossing, $e = {float(order['crossing_restitution']):g}$"
    )
    velocity.set_title("(d) velocity at the first crossing")
    legend(figure, [*handles(median), *handles(velocity)], columns=4)
    return figure


def _errors(axes: Axes, study: xr.Dataset, name: str) -> None:
    """Draw the error of each family over its force on the paper's curve, and CR with another e as a band."""
    dampers = study["damper"].values.astype(str)
    changed = study[name].isel(damper=np.char.startswith(dampers, "e "))
    axes.axhspan(
        float(changed.min()),
        float(changed.max()),
        color=PALE,
        linewidth=1.2,
        label=r"CR, $e \mp 0.01$",
    )
    families = {
        "ECD": "ECD of order $m$",
        "BAND": "BAND of width $t_c$",
        "CQD": "CQD of width $w/a_1$",
    }
    for family, label in families.items():
        rows = study.isel(damper=np.char.startswith(dampers, family))
        force = rows["crossing_force"].sel(wall="paper").values
        axes.plot(force, rows[name], label=label, **look(family, linestyle="solid", markersize=4))
        side = (
            -1 if family == "BAND" else 1
        )  # the lower line has its numbers below, the upper ones above
        place: dict[str, Any] = {
            "ha": "left" if side > 0 else "right",
            "va": "bottom" if side > 0 else "top",
        }
        for x, y, damper in zip(
            force, rows[name].values, rows["damper"].values.astype(str), strict=True
        ):
            number = damper.removeprefix(family) or "0"
            shift = (4 * side, 3 * side)
            axes.annotate(
                number,
                (x, y),
                shift,
                textcoords="offset points",
                color=LOOK[family]["color"],
                size=7,
                **place,
            )
    log_ticks(axes.xaxis)
    log_ticks(axes.yaxis)
    axes.margins(0.1)
    axes.set_xlabel(r"damping force at the crossing over $F_0$ [-]")


def _crossing(force: Axes, velocity: Axes, order: xr.Dataset) -> None:
    """Draw the force up to the first turn, as time goes from left to right, and the velocity about the crossing."""
    tau = order["tau"].values
    impact = tau[int(np.argmax(order["displacement"].sel(crossing_damper="CR").values <= 0)) - 1]
    near = np.abs(tau - impact) <= 0.35
    lines: dict[str, dict[str, Any]] = {  # impact last, on top
        "ECD16": look("ECD", marker=""),
        "BAND0.4": look("BAND", marker="", linestyle=(0, (5.0, 1.6))),
        "BAND0.2": look("BAND", marker="", linestyle="solid"),
        "CR": look("CR", marker=""),
    }
    for damper, line in lines.items():
        decay = order.sel(crossing_damper=damper)
        velocity.plot(
            tau[near] - impact,
            decay["velocity"].values[near],
            label="impact (CR)" if damper == "CR" else damper,
            **line,
        )
        if damper != "CR":
            half_cycle = slice(0, int(np.argmax(decay["velocity"].values[1:] >= 0)) + 1)
            force.plot(
                decay["displacement"][half_cycle], decay["damping_force"][half_cycle], **line
            )
    lowest = 1.2 * float(order["damping_force"].min())
    force.plot([0, 0], [0, lowest], **lines["CR"])
    force.set(xlim=(0.15, -0.15), ylim=(lowest, -0.03 * lowest), xlabel=DISPLACEMENT)
    force.set_ylabel(r"damping force $C\,\dot u/F_0$ [-]")
    velocity.set(
        xlabel=r"dimensionless time from the impact $p\,t$ [-]",
        ylabel=r"$\dot u/(p\,u_\mathrm{ins})$ [-]",
    )
