"""From viscous to impact: the error of ECD of order m by its order, and what the damper does at a crossing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, NullFormatter

from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    line_of,
    new_figure,
    present,
    ramp,
    style_of,
    styled,
    texts,
)
from rockdamp.text import at_most, percent, plain
from rockdamp.vocabulary import DECISIVE_CHANGE, REFERENCE

SHOWN = (0, 1, 4, 16)  # orders whose histories are drawn
LINES: tuple[Any, ...] = ("dotted", "dashdot", (0, (3.0, 1.4)), (0, (8.0, 1.6)))
NEAR = 0.35  # in tau, shown before and after the crossing


@styled
def fig_order(damper_order: xr.Dataset, earthquake_orders: xr.Dataset) -> Figure:
    """Draw the error against the order, and force and velocity in the first half cycle of a decay."""
    figure = new_figure(135.0)
    (decay, earthquakes), (force, velocity) = figure.subplots(2, 2, height_ratios=[1.0, 1.05])
    _decay(decay, at_shown(damper_order))
    _earthquakes(earthquakes, earthquake_orders)
    _force(force, damper_order)
    _velocity(velocity, damper_order)
    figure.legend(handles=force.get_legend_handles_labels()[0], loc="outside lower center", ncols=len(SHOWN) + 1)
    return figure


def at_shown(damper_order: xr.Dataset) -> xr.Dataset:
    """Return what was measured at the e nearest to that of the histories."""
    return damper_order.sel(restitution=float(damper_order["shown_restitution"]), method="nearest")


def at_middle(earthquake_orders: xr.Dataset) -> xr.Dataset:
    """Return what all records gave, at the middle e."""
    return earthquake_orders.isel(record_set=0, restitution=earthquake_orders.sizes["restitution"] // 2)


# --- error against order ---------------------------------------------------------------------------------------------


def _by_order(axes: Axes, at_e: xr.Dataset, sensitivity: xr.DataArray) -> Sequence[int]:
    """Prepare a panel with the orders evenly spaced and a band for CR's sensitivity to e; return their places."""
    orders, change = at_e["order"].values.tolist(), float(at_e["restitution_change"])
    places = range(len(orders))
    low, high = float(sensitivity.min()), float(sensitivity.max())
    # With an edge, so that a band as thin as a line is seen.
    axes.axhspan(low, high, color=PALE, alpha=0.8, linewidth=1.2, label=rf"CR, $e \mp {change:g}$")
    axes.set_yscale("log", subs=[2, 5])
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(list(places), texts(orders))
    axes.set(xlim=(-0.35, len(orders) - 0.65), xlabel="order $m$ [-]")
    return places


def _line(label: str) -> dict[str, Any]:
    style = style_of("ECD")
    return {"color": style.colour, "marker": style.marker, "label": label}


def _decay(axes: Axes, at_e: xr.Dataset) -> None:
    """Draw the error on the reference curve."""
    places = _by_order(axes, at_e, at_e["varied_rms_error"])
    axes.plot(places, at_e["rms_error"], **_line("ECD of order $m$"))
    axes.set_ylabel(r"rms of $\Delta|u|/u_\mathrm{ins}$ [-]")
    _titled(axes, f"(a) free decay, $e = {float(at_e['restitution']):g}$")


def _earthquakes(axes: Axes, earthquake_orders: xr.Dataset) -> None:
    at_e = at_middle(earthquake_orders)
    places = _by_order(axes, at_e, at_e["varied_log_error"].sel(variation=["lower e", "higher e"]))
    low, high = (at_e["log_error_interval"].isel(bound=bound) for bound in (0, -1))
    axes.fill_between(places, low, high, color=style_of("ECD").colour, alpha=0.2, linewidth=0, label="95 % interval")
    axes.plot(places, at_e["log_error"], **_line("all walls"))
    for set_formatter in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
        set_formatter(FormatStrFormatter("%g"))
    axes.set_ylabel("rms of ln(peak ratio) [-]")
    _titled(axes, f"(b) {int(at_e['records'])} records, $e = {float(at_e['restitution']):g}$")


def _titled(axes: Axes, title: str) -> None:
    """Give a panel its title and a legend below it, where no line passes."""
    axes.set_title(title)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.24))


# --- in the first half cycle -----------------------------------------------------------------------------------------


def _drawn(damper_order: xr.Dataset) -> list[tuple[xr.Dataset, dict[str, Any]]]:
    """Return the histories of the orders that are shown, and how each is drawn."""
    orders = present(damper_order["order"].values.tolist(), SHOWN)[: len(LINES)]
    colours = ramp(style_of("ECD").colour, len(orders))
    return [
        (
            damper_order.isel(order=order),
            {
                "color": colour,
                "linestyle": line,
                "linewidth": 1.3,
                "label": f"$m = {float(damper_order['order'][order]):g}$",
            },
        )
        for order, colour, line in zip(orders, colours, LINES, strict=False)
    ]


def crossing(damper_order: xr.Dataset) -> int:
    """Return the last sample before CR's first impact."""
    return int(np.argmax(damper_order["shown_reference_displacement"].values <= 0)) - 1


def _force(axes: Axes, damper_order: xr.Dataset) -> None:
    """Draw the damping force against displacement up to the first turn, and the impact, a force without bound."""
    for of_order, line in _drawn(damper_order):
        u, force = of_order["shown_displacement"].values, of_order["shown_damping_force"].values
        turned = np.flatnonzero(of_order["shown_velocity"].values[1:] >= 0)
        end = int(turned[0]) + 1 if turned.size else u.size
        axes.plot(u[:end], force[:end], **line)
    lowest = 1.25 * float(damper_order["shown_damping_force"].min())
    axes.set_ylim(lowest, -0.02 * lowest)
    style = style_of(REFERENCE)
    axes.plot([0, 0], [0, lowest], color=style.colour, linewidth=1.6, label="impact (CR)")
    axes.annotate(
        "", (0, lowest), (0, 0.85 * lowest), arrowprops={"arrowstyle": "-|>", "color": style.colour, "linewidth": 1.6}
    )
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    release = float(damper_order["release_amplitude"])
    axes.set_xlim(release, -release)  # as time goes, from left to right
    axes.set_xlabel(DISPLACEMENT)
    axes.set_ylabel(r"damping force $C\,\dot u/F_0$ [-]")
    axes.set_title(f"(c) the first half cycle of a decay, $e = {float(damper_order['shown_restitution']):g}$")


def _velocity(axes: Axes, damper_order: xr.Dataset) -> None:
    """Draw the velocity around the first crossing, in time from CR's impact."""
    tau, at = damper_order["tau"].values, crossing(damper_order)
    near = np.abs(tau - tau[at]) <= NEAR
    for of_order, line in _drawn(damper_order):
        axes.plot(tau[near] - tau[at], of_order["shown_velocity"].values[near], **line)
    velocity = damper_order["shown_reference_velocity"].values
    axes.plot(tau[near] - tau[at], velocity[near], label="impact (CR)", **line_of(REFERENCE))
    axes.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    axes.set_xlabel(r"dimensionless time from the impact $p\,t$ [-]")
    axes.set_ylabel(r"$\dot u/(p\,u_\mathrm{ins})$ [-]")
    axes.set_title("(d) its velocity at the crossing")


def fig_order_caption(damper_order: xr.Dataset, earthquake_orders: xr.Dataset) -> str:
    """Write the caption, HTML."""
    earthquakes = at_middle(earthquake_orders)
    judged = earthquake_orders.sel(change=DECISIVE_CHANGE)
    enough, everywhere = judged["smallest_order"].isel(record_set=0), judged["recommended_order"]
    return f"""
    Under earthquakes, all walls together, ECD of order m departs from CR by no more than a change of the loss by
    {percent(judged["loss_change"], 1)} does, in errors, collapses missed and collapses added alike,
    {_onwards(enough.sel(restitution=earthquakes["restitution"]), judged["order"])} at
    e&nbsp;=&nbsp;{plain(earthquakes["restitution"])}, and {_onwards(everywhere, judged["order"])} at every e studied.
    Over all orders and e of the study the peaks in free decay differ from those under CR by
    {at_most(damper_order["peak_error"].max())} at most.
    """


def _onwards(order: xr.DataArray, studied: xr.DataArray) -> str:
    if not np.isfinite(order):
        return "at no order studied"
    largest = float(order) == float(studied.max())
    return (
        f"at m&nbsp;=&nbsp;{plain(order)}, the largest studied" if largest else f"from m&nbsp;=&nbsp;{plain(order)} on"
    )
