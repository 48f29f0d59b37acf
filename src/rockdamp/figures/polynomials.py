"""Fig. 7: polynomials of the damping ratio in the coefficient of restitution."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rockdamp.figures.equivalence import MARKERS, every, head, response_length_text, title_panel
from rockdamp.figures.style import (
    DAMPING_RATIO,
    REFERENCE_CRACKED_STIFFNESS,
    REFERENCE_RESTITUTION,
    RESTITUTION,
    by_model,
    dampers,
    line_of,
    nearest,
    new_figure,
    papers,
    shades,
    style_of,
    styled,
    texts,
)
from rockdamp.text import listed, number, percent, plain

SHARED = {
    "strength_ratio": "$b_1",
    "ultimate_displacement_ratio": "$a_3",
    "release_amplitude": r"$u_0/u_\mathrm{ins}",
}
EQUATION_15: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0, (8.0, 1.4, 2.6, 1.4))}


@styled
def fig7(equivalence: xr.Dataset) -> Figure:
    """Draw the second-order polynomials xi(e) of each model and a1, the matched points and Eq. (15)."""
    equivalence = papers(equivalence)
    models, e = dampers(equivalence), equivalence["restitution"]
    values = equivalence["yield_displacement_ratio"].values.tolist()
    names = texts(values)
    figure = new_figure(92.0)
    grid = figure.add_gridspec(1, 1 + len(models), width_ratios=[1.75] + [1.0] * len(models))
    together = figure.add_subplot(grid[0])
    _ranges(together, equivalence)
    for position, model in enumerate(models):
        axes = figure.add_subplot(grid[1 + position], sharex=together, sharey=together)
        keys = []
        for index, (colour, marker) in enumerate(zip(shades(model, len(values)), cycle(MARKERS), strict=False)):
            fit = equivalence.sel(damping_model=model).isel(yield_displacement_ratio=index)
            line: dict[str, Any] = {"color": colour, "linewidth": 0.8, "markersize": 2.6, "markeredgewidth": 0.3}
            axes.plot(e, fit["damping_ratio_fit"], **line)
            points = slice(None, None, every(e))
            axes.plot(e[points], fit["damping_ratio"][points], marker, **line)
            keys.append(Line2D([], [], marker=marker, label=names[index], **line))
        axes.plot(e, equivalence["giannini_masiani"], **EQUATION_15)
        title_panel(axes, model)
        axes.legend(handles=keys, title="$a_1$ [-]", loc="upper right", ncols=2, handlelength=1.2, columnspacing=0.8)
        axes.tick_params(labelleft=position == 0)
        axes.set_xlabel("restitution $e$ [-]")
    together.locator_params("x", nbins=3, steps=[1, 2, 5, 10])  # shared by the narrow panels
    together.set_ylim(0, 1.05 * float(equivalence["damping_ratio"].max()))
    least = f"$R^2 \\geq {_rounded_down(equivalence['r_squared'])}$"
    lines = f"lines: polynomials, {least}; markers: {response_length_text(equivalence)}"
    head(figure, lines, *_shared(equivalence))
    return figure


def fig7_caption(equivalence: xr.Dataset) -> str:
    """Write the caption of Fig. 7, HTML."""
    fits = papers(equivalence)
    at = fits.sel(
        yield_displacement_ratio=REFERENCE_CRACKED_STIFFNESS, restitution=REFERENCE_RESTITUTION, method="nearest"
    )
    return f"""
    Second-order polynomials ξ(e) are off by up to {_by_range(fits["largest_relative_error"])} of ξ where little is
    lost, as they do not vanish where ξ does: R²&nbsp;≥&nbsp;{_rounded_down(fits["r_squared"])}, with residuals up to
    {number(fits["largest_residual"].max(), 2)}, hides it. ξ/δ of second order in δ&nbsp;=&nbsp;−ln&nbsp;e is off by up
    to {_by_range(fits["delta_largest_relative_error"])}. For b<sub>1</sub>&nbsp;=&nbsp;{plain(fits["strength_ratio"])};
    at e&nbsp;=&nbsp;{plain(at["restitution"])} and a<sub>1</sub>&nbsp;=&nbsp;{plain(at["yield_displacement_ratio"])}
    they give ξ&nbsp;=&nbsp;{by_model(at["damping_ratio_fit"])}, and Eq.&nbsp;(15) gives
    {number(at["giannini_masiani"])}.
    """


def _by_range(errors: xr.DataArray) -> str:
    """Write the largest error of all models and a1 in each range of e that holds values: "4 % (e up to 0.9)"."""
    largest = errors.max(("damping_model", "yield_displacement_ratio")).dropna("restitution_range")
    return listed(
        f"{percent(error)} (e up to {plain(end)})"
        for end, error in zip(largest["restitution_range"].values, largest.values, strict=True)
    )


def _rounded_down(r_squared: xr.DataArray) -> str:
    """Write the least R², rounded down: neither figure nor caption claims more than the least fit."""
    return f"{np.floor(1e4 * float(r_squared.min())) / 1e4:.4f}"


def _shared(dataset: xr.Dataset) -> list[str]:
    """Write what all values of a dataset share of the curve and release."""
    scalars = {name: symbol for name, symbol in SHARED.items() if name in dataset and dataset[name].ndim == 0}
    return [f"{symbol} = {float(dataset[name]):g}$" for name, symbol in scalars.items()]


def _ranges(axes: Axes, equivalence: xr.Dataset) -> None:
    """Draw all models together: the polynomial at the reference a1, and the band that the other a1 fill."""
    e, values = equivalence["restitution"], equivalence["yield_displacement_ratio"].values.tolist()
    index = nearest(values, REFERENCE_CRACKED_STIFFNESS)
    fits = equivalence["damping_ratio_fit"]
    for model in dampers(equivalence):
        band = fits.sel(damping_model=model)
        low, high = band.min("yield_displacement_ratio"), band.max("yield_displacement_ratio")
        axes.fill_between(e, low, high, color=style_of(model).colour, alpha=0.18, linewidth=0)
        axes.plot(e, band.isel(yield_displacement_ratio=index), label=model, **line_of(model))
    axes.plot(e, equivalence["giannini_masiani"], label="Eq. (15)", **EQUATION_15)
    axes.set_title(f"all models at $a_1 = {values[index]:g}$, bands: ${min(values):g} \\leq a_1 \\leq {max(values):g}$")
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(DAMPING_RATIO)
    axes.legend(loc="upper right")
