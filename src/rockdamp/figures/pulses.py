"""The dampers under pulses: rocking spectra of each, and their peaks against those under restitution; local damping."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.figures.earthquakes import at_source, plain_logarithmic
from rockdamp.figures.style import GREY, by_damper, by_model, new_figure, style_of, styled
from rockdamp.text import plain
from rockdamp.vocabulary import REFERENCE

COLLAPSED = "#262626"
PEAKS = LinearSegmentedColormap.from_list("peaks", ["#FFFFFF", "#FBE0AC", "#E0962F", "#8F3D12"])
BORDER = "#00C2D1"  # seen on every shade, and in grey
# u/u_ins that stands for a collapse, so that its contour lies between a wall that stands and one that falls.
BEYOND = 1.6
SMALLEST = 1e-12  # u/u_ins; between the nodes the logarithm is interpolated, since peaks span decades
ONLY_CR, ONLY_DAMPER = "o", "X"  # marks of the pulses that collapse the wall with one of both
MARK: dict[str, Any] = {"linestyle": "none", "color": "white", "markeredgecolor": "black", "markeredgewidth": 0.5}
MARKS = {"Ricker": "o", "sine": "^"}
LIMITS = (0.5, 2.0)  # of the ratio of peaks; what lies beyond is drawn at the edge
NAMES = {"Ricker": "Ricker pulse", "sine": "one cycle of a sine"}


@styled
def fig_pulses(pulses: xr.Dataset) -> Figure:
    """Draw contours of the peak over frequency and load of each pulse, and each damper's peaks over CR's."""
    at_e = at_source(pulses)
    shapes, models = (at_e[name].values for name in ("pulse", "damping_model"))
    figure = new_figure(54.0 * len(shapes) + 78.0)
    grid = figure.add_gridspec(len(shapes) + 1, 1 + len(models), height_ratios=[1.0] * len(shapes) + [0.92])
    _maps(figure, grid, at_e)
    _all_ratios(figure, grid, at_e)
    figure.legend(
        handles=[
            Patch(facecolor=COLLAPSED, label="collapses"),
            Line2D([], [], color=BORDER, linewidth=1.2, label="where CR collapses"),
            Line2D([], [], marker=ONLY_CR, markersize=4, label="only CR collapses", **MARK),
            Line2D([], [], marker=ONLY_DAMPER, markersize=4, label="only the damper collapses", **MARK),
        ],
        loc="outside upper center",
        ncols=4,
        title=f"$e = {float(at_e['restitution']):g}$; damping ratios of least error for a release from "
        f"{float(at_e['release_amplitude']):g} $u_\\mathrm{{ins}}$",
    )
    return figure


# --- rocking spectra -------------------------------------------------------------------------------------------------


def _maps(figure: Figure, grid: GridSpec, at_e: xr.Dataset) -> None:
    """Draw a row of spectra for each pulse, CR first, and the bar of their shades."""
    models = [REFERENCE, *map(str, at_e["damping_model"].values)]
    levels = [0.0, *at_e["band_start"].values, float(at_e["band_end"][-1])]
    panels: list[Axes] = []
    for row, shape in enumerate(map(str, at_e["pulse"].values)):
        for column, model in enumerate(models):
            first = panels[0] if panels else None
            axes = figure.add_subplot(grid[row, column], sharex=first, sharey=first)
            _spectrum(axes, at_e.sel(pulse=shape), model, levels)
            axes.tick_params(labelleft=column == 0, labelbottom=row == at_e.sizes["pulse"] - 1)
            panels.append(axes)
        panels[-len(models)].set_ylabel(f"{NAMES.get(shape, shape)}\nload over plateau [-]")
    for axes, model in zip(panels, models, strict=False):
        ratio = "" if model == REFERENCE else f"\n$\\xi = {float(at_e['damping_ratio'].sel(damping_model=model)):.3f}$"
        axes.set_title(f"{model}{ratio}", color=style_of(model).colour, fontsize=7)
    for axes in panels[-len(models) :]:
        axes.set_xlabel(r"$\omega/p$ [-]")
    _bar(figure, panels, levels)


def _peak(of_pulse: xr.Dataset, model: str) -> tuple[Array, NDArray[np.bool_]]:
    """Return the peaks (load_ratio, pulse_frequency) of a model, `BEYOND` where it collapses, and where it does."""
    if model == REFERENCE:
        peak, collapsed = of_pulse["reference_peak"], of_pulse["reference_collapsed"]
    else:
        peak, collapsed = (of_pulse[name].sel(damping_model=model) for name in ("peak", "collapsed"))
    dims = ("load_ratio", "pulse_frequency")
    fell = collapsed.transpose(*dims).values == 1
    return np.where(fell, BEYOND, peak.transpose(*dims).values), fell


def _spectrum(axes: Axes, of_pulse: xr.Dataset, model: str, levels: list[float]) -> None:
    frequency, load = of_pulse["pulse_frequency"].values, of_pulse["load_ratio"].values
    bounds = np.log([max(level, SMALLEST) for level in levels])
    (peak, fell), (of_cr, cr_fell) = _peak(of_pulse, model), _peak(of_pulse, REFERENCE)
    height, border = (np.log(np.clip(values, 2 * SMALLEST, None)) for values in (peak, of_cr))
    axes.contourf(frequency, load, height, [*bounds, np.log(2 * BEYOND)], colors=[*shades_of(levels), COLLAPSED])
    if border.min() < 0 < border.max():
        axes.contour(frequency, load, border, [0.0], colors=[BORDER], linewidths=1.2)
    for only, marker in ((cr_fell & ~fell, ONLY_CR), (fell & ~cr_fell, ONLY_DAMPER)):
        rows, columns = np.nonzero(only)
        if rows.size:
            axes.plot(frequency[columns], load[rows], marker=marker, markersize=2.8, clip_on=False, **MARK)
    plain_logarithmic(axes, [0.5, 1, 2, 4, 8], [0.5, 1, 2, 4, 8, 16])
    axes.set(xlim=(frequency[0], frequency[-1]), ylim=(load[0], load[-1]))


def shades_of(levels: list[float]) -> list[tuple[float, float, float, float]]:
    """Return the shade of each band of peaks, light to dark."""
    return [PEAKS((i + 0.5) / (len(levels) - 1)) for i in range(len(levels) - 1)]


def _bar(figure: Figure, panels: list[Axes], levels: list[float]) -> None:
    shades = ListedColormap(shades_of(levels))
    bar = figure.colorbar(
        ScalarMappable(BoundaryNorm(levels, shades.N), shades), ax=panels, ticks=levels, pad=0.01, aspect=40
    )
    bar.set_label(r"peak, $u/u_\mathrm{ins}$ [-]")
    bar.ax.set_yticklabels([f"{level:g}" for level in levels])
    bar.outline.set_linewidth(0.4)


# --- peaks against peaks ---------------------------------------------------------------------------------------------


def _all_ratios(figure: Figure, grid: GridSpec, at_e: xr.Dataset) -> None:
    """Draw a panel of ratios below the spectra of each damper, and their legend below those of CR."""
    panels: list[Axes] = []
    row = at_e.sizes["pulse"]
    for column, model in enumerate(map(str, at_e["damping_model"].values), start=1):
        first = panels[0] if panels else None
        axes = figure.add_subplot(grid[row, column], sharex=first, sharey=first)
        _ratios(axes, at_e.sel(damping_model=model), model)
        axes.tick_params(labelleft=first is None)
        panels.append(axes)
    panels[0].set_ylabel("peak over that of CR [-]")
    panels[0].yaxis.label.set_in_layout(False)  # it stands below the spectra of CR, which stay near to the others
    beside = figure.add_subplot(grid[row, 0])
    beside.set_axis_off()
    handles = [
        Line2D([], [], linestyle="none", marker=MARKS.get(shape, "s"), color=GREY, markersize=2.5, label=shape)
        for shape in map(str, at_e["pulse"].values)
    ]
    handles.append(Line2D([], [], marker="D", color="black", markersize=3.5, label="median ±\nlog-dispersion"))
    beside.legend(handles=handles, loc="center left", bbox_to_anchor=(-0.45, 0.5))


def _ratios(axes: Axes, of_model: xr.Dataset, model: str) -> None:
    """Draw the ratio of every two peaks where neither collapses, and the median and dispersion of each band."""
    stands = (of_model["reference_collapsed"] == 0) & (of_model["collapsed"] == 0)
    ratio = (of_model["peak"] / of_model["reference_peak"]).where(stands)
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
        markersize=3,
        linewidth=0.9,
        capsize=1.5,
        zorder=4,
    )
    plain_logarithmic(axes, [0.01, 0.1, 1], [0.5, 0.7, 1.0, 1.4, 2.0])
    axes.set(xlim=(start[0], end[-1]), ylim=LIMITS, xlabel="peak of CR,\n" + r"$u/u_\mathrm{ins}$ [-]")
    axes.set_title(
        f"{float(of_model['median_ratio_all']):.2f} ± {float(of_model['log_dispersion_all']):.2f}\n"
        f"collapses missed\n{int(of_model['false_safe'])} of {int(of_model['reference_collapses'])}\n"
        f"collapses added\n{int(of_model['false_collapse'])} of {int(of_model['reference_survivals'])}",
        color=style.colour,
        fontsize=7,
    )


def fig_pulses_caption(pulses: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at_e = at_source(pulses)
    collapses, survivals = (int(at_e[f"reference_{name}"]) for name in ("collapses", "survivals"))
    medians = by_damper(at_e, lambda at: f"{float(at['median_ratio_all']):.2f} ± {float(at['log_dispersion_all']):.2f}")
    false_safe, false_collapse = (
        by_model(at_e[name], lambda count: str(int(count))) for name in ("false_safe", "false_collapse")
    )
    return f"""
    Under pulses the peak over that under restitution is {medians} (median, ± standard deviation of its logarithm, for
    peaks from {plain(at_e["band_start"][0])}&nbsp;u<sub>ins</sub> on under restitution). Of {collapses} collapses under
    restitution the dampers miss {false_safe}; of {survivals} survivals they turn {false_collapse} into collapses. The
    pulses are a Ricker pulse and one cycle of a sine, at e&nbsp;=&nbsp;{plain(at_e["restitution"])}, with ξ of the
    least error for a release from {plain(at_e["release_amplitude"])}&nbsp;u<sub>ins</sub>.
    """
