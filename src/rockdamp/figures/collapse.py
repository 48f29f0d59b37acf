"""Collapse under earthquakes, of every wall: incremental dynamic analyses and fragility."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpecBase, SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.special import ndtr

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED_SOURCE, REFERENCE
from rockdamp.figures.earthquakes import SOURCE_NAMES, at_source, legend_above, plain_logarithmic
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    columns_of,
    dampers,
    line_of,
    literal,
    new_figure,
    one_two_five,
    scaling,
    style_of,
    styled,
)
from rockdamp.mechanics.wall import EXCITATION_FACTOR

MOST_COLUMNS = 4
VELOCITY = "PGV [m s$^{-1}$]"
VELOCITY_RATIO = r"velocity ratio $\lambda\,\mathrm{PGV}/(p\,u_\mathrm{ins})$ [-]"
VELOCITY_RATIO_TICKS = (0.2, 0.5, 1.0, 2.0, 5.0)
LABEL: dict[str, Any] = {"fontsize": 9}
LEGEND: dict[str, Any] = {"fontsize": 8, "title_fontsize": 8}
TICKS = 8  # size of their labels [pt]
SMALLEST_PEAK = 0.003  # u/u_ins; below, nothing but the first branch
BAND = "#D9D9D9"
SHARES: dict[str, Any] = {  # of histories under CR that collapse
    "linestyle": "none",
    "marker": "o",
    "markerfacecolor": "white",
    "color": style_of(REFERENCE).colour,
}
SOURCE_MARKS = {"polynomial": "<", "least error": "o", "closed form": ">"}


@styled
def fig_ida(comparison: xr.Dataset, walls: xr.Dataset) -> Figure:
    """Draw fractiles of the peaks over the records against the velocity ratio, for each wall."""
    peaks = with_velocity(at_source(comparison), walls)
    columns, rows = _shape(peaks)
    figure = new_figure(30.0 + 62.0 * rows)
    panels = _panels(figure, peaks, _fractiles, figure.add_gridspec(rows, columns))
    for axes in panels:
        axes.set_xlim(SMALLEST_PEAK, 1.0)
        plain_logarithmic(axes, [0.01, 0.1, 1], VELOCITY_RATIO_TICKS)
    for axes in panels:
        axes.set_xlabel(DISPLACEMENT, **LABEL)
    scale = peaks["velocity_ratio"]
    standing = scale.where(peaks["fractile"].notnull().any(("fractile_probability", "wall", "damping_model")), scale[1])
    panels[0].set_ylim(float(scale[0]), 1.1 * float(standing.max()))
    for axes in panels[::columns]:
        axes.set_ylabel(VELOCITY_RATIO, **LABEL)
    for axes, unit in zip(panels, peaks["unit_velocity"].values, strict=True):
        _velocities(axes, "right", float(unit)).set_ylabel(VELOCITY, **LABEL)
    low, centre, high = (f"{100 * value:g}" for value in peaks["fractile_probability"].values)
    handles = [
        Patch(facecolor=BAND, label=f"CR, {low} to {high} %"),
        *(
            Line2D([], [], marker=style_of(model).marker, label=f"{model}, {centre} %", **line_of(model))
            for model in (REFERENCE, *dampers(peaks))
        ),
        Line2D([], [], color=GREY, linewidth=0.5, label=f"dampers, {low} and {high} %"),
    ]
    legend_above(figure, peaks, handles, **LEGEND)
    return figure


def with_velocity(of_walls: xr.Dataset, walls: xr.Dataset) -> xr.Dataset:
    """Add ``unit_velocity`` (wall), the peak ground velocity of the velocity ratio 1. [m s-1]"""
    unit = walls["frequency_parameter"] * walls["instability_displacement"] / EXCITATION_FACTOR
    return of_walls.assign(unit_velocity=("wall", unit.sel(wall=of_walls["wall"]).values))


def _shape(of_walls: xr.Dataset) -> tuple[int, int]:
    """Return columns and rows of the panels, as full as they can be."""
    count = of_walls.sizes["wall"]
    columns = columns_of(count, MOST_COLUMNS)
    return columns, -(-count // columns)


def _velocities(axes: Axes, side: Any, unit: float) -> Any:
    """Give a panel a second axis, with the peak ground velocity of each velocity ratio."""
    second: Any = (axes.secondary_xaxis if side == "top" else axes.secondary_yaxis)(side, functions=scaling(unit))
    axis: Axis = second.xaxis if side == "top" else second.yaxis
    axis.set_tick_params(labelsize=TICKS)
    one_two_five(axis)
    axes.spines[side].set_visible(True)
    return second


def _panels(
    figure: Figure, walls: xr.Dataset, draw: Callable[[Axes, xr.Dataset], None], grid: GridSpecBase
) -> list[Axes]:
    """Draw one panel for each wall, with shared axes; its text is larger than elsewhere, as the panels are small."""
    panels: list[Axes] = []
    columns = grid.ncols
    for index in range(walls.sizes["wall"]):
        first = panels[0] if panels else None
        axes = figure.add_subplot(grid[index // columns, index % columns], sharex=first, sharey=first)
        draw(axes, walls.isel(wall=index))
        axes.set_title(literal(str(walls["wall"].values[index])), **LABEL)
        axes.tick_params(labelleft=index % columns == 0, labelsize=TICKS)
        panels.append(axes)
    return panels


def _fractiles(axes: Axes, wall: xr.Dataset) -> None:
    scale = wall["velocity_ratio"].values
    low, centre, high = (
        {str(model): values.sel(damping_model=model).values for model in wall["damping_model"].values}
        for values in wall["fractile"]
    )
    # A fractile that has collapsed is beyond any displacement: the band is open there.
    axes.fill_betweenx(
        scale,
        low[REFERENCE],
        np.where(np.isfinite(high[REFERENCE]), high[REFERENCE], 1.0),
        where=np.isfinite(low[REFERENCE]).tolist(),
        color=BAND,
        linewidth=0,
    )
    for model in (REFERENCE, *dampers(wall)):
        if model != REFERENCE:
            for values in (low[model], high[model]):
                axes.plot(values, scale, linewidth=0.5, **line_of(model))
        last = np.flatnonzero(np.isfinite(centre[model]))[-1:]
        axes.plot(centre[model], scale, marker=style_of(model).marker, markevery=last.tolist(), **line_of(model))


# --- fragility --------------------------------------------------------------------------------------------------------


@styled
def fig_fragility(comparison: xr.Dataset, walls: xr.Dataset) -> Figure:
    """Draw fragility curves of each wall, and each damper's median of collapse over CR's."""
    fragility = with_velocity(at_source(comparison), walls)
    columns, rows = _shape(fragility)
    figure = new_figure(82.0 + 58.0 * rows)
    halves = figure.add_gridspec(2, 1, height_ratios=[58.0 * rows, 55.0])
    panels = _panels(figure, fragility, _curves, halves[0, 0].subgridspec(rows, columns))
    for axes, unit in zip(panels, fragility["unit_velocity"].values, strict=True):
        plain_logarithmic(axes, VELOCITY_RATIO_TICKS)
        _velocities(axes, "top", float(unit)).set_xlabel(VELOCITY, **LABEL)
    for axes in panels[-columns:]:
        axes.set_xlabel(VELOCITY_RATIO.replace("velocity ratio ", ""), **LABEL)
    for axes in panels[::columns]:
        axes.set_ylabel("probability of collapse [-]", **LABEL)
    _forests(figure, halves[1, 0], comparison)
    curves: list[Line2D | Patch] = [
        Line2D([], [], label=REFERENCE, **line_of(REFERENCE)),
        Patch(facecolor=BAND, label="CR, at least 90 % band"),
        Line2D([], [], label="CR, share of the records", **SHARES),
        *(Line2D([], [], label=model, **line_of(model)) for model in dampers(fragility)),
    ]
    title = f"curves: $e = {float(fragility['restitution']):g}$, {SOURCE_NAMES[RECOMMENDED_SOURCE]} at each wall"
    figure.legend(handles=curves, loc="outside upper center", ncols=4, title=title, **LEGEND)
    marks = [
        Line2D([], [], linestyle="none", marker=mark, color=GREY, label=SOURCE_NAMES[source])
        for source, mark in SOURCE_MARKS.items()
    ]
    title = "median of collapse of all walls together, 95 % bootstrap intervals"
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), title=title, **LEGEND)
    return figure


def envelope(intensity: Array, median: Array, dispersion: Array) -> tuple[Array, Array]:
    """Return lowest and highest probability over the fragility curves with parameters in two intervals.

    Of two intervals that each hold 95 % of the replicates, nine in ten replicates at least lie in both. The
    probability is monotone in the median, and in the dispersion at a given median, so that its extremes are at corners.
    """
    corners = np.stack([ndtr(np.log(intensity / m) / s) for m in median for s in dispersion])
    return corners.min(axis=0), corners.max(axis=0)


def _curves(axes: Axes, wall: xr.Dataset) -> None:
    names = {"wall_median_velocity_ratio": "median", "wall_median_velocity_ratio_interval": "median_interval"}
    names |= {f"wall_{name}": name for name in ("dispersion", "dispersion_interval")}
    draw_fragility(axes, wall[["collapse_fraction", *names]].rename(names), "velocity_ratio")


def draw_fragility(axes: Axes, fragility: xr.Dataset, intensity: str) -> None:
    """Draw the lognormal curve of each model over an intensity, with the band of CR and the shares that collapsed."""
    level = np.geomspace(float(fragility[intensity][0]), float(fragility[intensity][-1]), 201)
    cr = fragility.sel(damping_model=REFERENCE)
    low, high = envelope(level, cr["median_interval"].values, cr["dispersion_interval"].values)
    axes.fill_between(level, low, high, color=BAND, linewidth=0)
    for model in (*dampers(fragility), REFERENCE):
        median, beta = (float(fragility[name].sel(damping_model=model)) for name in ("median", "dispersion"))
        axes.plot(level, ndtr(np.log(level / median) / beta), label=model, **line_of(model))
    axes.plot(fragility[intensity], cr["collapse_fraction"], markersize=2.8, zorder=4, **SHARES)
    axes.set(xlim=(level[0], level[-1]), ylim=(0, 1.02))


def _forests(figure: Figure, place: SubplotSpec, comparison: xr.Dataset) -> None:
    """Draw the ratio of medians for every damper and source, a panel for each e."""
    grid = place.subgridspec(1, comparison.sizes["restitution"])
    first: Axes | None = None
    for column in range(comparison.sizes["restitution"]):
        axes = figure.add_subplot(grid[0, column], sharex=first, sharey=first)
        _forest(axes, at_e := comparison.isel(restitution=column))
        axes.set_title(f"$e = {float(at_e['restitution']):g}$", **LABEL)
        axes.set_xlabel("median over that of CR [-]", **LABEL)
        axes.tick_params(labelleft=first is None, labelsize=TICKS)
        if first is None:
            first = axes


def _forest(axes: Axes, at_e: xr.Dataset) -> None:
    models, sources = dampers(at_e), [str(source) for source in at_e["damping_ratio_source"].values]
    for row, model in enumerate(models):
        for shift, source in enumerate(sources):
            cell = at_e.sel(damping_model=model, damping_ratio_source=source)
            y = row + 0.24 * (shift - (len(sources) - 1) / 2)
            ends = cell["median_intensity_ratio_interval"].values
            axes.plot(ends, [y, y], color=style_of(model).colour, linewidth=1.1)
            mark: dict[str, Any] = {"marker": SOURCE_MARKS.get(source, "o"), "color": style_of(model).colour}
            axes.plot(float(cell["median_intensity_ratio"]), y, markersize=3.6, **mark)
    axes.axvline(1.0, color="black", linewidth=0.6)
    for row in range(1, len(models)):
        axes.axhline(row - 0.5, color=PALE, linewidth=0.4)
    axes.set_yticks(range(len(models)), models)
    axes.set_ylim(len(models) - 0.4, -0.6)
    axes.margins(x=0.08)
