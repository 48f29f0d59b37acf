"""One wall under records: its fragility, and what the page of a wall shows beside it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import ndtr

from rockdamp.figures.style import GREY, in_units, line_of, new_figure, one_two_five, style_of, styled
from rockdamp.vocabulary import REFERENCE

UNITS = {"pgv": "m s-1", "pga": "m s-2"}
POINTS = 200  # of a curve


@styled
def fragility_figure(answer: xr.Dataset, system: str = "si") -> Figure:
    """Draw the fragility under each damping model, with its stripes and the share at the intensities asked for.

    `system` is that of the units, si or imperial.
    """
    figure = new_figure(66.0)
    draw_fragility(figure.subplots(), answer, system)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def draw_fragility(axes: Axes, answer: xr.Dataset, system: str) -> None:
    """Draw the fragility into a panel."""
    measure = measure_of(answer)
    unit, one = in_units(UNITS[measure], system)
    records = int(answer["records"])
    stripes = answer[f"stripe_{measure}"].values / one
    levels = np.geomspace(stripes[0], stripes[-1], POINTS)
    for model in map(str, answer["damping_model"].values):
        of_model = answer.sel(damping_model=model)
        median, dispersion = float(of_model[f"median_{measure}"]) / one, float(of_model["dispersion"])
        style = style_of(model)
        # CR's are larger and open, so that those of a damper that lie on them are seen.
        size: dict[str, Any] = {"markersize": 5, "markerfacecolor": "none"} if model == REFERENCE else {"markersize": 3}
        axes.plot(
            stripes, of_model["stripe_collapses"] / records, style.marker, color=style.colour, clip_on=False, **size
        )
        if np.isfinite(median):
            text = f"{model}: median {median:.3g}, dispersion {dispersion:.2f}"
            axes.plot(levels, ndtr(np.log(levels / median) / dispersion), label=text, **line_of(model))
        else:
            axes.plot([], [], style.marker, color=style.colour, label=f"{model}: no lognormal curve")
    _draw_asked(axes, answer, measure, one)
    axes.set_xscale("log")
    one_two_five(axes.xaxis)
    axes.set_xlim(stripes[0], stripes[-1])
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(f"{measure.upper()} [{unit}]")
    runs = "histories" if "STOP" in answer["damping_model"].values else "records"  # against a stop each acts both ways
    axes.set_ylabel(f"share of {records} {runs} that collapse")


def _draw_asked(axes: Axes, answer: xr.Dataset, measure: str, one: float) -> None:
    """Draw the share under restitution at the intensities asked for, with its interval."""
    cr = answer.isel(damping_model=0)
    share, bounds = cr["collapse_probability"].values, cr["collapse_probability_interval"].values
    error: Any = np.abs(bounds.T - share)
    axes.errorbar(
        cr[measure] / one,
        share,
        error,
        fmt="_",
        color=GREY,
        capsize=3,
        linewidth=1.2,
        label=f"{cr['damping_model'].item()} at the intensity asked for, 95 %",
    )


def measure_of(answer: xr.Dataset) -> str:
    """Return `pgv` or `pga`, the intensity measure of an assessment."""
    return str(answer.attrs["intensity_measure"]).lower()
