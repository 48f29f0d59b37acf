"""Error against force of dampers that act about the crossing, and the motion there."""

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

FAMILIES = {"ECD": "ECD of order $m$", "BAND": "BAND of width $t_c$", "CQD": "CQD of width $w/a_1$"}


def fig_order(order: xr.Dataset) -> Figure:
    """Draw error against force, and force and velocity about the first crossing of a decay."""
    figure, ((median, quantile), (force, velocity)) = panels(2, 2, 136.0)
    study = order.sel(restitution=RESTITUTION, method="nearest")
    title = f"{int(order['records'])} records, $e = {float(study['restitution']):g}$"
    draw_errors(median, study, "log_error_median")
    median.set(title=f"(a) median, {title}", ylabel=r"median of $|\ln r|$ [-]")
    draw_errors(quantile, study, "log_error_90")
    quantile.set(title=f"(b) 90th percentile, {title}", ylabel=r"90th percentile of $|\ln r|$ [-]")
    draw_crossing(force, velocity, order)
    e = float(order["crossing_restitution"])
    force.set_title(f"(c) damping force at the first crossing, $e = {e:g}$")
    velocity.set_title("(d) velocity at the first crossing")
    legend(figure, [*handles(median), *handles(velocity)], columns=4)
    return figure


def draw_errors(axes: Axes, study: xr.Dataset, name: str) -> None:
    """Draw the error of each family against its force, and CR with another e as a band."""
    families = study["damper_family"].values
    other_restitution = study[name].isel(damper=(families == "restitution"))
    low = float(other_restitution.min())
    high = float(other_restitution.max())
    axes.axhspan(low, high, color=PALE, linewidth=1.2, label=r"CR, $e \mp 0.01$")
    for family, label in FAMILIES.items():
        rows = study.isel(damper=(families == family))
        force = rows["crossing_force"].sel(wall="paper").values
        line = look(family, linestyle="solid", markersize=4, label=label)
        axes.plot(force, rows[name], **line)
        numbers = [f"{parameter:g}" for parameter in rows["damper_parameter"].values]
        annotate_points(axes, family, force, rows[name].values, numbers)
    log_ticks(axes.xaxis)
    log_ticks(axes.yaxis)
    axes.margins(0.1)
    axes.set_xlabel(r"damping force at the crossing / $F_0$ [-]")


def annotate_points(axes: Axes, family: str, x: Any, y: Any, numbers: list[str]) -> None:
    """Write the order or width beside each point: below the lower line, above the upper ones."""
    place: dict[str, Any] = {"xytext": (4, 3), "ha": "left", "va": "bottom"}
    if family == "BAND":
        place = {"xytext": (-4, -3), "ha": "right", "va": "top"}
    place |= {"textcoords": "offset points", "color": LOOK[family]["color"], "size": 7}
    for point_x, point_y, number in zip(x, y, numbers, strict=True):
        axes.annotate(number, (point_x, point_y), **place)


def draw_crossing(force: Axes, velocity: Axes, order: xr.Dataset) -> None:
    """Draw the force up to the first turn, from left to right, and the velocity about it."""
    tau = order["tau"].values
    displacement = order["displacement"].sel(crossing_damper="CR").values
    impact = tau[int(np.argmax(displacement <= 0)) - 1]
    is_near = np.abs(tau - impact) <= 0.35  # [tau]
    lines: dict[str, dict[str, Any]] = {  # CR last, on top
        "ECD16": look("ECD", marker="", label="ECD16"),
        "BAND0.4": look("BAND", marker="", linestyle=(0, (5.0, 1.6)), label="BAND0.4"),
        "BAND0.2": look("BAND", marker="", linestyle="solid", label="BAND0.2"),
        "CR": look("CR", marker="", label="impact (CR)"),
    }
    for damper, line in lines.items():
        decay = order.sel(crossing_damper=damper)
        velocity.plot(tau[is_near] - impact, decay["velocity"].values[is_near], **line)
        if damper != "CR":
            turn = int(np.argmax(decay["velocity"].values[1:] >= 0)) + 1
            half_cycle = decay.isel(tau=slice(0, turn))
            force.plot(half_cycle["displacement"], half_cycle["damping_force"], **line)
    lowest = 1.2 * float(order["damping_force"].min())
    # The force of an impact is an impulse, so CR has a vertical line.
    force.plot([0, 0], [0, lowest], **lines["CR"])
    force.set(xlim=(0.15, -0.15), ylim=(lowest, -0.03 * lowest), xlabel=DISPLACEMENT)
    force.set_ylabel(r"damping force $C\,\dot u/F_0$ [-]")
    velocity.set_xlabel(r"dimensionless time from the impact $p\,t$ [-]")
    velocity.set_ylabel(r"$\dot u/(p\,u_\mathrm{ins})$ [-]")
