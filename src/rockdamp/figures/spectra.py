"""Rocking spectra: peaks over the frequency and the acceleration of a pulse, with restitution and with each damper."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rockdamp.figures.natural import plain_logarithmic
from rockdamp.figures.pulses import COLLAPSED, NAMES, PEAKS
from rockdamp.figures.style import DOUBLE_COLUMN, new_figure, style_of, styled
from rockdamp.vocabulary import REFERENCE

BEYOND = (
    1.6  # u/u_ins that stands for a collapse, so that its contour lies between a wall that stands and one that falls
)
BORDER = "#00C2D1"  # seen on every shade, and in grey


@styled
def fig_spectra(pulses: xr.Dataset) -> Figure:
    """Draw contours of the peak over frequency and load of each pulse, for CR and each damper.

    Parameters
    ----------
    pulses : xarray.Dataset
        As `rockdamp.studies.pulses.pulses` returns it; drawn at the middle e, with damping ratios from the closed form.
    """
    at_e = pulses.isel(restitution=pulses.sizes["restitution"] // 2, damping_ratio_source=0)
    models = [REFERENCE, *map(str, at_e["damping_model"].values)]
    shapes = [str(shape) for shape in at_e["pulse"].values]
    levels = [0.0, *at_e["band_start"].values, float(at_e["band_end"][-1])]
    figure = new_figure(DOUBLE_COLUMN, 130.0)
    grid = figure.subplots(len(shapes), len(models), sharex=True, sharey=True, squeeze=False)
    for row, shape in zip(grid, shapes, strict=True):
        for axes, model in zip(row, models, strict=True):
            _spectrum(axes, at_e.sel(pulse=shape), model, levels)
        row[0].set_ylabel(f"{NAMES.get(shape, shape)}\nload over plateau [-]")
    fontsize = None if len(models) <= 5 else 7
    frequency = r"frequency $\omega/p$ [-]" if len(models) <= 6 else r"$\omega/p$ [-]"  # panels get narrow
    for axes, model in zip(grid[0], models, strict=True):
        ratio = "" if model == REFERENCE else f"\n$\\xi = {float(at_e['damping_ratio'].sel(damping_model=model)):.3f}$"
        axes.set_title(f"{model}{ratio}", color=style_of(model).colour, fontsize=fontsize)
    for axes in grid[-1]:
        axes.set_xlabel(frequency)
    _bar(figure, grid.ravel().tolist(), levels)
    figure.legend(
        handles=[
            Patch(facecolor=COLLAPSED, label="overturns"),
            Line2D([], [], color=BORDER, linewidth=1.2, label="where CR overturns"),
        ],
        loc="outside upper center",
        ncols=2,
        title=f"$e = {float(at_e['restitution']):g}$; damping ratios from the closed form at "
        f"{float(at_e['release_amplitude']):g} $u_\\mathrm{{ins}}$",
    )
    return figure


def _peak(of_pulse: xr.Dataset, model: str) -> xr.DataArray:
    """Peaks (load_ratio, pulse_frequency) of a model; of what overturns, the same value beyond 1."""
    if model == REFERENCE:
        peak, fell = of_pulse["reference_peak"], of_pulse["reference_collapsed"]
    else:
        peak, fell = (of_pulse[name].sel(damping_model=model) for name in ("peak_ratio", "collapsed"))
    return xr.where(fell == 1, BEYOND, peak).transpose("load_ratio", "pulse_frequency")


def _spectrum(axes: Axes, of_pulse: xr.Dataset, model: str, levels: list[float]) -> None:
    frequency, load = of_pulse["pulse_frequency"].values, of_pulse["load_ratio"].values
    colours = PEAKS([(i + 0.5) / (len(levels) - 1) for i in range(len(levels) - 1)])
    # Between the nodes the logarithm is interpolated, since peaks span decades.
    bounds = np.log([max(level, 1e-9) for level in levels])
    height = np.log(np.clip(_peak(of_pulse, model).values, 2e-9, None))
    axes.contourf(frequency, load, height, [*bounds, np.log(2 * BEYOND)], colors=[*colours, COLLAPSED])
    border = np.log(np.clip(_peak(of_pulse, REFERENCE).values, 2e-9, None))
    if border.min() < 0 < border.max():
        axes.contour(frequency, load, border, [0.0], colors=[BORDER], linewidths=1.2)
    plain_logarithmic(axes, [0.5, 1, 2, 4, 8], [0.5, 1, 2, 4, 8, 16])
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_ylim(load[0], load[-1])


def _bar(figure: Figure, panels: list[Axes], levels: list[float]) -> None:
    shades = ScalarMappable(BoundaryNorm(levels, PEAKS.N), PEAKS)
    bar = figure.colorbar(shades, ax=panels, ticks=levels, pad=0.01, aspect=40, spacing="uniform")
    bar.set_label(r"peak, $u/u_\mathrm{ins}$ [-]")
    bar.ax.set_yticklabels([f"{level:g}" for level in levels])
    bar.outline.set_linewidth(0.4)
