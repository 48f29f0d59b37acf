"""What holds a wall, and what its equation of motion leaves out: effects on the median intensity of collapse."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import GREY, PALE, new_figure, styled, with_interval
from rockdamp.text import number, percent, plain

ALL, RATIO = "all", "median_intensity_ratio"
SHADES = ("#0072B2", "#D0267F", "#E69F00", "#009E73", "#56B4E9", "#8C6D1F", "#9A4C95", GREY)  # of walls
MARKERS = "o^sDv<>p"


@styled
def fig_supports(supports: xr.Dataset) -> Figure:
    """Draw the effect of a flexible floor by its period, and that of each other assumption."""
    figure = new_figure(95.0)
    left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.1)})
    _floors(left, supports.isel(assumption=floors(supports)).sortby("diaphragm_period"))
    _others(right, supports.isel(assumption=~floors(supports)))
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def floors(supports: xr.Dataset) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return which cases are of a flexible floor."""
    return np.isfinite(supports["diaphragm_period"].values)


def _floors(axes: Axes, cases: xr.Dataset) -> None:
    period = np.concatenate([[0.0], cases["diaphragm_period"].values])
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for column, wall in enumerate(_walls(cases)):
        ratio = np.concatenate([[1.0], cases[RATIO].sel(wall=wall).values])
        colour, marker = SHADES[column % 8], MARKERS[column % 8]
        axes.plot(period, ratio, markersize=2.5, linewidth=0.6, label=wall, color=colour, marker=marker)
    whole = cases.isel(wall=0)
    ratio = whole[RATIO].values
    errors = np.abs(whole[f"{RATIO}_interval"].transpose("bound", ...).values - ratio)
    axes.errorbar(
        period[1:], ratio, yerr=errors, color="#1A1A1A", linewidth=1.8, capsize=2, marker="o", markersize=3, label=ALL
    )
    axes.set_title("(a) a flexible floor at the top")
    axes.set(xlim=(0, 1.04 * period[-1]))  # room for the last bar's ends
    axes.set(xlabel="period of the floor [s]", ylabel="median intensity of collapse over the assumed [-]")


def _others(axes: Axes, cases: xr.Dataset) -> None:
    names = [*map(str, cases["assumption"].values)]
    place = np.arange(len(names))[::-1]
    axes.axvline(1.0, color=PALE, linewidth=0.8)
    for column, wall in enumerate(_walls(cases)):
        ratio = cases[RATIO].sel(wall=wall).values
        axes.plot(ratio, place, linestyle="none", marker=MARKERS[column % 8], color=SHADES[column % 8], markersize=3)
    whole = cases.isel(wall=0)
    ratio = whole[RATIO].values
    errors = np.abs(whole[f"{RATIO}_interval"].transpose("bound", ...).values - ratio)
    axes.errorbar(
        ratio, place - 0.25, xerr=errors, linestyle="none", color="#1A1A1A", marker="o", markersize=4, capsize=2
    )
    axes.set(xscale="log", yticks=place, yticklabels=names, xlabel="median intensity of collapse over the assumed [-]")
    ticks = [0.5, 0.7, 1.0, 1.4, 2.0, 2.8]
    axes.set_xticks(ticks, [plain(tick) for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.set_title("(b) other assumptions")


def _walls(cases: xr.Dataset) -> list[str]:
    return [str(wall) for wall in cases["wall"].values[1:]]


def fig_supports_caption(supports: xr.Dataset) -> str:
    """Write the caption, HTML."""
    whole, walls = supports.isel(wall=0), supports.isel(wall=slice(1, None))
    floor = whole.isel(assumption=floors(supports))
    ratio = floor[RATIO]
    worst = floor.isel(assumption=int(np.argmin(ratio.fillna(np.inf).values)))
    least = walls[RATIO].isel(assumption=floors(supports)).min()
    others = [whole.isel(assumption=index) for index in np.flatnonzero(~floors(whole))]
    known = [case for case in others if np.isfinite(case[RATIO])]
    texts = [f"{case['assumption'].item()} {with_interval(case, RATIO)}" for case in known]
    return f"""
    The median intensity of collapse, as a PGV of the ground, over that under the usual assumption, for the walls and
    records of the study of earthquakes with e by the rule measured; all walls together with bootstrap intervals over
    stations, and each wall. (a) A floor with {percent(supports["diaphragm_damping"])} of damping that the wall does not
    load: over all walls the least is {with_interval(worst, RATIO)}, at a period of
    {plain(worst["diaphragm_period"])}&nbsp;s, over single walls {number(least)}. (b) {"; ".join(texts)}. Each is
    compared with the walls as assumed, but the mass that counts at the impact with e impulsive, and an overburden that
    keeps its side with the worse of both. Below one the usual assumption is unsafe, above one safe.
    """
