"""The dampers under earthquakes: ratios of their peaks to those under restitution, and fragility of each wall."""

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
    """Return the e nearest to the paper's, and the ratios of least error."""
    return study.sel(restitution=RESTITUTION, method="nearest").sel(
        damping_ratio_source=RECOMMENDED_SOURCE
    )


def fig_earthquakes(comparison: xr.Dataset) -> Figure:
    """Draw the median ratio of the peaks to CR's and the error of its logarithm, by band of the peak."""
    study = middle_restitution(comparison)
    figure, ((ratio, error),) = panels(1, 2, 80.0)
    for axes, name in ((ratio, "median_ratio"), (error, "log_error")):
        _bands(axes, study, name)
    ratio.axhline(1.0, color="black", linewidth=0.6)
    log_ticks(ratio.yaxis, [0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.2, 1.4])
    limits = study["median_ratio_interval"].sel(damping_model=list(VISCOUS_MODELS))
    ratio.set(ylim=(max(0.98 * float(limits.min()), 0.5), min(1.02 * float(limits.max()), 2.0)))
    error.set_ylim(0, None)
    e = float(study["restitution"])
    ratio.set(
        title=f"(a) median ratio, $e = {e:g}$", ylabel="median of $r$, peak over that of CR [-]"
    )
    error.set(title=f"(b) error, $e = {e:g}$", ylabel=r"root mean square of $\ln\,r$ [-]")
    legend(figure, handles(ratio))
    return figure


def _bands(axes: Axes, study: xr.Dataset, name: str) -> None:
    """Draw a statistic of every damper in each band, and its range under CR after small changes as grey bars."""
    place = np.arange(study.sizes["band"])
    changed = study[f"varied_{name}"]
    low = changed.min("variation").values if name == "median_ratio" else 0.0
    height = changed.max("variation").values - low
    axes.bar(
        place, height, bottom=low, width=0.86, color=PALE, label="CR after small changes", zorder=0
    )
    for index, model in enumerate(VISCOUS_MODELS):
        values, x = study.sel(damping_model=model), place + 0.16 * (index - 2)
        points = look(model, linestyle="none", markersize=3.2)
        error_bars(axes, x, values[name].values, values[f"{name}_interval"], label=model, **points)
    edges = zip(study["band_start"].values[1:], study["band_end"].values[1:], strict=True)
    axes.set_xticks(place, ["all", *(f"{low:g}–\n{high:g}" for low, high in edges)])
    axes.tick_params(axis="x", length=0)
    axes.set(xlim=(-0.5, place[-1] + 0.5), xlabel=r"peak under CR, $u/u_\mathrm{ins}$ [-]")
    axes.axvline(0.5, color=PALE, linewidth=0.6)


def envelope(intensity: Array, median: Array, dispersion: Array) -> tuple[Array, Array]:
    """Return lowest and highest probability over the fragility curves with parameters in two intervals.

    Each interval contains 95 % of the replicates, so at least nine in ten replicates lie in both. The probability is
    monotone in the median, and in the dispersion at one median, so its extremes are at corners.
    """
    corners = np.stack([ndtr(np.log(intensity / m) / s) for m in median for s in dispersion])
    return corners.min(axis=0), corners.max(axis=0)


def fig_fragility(comparison: xr.Dataset) -> Figure:
    """Draw the fragility curves of each wall under every damper, with the band and the shares of CR."""
    study = middle_restitution(comparison)
    columns = min(4, study.sizes["wall"])
    rows = -(-study.sizes["wall"] // columns)
    figure, grid = panels(rows, columns, 22.0 + 46.0 * rows, sharex=True, sharey=True)
    level = np.geomspace(float(study["velocity_ratio"][0]), float(study["velocity_ratio"][-1]), 201)
    for axes, wall in zip(grid.flat, study["wall"].values, strict=False):
        curves = study.sel(wall=wall)
        cr = curves.sel(damping_model="CR")
        median, dispersion = (
            cr[f"wall_{name}_interval"].values for name in ("median_velocity_ratio", "dispersion")
        )
        low, high = envelope(level, median, dispersion)
        axes.fill_between(level, low, high, color=PALE, linewidth=0, label="CR, at least 90 % band")
        for model in (*VISCOUS_MODELS, "CR"):
            one_model = curves.sel(damping_model=model)
            depth = np.log(level / float(one_model["wall_median_velocity_ratio"])) / float(
                one_model["wall_dispersion"]
            )
            axes.plot(level, ndtr(depth), label=model, **look(model, marker=""))
        points = look("CR", linestyle="none", markersize=2.8, markerfacecolor="white")
        axes.plot(
            cr["velocity_ratio"],
            cr["collapse_fraction"],
            label="CR, share of the records",
            **points,
        )
        axes.set(title=str(wall), xlim=level[[0, -1]], ylim=(-0.02, 1.02))
    for axes in grid.flat[study.sizes["wall"] :]:
        axes.remove()
    log_ticks(grid[0, 0].xaxis, [0.2, 0.5, 1.0, 2.0, 5.0])
    for axes in grid.flat[max(study.sizes["wall"] - columns, 0) : study.sizes["wall"]]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(r"$\lambda\,\mathrm{PGV}/(p\,u_\mathrm{ins})$ [-]")
    for axes in grid[:, 0]:
        axes.set_ylabel("probability of collapse [-]")
    legend(figure, handles(grid[0, 0]), columns=4, title=f"$e = {float(study['restitution']):g}$")
    return figure
