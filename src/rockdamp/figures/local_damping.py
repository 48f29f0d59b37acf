"""Local damping beside ECD and ECD16: peaks against those under restitution, under pulses and earthquakes."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from rockdamp.figures.style import PALE, by_model, line_of, new_figure, style_of, styled
from rockdamp.text import number, percent, plain

APART = 1.06  # of the marks of two dampers in one band
RATIOS = (0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 2.0)  # labelled


@styled
def fig_local_damping(local_damping: xr.Dataset) -> Figure:
    """Draw the median of each damper's peaks over CR's by band of CR's peak, with one standard deviation."""
    figure = new_figure(80.0)
    panels = figure.subplots(1, local_damping.sizes["loading"], sharex=True, sharey=True, squeeze=False)[0]
    for index, (axes, name) in enumerate(zip(panels, local_damping["loading"].values, strict=True)):
        _panel(axes, local_damping.sel(loading=name))
        axes.set_title(f"({chr(ord('a') + index)}) {name}, $e = {float(local_damping['restitution']):g}$")
    panels[0].set_ylabel("peak over that under CR [-]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _panel(axes: Axes, by_band: xr.Dataset) -> None:
    edges = [*by_band["band_start"].values.tolist(), float(by_band["band_end"][-1])]
    middle = np.sqrt(by_band["band_start"].values * by_band["band_end"].values)
    models = list(map(str, by_band["damping_model"].values))
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for count, model in enumerate(models):
        one = by_band.sel(damping_model=model)
        median, spread = one["band_median_ratio"].values, np.exp(one["band_log_dispersion"].values)
        axes.errorbar(
            middle * APART ** (count - (len(models) - 1) / 2),
            median,
            yerr=(median - median / spread, median * spread - median),
            marker=style_of(model).marker,
            markersize=4,
            linewidth=0.9,
            elinewidth=0.7,
            capsize=2,
            label=model,
            **line_of(model),
        )
    axes.set(xscale="log", yscale="log")
    for axis, ticks in ((axes.xaxis, edges), (axes.yaxis, RATIOS)):
        axis.set_major_locator(FixedLocator(list(ticks)))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axes.set(xlim=(edges[0], edges[-1]), xlabel=r"peak under CR, $u/u_\mathrm{ins}$ [-]")


def fig_local_damping_caption(local_damping: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at = local_damping
    return f"""
    Three dampers that all lose in a half cycle of free decay what an impact with
    e&nbsp;=&nbsp;{plain(at["restitution"])} takes: ECD, ECD of the recommended order, and local damping (LOCAL), which
    programs of discrete elements apply, with α&nbsp;=&nbsp;{number(at["local_damping"])}. Marks are medians by band of
    the peak under restitution, bars one standard deviation of the logarithm. Under earthquakes the root mean square of
    the logarithm of the ratio is {by_model(at["record_log_error"])}; of the collapses under restitution,
    {by_model(at["record_false_safe_rate"], percent)} do not happen with the damper.
    """
