"""Error against force: dampers that act about the crossing, and what they do there."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.constants import REFERENCE
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    REFERENCE_RESTITUTION,
    line_of,
    new_figure,
    one_two_five,
    style_of,
    styled,
)

FAMILIES = {"ECD": "ECD of order $m$", "BAND": "BAND of width $t_c$", "CQD": "CQD of width $w/a_1$"}
MEASURES = {"log_error_median": "median", "log_error_90": "90 % quantile"}
LOOKS: dict[str, dict[str, Any]] = {  # of the shown decay; the colours are those of the families
    "ECD16": {"color": style_of("ECD").colour, "linestyle": (0, (1.0, 1.2)), "linewidth": 1.5},
    "BAND0.4": {"color": style_of("BAND").colour, "linestyle": (0, (5.0, 1.6)), "linewidth": 1.2},
    "BAND0.2": {"color": style_of("BAND").colour, "linestyle": "solid", "linewidth": 1.2},
}
NEAR = 0.35  # in tau, shown before and after the crossing


@styled
def fig_order(order: xr.Dataset) -> Figure:
    """Draw the error over the force at the crossing, and force and velocity about the first crossing of a decay."""
    figure = new_figure(140.0)
    panels, (force, velocity) = figure.subplots(2, 2)
    at_e = order.sel(restitution=REFERENCE_RESTITUTION, method="nearest")
    for axes, letter, (measure, words) in zip(panels, "ab", MEASURES.items(), strict=True):
        _errors(axes, at_e, measure)
        axes.set_title(f"({letter}) {words}, {int(order['records'])} records, $e = {float(at_e['restitution']):g}$")
        axes.set_ylabel(f"{words} of $|\\ln r|$ [-]")
    panels[0].legend(loc="lower left")
    _force(force, order)
    _velocity(velocity, order)
    figure.legend(handles=force.get_legend_handles_labels()[0], loc="outside lower center", ncols=len(LOOKS) + 1)
    return figure


def _errors(axes: Axes, at_e: xr.Dataset, measure: str) -> None:
    """Draw an error of each family over its force on the paper's curve, and that of CR with another e as a band."""
    names = at_e["damper"].values.astype(str)
    changed = at_e[measure].sel(damper=[name for name in names if name.startswith("e ")])
    label = r"CR, $e \mp$ " + names[np.char.startswith(names, "e -")][0].removeprefix("e - ")
    axes.axhspan(float(changed.min()), float(changed.max()), color=PALE, alpha=0.8, linewidth=1.2, label=label)
    for family, words in FAMILIES.items():
        of_family = at_e.sel(damper=[name for name in names if name.startswith(family)])
        force, error = of_family["crossing_force"].sel(wall="paper").values, of_family[measure].values
        look = style_of(family)
        axes.plot(force, error, color=look.colour, marker=look.marker, markersize=4, label=words)
        for x, y, name in zip(force, error, of_family["damper"].values.astype(str), strict=True):
            side = -1 if family == "BAND" else 1  # the lower line has its labels below, the upper ones above
            axes.annotate(
                name.removeprefix(family) or "0",
                (x, y),
                xytext=(4 * side, 3 * side),
                textcoords="offset points",
                ha="left" if side > 0 else "right",
                va="bottom" if side > 0 else "top",
                fontsize=7,
                color=look.colour,
            )
    axes.set(xscale="log", yscale="log", xlabel=r"damping force at the crossing over $F_0$ [-]")
    axes.margins(0.1)
    one_two_five(axes.xaxis)
    one_two_five(axes.yaxis)


def _of(order: xr.Dataset, name: str, damper: str) -> Any:
    return order[name].sel(shown_damper=damper).values


def _force(axes: Axes, order: xr.Dataset) -> None:
    """Draw the damping force against displacement up to the first turn, and the impact, a force without bound."""
    for damper, look in LOOKS.items():
        turned = int(np.argmax(_of(order, "shown_velocity", damper)[1:] >= 0)) + 1
        u, force = (_of(order, name, damper)[:turned] for name in ("shown_displacement", "shown_damping_force"))
        axes.plot(u, force, label=damper, **look)
    lowest = 1.2 * float(order["shown_damping_force"].min())
    axes.set_ylim(lowest, -0.03 * lowest)
    axes.plot([0, 0], [0, lowest], label="impact (CR)", **line_of(REFERENCE))
    release = float(_of(order, "shown_displacement", REFERENCE)[0])
    axes.set_xlim(release, -release)  # as time goes, from left to right
    axes.set(xlabel=DISPLACEMENT, ylabel=r"damping force $C\,\dot u/F_0$ [-]")
    axes.set_title(f"(c) the first half cycle of a decay, $e = {float(order['shown_restitution']):g}$")


def _velocity(axes: Axes, order: xr.Dataset) -> None:
    """Draw the velocity around the first crossing, in time from CR's impact."""
    tau = order["tau"].values
    at = int(np.argmax(_of(order, "shown_displacement", REFERENCE) <= 0)) - 1
    near = np.abs(tau - tau[at]) <= NEAR
    for damper, look in {**LOOKS, REFERENCE: line_of(REFERENCE)}.items():
        axes.plot(tau[near] - tau[at], _of(order, "shown_velocity", damper)[near], **look)
    axes.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    axes.set_xlabel(r"dimensionless time from the impact $p\,t$ [-]")
    axes.set_ylabel(r"$\dot u/(p\,u_\mathrm{ins})$ [-]")
    axes.set_title("(d) its velocity at the crossing")
