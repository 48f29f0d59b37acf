"""A population of walls under earthquakes: its fragility, and which parameters it depends on."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rockdamp.figures.collapse import BAND, SHARES, draw_fragility
from rockdamp.figures.earthquakes import plain_logarithmic
from rockdamp.figures.style import (
    GREY,
    by_damper,
    dampers,
    line_of,
    marks_of,
    new_figure,
    style_of,
    styled,
    with_interval,
)
from rockdamp.text import number
from rockdamp.vocabulary import REFERENCE

NAMES = {  # of the parameters, as the axes show them
    "thickness": "thickness $t$",
    "slenderness": "slenderness $h/t$",
    "overburden_ratio": "overburden $O/W$",
    "hinge_ratio": "hinge $h_1/h$",
    "yield_displacement_ratio": "yield displacement $a_1$",
    "strength_ratio": "strength $b_1$",
    "restitution": "restitution $e$",
}
HEIGHT = 0.7  # of a bar
INDEX: dict[str, Any] = {"facecolor": BAND, "edgecolor": GREY, "linewidth": 0.5}
TICKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)


@styled
def fig_population(population: xr.Dataset) -> Figure:
    """Draw the population's fragility, each damper's median over CR's, and the sensitivity to each parameter."""
    figure = new_figure(88.0)
    left, middle, right = figure.subplots(1, 3, width_ratios=[1.25, 0.85, 1.0])
    _fragility(left, population)
    _ratios(middle, population)
    _sensitivity(right, population)
    handles = [
        Line2D([], [], label=REFERENCE, **line_of(REFERENCE)),
        Patch(facecolor=BAND, label="CR, at least 90 % band"),
        *(
            Line2D([], [], label=model, marker=style_of(model).marker, markersize=3.5, **line_of(model))
            for model in dampers(population)
        ),
        Line2D([], [], label="CR, share of the runs", **SHARES),
        Patch(label="CR, first-order index", **INDEX),
    ]
    walls, records = population.sizes["wall"], int(population["records"])
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=4,
        title=(f"{walls} walls under {records} records; damping ratios by the closed form at each wall"),
    )
    return figure


def _fragility(axes: Axes, population: xr.Dataset) -> None:
    names = {"median_intensity": "median", "median_intensity_interval": "median_interval"}
    draw_fragility(axes, population.rename(names), "intensity")
    plain_logarithmic(axes, TICKS)
    axes.set(xlabel="peak ground velocity [m s$^{-1}$]", ylabel="probability of collapse [-]", title="fragility")


def _ratios(axes: Axes, population: xr.Dataset) -> None:
    models = dampers(population)
    for row, model in enumerate(models):
        of_model, style = population.sel(damping_model=model), style_of(model)
        axes.plot(of_model["median_intensity_ratio_interval"], [row, row], color=style.colour, linewidth=1.1)
        axes.plot(float(of_model["median_intensity_ratio"]), row, marker=style.marker, markersize=4, color=style.colour)
    axes.axvline(1.0, color="black", linewidth=0.6)
    axes.set_yticks(range(len(models)), models)
    axes.set_ylim(len(models) - 0.5, -0.5)
    axes.margins(x=0.1)
    axes.set(xlabel="median over that of CR [-]", title="median of collapse, 95 %")


def _sensitivity(axes: Axes, population: xr.Dataset) -> None:
    names = [str(name) for name in population["parameter"].values]
    rows, cr = np.arange(len(names)), population.sel(damping_model=REFERENCE)
    axes.barh(
        rows,
        cr["first_order_index"],
        height=HEIGHT,
        xerr=cr["first_order_index_confidence"],
        error_kw={"linewidth": 0.7, "ecolor": style_of(REFERENCE).colour},
        **INDEX,
    )
    for model in dampers(population):
        axes.plot(population["first_order_index"].sel(damping_model=model), rows, markersize=2.6, **marks_of(model))
    axes.set_yticks(rows, [NAMES.get(name, name) for name in names])
    axes.invert_yaxis()
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_xlabel("share of the variance [-]")
    axes.set_title("sensitivity of collapse,\nfirst-order indices")


def fig_population_caption(population: xr.Dataset) -> str:
    """Write the caption, HTML."""
    cr = population.sel(damping_model=REFERENCE)
    index = cr["first_order_index"].values
    most = ", ".join(
        f"{str(population['parameter'].values[i]).replace('_', ' ')} ({number(index[i], 2)})"
        for i in np.argsort(-np.nan_to_num(index))[:3]
    )

    ratio = partial(with_interval, name="median_intensity_ratio")
    return f"""
    The dampers' medians of collapse, over that of restitution and with ξ of the closed form at each wall, are
    {by_damper(population, ratio)}. Collapse depends most on these parameters: {most} (first-order index; of a
    correlated parameter it includes what it shares with others). With restitution half of the runs collapse at
    {number(cr["median_intensity"])}&nbsp;m/s (dispersion {number(cr["dispersion"], 2)}). {population.sizes["wall"]}
    walls, a Latin hypercube over the distributions of the config, under {int(population["records"])} records at
    {population.sizes["intensity"]} intensities each.
    """
