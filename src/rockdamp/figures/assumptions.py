"""Effects of the assumptions, a constant e and rigid supports, and of the solver's step."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterMathtext

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    COLUMN,
    GREY,
    PALE,
    POINTS,
    error_bars,
    handles,
    legend,
    log_ticks,
    look,
    panels,
    series,
    unit_line,
)

MEDIANS = "ratio of the median intensities [-]"
ALL_WALLS: dict[str, Any] = {**POINTS, "label": "all walls, 95 % interval"}

# The assumptions whose names in ``supports.nc`` are too short to read alone.
ASSUMPTIONS = {
    "own inertia": "bodies' own rotational inertia",
    "e of Eq. (7)": "e = Eq. (7), not 0.90 times it",
    "e impulsive": "e by the rule impulsive",
    "vertical shaking": "vertical ground motion",
    "eccentric overburden, fixed side": "overburden always eccentric to the same side",
}


def describe_assumption(name: str) -> str:
    """Return an assumption in words: ``flexible floor with a period of 0.3 s``."""
    words = ASSUMPTIONS.get(name, name)
    return words.replace("floor of", "flexible floor with a period of")


# --- a loss that depends on the amplitude ------------------------------------------------------


def fig_loss_law(loss_law: xr.Dataset) -> Figure:
    """Draw the median intensity of collapse and the peaks, divided by those with a constant e."""
    study = loss_law.isel(wall=0)  # all walls together
    figure, ((collapse, peaks),) = panels(1, 2, 76.0)
    draw_collapse(collapse, study)
    draw_peaks(peaks, study.isel(loss_exponent=study.sizes["loss_exponent"] // 2))
    legend(figure, handles(collapse, peaks))
    return figure


def draw_collapse(axes: Axes, study: xr.Dataset) -> None:
    """Draw the ratio of the median intensities against the amplitude of the measured e."""
    amplitudes = study["reference_amplitude"].values
    exponents = study["loss_exponent"].values
    for index, g in enumerate(exponents):
        curve = study.sel(loss_exponent=g)
        ratio = curve["median_intensity_ratio"].values
        interval = curve["median_intensity_ratio_interval"]
        # Side by side, so that no interval covers another.
        x = amplitudes + 0.006 * (index - (exponents.size - 1) / 2)
        error_bars(axes, x, ratio, interval, **series(index, label=f"(a) $g = {g:g}$"))
    unit_line(axes)
    axes.set(title=f"(a) collapse, $e = {float(study['restitution']):g}$", ylabel=MEDIANS)
    axes.set_xlabel(r"amplitude at which $e$ was measured, $u/u_\mathrm{ins}$ [-]")
    axes.margins(x=0.08)


def draw_peaks(axes: Axes, study: xr.Dataset) -> None:
    """Draw the median ratio of the peaks by band of the peak."""
    edges = np.append(study["band_start"].values, study["band_end"].values[-1])
    centres = np.sqrt(edges[:-1] * edges[1:])
    for index, amplitude in enumerate(study["reference_amplitude"].values):
        curve = study.sel(reference_amplitude=amplitude)
        label = rf"(b) $e$ at ${amplitude:g}\,u_\mathrm{{ins}}$"
        x = centres * 1.04 ** (index - 1)
        line = series(3 + index, label=label)
        error_bars(axes, x, curve["median_ratio"].values, curve["median_ratio_interval"], **line)
    unit_line(axes)
    log_ticks(axes.xaxis, edges)
    axes.set(xlim=edges[[0, -1]], title=f"(b) peaks, $g = {float(study['loss_exponent']):g}$")
    axes.set_xlabel(r"peak with constant $e$, $u/u_\mathrm{ins}$ [-]")
    axes.set_ylabel("median ratio of the peaks [-]")


# --- supports ----------------------------------------------------------------------------------


def fig_supports(supports: xr.Dataset) -> Figure:
    """Draw the effect of a flexible floor by its period, and of the other assumptions."""
    figure, ((floor, assumptions),) = panels(1, 2, 96.0, width_ratios=(1, 1.05))
    is_floor = np.isfinite(supports["diaphragm_period"].values)
    draw_floors(floor, supports.isel(assumption=is_floor).sortby("diaphragm_period"))
    draw_assumptions(assumptions, supports.isel(assumption=~is_floor))
    legend(figure, handles(floor), columns=5)
    return figure


def wall_series(study: xr.Dataset) -> list[tuple[xr.DataArray, dict[str, Any]]]:
    """Return the ratios of each wall, with its look."""
    curves = []
    for index, wall in enumerate(study["wall"].values[1:].tolist()):  # the first is "all"
        line = series(index, markersize=3, linewidth=0.6, label=wall)
        curves.append((study["median_intensity_ratio"].sel(wall=wall), line))
    return curves


def draw_floors(axes: Axes, floors: xr.Dataset) -> None:
    """Draw the ratios of the median intensities against the period of the floor, 0 if rigid."""
    period = floors["diaphragm_period"].values
    for ratio, line in wall_series(floors):
        axes.plot([0.0, *period], [1.0, *ratio.values], **line)
    all_walls = floors.sel(wall="all")
    common_ratio = all_walls["median_intensity_ratio"].values
    line = {**ALL_WALLS, "linestyle": "solid", "linewidth": 1.8}
    error_bars(axes, period, common_ratio, all_walls["median_intensity_ratio_interval"], **line)
    unit_line(axes)
    axes.set(title="(a) a flexible floor at the top", xlabel="period of the floor [s]")
    axes.set(xlim=(0, 1.04 * period[-1]), ylabel=MEDIANS)


def draw_assumptions(axes: Axes, study: xr.Dataset) -> None:
    """Draw the ratios of the median intensities, a row for each assumption."""
    row = np.arange(study.sizes["assumption"])[::-1]
    for ratio, line in wall_series(study):
        axes.plot(ratio, row, **{**line, "linestyle": "none"})
    all_walls = study.sel(wall="all")
    common_ratio = all_walls["median_intensity_ratio"].values
    interval = all_walls["median_intensity_ratio_interval"]
    error_bars(axes, common_ratio, row - 0.28, interval, upright=False, **ALL_WALLS)
    axes.axvline(1.0, color=GREY, linewidth=0.6, zorder=0)
    for border in row[:-1] - 0.6:
        axes.axhline(border, color=PALE, linewidth=0.6, zorder=0)
    log_ticks(axes.xaxis, [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 2.0, 2.4, 2.8])
    axes.margins(x=0.05)
    names = [describe_assumption(name) for name in study["assumption"].values.tolist()]
    axes.set_yticks(row, [fill(name, 22) for name in names])
    axes.set(title="(b) other assumptions", xlabel=MEDIANS)


# --- convergence -------------------------------------------------------------------------------


def fig_convergence(convergence: xr.Dataset) -> Figure:
    """Draw the error against the step for each scheme, excitation and model, with slopes."""
    figure, grid = panels(2, 2, 108.0, COLUMN, sharex=True, sharey=True)
    schemes = {"newmark": "default scheme", "paper": "scheme of the paper"}
    excitations = {"free": "free decay", "forced": "under a load"}
    for row, (scheme, words) in zip(grid, schemes.items(), strict=True):
        for axes, excitation in zip(row, excitations, strict=True):
            errors = convergence["solver_error"].sel(scheme=scheme, excitation=excitation)
            draw_convergence(axes, errors)
            axes.set_title(f"{words},\n{excitations[excitation]}")
        row[0].set_ylabel(r"error of $u/u_\mathrm{ins}$ [-]")
    for axes in grid[-1]:
        axes.set_xlabel(r"step $p\,\Delta t$ [-]")
    log_ticks(grid[0, 0].xaxis, [0.001, 0.005, 0.02])
    log_ticks(grid[0, 0].yaxis, 10.0 ** np.arange(-12, 1))
    grid[0, 0].yaxis.set_major_formatter(LogFormatterMathtext())
    legend(figure, handles(grid[0, 0]), columns=4)
    return figure


def draw_convergence(axes: Axes, errors: xr.DataArray) -> None:
    """Draw the errors of each model against the step, and lines of slope 1 and 2."""
    step: Array = errors["step"].values
    for model in errors["damping_model"].values.tolist():
        axes.plot(step, errors.sel(damping_model=model), label=model, **look(model))
    largest = float(errors.sel(step=step.max()).max())
    for slope, linestyle in ((1, "dashed"), (2, "dotted")):
        # 1.6 keeps the line above the curves.
        guide = 1.6 * largest * (step / step.max()) ** slope
        line: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "linestyle": linestyle}
        axes.plot(step, guide, label=f"slope {slope}", **line)
