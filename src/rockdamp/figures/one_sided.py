"""Walls that rock to one side: a history, the sketch of one with its stop and tie, and how good the damper at it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from rockdamp.figures.mechanism import wall_corners
from rockdamp.figures.style import GREY, PALE, STOP_COLOUR, new_figure, styled
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import OneSidedWall, height_of_u
from rockdamp.mechanics.wall import Wall
from rockdamp.text import number, plain

DRAWN = 0.6  # of the thickness: the displacement of the sketch
MASONRY, STONE = "#D9C3B0", "#BDBDBD"
POINTS = 400  # of the curve
MILLIMETRES = 1000.0
SHADES, MARKERS = ("#8C510A", "#01665E", "#5E3C99", "#1A1A1A"), ("o", "s", "^", "D", "v")
LINES = ("solid", "dashed", "dotted", "dashdot", (0, (5.0, 1.2, 1.0, 1.2)))


@styled
def history_figure(history: xr.Dataset) -> Figure:
    """Draw the ground's motion as it acts and the response of a wall against a stop, of one sign."""
    one = history.isel(sign=0) if "sign" in history.dims else history
    displacement = MILLIMETRES * one["control_displacement"]
    figure = new_figure(110.0)
    ground, axes = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 2.2]})
    ground.plot(one["elapsed"], one["ground_acceleration"], color="black", linewidth=0.8)
    ground.set_ylabel(r"$\ddot u_g$ [m s$^{-2}$]")
    label = f"CR, largest displacement {float(displacement.max()):.3g} mm"
    if bool(one["collapsed"]):
        label = f"CR, collapses at {float(one['outcome_elapsed']):.2f} s"
    axes.plot(one["elapsed"], displacement, color="black", linewidth=0.9, label=label)
    axes.axhspan(-0.04 * axes.get_ylim()[1], 0.0, color=STONE)
    for each in (ground, axes):
        each.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    axes.set(xlabel="time $t$ [s]", ylabel="$u$ away from the stop [mm]")
    figure.align_ylabels([ground, axes])
    figure.legend(loc="outside lower center")
    return figure


@styled
def one_sided_wall_figure(wall: OneSidedWall, curve: TrilinearCurve) -> Figure:
    """Draw a wall against its stop, displaced, with its tie; its force with the tie and without."""
    figure = new_figure(70.0)
    sketch, forces = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.7]})
    _draw_wall(sketch, wall)
    _draw_force(forces, wall, curve)
    return figure


def _draw_wall(axes: Axes, wall: OneSidedWall) -> None:
    mechanism = wall.mechanism
    thickness, height = float(mechanism.thickness), float(mechanism.height)
    hinge = float(mechanism.hinge_ratio) if isinstance(mechanism, Wall) else np.nan
    offset = DRAWN * thickness
    for corners in wall_corners(thickness, height, hinge, 0.0):
        axes.add_patch(Polygon(corners, closed=True, facecolor="none", edgecolor=PALE, linewidth=0.8))
    for corners in wall_corners(thickness, height, hinge, offset):
        axes.add_patch(Polygon(corners, closed=True, facecolor=MASONRY, edgecolor="black", linewidth=0.8))
    behind = -0.5 * thickness
    axes.add_patch(Rectangle((behind - 2.2 * thickness, 0), 2.2 * thickness, height, facecolor=STONE, hatch="////"))
    axes.text(behind - 1.1 * thickness, -0.03 * height, "stop", ha="center", va="top")
    if wall.tie is not None:
        level = float(height_of_u(mechanism))
        at = float(wall.tie.height_ratio)
        start, end = behind - 2.2 * thickness, behind + offset * at
        axes.plot([start, end], [at * level] * 2, color=STOP_COLOUR, linewidth=1.4, marker="|", markersize=5)
        axes.text(end + 1.3 * thickness, at * level, "tie", va="center", color=STOP_COLOUR)
    axes.plot([behind - 2.4 * thickness, 3 * thickness], [0, 0], color="black", linewidth=1.2)
    sizes = f"$t$ = {thickness:g} m, $h$ = {height:g} m"
    axes.text(0.6 * thickness, -0.03 * height, sizes, ha="left", va="top")
    axes.set(ylim=(-0.12 * height, 1.1 * height), aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(-0.75 * height, 0.75 * height)
    axes.spines[:].set_visible(False)


def _draw_force(axes: Axes, wall: OneSidedWall, curve: TrilinearCurve) -> None:
    u_ins = MILLIMETRES * float(wall.instability_displacement)
    strength = float(wall.mechanism.rigid_strength) / 1000
    x = np.linspace(0.0, 1.0, POINTS)
    axes.plot(u_ins * x, strength * (1.0 - x), color=GREY, linestyle="dashed", label="rigid wall")
    force = wall.force(curve)
    slope, initial, b1, ks, *_, a3, kt, ft, gap, rupture = (float(value) for value in force.parameters())
    own = np.maximum(np.minimum(np.minimum(initial + slope * x, b1), ks * (a3 - x)), 0.0)
    axes.plot(u_ins * x, strength * own, color="black", label="this wall")
    if kt > 0:
        tension = np.where(x - gap > rupture, 0.0, np.clip(kt * (x - gap), 0.0, ft))
        axes.plot(u_ins * x, strength * (own + tension), color=STOP_COLOUR, label="with its ties, stretched once")
    axes.set(xlim=(0, None), ylim=(0, None), xlabel="$u$ [mm]", ylabel="force $F$ [kN]")
    axes.legend(loc="upper right")


# --- the study --------------------------------------------------------------------------------------------------------


@styled
def fig_one_sided(one_sided: xr.Dataset) -> Figure:
    """Draw the peaks with the damper at the stop over those under restitution, and the two-sided wall's collapse."""
    figure = new_figure(80.0)
    peaks, falls = figure.subplots(1, 2)
    _draw_peaks(peaks, one_sided)
    _draw_two_sided(falls, one_sided)
    of_peaks, of_falls = peaks.get_legend_handles_labels(), falls.get_legend_handles_labels()
    handles, labels = [*of_peaks[0], *of_falls[0]], [*of_peaks[1], *of_falls[1]]
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def stops_of(one_sided: xr.Dataset) -> list[str]:
    """Return the alternatives that are dampers at the stop."""
    return [str(name) for name in one_sided["alternative"].values if "stop" in str(name)]


def middle_of(one_sided: xr.Dataset) -> float:
    """Return the e in the middle of those studied."""
    values = one_sided["restitution"].values
    return float(values[(values.size - 1) // 2])


def _draw_peaks(axes: Axes, one_sided: xr.Dataset) -> None:
    at = one_sided.sel(restitution=middle_of(one_sided))
    middle = np.sqrt(at["band_start"].values * at["band_end"].values)
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for index, name in enumerate(stops_of(one_sided)):
        one = at.sel(alternative=name)
        median, bounds = one["median_ratio"].values, one["median_ratio_interval"].values
        known = np.isfinite(bounds).all(axis=-1)
        error = np.where(known, np.abs(bounds.T - median), 0.0)
        axes.errorbar(
            middle * 1.05 ** (index - 1),
            median,
            yerr=error,
            color=SHADES[index % len(SHADES)],
            marker=MARKERS[index % len(MARKERS)],
            markersize=4,
            linewidth=0.9,
            capsize=2,
            label=name,
        )
    axes.set(xscale="log", xlabel=r"peak under CR, $u/u_\mathrm{ins}$ [-]", ylabel="peak over that under CR [-]")
    axes.set_title(f"(a) $e = {middle_of(one_sided):g}$")
    edges = [*one_sided["band_start"].values, one_sided["band_end"].values[-1]]
    axes.set_xlim(edges[0], edges[-1])
    axes.set_xticks(edges, [f"{edge:g}" for edge in edges])
    axes.minorticks_off()


def _draw_two_sided(axes: Axes, one_sided: xr.Dataset) -> None:
    at = one_sided.sel(restitution=middle_of(one_sided))
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for index, name in enumerate(map(str, at["wall"].values)):
        style: dict[str, Any] = {
            "color": "black",
            "linestyle": LINES[index % len(LINES)],
            "marker": MARKERS[index % len(MARKERS)],
        }
        ratio = at["two_sided_intensity_ratio"].sel(wall=name)
        axes.plot(ratio["two_sided_restitution"], ratio, linewidth=0.9, markersize=4, label=name, **style)
    axes.set(xlabel="$e$ of the two-sided wall [-]", ylabel="median of collapse over\nthe one-sided wall's [-]")
    axes.margins(x=0.05)
    axes.set_title("(b) two-sided in its place")


def fig_one_sided_caption(one_sided: xr.Dataset) -> str:
    """Write the caption, HTML."""
    e = middle_of(one_sided)
    at = one_sided.sel(restitution=e)
    stops = stops_of(one_sided)
    stiffest = at.sel(alternative=stops[-2] if len(stops) > 1 else stops[-1])
    medians = stiffest["median_ratio"].values
    return f"""
    Facades that hit a stop with e&nbsp;=&nbsp;{plain(e)}. (a) Peaks with a spring and
    a dashpot at the stop over those under restitution, which acts at the impact itself: medians by band of the peak,
    with bootstrap intervals over stations; with the {stiffest["alternative"].item()} they lie between
    {number(float(np.nanmin(medians)))} and {number(float(np.nanmax(medians)))}. (b) The median intensity of collapse
    of the two-sided wall over that of the one-sided: above one the two-sided wall errs on the unsafe side.
    """
