"""The effect of assumptions, a constant e and the supports, and of the solver's step."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterMathtext

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
)


def fig_loss_law(loss_law: xr.Dataset) -> Figure:
    """Draw ratios to a constant e: of the median intensity of collapse by amplitude, and of the peaks by band."""
    study = loss_law.isel(wall=0)  # all
    figure, ((collapse, peaks),) = panels(1, 2, 76.0)
    exponents, amplitudes = study["loss_exponent"].values, study["reference_amplitude"].values
    for index, g in enumerate(exponents):
        curve, x = (
            study.sel(loss_exponent=g),
            amplitudes + 0.006 * (index - (exponents.size - 1) / 2),
        )
        ratio, interval = (
            curve["median_intensity_ratio"].values,
            curve["median_intensity_ratio_interval"],
        )
        error_bars(collapse, x, ratio, interval, **series(index, label=f"(a) $g = {g:g}$"))
    middle = study.isel(loss_exponent=exponents.size // 2)
    edges = np.append(study["band_start"].values, study["band_end"].values[-1])
    for index, amplitude in enumerate(amplitudes):
        curve = middle.sel(reference_amplitude=amplitude)
        x = np.sqrt(edges[:-1] * edges[1:]) * 1.04 ** (index - 1)
        line = series(3 + index, label=rf"(b) $e$ at ${amplitude:g}\,u_\mathrm{{ins}}$")
        error_bars(peaks, x, curve["median_ratio"].values, curve["median_ratio_interval"], **line)
    for axes in (collapse, peaks):
        axes.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)
    log_ticks(peaks.xaxis, edges)
    peaks.set(xlim=edges[[0, -1]], title=f"(b) peaks, $g = {float(middle['loss_exponent']):g}$")
    peaks.set(
        xlabel=r"peak with constant $e$, $u/u_\mathrm{ins}$ [-]",
        ylabel="median ratio of the peaks [-]",
    )
    collapse.set(title=f"(a) collapse, $e = {float(study['restitution']):g}$")
    collapse.set(xlabel=r"amplitude that $e$ belongs to, $u/u_\mathrm{ins}$ [-]")
    collapse.set(ylabel="ratio of the median intensities [-]")
    collapse.margins(x=0.08)
    legend(figure, handles(collapse, peaks))
    return figure


def fig_supports(supports: xr.Dataset) -> Figure:
    """Draw the effect of a flexible floor by its period, and of the other assumptions."""
    figure, ((floor, other),) = panels(1, 2, 96.0, width_ratios=(1, 1.05))
    flexible = np.isfinite(supports["diaphragm_period"].values)
    floors = supports.isel(assumption=flexible).sortby("diaphragm_period")
    others = supports.isel(assumption=~flexible)
    period, row = floors["diaphragm_period"].values, np.arange(others.sizes["assumption"])[::-1]
    floor_ratio, other_ratio = (cases["median_intensity_ratio"] for cases in (floors, others))
    for index, wall in enumerate(map(str, supports["wall"].values[1:])):
        line = series(index, markersize=3, linewidth=0.6)
        floor.plot([0.0, *period], [1.0, *floor_ratio.sel(wall=wall).values], label=wall, **line)
        other.plot(other_ratio.sel(wall=wall), row, **{**line, "linestyle": "none"})
    together: dict[str, Any] = {**POINTS, "label": "all walls, 95 %"}
    line = {**together, "linestyle": "solid", "linewidth": 1.8}
    floor_interval, other_interval = (
        cases["median_intensity_ratio_interval"].sel(wall="all") for cases in (floors, others)
    )
    error_bars(floor, period, floor_ratio.sel(wall="all").values, floor_interval, **line)
    error_bars(
        other,
        other_ratio.sel(wall="all").values,
        row - 0.28,
        other_interval,
        upright=False,
        **together,
    )
    floor.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)
    other.axvline(1.0, color=GREY, linewidth=0.6, zorder=0)
    for between in row[:-1] - 0.6:
        other.axhline(between, color=PALE, linewidth=0.6, zorder=0)
    floor.set(
        title="(a) a flexible floor at the top",
        xlabel="period of the floor [s]",
        xlim=(0, 1.04 * period[-1]),
    )
    floor.set_ylabel("ratio of the median intensities [-]")
    log_ticks(other.xaxis, [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 2.0, 2.4, 2.8])
    other.margins(x=0.05)
    other.set_yticks(row, [fill(name, 22) for name in map(str, others["assumption"].values)])
    other.set(title="(b) other assumptions", xlabel="ratio of the median intensities [-]")
    legend(figure, handles(floor), columns=5)
    return figure


def fig_convergence(convergence: xr.Dataset) -> Figure:
    """Draw the error against the step for each scheme, excitation and damping model, and lines of slope 1 and 2."""
    figure, grid = panels(2, 2, 108.0, COLUMN, sharex=True, sharey=True)
    step = convergence["step"].values
    for row, scheme, words in zip(
        grid, ("newmark", "paper"), ("Newmark", "as printed"), strict=True
    ):
        for axes, excitation in zip(row, ("free", "forced"), strict=True):
            errors = convergence["solver_error"].sel(scheme=scheme, excitation=excitation)
            for model in map(str, errors["damping_model"].values):
                axes.plot(step, errors.sel(damping_model=model), label=model, **look(model))
            for slope, line in ((1, "dashed"), (2, "dotted")):
                guide = (
                    1.6 * float(errors.sel(step=step.max()).max()) * (step / step.max()) ** slope
                )
                axes.plot(
                    step, guide, color=GREY, linewidth=0.8, linestyle=line, label=f"slope {slope}"
                )
            axes.set_title(f"{words}, {excitation}")
        row[0].set_ylabel(r"error of $u/u_\mathrm{ins}$ [-]")
    for axes in grid[-1]:
        axes.set_xlabel(r"step $p\,\Delta t$ [-]")
    log_ticks(grid[0, 0].xaxis, [0.001, 0.005, 0.02])
    log_ticks(grid[0, 0].yaxis, 10.0 ** np.arange(-12, 1))
    grid[0, 0].yaxis.set_major_formatter(LogFormatterMathtext())
    legend(figure, handles(grid[0, 0]), columns=4)
    return figure
