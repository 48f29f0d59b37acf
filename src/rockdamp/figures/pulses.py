"""The dampers beyond free decay: peaks under pulses against those under a coefficient of restitution."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter, ScalarFormatter

from rockdamp.figures.style import DOUBLE_COLUMN, GREY, columns_of, new_figure, style_of, styled, title_of

COLLAPSED = "#3A3A3A"
PEAKS = LinearSegmentedColormap.from_list("peaks", ["#FFFFFF", "#FDE3B0", "#D98B2B", "#7A2E0E"])
MARKS = {"Ricker": "o", "sine": "^"}
LIMITS = (0.5, 2.0)  # of the ratio of peaks; what lies beyond is drawn at the edge
SIZES = {"CDC": 6.5, "CDR": 4.5, "SDR": 5.0, "ECD": 2.0}  # on the map, where they coincide
NAMES = {"Ricker": "Ricker pulse", "sine": "one cycle of a sine"}


@styled
def fig_pulses(pulses: xr.Dataset) -> Figure:
    """Draw CR's peaks over frequency and load of each pulse, and each model's peak over CR's against CR's.

    Parameters
    ----------
    pulses : xarray.Dataset
        As `rockdamp.studies.pulses.pulses` returns it; drawn at the middle e, with damping ratios from the closed form.
    """
    e = pulses["restitution"].values
    at_e = pulses.isel(restitution=e.size // 2, damping_ratio_source=0)
    shapes, models = ([str(value) for value in at_e[name].values] for name in ("pulse", "damping_model"))
    columns = columns_of(len(models), 5)
    rows = -(-len(models) // columns)
    figure = new_figure(DOUBLE_COLUMN, 78.0 + 62.0 * rows)
    grid = figure.add_gridspec(1 + rows, len(shapes) * columns, height_ratios=[1.1] + [1.0] * rows)
    first: Axes | None = None
    for column, shape in enumerate(shapes):
        axes = figure.add_subplot(grid[0, columns * column : columns * (column + 1)], sharey=first)
        _map(axes, at_e.sel(pulse=shape), shape, last=column == len(shapes) - 1)
        if first is None:
            axes.set_ylabel("load over plateau [-]")
            first = axes
        else:
            axes.tick_params(labelleft=False)
    first = None
    for position, model in enumerate(models):
        row, column = divmod(position, columns)
        place = grid[1 + row, len(shapes) * column : len(shapes) * (column + 1)]
        axes = figure.add_subplot(place, sharex=first, sharey=first)
        _ratios(axes, at_e.sel(damping_model=model), model)
        first = first or axes
        axes.tick_params(labelleft=column == 0)
        if column == 0:
            axes.set_ylabel("peak over that of CR [-]")
    _legend(figure, shapes, models, float(at_e["restitution"]), float(at_e["release_amplitude"]))
    return figure


def _map(axes: Axes, of_pulse: xr.Dataset, shape: str, last: bool) -> None:
    """A rocking spectrum: CR's peak as shade over frequency and load, collapse dark."""
    frequency, load = of_pulse["pulse_frequency"].values, of_pulse["load_ratio"].values
    peak = (
        of_pulse["reference_peak"]
        .where(of_pulse["reference_collapsed"] == 0)
        .transpose("load_ratio", "pulse_frequency")
    )
    edges = [0.0, *of_pulse["band_start"].values, float(of_pulse["band_end"][-1])]
    axes.set_facecolor(COLLAPSED)
    mesh = axes.pcolormesh(frequency, load, peak, cmap=PEAKS, norm=BoundaryNorm(edges, PEAKS.N), shading="nearest")
    fell = (of_pulse["reference_collapsed"] == 1).transpose("load_ratio", "pulse_frequency").values
    # Cells whose verdict a damper reverses: CR collapses and it does not, or the other way round.
    for model in map(str, of_pulse["damping_model"].values):
        damper_fell = (
            (of_pulse["collapsed"].sel(damping_model=model) == 1).transpose("load_ratio", "pulse_frequency").values
        )
        rows, columns = np.nonzero(damper_fell != fell)
        style = style_of(model)
        axes.plot(
            frequency[columns],
            load[rows],
            linestyle="none",
            marker=style.marker,
            color=style.colour,
            markersize=SIZES.get(model, 3.0),
            markerfacecolor="none",
            markeredgewidth=0.8,
        )
    for scale in (axes.set_xscale, axes.set_yscale):
        scale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
    axes.set_xticks([0.5, 1, 2, 4, 8])
    axes.set_yticks([0.5, 1, 2, 4, 8, 16])
    axes.set_title(NAMES.get(shape, shape))
    axes.set_xlabel("pulse frequency $\\omega/p$ [-]")
    if last:
        bar = axes.figure.colorbar(mesh, ax=axes, ticks=edges)
        bar.set_label(r"peak of CR, $u/u_\mathrm{ins}$ [-]")
        bar.ax.set_yticklabels([f"{edge:g}" for edge in edges])
        bar.outline.set_linewidth(0.4)


def _ratios(axes: Axes, of_model: xr.Dataset, model: str) -> None:
    """Every pair of peaks where neither collapses, and the median and dispersion of each band."""
    stands = (of_model["reference_collapsed"] == 0) & (of_model["collapsed"] == 0)
    ratio = (of_model["peak_ratio"] / of_model["reference_peak"]).where(stands)
    style = style_of(model)
    for shape in map(str, of_model["pulse"].values):
        x, y = of_model["reference_peak"].sel(pulse=shape).values.ravel(), ratio.sel(pulse=shape).values.ravel()
        marks = MARKS.get(shape, "s")
        axes.plot(x, np.clip(y, *LIMITS), marks, color=style.colour, markersize=1.6, alpha=0.35, markeredgewidth=0)
    axes.axhline(1, color="black", linewidth=0.6)
    start, end = of_model["band_start"].values, of_model["band_end"].values
    centre, median = np.sqrt(start * end), of_model["median_ratio"].values
    factor = np.exp(of_model["log_dispersion"].values)
    axes.errorbar(
        centre,
        median,
        yerr=[median - median / factor, median * factor - median],
        fmt="D",
        color="black",
        markersize=3.5,
        linewidth=0.9,
        capsize=2,
        zorder=4,
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(start[0], end[-1])
    axes.set_ylim(*LIMITS)
    axes.set_yticks([0.5, 0.7, 1.0, 1.4, 2.0])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
    axes.set_xticks([0.01, 0.1, 1])
    axes.set_xlabel(r"peak of CR, $u/u_\mathrm{ins}$ [-]")
    axes.set_title(
        f"{title_of(model, lines=2)}\n$\\xi = {float(of_model['damping_ratio']):.3f}$\n"
        f"all: {float(of_model['median_ratio_all']):.2f} ± {float(of_model['log_dispersion_all']):.2f}\n"
        f"false safe {int(of_model['false_safe'])} of {int(of_model['reference_collapses'])}\n"
        f"false collapse {int(of_model['false_collapse'])} of {int(of_model['reference_survivals'])}",
        color=style.colour,
        fontsize=7,
    )


def _legend(figure: Figure, shapes: list[str], models: list[str], e: float, amplitude: float) -> None:
    handles: list[Line2D | Patch] = [Patch(facecolor=COLLAPSED, label="CR collapses")]
    handles += [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=style_of(model).marker,
            color=style_of(model).colour,
            markerfacecolor="none",
            label=f"{model} judges otherwise",
        )
        for model in models
    ]
    handles += [
        Line2D([], [], linestyle="none", marker=MARKS.get(shape, "s"), color=GREY, markersize=2.5, label=shape)
        for shape in shapes
    ]
    handles.append(Line2D([], [], marker="D", color="black", markersize=3.5, label="median ± log-dispersion"))
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=4,
        title=f"$e = {e:g}$; damping ratios from the closed form at {amplitude:g} $u_\\mathrm{{ins}}$",
    )
