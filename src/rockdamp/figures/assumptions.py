"""What assumptions cost: one e at all amplitudes, what holds a wall, and what its equation of motion leaves out."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rockdamp.figures.style import GREY, POINTS, error_bars, handles, legend, log_ticks, panels, series

RATIO = "median_intensity_ratio"
INTENSITY = "median intensity over that assumed [-]"


def fig_loss_law(loss_law: xr.Dataset) -> Figure:
    """Draw the median intensity of collapse by amplitude, and the median of the peaks by band, over those of e."""
    study = loss_law.isel(wall=0)  # all
    figure, ((collapse, peaks),) = panels(1, 2, 82.0)
    exponents, amplitudes = study["loss_exponent"].values, study["reference_amplitude"].values
    for index, g in enumerate(exponents):
        curve, x = study.sel(loss_exponent=g), amplitudes + 0.006 * (index - (exponents.size - 1) / 2)
        error_bars(collapse, x, curve[RATIO].values, curve[f"{RATIO}_interval"], label=f"$g = {g:g}$", **series(index))
    middle = study.isel(loss_exponent=exponents.size // 2)
    edges = np.append(study["band_start"].values, study["band_end"].values[-1])
    for index, amplitude in enumerate(amplitudes):
        curve = middle.sel(reference_amplitude=amplitude)
        x = np.sqrt(edges[:-1] * edges[1:]) * 1.04 ** (index - 1)
        line = series(3 + index, label=rf"$e$ at ${amplitude:g}\,u_\mathrm{{ins}}$")
        error_bars(peaks, x, curve["median_ratio"].values, curve["median_ratio_interval"], **line)
    for axes in (collapse, peaks):
        axes.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)
    log_ticks(peaks.xaxis, edges)
    peaks.set(xlim=edges[[0, -1]], title=f"(b) peaks, $g = {float(middle['loss_exponent']):g}$")
    peaks.set(
        xlabel=r"peak with constant $e$, $u/u_\mathrm{ins}$ [-]", ylabel="median peak over that of constant $e$ [-]"
    )
    collapse.set(title=f"(a) collapse, $e = {float(study['restitution']):g}$", ylabel=INTENSITY)
    collapse.set_xlabel(r"amplitude that $e$ belongs to, $u/u_\mathrm{ins}$ [-]")
    collapse.margins(x=0.08)
    legend(figure, handles(collapse, peaks))
    return figure


def fig_supports(supports: xr.Dataset) -> Figure:
    """Draw the effect of a flexible floor by its period, and that of each other assumption."""
    figure, ((floor, other),) = panels(1, 2, 100.0, width_ratios=(1, 1.05))
    flexible = np.isfinite(supports["diaphragm_period"].values)
    floors = supports.isel(assumption=flexible).sortby("diaphragm_period")
    others = supports.isel(assumption=~flexible)
    period, row = floors["diaphragm_period"].values, np.arange(others.sizes["assumption"])[::-1]
    for index, wall in enumerate(map(str, supports["wall"].values[1:])):
        line = series(index, markersize=3, linewidth=0.6)
        floor.plot([0.0, *period], [1.0, *floors[RATIO].sel(wall=wall).values], label=wall, **line)
        other.plot(others[RATIO].sel(wall=wall), row, **{**line, "linestyle": "none"})
    together: dict[str, Any] = {**POINTS, "label": "all, with 95 % intervals"}
    ratio, interval = (floors[name].sel(wall="all") for name in (RATIO, f"{RATIO}_interval"))
    error_bars(floor, period, ratio.values, interval, **{**together, "linestyle": "solid", "linewidth": 1.8})
    ratio, interval = (others[name].sel(wall="all") for name in (RATIO, f"{RATIO}_interval"))
    error_bars(other, ratio.values, row - 0.28, interval, upright=False, **together)
    floor.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)
    other.axvline(1.0, color=GREY, linewidth=0.6, zorder=0)
    floor.set(title="(a) a flexible floor at the top", xlabel="period of the floor [s]", ylabel=INTENSITY)
    floor.set_xlim(0, 1.04 * period[-1])
    log_ticks(other.xaxis, [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 2.0, 2.4, 2.8])
    other.margins(x=0.05)
    other.set_yticks(row, [fill(name, 22) for name in map(str, others["assumption"].values)])
    other.set(title="(b) other assumptions", xlabel=INTENSITY)
    legend(figure, handles(floor), columns=5)
    return figure
