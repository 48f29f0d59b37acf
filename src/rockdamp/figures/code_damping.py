"""The damping ratio that stands for each coefficient of restitution, in the two readings of a damping ratio."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    GREY,
    PALE,
    REFERENCE_AMPLITUDE,
    RESTITUTION,
    SINGLE_COLUMN,
    by_model,
    line_of,
    new_figure,
    present,
    styled,
)
from rockdamp.mechanics.damping.ecd import damping_ratio, log_decrement
from rockdamp.text import by_name, listed, number, percent, plain
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER

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
    others = by_name({model: number(restitution_of(match, model, level)) for model in PAPER_MODELS})
    amplitudes = amplitude["release_amplitude"].values.tolist()
    shown = [amplitudes[index] for index in present(amplitudes, SECANT_AMPLITUDES)]
    ratios = by_model(
        match["damping_ratio"].sel(damping_model=list(PAPER_MODELS)).interp(restitution=TESTED[1]), percent
    )
    secant = listed(f"{number(secant_restitution_of(amplitude, x0, level))} at {plain(x0)}" for x0 in shown)
    return f"""
    A damping ratio alone states no e: it depends on how it is read. <em>By the loss of each half cycle</em> (coloured),
    {percent(level, 1)} stand for e&nbsp;=&nbsp;{exact:.4f} under {RECOMMENDED}, whatever the curve and the amplitude;
    under the paper's dampers for {others}, but only for the paper's curve and a release from
    {plain(match["release_amplitude"])}&nbsp;u<sub>ins</sub>. <em>By the loop at the secant period</em> (grey), as
    displacement checks read it, {percent(level, 1)} stand for e&nbsp;=&nbsp;{secant}&nbsp;u<sub>ins</sub>. The mean of
    tested walls is {mean} (grey band, {lowest} to {highest}; Graziotti et al., as the paper quotes them); under the
    paper's dampers it needs ξ&nbsp;=&nbsp;{ratios}.
    """
