"""A code's displacement check beside histories, by wall, limit state and confidence factor."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import GREY, PALE, literal, new_figure, styled, with_interval
from rockdamp.text import number, percent, plain, span

MARKERS, COLOURS = ("o", "s", "^", "D"), ("#0072B2", "#D55E00", "#009E73", GREY)
RATIO = "median_demand_ratio"
FIRST, ALONE, MEASURED, ONE = "from the first branch on", "at the secant alone", "measured", "one for all"


@styled
def fig_code_checks(study: xr.Dataset) -> Figure:
    """Draw the median demand over the capacity with its interval, for each wall and for all of them."""
    figure = new_figure(85.0)
    panels = figure.subplots(1, study.sizes["limit_state"], sharey=True)
    for axes, state in zip(panels, study["limit_state"].values.tolist(), strict=True):
        at = study.sel(limit_state=state, period_range=FIRST)
        _demands(axes, at)
        axes.set_title(f"{state}, $u = {float(at['capacity']):g}\\,u_\\mathrm{{ins}}$")
    panels[0].set_yticks(range(study.sizes["wall"]), [literal(str(name)) for name in study["wall"].values])
    panels[0].invert_yaxis()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _demands(axes: Axes, study: xr.Dataset) -> None:
    """Draw a mark and a bar for each wall and confidence factor, and an open mark with one e for all walls."""
    factors = study["confidence_factor"].values.tolist()
    row = np.arange(study.sizes["wall"])
    for place, factor in enumerate(factors):
        y = row + 0.25 * (place - (len(factors) - 1) / 2)
        at = study.sel(confidence_factor=factor)
        of_rule = at[RATIO].sel(restitution_rule=MEASURED).values
        ends = at[f"{RATIO}_interval"].sel(restitution_rule=MEASURED).transpose("bound", ...).values
        axes.errorbar(
            of_rule,
            y,
            xerr=np.abs(ends - of_rule),
            linestyle="none",
            marker=MARKERS[place % len(MARKERS)],
            color=COLOURS[place % len(COLOURS)],
            markersize=4,
            label=f"FC = {factor:g}",
        )
    alike = study.isel(confidence_factor=0).sel(restitution_rule=ONE)
    label = f"FC = {factors[0]:g}, $e = {float(alike['restitution'].max()):g}$"
    axes.plot(alike[RATIO], row, "x", color=COLOURS[0], markersize=4, label=label)
    axes.axvline(1.0, color="black", linewidth=0.6)
    for edge in row[1:]:
        axes.axhline(edge - 0.5, color=PALE, linewidth=0.4)
    axes.set_xscale("log")
    axes.set_xticks([0.5, 0.7, 1.0, 1.4, 2.0], ["0.5", "0.7", "1", "1.4", "2"])
    axes.minorticks_off()
    axes.margins(x=0.05)
    axes.set(xlabel="demand by the check over capacity [-]")


def fig_code_checks_caption(study: xr.Dataset) -> str:
    """Write the caption, HTML."""
    lowest, highest = (study.isel(confidence_factor=index) for index in (0, -1))
    texts = []
    for state in study["limit_state"].values.tolist():
        by_factor = [
            at.sel(limit_state=state, period_range=FIRST, restitution_rule=MEASURED) for at in (lowest, highest)
        ]
        one, other = (at.isel(wall=0) for at in by_factor)
        walls = by_factor[0][RATIO].isel(wall=slice(1, None))
        texts.append(
            f"{state} {with_interval(one, RATIO)} with FC&nbsp;=&nbsp;{plain(one['confidence_factor'])} ({span(walls)}"
            f" by wall; {percent(one['unsafe_share'])} of walls and records pass and reach the capacity) and"
            f" {with_interval(other, RATIO)} with FC&nbsp;=&nbsp;{plain(other['confidence_factor'])}"
        )
    e = plain(study["restitution"].sel(restitution_rule=ONE).max())
    shown = lowest.isel(limit_state=0, wall=0)
    alike = shown.sel(period_range=FIRST, restitution_rule=ONE)[RATIO]
    alone = shown.sel(period_range=ALONE, restitution_rule=MEASURED)[RATIO]
    return f"""
    The Italian code's displacement check for local mechanisms, after a transcription that has not been compared with
    the official gazette, at the intensity at which histories under restitution first reach its capacity. A check
    without error finds a ratio of one there; below one it passes a wall that reaches the capacity. Medians over all
    walls and records, with bootstrap intervals over stations, e by the rule measured: {"; ".join(texts)}. For the first
    limit state and the lower FC, one e for all walls, {e} (crosses), gives {number(alike)}, and the spectrum at the
    secant's period alone, in place of its largest value from the first branch's period on, {number(alone)}.
    """
