"""The dampers under earthquakes: ratios of their peaks to those of CR, and fragility of walls."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import ndtr

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED_SOURCE, VISCOUS_MODELS
from rockdamp.figures.style import (
    PALE,
    RESTITUTION,
    error_bars,
    handles,
    legend,
    log_ticks,
    look,
    panels,
)


def middle_restitution(study: xr.Dataset) -> xr.Dataset:
    """Select the e nearest to the paper's, and the damping ratios of least error."""
    nearest = study.sel(restitution=RESTITUTION, method="nearest")
    return nearest.sel(damping_ratio_source=RECOMMENDED_SOURCE)


# --- ratios of the peaks -----------------------------------------------------------------------


def fig_earthquakes(comparison: xr.Dataset) -> Figure:
    """Draw median ratio and error of the peaks, by band of the peak under CR."""
    study = middle_restitution(comparison)
    e = float(study["restitution"])
    figure, ((ratio, error),) = panels(1, 2, 80.0)
    draw_bands(ratio, study, "median_ratio")
    ratio.axhline(1.0, color="black", linewidth=0.6)
    log_ticks(ratio.yaxis, [0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.2, 1.4])
    limits = study["median_ratio_interval"].sel(damping_model=list(VISCOUS_MODELS))
    low = max(0.98 * float(limits.min()), 0.5)
    high = min(1.02 * float(limits.max()), 2.0)
    ratio.set(ylim=(low, high), title=f"(a) median ratio, $e = {e:g}$")
    ratio.set_ylabel("median of $r$ = peak / peak with CR [-]")
    draw_bands(error, study, "log_error")
    error.set(ylim=(0, None), title=f"(b) error, $e = {e:g}$")
    error.set_ylabel(r"root mean square of $\ln\,r$ [-]")
    legend(figure, handles(ratio))
    return figure


def draw_bands(axes: Axes, study: xr.Dataset, name: str) -> None:
    """Draw a statistic of every damper in each band; grey bars are CR after small changes."""
    place = np.arange(study.sizes["band"])
    variations = study[f"varied_{name}"]
    low = variations.min("variation").values if name == "median_ratio" else 0.0
    height = variations.max("variation").values - low
    label = "CR after small changes"
    axes.bar(place, height, bottom=low, width=0.86, color=PALE, label=label, zorder=0)
    for index, model in enumerate(VISCOUS_MODELS):
        statistic = study.sel(damping_model=model)
        x = place + 0.16 * (index - 2)  # five dampers, centred on the band
        points = look(model, linestyle="none", markersize=3.2, label=model)
        error_bars(axes, x, statistic[name].values, statistic[f"{name}_interval"], **points)
    starts = study["band_start"].values[1:]
    ends = study["band_end"].values[1:]
    bands = [f"{start:g}–\n{end:g}" for start, end in zip(starts, ends, strict=True)]
    axes.set_xticks(place, ["all", *bands])
    axes.tick_params(axis="x", length=0)
    axes.set(xlim=(-0.5, place[-1] + 0.5), xlabel=r"peak under CR, $u/u_\mathrm{ins}$ [-]")
    axes.axvline(0.5, color=PALE, linewidth=0.6)  # between "all" and the bands


# --- fragility ---------------------------------------------------------------------------------


def fig_fragility(comparison: xr.Dataset) -> Figure:
    """Draw the fragility curves of each wall with every damper, and the band and shares of CR."""
    study = middle_restitution(comparison)
    walls = study["wall"].values.tolist()
    columns = min(4, len(walls))
    rows = -(-len(walls) // columns)  # rounded up
    figure, grid = panels(rows, columns, 22.0 + 46.0 * rows, sharex=True, sharey=True)
    for axes, wall in zip(grid.flat, walls, strict=False):
        draw_wall(axes, study.sel(wall=wall))
    for axes in grid.flat[len(walls) :]:
        axes.remove()
    log_ticks(grid[0, 0].xaxis, [0.2, 0.5, 1.0, 2.0, 5.0])
    for axes in grid.flat[max(len(walls) - columns, 0) : len(walls)]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(r"$\lambda\,\mathrm{PGV}/(p\,u_\mathrm{ins})$ [-]")
    for axes in grid[:, 0]:
        axes.set_ylabel("probability of collapse [-]")
    e = float(study["restitution"])
    legend(figure, handles(grid[0, 0]), columns=4, title=f"$e = {e:g}$")
    return figure


def draw_wall(axes: Axes, wall: xr.Dataset) -> None:
    """Draw the fragility curves of one wall."""
    stripes = wall["velocity_ratio"].values
    level = np.geomspace(stripes[0], stripes[-1], 201)
    cr = wall.sel(damping_model="CR")
    medians = cr["wall_median_velocity_ratio_interval"].values
    dispersions = cr["wall_dispersion_interval"].values
    low, high = envelope(level, medians, dispersions)
    label = "CR, confidence band (at least 90 %)"
    axes.fill_between(level, low, high, color=PALE, linewidth=0, label=label)
    for model in (*VISCOUS_MODELS, "CR"):
        curve = wall.sel(damping_model=model)
        log_ratio = np.log(level / float(curve["wall_median_velocity_ratio"]))
        probability = ndtr(log_ratio / float(curve["wall_dispersion"]))
        axes.plot(level, probability, label=model, **look(model, marker=""))
    points = look("CR", linestyle="none", markersize=2.8, markerfacecolor="white")
    axes.plot(stripes, cr["collapse_fraction"], label="CR, share of the records", **points)
    axes.set(title=str(wall["wall"].item()), xlim=level[[0, -1]], ylim=(-0.02, 1.02))


def envelope(intensity: Array, medians: Array, dispersions: Array) -> tuple[Array, Array]:
    """Return lowest and highest probability over the curves with parameters in two intervals.

    `medians` and `dispersions` are the ends of the intervals. Each interval contains 95 % of the
    replicates, so at least nine in ten replicates lie in both. The probability is monotone in the
    median, and in the dispersion at one median, so its extremes are at corners.
    """
    corners = []
    for median in medians:
        for dispersion in dispersions:
            corners.append(ndtr(np.log(intensity / median) / dispersion))
    return np.min(corners, axis=0), np.max(corners, axis=0)
