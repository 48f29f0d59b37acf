"""What codes ask beside histories: a displacement check, an elastic spectrum, and a damping ratio for a restitution."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    GREY,
    PALE,
    REFERENCE_AMPLITUDE,
    REFERENCE_RESTITUTION,
    RESTITUTION,
    SINGLE_COLUMN,
    by_model,
    line_of,
    literal,
    new_figure,
    present,
    ramp,
    styled,
    with_interval,
)
from rockdamp.mechanics.damping.ecd import damping_ratio, log_decrement
from rockdamp.text import by_name, listed, number, percent, plain, span
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER

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
    _beside_one(axes, row.size, [0.5, 0.7, 1.0, 1.4, 2.0])
    axes.margins(x=0.05)
    axes.set(xlabel="demand by the check over capacity [-]")


def _beside_one(axes: Axes, walls: int, ticks: list[float]) -> None:
    """Draw a line at a ratio of 1 and one between each two walls, on a logarithmic axis."""
    axes.axvline(1.0, color="black", linewidth=0.6)
    for edge in range(1, walls):
        axes.axhline(edge - 0.5, color=PALE, linewidth=0.4)
    axes.set_xscale("log")
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()


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
    without error finds a demand over capacity of one there; below one it passes a wall that reaches the capacity.
    Medians over all walls and records, with bootstrap intervals over stations, e by the rule measured:
    {"; ".join(texts)}. For the first limit state and the lower FC, one e for all walls, {e} (crosses), gives
    {number(alike)}, and the spectrum at the secant's period alone, in place of its largest value from the first
    branch's period on, {number(alone)}.
    """


# --- an elastic spectrum at the secant period -------------------------------------------------------------------------

CAPACITY = 0.4  # that of the check, shown by e
QUANTILES = (0.16, 0.84)  # of the records, which a bar spans
DAMPING_COLOURS = {"5 %": "#0072B2", "equivalent": "#D55E00"}
LINES = {"ground": "solid", "storey": (0, (4.0, 2.0))}
TITLES = {"ground": "on the ground"}


@styled
def fig_spectrum_method(study: xr.Dataset) -> Figure:
    """Draw the demand over the capacity for each wall, and the share of unsafe answers against e."""
    figure = new_figure(100.0)
    left, middle, right = figure.subplots(1, 3, width_ratios=[1.2, 1.2, 1.0])
    middle.sharey(left)
    at_e = study.sel(spectrum_damping="5 %").sel(restitution=REFERENCE_RESTITUTION, method="nearest")
    for axes, support in zip((left, middle), study["support"].values, strict=True):
        _spectral_demands(axes, at_e.sel(support=support))
        axes.set_title(_place(study, str(support)))
    left.set_yticks(range(study.sizes["wall"]), [literal(str(name)) for name in study["wall"].values])
    left.invert_yaxis()
    middle.tick_params(labelleft=False)
    _shares(right, study.sel(capacity=CAPACITY, method="nearest"))
    handles, labels = left.get_legend_handles_labels()
    others = right.get_legend_handles_labels()
    figure.legend(handles + others[0], labels + others[1], loc="outside upper center", ncols=4)
    return figure


def _place(study: xr.Dataset, support: str) -> str:
    return TITLES.get(support, f"storey {int(study['storey'])} of {int(study['storeys'])}")


def _spectral_demands(axes: Axes, study: xr.Dataset) -> None:
    """Draw median and quantiles over the records for each wall, side by side for each capacity."""
    capacities = study["capacity"].values.tolist()
    for place, (capacity, colour) in enumerate(zip(capacities, ramp(GREY, len(capacities)), strict=True)):
        at = study.sel(capacity=capacity)
        low, high = (at["demand_ratio"].quantile(share, "record").values for share in QUANTILES)
        y = [row + 0.25 * (place - (len(capacities) - 1) / 2) for row in range(study.sizes["wall"])]
        axes.hlines(y, low, high, color=colour, linewidth=1.2)
        label = f"$u = {capacity:g}\\,u_\\mathrm{{ins}}$"
        axes.plot(
            at["bias"],
            y,
            linestyle="none",
            marker=MARKERS[place % len(MARKERS)],
            color=colour,
            markersize=4,
            label=label,
        )
    _beside_one(axes, study.sizes["wall"], [0.5, 1.0, 2.0, 5.0])
    axes.set(xlim=(0.3, 10.0), xlabel="demand by spectrum\nover capacity [-]")


def _shares(axes: Axes, study: xr.Dataset) -> None:
    """Draw the share of all walls and records that pass and fail, against e, for each method and support."""
    for method in map(str, study["spectrum_damping"].values):
        for support in map(str, study["support"].values):
            at = study["overall_unsafe_share"].sel(spectrum_damping=method, support=support)
            kind = "5 %" if method == "5 %" else r"$\xi(e)$"
            line: dict[str, Any] = {"color": DAMPING_COLOURS[method], "linestyle": LINES[support]}
            axes.plot(at["restitution"], 100 * at, marker=".", label=f"{kind}, {_place(study, support)}", **line)
    axes.set_ylim(bottom=0)
    axes.set_xticks(study["restitution"].values)
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel("walls that pass and fail [%]")
    axes.set_title(f"$u = {float(study['capacity']):g}\\,u_\\mathrm{{ins}}$")


def fig_spectrum_method_caption(study: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at = study.sel(capacity=CAPACITY, restitution=REFERENCE_RESTITUTION, method="nearest").sel(spectrum_damping="5 %")
    ground, storey = (at.sel(support=support) for support in ("ground", "storey"))
    bars = " to ".join(percent(share) for share in QUANTILES)
    return f"""
    At e&nbsp;=&nbsp;{plain(at["restitution"])} and the least intensity at which a wall reaches the capacity,
    {plain(at["capacity"])}&nbsp;u<sub>ins</sub>, the elastic spectrum with {percent(at["damping_ratio"], 1)} of
    damping passes {percent(ground["overall_unsafe_share"])} of the walls and records on the ground, and
    {percent(storey["overall_unsafe_share"])} on the storey. The demand must be multiplied by
    {number(ground["overall_unsafe_factor"])} and {number(storey["overall_unsafe_factor"])} for one in twenty to pass.
    Bars span {bars} of the records. The building has a period of
    {plain(at["building_period"])}&nbsp;s.
    """


# --- which damping ratio stands for which restitution -----------------------------------------------------------------

LEVELS = (0.02, 0.03, 0.05, 0.10)  # [-] that analysts use
ORDERS = {"ECD": 0.0, RECOMMENDED: float(RECOMMENDED_ORDER)}
SECANT_AMPLITUDES = (0.1, 0.3, 0.7)  # u/u_ins
# Lowest, mean and highest e of shaking-table tests of single-leaf and cavity walls (Graziotti et al., as section 4.1 of
# the paper quotes them; second-hand).
TESTED = (0.84, 0.852, 0.90)


def ratio_of(match: xr.Dataset, model: str, restitution: Array) -> Array:
    """Return xi at each e: exact where the damper has an exact one, and else matched, linear between the study's e."""
    if model in ORDERS:
        return damping_ratio(-np.log(restitution), ORDERS[model])
    xi = match["damping_ratio"].sel(damping_model=model).values
    return np.interp(restitution, match["restitution"].values, xi, left=np.nan, right=np.nan)


def restitution_of(match: xr.Dataset, model: str, ratio: float) -> float:
    """Return the e that a damping ratio stands for; NaN outside of the study's e where it is matched."""
    if model in ORDERS:
        return float(np.exp(-log_decrement(ratio, ORDERS[model])))
    return _inverse(match["damping_ratio"].sel(damping_model=model), ratio)


def secant_restitution_of(match: xr.Dataset, amplitude: float, ratio: float) -> float:
    """Return the e that a damping ratio at the secant period stands for; NaN outside of the study's e."""
    return _inverse(match["damping_ratio_secant"].sel(release_amplitude=amplitude), ratio)


def _inverse(xi: xr.DataArray, ratio: float) -> float:
    e = xi["restitution"].values[::-1]
    return float(np.interp(ratio, xi.values[::-1], e, left=np.nan, right=np.nan))


def released_as_the_paper(match: xr.Dataset) -> xr.Dataset:
    """Return the study's decays from the paper's reference amplitude."""
    return match.sel(release_amplitude=REFERENCE_AMPLITUDE, method="nearest")


@styled
def fig_code_damping(amplitude: xr.Dataset) -> Figure:
    """Draw the damping ratio against e, under each damper and at the secant period, beside measured e."""
    match = released_as_the_paper(amplitude)
    figure = new_figure(105.0, SINGLE_COLUMN)
    axes = figure.add_subplot()
    low, mean, high = TESTED
    axes.axvspan(low, high, color=PALE, alpha=0.5, linewidth=0, label="tested walls")
    axes.axvline(mean, color=GREY, linewidth=0.8, label="their mean")
    e = match["restitution"].values
    for model in map(str, match["damping_model"].values):
        style = line_of(model)
        axes.plot(e, 100 * ratio_of(match, model, e), label=model, linewidth=2.0 if model in ORDERS else 1.2, **style)
        at = [restitution_of(match, model, level) for level in LEVELS]
        axes.plot(at, 100 * np.array(LEVELS), linestyle="none", marker=".", color=style["color"])
    amplitudes = amplitude["release_amplitude"].values.tolist()
    shown = [amplitudes[index] for index in present(amplitudes, SECANT_AMPLITUDES)]
    for count, x0 in enumerate(shown):
        xi = 100 * amplitude["damping_ratio_secant"].sel(release_amplitude=x0)
        label = f"secant, {x0:g} $u_\\mathrm{{ins}}$"
        shade = str(0.25 + 0.45 * count / max(len(shown) - 1, 1))
        axes.plot(
            e, xi, color=shade, linewidth=0.8, marker="o^sDv<"[count % 6], markersize=2.5, markevery=6, label=label
        )
    for level in LEVELS:
        axes.axhline(100 * level, color=PALE, linewidth=0.6, zorder=0)
    axes.set(ylim=(0, 110 * max(LEVELS)), xlim=(float(e.min()), 1.0))
    axes.yaxis.set_major_locator(FixedLocator([0, *(100 * level for level in LEVELS)]))
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(r"damping ratio $\xi$ [%]")
    axes.set_title(f"CDC, CDR, SDR: $u_0/u_\\mathrm{{ins}} = {float(match['release_amplitude']):g}$")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def fig_code_damping_caption(amplitude: xr.Dataset) -> str:
    """Write the caption, HTML."""
    match, level = released_as_the_paper(amplitude), 0.05
    lowest, mean, highest = map(plain, TESTED)
    exact = restitution_of(match, RECOMMENDED, level)
    ratios = by_model(
        match["damping_ratio"].sel(damping_model=list(PAPER_MODELS)).interp(restitution=TESTED[1]), percent
    )
    others = by_name({model: number(restitution_of(match, model, level)) for model in PAPER_MODELS})
    amplitudes = amplitude["release_amplitude"].values.tolist()
    shown = [amplitudes[index] for index in present(amplitudes, SECANT_AMPLITUDES)]
    secant = listed(f"{number(secant_restitution_of(amplitude, x0, level))} at {plain(x0)}" for x0 in shown)
    return f"""
    <em>By the loss of each half cycle</em> (coloured),
    {percent(level, 1)} stand for e&nbsp;=&nbsp;{exact:.4f} under {RECOMMENDED}, whatever the curve and the amplitude;
    under the paper's dampers for {others}, but only for the paper's curve and a release from
    {plain(match["release_amplitude"])}&nbsp;u<sub>ins</sub>. <em>By the loop at the secant period</em> (grey), as
    displacement checks read it, {percent(level, 1)} stand for e&nbsp;=&nbsp;{secant}&nbsp;u<sub>ins</sub>. The grey
    band is e of tested walls, {lowest} to {highest} (Graziotti et al., as the paper quotes them); at their
    mean, {mean}, the paper's dampers need ξ&nbsp;=&nbsp;{ratios}.
    """
