"""The coefficient of restitution that the damping ratio of a code stands for."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rockdamp.figures.style import (
    GREY,
    PALE,
    REFERENCE_AMPLITUDE,
    SINGLE_COLUMN,
    at_nearest,
    by_model,
    line_of,
    new_figure,
    styled,
)
from rockdamp.mechanics.half_cycle_loss import log_decrement
from rockdamp.text import by_name, number, percent, plain
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER

LEVELS = (0.02, 0.03, 0.05, 0.10)  # [-] that codes and analysts use
# Lowest, mean and highest e of shaking-table tests of single-leaf and cavity walls (Graziotti et al., as section 4.1 of
# the paper quotes them; second-hand).
TESTED = (0.84, 0.852, 0.90)


def restitution_of(match: xr.Dataset, model: str, damping_ratio: float) -> float:
    """Return the e whose matched damping ratio is this, linear between the study's e; NaN outside of them."""
    xi = match["damping_ratio"].sel(damping_model=model).values
    return float(np.interp(damping_ratio, xi[::-1], match["restitution"].values[::-1], left=np.nan, right=np.nan))


def released_as_the_paper(match: xr.Dataset) -> xr.Dataset:
    """Return the study's decays from the paper's reference amplitude."""
    return at_nearest(match, release_amplitude=REFERENCE_AMPLITUDE)


@styled
def fig_code_damping(amplitude: xr.Dataset) -> Figure:
    """Draw the e that each damping ratio stands for, under each damper, beside measured e."""
    match = released_as_the_paper(amplitude)
    figure = new_figure(SINGLE_COLUMN, 90.0)
    axes = figure.add_subplot()
    low, mean, high = TESTED
    axes.axhspan(low, high, color=PALE, alpha=0.5, linewidth=0, label="tested walls")
    axes.axhline(mean, color=GREY, linewidth=0.8, label="their mean")
    for model in map(str, match["damping_model"].values):
        xi = 100 * match["damping_ratio"].sel(damping_model=model)
        width = 1.2 if model in PAPER_MODELS else 2.0
        axes.plot(xi, match["restitution"], label=model, linewidth=width, **line_of(model))
        at = [restitution_of(match, model, level) for level in LEVELS]
        axes.plot(100 * np.array(LEVELS), at, linestyle="none", marker=".", color=line_of(model)["color"])
    for level in LEVELS:
        axes.axvline(100 * level, color=PALE, linewidth=0.6, zorder=0)
    axes.set_xlim(0, 110 * max(LEVELS))
    axes.set_ylim(float(match["restitution"].min()), 1.0)
    axes.set_xticks([0, *(100 * level for level in LEVELS)])
    axes.set_xlabel(r"damping ratio $\xi$ [%]")
    axes.set_ylabel("coefficient of restitution $e$ [-]")
    axes.set_title(f"$u_0/u_\\mathrm{{ins}} = {float(match['release_amplitude']):g}$")
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def fig_code_damping_caption(amplitude: xr.Dataset) -> str:
    """Write the caption, HTML."""
    match, level = released_as_the_paper(amplitude), 0.05
    lowest, mean, highest = map(plain, TESTED)
    exact = float(np.exp(-log_decrement(level, RECOMMENDED_ORDER)))
    others = by_name({model: number(restitution_of(match, model, level)) for model in PAPER_MODELS})
    ratios = by_model(match["damping_ratio"].interp(restitution=TESTED[1]), percent)
    return f"""
    {percent(level, 1)} of damping stand for e&nbsp;=&nbsp;{exact:.3f} under {RECOMMENDED}, whatever the curve and the
    amplitude. The mean of tested walls is {mean} (grey, {lowest} to {highest}; Graziotti et al., as the paper quotes
    them). Under the paper's dampers they stand for {others}, but only for the paper's curve and a release from
    {plain(match["release_amplitude"])}&nbsp;u<sub>ins</sub>. The mean of tested walls needs ξ&nbsp;=&nbsp;{ratios}.
    """
