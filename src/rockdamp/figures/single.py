"""Pictures that the command line draws of one wall: free decays, the response to a record, fragility under records."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import ndtr

from rockdamp.constants import REFERENCE
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    TAU,
    line_of,
    literal,
    new_figure,
    one_two_five,
    scaling,
    style_of,
    styled,
)
from rockdamp.figures.validation import MILLIMETRES

TIME = "time $t$ [s]"
ACCELERATION = r"$\ddot u_g$ [m s$^{-2}$]"


def label_of(history: xr.Dataset, model: str) -> str:
    """Return the name of a model with its parameter."""
    of_model = history.sel(damping_model=model)
    if model == REFERENCE:
        return f"CR, $e = {float(of_model['restitution']):g}$"
    return f"{model}, $\\xi = {float(of_model['damping_ratio']):.4f}$"


@styled
def decay_figure(decay: xr.Dataset) -> Figure:
    """Draw a free decay under each of its models, with a second axis in seconds where it has ``elapsed``."""
    figure = new_figure(80.0)
    axes = figure.subplots()
    for model in map(str, decay["damping_model"].values):
        axes.plot(
            decay["tau"],
            decay["displacement"].sel(damping_model=model),
            label=label_of(decay, model),
            **_line(model),
        )
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    axes.set(xlabel=TAU, ylabel=DISPLACEMENT)
    if "elapsed" in decay.coords:
        above = axes.secondary_xaxis("top", functions=scaling(1 / float(decay["frequency_parameter"])))
        above.set_xlabel(TIME)
        axes.spines["top"].set_visible(True)
    _legend(figure, axes)
    return figure


@styled
def response_figure(response: xr.Dataset) -> Figure:
    """Draw the ground's motion and the response under each model, up to a cross where the wall collapses."""
    figure = new_figure(110.0)
    ground, axes = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 2.2]})
    ground.plot(response["elapsed"], response["ground_acceleration"], color="black", linewidth=0.8)
    ground.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    ground.set_ylabel(r"$\ddot u_g$ [m s$^{-2}$]")
    for model in map(str, response["damping_model"].values):
        _history(axes, response, model)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    axes.set(xlabel=TIME, ylabel="$u$ [mm]")
    right = axes.secondary_yaxis(
        "right", functions=scaling(1 / (MILLIMETRES * float(response["instability_displacement"])))
    )
    right.set_ylabel(DISPLACEMENT)
    axes.spines["right"].set_visible(True)
    figure.align_ylabels([ground, axes])
    figure.suptitle(record_title(response), fontsize=8)
    _legend(figure, axes)
    return figure


def record_title(dataset: xr.Dataset) -> str:
    """Return the record's specimen or source, and the factor on it."""
    kind = "SYNTHETIC record" if dataset.attrs.get("record_synthetic") == "yes" else "Record"
    specimen, source = (str(dataset.attrs.get(f"record_{key}", "not stated")) for key in ("specimen", "source"))
    name = specimen if specimen not in ("none", "not stated") else source
    factor = f" (times {float(dataset['scale_factor']):g})" if float(dataset.get("scale_factor", 1.0)) != 1 else ""
    return fill(literal(f"{kind}: {name}{factor}"), 120, max_lines=2)


def _history(axes: Axes, response: xr.Dataset, model: str) -> None:
    of_model = response.sel(damping_model=model)
    label, collapsed = label_of(response, model), bool(of_model["collapsed"])
    label += f", collapses at {float(of_model['end_elapsed']):.2f} s" if collapsed else ""
    displacement = MILLIMETRES * of_model["control_displacement"].values
    axes.plot(of_model["elapsed"], displacement, label=label, **_line(model))
    if collapsed:
        last = int(np.flatnonzero(np.isfinite(displacement))[-1])
        axes.plot(
            of_model["elapsed"][last],
            displacement[last],
            "x",
            color=_line(model)["color"],
            markersize=6,
            clip_on=False,
        )


def _line(label: str) -> dict[str, Any]:
    return line_of(label.rstrip("0123456789."))  # of ECD16 that of ECD


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(3, len(labels)))


# --- fragility --------------------------------------------------------------------------------------------------------

UNITS = {"pgv": "m s$^{-1}$", "pga": "m s$^{-2}$"}
POINTS = 200  # of a curve


@styled
def fragility_figure(answer: xr.Dataset) -> Figure:
    """Draw the fragility under each damping model, with its stripes and the share at the intensities asked for."""
    figure = new_figure(66.0)
    draw_fragility(figure.subplots(), answer)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def draw_fragility(axes: Axes, answer: xr.Dataset) -> None:
    """Draw the fragility into a panel."""
    measure = str(answer.attrs["intensity_measure"]).lower()  # pgv or pga
    records = int(answer["records"])
    stripes = answer[f"stripe_{measure}"].values
    levels = np.geomspace(stripes[0], stripes[-1], POINTS)
    for model in map(str, answer["damping_model"].values):
        of_model = answer.sel(damping_model=model)
        median, dispersion = float(of_model[f"median_{measure}"]), float(of_model["dispersion"])
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
    _draw_asked(axes, answer, measure)
    axes.set_xscale("log")
    one_two_five(axes.xaxis)
    axes.set_xlim(stripes[0], stripes[-1])
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(f"{measure.upper()} [{UNITS[measure]}]")
    runs = "histories" if answer.sizes["damping_model"] == 1 else "records"  # against a stop each acts both ways
    axes.set_ylabel(f"share of {records} {runs} that collapse")


def _draw_asked(axes: Axes, answer: xr.Dataset, measure: str) -> None:
    """Draw the share under restitution at the intensities asked for, with its interval."""
    cr = answer.isel(damping_model=0)
    share, bounds = cr["collapse_probability"].values, cr["collapse_probability_interval"].values
    error: Any = np.abs(bounds.T - share)
    axes.errorbar(
        cr[measure],
        share,
        error,
        fmt="_",
        color=GREY,
        capsize=3,
        linewidth=1.2,
        label=f"{cr['damping_model'].item()} at the intensity asked for, 95 %",
    )
