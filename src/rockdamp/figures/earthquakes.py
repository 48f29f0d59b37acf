"""The dampers under earthquakes: their peaks against those under restitution, and the errors of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, StrMethodFormatter
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED_SOURCE, REFERENCE
from rockdamp.figures.style import GREY, PALE, dampers, line_of, marks_of, new_figure, ramp, style_of, styled

SOURCE_NAMES = {
    "polynomial": r"$\xi$ of the polynomials (one $b_1$)",
    "least error": r"$\xi$ of least error",
    "closed form": r"$\xi$ of the closed form",
}
VARIATION_NAMES = {
    "step": "step four times as long",
    "impact": "impact at the end of the step",
    "lower e": "slightly lower $e$",
    "higher e": "slightly higher $e$",
}
VARIATION_MARKS = {"step": "x", "impact": "+", "lower e": "1", "higher e": "2"}
MARGIN = 1.5  # where the panels of peaks end; beyond 1 are the collapses
PEAK_OF_CR = r"peak under CR, $u/u_\mathrm{ins}$ [-]"


def at_source(study: xr.Dataset) -> xr.Dataset:
    """Return what the figures draw: the middle one of the coefficients of restitution, the ratios of least error."""
    return study.isel(restitution=study.sizes["restitution"] // 2).sel(damping_ratio_source=RECOMMENDED_SOURCE)


def pale_to_dark(colour: str) -> LinearSegmentedColormap:
    """Return the shades of a colour, for counts."""
    return LinearSegmentedColormap.from_list(colour, ramp(colour, 3))


def plain_logarithmic(axes: Axes, x: Sequence[float] | None = None, y: Sequence[float] | None = None) -> None:
    """Make the axes that have ticks logarithmic, with those ticks as plain numbers and no others labelled."""
    for ticks, axis, scale in ((x, axes.xaxis, axes.set_xscale), (y, axes.yaxis, axes.set_yscale)):
        if ticks is not None:
            scale("log")
            axis.set_ticks(list(ticks))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())


# --- peak against peak ------------------------------------------------------------------------------------------------


@styled
def fig_earthquakes(earthquakes: xr.Dataset, comparison: xr.Dataset) -> Figure:
    """Draw every damper's peaks against CR's, and at the margins where only one of both collapses."""
    histories = at_source(earthquakes).isel(wall=at_source(comparison)["pooled"].values == 1)
    models = dampers(histories)
    columns = 2 if len(models) <= 4 else 3
    figure = new_figure(20.0 + 160.0 / columns * -(-len(models) // columns))
    panels = _grid(figure, len(models), columns)
    low = float(comparison["band_start"].min()) / 2
    # The shades end at a hundredth of the histories of a panel.
    norm = LogNorm(1, max(histories["peak"].sel(damping_model=REFERENCE).size / 100, 10.0))
    for axes, model in zip(panels, models, strict=True):
        _peaks(axes, histories, model, low, norm)
    for axes in panels[-columns:]:
        axes.set_xlabel(PEAK_OF_CR)
    for axes in panels[::columns]:
        axes.set_ylabel(r"peak with the damper, $u/u_\mathrm{ins}$ [-]")
    _count_bar(figure, panels, norm)
    handles = [
        Line2D([], [], color="black", linewidth=0.8, label="equal peaks"),
        Line2D([], [], color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), label="twice and half"),
        Line2D([], [], color=GREY, linestyle="none", marker="|", markersize=6, label="only the damper collapses"),
        Line2D([], [], color=GREY, linestyle="none", marker="_", markersize=6, label="only CR collapses"),
    ]
    legend_above(figure, histories, handles)
    return figure


def legend_above(figure: Figure, drawn: xr.Dataset, handles: Sequence[Artist], also: str = "", **look: Any) -> None:
    """Put a legend above all panels, headed by e and the source of the damping ratios."""
    title = f"$e = {float(drawn['restitution']):g}$; {SOURCE_NAMES[RECOMMENDED_SOURCE]} at each wall{also}"
    figure.legend(handles=handles, loc="outside upper center", ncols=4, title=title, **look)


def _grid(figure: Figure, count: int, columns: int) -> list[Axes]:
    """Return `count` panels that share their axes, row by row; the lowest of each column has its ticks labelled."""
    grid = figure.subplots(-(-count // columns), columns, sharex=True, sharey=True, squeeze=False)
    panels = grid.ravel().tolist()
    for spare in panels[count:]:
        spare.remove()
    for axes in panels[max(count - columns, 0) : count]:
        axes.tick_params(labelbottom=True)
    return panels[:count]


def _outcomes(histories: xr.Dataset, model: str) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the peaks of CR and of the damper, and which collapse, for histories that have a damping ratio."""
    by = [histories.sel(damping_model=name) for name in (REFERENCE, model)]
    order = by[0]["peak"].dims
    run = (by[1]["collapsed"].transpose(*order).values >= 0).ravel()
    peaks = [each["peak"].transpose(*order).values.ravel()[run] for each in by]
    fell = [each["collapsed"].transpose(*order).values.ravel()[run] == 1 for each in by]
    return peaks[0], peaks[1], fell[0], fell[1]


def _peaks(axes: Axes, histories: xr.Dataset, model: str, low: float, norm: LogNorm) -> None:
    reference, peak, fell, collapsed = _outcomes(histories, model)
    colour, stand = style_of(model).colour, ~fell & ~collapsed
    ends = (np.log10(low), 0.0, np.log10(low), 0.0)
    axes.hexbin(
        np.clip(reference[stand], low, 1),
        np.clip(peak[stand], low, 1),
        gridsize=56,
        extent=ends,
        xscale="log",
        yscale="log",
        mincnt=1,
        norm=norm,
        cmap=pale_to_dark(colour),
        linewidths=0.1,
    )
    for factor, style in ((1.0, "solid"), (2.0, (0, (4, 2))), (0.5, (0, (4, 2)))):
        start, end = max(low, low / factor), min(1.0, 1.0 / factor)
        shade = "black" if factor == 1 else GREY
        axes.plot([start, end], [factor * start, factor * end], color=shade, linestyle=style, linewidth=0.6)
    between = np.sqrt(MARGIN)
    only, missed = ~fell & collapsed, fell & ~collapsed
    marks: dict[str, Any] = {"color": colour, "linestyle": "none", "markersize": 6, "markeredgewidth": 0.4}
    axes.plot(np.clip(reference[only], low, 1), np.full(only.sum(), between), marker="|", **marks)
    axes.plot(np.full(missed.sum(), between), np.clip(peak[missed], low, 1), marker="_", **marks)
    for line in (axes.axhline, axes.axvline):
        line(1.0, color=PALE, linewidth=0.6)
    axes.set(xlim=(low, MARGIN), ylim=(low, MARGIN), aspect="equal")
    plain_logarithmic(axes, [0.01, 0.1, 1], [0.01, 0.1, 1])
    axes.set_title(
        f"{model}\nmissed {missed.sum()} of {fell.sum()} collapses\nadded {only.sum()} in {(~fell).sum()} survivals",
        color=colour,
        fontsize=7,
    )


def _count_bar(figure: Figure, panels: list[Axes], norm: LogNorm) -> None:
    shades = ScalarMappable(norm, pale_to_dark(GREY))  # grey: every panel has its own colour
    bar = figure.colorbar(shades, ax=panels, shrink=0.5, aspect=30, pad=0.01, extend="max")
    bar.set_label("histories in a cell [-]")
    bar.ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    bar.outline.set_linewidth(0.4)


# --- ratios by band ---------------------------------------------------------------------------------------------------


@styled
def fig_earthquakes_ratio(comparison: xr.Dataset) -> Figure:
    """Draw the median ratio to CR's peaks, the error of its logarithm and the misfit over the decay."""
    drawn = at_source(comparison)
    figure = new_figure(92.0)
    ratios, errors, misfits = figure.subplots(1, 3)
    _by_band(ratios, drawn, "median_ratio")
    _by_band(errors, drawn, "log_error")
    _misfits(misfits, drawn)
    plain_logarithmic(ratios, y=[0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.2, 1.4, 1.7, 2])
    limits = _limits(drawn["median_ratio_interval"], (0.85, 1.2))
    ratios.set(ylim=limits, ylabel="median of peak over that of CR [-]")
    errors.set(ylim=(0, None), ylabel="rms of the logarithm of that ratio [-]")
    misfits.set(ylim=(0, None), ylabel="misfit over the decay over CR's peak [-]")
    also = "; 95 % bootstrap intervals; bars: CR itself after a small change"
    legend_above(figure, drawn, _handles(drawn), also)
    return figure


def standing(statistics: xr.Dataset) -> xr.DataArray:
    """Return the share of histories on the pooled walls that survive under CR, at each velocity ratio. [-]"""
    collapsed = statistics["collapse_fraction"].sel(damping_model=REFERENCE)
    return 1 - collapsed.isel(wall=np.flatnonzero(statistics["pooled"].values == 1)).mean("wall")


def _limits(values: xr.DataArray, least: tuple[float, float]) -> tuple[float, float]:
    """Return limits that hold all values and `least`, but no ratio beyond a factor of two."""
    known = values.values[np.isfinite(values.values) & (values.values > 0)]
    low, high = (known.min(), known.max()) if known.size else least
    return max(min(0.98 * low, least[0]), 0.5), min(max(1.02 * high, least[1]), 2.0)


def _by_band(axes: Axes, statistics: xr.Dataset, name: str) -> None:
    """Draw a statistic of every damper in each band beside that of CR after small changes."""
    place = np.arange(statistics.sizes["band"])
    varied = statistics[f"varied_{name}"]
    high = varied.max("variation").values
    low = varied.min("variation").values if name == "median_ratio" else np.zeros_like(high)
    axes.bar(place, high - low, bottom=low, width=0.86, color="#E4E4E4", zorder=0)
    if name == "median_ratio":
        axes.axhline(1.0, color="black", linewidth=0.6, zorder=1)
    for row, variation in enumerate(map(str, statistics["variation"].values)):
        axes.plot(
            place + 0.2 * (row - 1.5),
            varied.sel(variation=variation),
            linestyle="none",
            color=GREY,
            markersize=4,
            marker=VARIATION_MARKS[variation],
            markeredgewidth=0.7,
        )
    models = dampers(statistics)
    for row, model in enumerate(models):
        values = statistics.sel(damping_model=model)
        bounds = values[f"{name}_interval"]
        axes.vlines(
            x := place + 0.18 * (row - (len(models) - 1) / 2),
            bounds.sel(bound="lower"),
            bounds.sel(bound="upper"),
            color=style_of(model).colour,
            linewidth=1.0,
        )
        axes.plot(x, values[name], markersize=3.2, label=model, **marks_of(model))
    axes.axvline(0.5, color=PALE, linewidth=0.6)
    edges = zip(statistics["band_start"].values, statistics["band_end"].values, strict=True)
    axes.set_xticks(place, ["all", *(f"{low:g}–\n{high:g}" for low, high in list(edges)[1:])])
    axes.set_xlim(-0.5, place[-1] + 0.5)
    axes.tick_params(axis="x", length=0)
    axes.set_xlabel(PEAK_OF_CR)


def _misfits(axes: Axes, statistics: xr.Dataset) -> None:
    for model in dampers(statistics):
        misfit, marker = statistics["median_decay_misfit"].sel(damping_model=model), style_of(model).marker
        axes.plot(statistics["velocity_ratio"], misfit, marker=marker, markersize=2.2, label=model, **line_of(model))
    share = axes.twinx()
    share.plot(
        statistics["velocity_ratio"], 100 * standing(statistics), color=GREY, linewidth=0.8, linestyle=(0, (1, 1))
    )
    share.set_ylim(0, 105)
    axes.set_xlim(*statistics["velocity_ratio"].values[[0, -1]])
    share.set_ylabel("histories that survive under CR [%]", color=GREY)
    plain_logarithmic(axes, [0.2, 0.5, 1, 2, 5])
    axes.set_xlabel(r"velocity ratio $\lambda\,\mathrm{PGV}/(p\,u_\mathrm{ins})$ [-]")


def _handles(statistics: xr.Dataset) -> list[Line2D]:
    models = dampers(statistics)
    changed: dict[str, Any] = {"linestyle": "none", "color": GREY, "markersize": 4}
    return [
        *(Line2D([], [], marker=style_of(model).marker, label=model, **line_of(model)) for model in models),
        *(
            Line2D([], [], marker=VARIATION_MARKS[name], label=f"CR, {VARIATION_NAMES[name]}", **changed)
            for name in map(str, statistics["variation"].values)
        ),
        Line2D([], [], color=GREY, linewidth=0.8, linestyle=(0, (1, 1)), label="CR, share that survives"),
    ]
