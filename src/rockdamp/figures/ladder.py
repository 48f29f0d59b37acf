"""Fig. 8 of several records: each model on the rungs of a ladder, and what is right of it at which amplitude."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    DISPLACEMENT,
    DOUBLE_COLUMN,
    GREY,
    PALE,
    line_of,
    new_figure,
    plain,
    style_of,
    title_of,
)

MEASURED: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 2.0}
MOST_RUNGS = 4  # whose histories are drawn
RIGHT = 0.1  # of the measured value: as far as a model may be off to be called right
SHOWN_FROM, MARGIN = 0.05, 0.05  # of the motion's peak; of what is shown
SHORTEST_ROW, TALLEST = 15.0, 236.0  # [mm]


def amplitudes(validation: xr.Dataset) -> Array:
    """Largest measured displacement of each record, u/u_ins. [-]"""
    peaks: Array = (validation["measured_peak_displacement"] / validation["instability_displacement"]).values
    return peaks


def ladders(validation: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the records by what made them, each ladder from its lowest rung up."""
    makers = [str(maker) for maker in validation["record_made_by"].values]
    rungs = {maker: [i for i, other in enumerate(makers) if other == maker] for maker in dict.fromkeys(makers)}
    return {
        maker: validation.isel(record=sorted(of_maker, key=lambda i: amplitudes(validation)[i]))
        for maker, of_maker in rungs.items()
    }


def off(validation: xr.Dataset, quantity: str) -> xr.DataArray:
    """Computed over measured, of ``peak`` or ``decrement``; NaN where a model collapsed or there is no free decay."""
    if quantity == "peak":
        return validation["peak_ratio_to_measured"].where(validation["collapsed"] == 0)
    return validation["log_decrement"] / validation["measured_log_decrement"]


def draw_ladder(validation: xr.Dataset, heading: str, measured_name: str) -> Figure:
    """Draw the first ladder's histories, a row for each model, and below, for each ladder, what is right of them.

    Parameters
    ----------
    validation : xarray.Dataset
        As `fig8` takes it, of several records.
    heading, measured_name : str
        Of the figure; what the measured line is called.
    """
    models = [str(model) for model in validation["damping_model"].values]
    by_maker = ladders(validation)
    (maker, first), *_ = by_maker.items()
    rungs = first.isel(record=np.unique(np.linspace(0, first.sizes["record"] - 1, MOST_RUNGS).astype(int)))
    columns = max(rungs.sizes["record"], len(by_maker))
    rows = [1.0, *[1.0] * len(models), 1.9, 1.9]
    figure = new_figure(DOUBLE_COLUMN, min(TALLEST, 30 + SHORTEST_ROW * sum(rows)))
    grid = figure.add_gridspec(len(rows), columns, height_ratios=rows)
    corner: Axes | None = None
    for column in range(rungs.sizes["record"]):
        rung = rungs.isel(record=column)
        above = figure.add_subplot(grid[0, column], sharex=corner, sharey=figure.axes[0] if column else None)
        _motion(above, rung, first_column=not column)
        corner = corner or above
        for row, model in enumerate(models, start=1):
            shared = figure.axes[1] if len(figure.axes) > 1 else None
            axes = figure.add_subplot(grid[row, column], sharex=corner, sharey=shared)
            _history(axes, rung.sel(damping_model=model), model)
            axes.tick_params(labelleft=not column, labelbottom=row == len(models))
            if not column and row == (len(models) + 1) // 2:
                axes.set_ylabel("$u$ over the largest measured [-]")
            if row == len(models):
                axes.set_xlabel("time $t$ [s]")
    figure.axes[0].set_xlim(*_shown(rungs))
    figure.axes[1].set_ylim(-1.35, 1.35)
    left: list[Axes] = []
    for column, (name, ladder) in enumerate(by_maker.items()):
        for row, quantity in enumerate(("peak", "decrement")):
            axes = figure.add_subplot(grid[len(models) + 1 + row, column], sharey=left[row] if column else None)
            _right(axes, ladder, quantity, models)
            if not column:
                axes.set_ylabel(f"{quantity} over\nmeasured [-]")
                left.append(axes)
            axes.tick_params(labelleft=not column, labelbottom=bool(row))
            if row:
                axes.set_xlabel(f"measured peak {DISPLACEMENT}")
            else:
                axes.set_title(plain("measured" if name == "measured" else f"made by {name}"))
    for axes in left:
        axes.set_ylim(0, 1.75)
    figure.suptitle(fill(plain(f"{heading}; above, those made by {maker}"), 120), fontsize=8)
    _legend(figure, models, measured_name)
    return figure


def _shown(rungs: xr.Dataset) -> tuple[float, float]:
    """First and last time drawn: the motion and the decays. [s]"""
    motion, elapsed = np.abs(rungs["ground_acceleration"].values), rungs["elapsed"].values
    moving = np.nanmax(motion >= SHOWN_FROM * np.nanmax(motion, axis=1, keepdims=True), axis=0)
    start, end = elapsed[np.argmax(moving)], float(rungs["measured_decay_peak_elapsed"].max())
    margin = MARGIN * (end - start)
    return max(float(elapsed[0]), start - margin), min(float(elapsed[-1]), end + margin)


def _motion(axes: Axes, rung: xr.Dataset, *, first_column: bool) -> None:
    axes.plot(rung["elapsed"], rung["ground_acceleration"], color="black", linewidth=0.8)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    peak = float(rung["measured_peak_displacement"] / rung["instability_displacement"])
    axes.set_title(f"peak {peak:.2f} $u_\\mathrm{{ins}}$")
    axes.tick_params(labelleft=first_column, labelbottom=False)
    axes.yaxis.set_major_locator(MaxNLocator(2))
    if first_column:
        axes.set_ylabel("$\\ddot u_g$\n[m s$^{-2}$]")


def _history(axes: Axes, of_model: xr.Dataset, model: str) -> None:
    """One model on one rung, over the largest measured displacement."""
    largest = float(of_model["measured_peak_displacement"])
    axes.plot(of_model["elapsed"], of_model["measured"] / largest, label="measured", zorder=1, **MEASURED)
    axes.plot(of_model["elapsed"], of_model["displacement"] / largest, label=model, zorder=2, **line_of(model))
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    start = float(of_model["free_phase_start"])
    if np.isfinite(start):
        axes.axvline(start, color=GREY, linewidth=0.6, linestyle="dotted", zorder=0)
    fell = bool(of_model["collapsed"])
    said = "collapsed" if fell else f"{float(of_model['peak_ratio_to_measured']):.2f}"
    colour = style_of(model).colour
    axes.text(0.02, 0.96, model, transform=axes.transAxes, va="top", fontsize=7, color=colour, weight="bold")
    axes.text(0.98, 0.04, said, transform=axes.transAxes, ha="right", va="bottom", fontsize=7)


def _right(axes: Axes, ladder: xr.Dataset, quantity: str, models: Sequence[str]) -> None:
    """Draw a quantity of every model over the measured one, against the amplitude of the rungs."""
    axes.axhspan(1 - RIGHT, 1 + RIGHT, color="#E8E8E8", zorder=0, linewidth=0)
    values = off(ladder, quantity)
    for model in models:
        style = {"marker": style_of(model).marker, "markersize": 3.5, **line_of(model)}
        axes.plot(amplitudes(ladder), values.sel(damping_model=model), label=model, **style)
    axes.set_xlim(0, 1)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def _legend(figure: Figure, models: Sequence[str], measured_name: str) -> None:
    handles = [Line2D([], [], label=measured_name, **MEASURED)]
    handles += [
        Line2D([], [], label=title_of(model), marker=style_of(model).marker, markersize=3.5, **line_of(model))
        for model in models
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
