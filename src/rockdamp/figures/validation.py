"""Fig. 8: the response measured on a shaking table and that of each damping model; of one record, or of a ladder."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rockdamp.figures.ladder import draw_ladder
from rockdamp.figures.style import DOUBLE_COLUMN, GREY, PALE, line_of, new_figure, plain, style_of, styled, title_of
from rockdamp.vocabulary import REFERENCE

MILLIMETRES = 1000.0
SHOWN_FROM = 0.1  # of the table's peak: what is drawn starts shortly before the motion exceeds it
MARGIN = 0.08  # of what is shown, before the motion and after the last peak
MEASURED: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 2.2}


@styled
def fig8(validation: xr.Dataset) -> Figure:
    """Draw the table's motion, and the measured displacement against each model's, with the peaks of the decay.

    Of several records: each model on every rung, and how its peak and decrement compare with the measured ones.

    Parameters
    ----------
    validation : xarray.Dataset
        ``displacement`` (record, damping_model, elapsed), ``measured`` and ``ground_acceleration`` (record, elapsed),
        the decay's peaks and the attribute ``record_synthetic``.
    """
    specimen = validation.attrs.get("record_specimen", "specimen not stated")
    kind = "SYNTHETIC record" if is_synthetic(validation) else "Record"
    if validation.sizes["record"] > 1:
        return draw_ladder(validation, f"{kind}s: {specimen}", measured_name(validation))
    return _draw_one(validation.isel(record=0), f"{kind}: {specimen}")


def _draw_one(validation: xr.Dataset, heading: str) -> Figure:
    models = [str(model) for model in validation["damping_model"].values]
    rows = -(-(1 + len(models)) // 2)
    figure = new_figure(DOUBLE_COLUMN, 155.0 / 3 * rows)
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False).ravel()
    for spare in panels[1 + len(models) :]:
        spare.remove()
    _table(panels[0], validation)
    for axes, model in zip(panels[1 : 1 + len(models)], models, strict=True):
        if axes is not panels[1]:
            axes.sharey(panels[1])
        _history(axes, validation, model)
    for axes in panels[len(models) - 1 : len(models) + 1]:
        axes.set_xlabel("time $t$ [s]")
        axes.tick_params(labelbottom=True)
    panels[0].set_xlim(*shown(validation))
    low, high = float(validation["measured"].min()), float(validation["measured"].max())
    largest = MILLIMETRES * max(-low, high, float(np.abs(validation["displacement"]).max()))
    panels[1].set_ylim(-1.1 * largest, 1.1 * largest)
    figure.suptitle(fill(plain(heading), 120), fontsize=8)
    _legend(figure, measured_name(validation))
    return figure


def is_synthetic(validation: xr.Dataset) -> bool:
    """Whether the record was computed: only one that says it was not counts as a test."""
    return str(validation.attrs.get("record_synthetic", "yes")) != "no"


def measured_name(validation: xr.Dataset) -> str:
    """What the record's displacement is called on the figure."""
    return "measured (SYNTHETIC)" if is_synthetic(validation) else "measured"


def has_free_decay(validation: xr.Dataset) -> bool:
    """Tell whether any half cycle of the measured decay is free of the motion."""
    return bool((validation["half_cycle_free"] == 1).any())


def shown(validation: xr.Dataset) -> tuple[float, float]:
    """First and last time drawn: the motion and the decay, not the rest before and after. [s]"""
    motion = np.abs(validation["ground_acceleration"].values)
    elapsed = validation["elapsed"].values
    start = elapsed[np.argmax(motion >= SHOWN_FROM * motion.max())]
    end = float(validation["measured_decay_peak_elapsed"].max())
    margin = MARGIN * (end - start)
    return max(float(elapsed[0]), start - margin), min(float(elapsed[-1]), end + margin)


def _legend(figure: Figure, name: str) -> None:
    hollow: dict[str, Any] = {"marker": "o", "markerfacecolor": "white", "markeredgewidth": 0.6}
    full: dict[str, Any] = {"marker": style_of(REFERENCE).marker, **line_of(REFERENCE)}
    handles = [
        Line2D([], [], label=f"{name}, with the peaks of its decay", **hollow, **MEASURED),
        Line2D([], [], label="computed, each model in its own line, with the matched peaks", **full),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)


def _table(axes: Axes, validation: xr.Dataset) -> None:
    axes.plot(validation["elapsed"], validation["ground_acceleration"], color="black", linewidth=0.9)
    axes.set_ylabel(r"$\ddot u_g$ [m s$^{-2}$]")
    axes.set_title("table motion")
    _phases(axes, validation)
    if has_free_decay(validation):
        top = float(validation["ground_acceleration"].max())
        axes.annotate(
            "free decay",
            (float(validation["free_phase_start"]), top),
            (4, 0),
            textcoords="offset points",
            fontsize=7,
            ha="left",
            va="top",
        )


def _phases(axes: Axes, validation: xr.Dataset) -> None:
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    if has_free_decay(validation):
        axes.axvline(float(validation["free_phase_start"]), color=GREY, linewidth=0.6, linestyle="dotted", zorder=0)


def _history(axes: Axes, validation: xr.Dataset, model: str) -> None:
    of_model = validation.sel(damping_model=model)
    elapsed = validation["elapsed"].values
    measured, computed = (MILLIMETRES * values.values for values in (validation["measured"], of_model["displacement"]))
    axes.plot(elapsed, measured, label=measured_name(validation), zorder=1, **MEASURED)
    axes.plot(elapsed, computed, label="computed", zorder=2, **line_of(model))
    for values, peaks, at, marker, face in (
        (measured, validation["measured_decay_peak"], validation["measured_decay_peak_elapsed"], "o", "white"),
        (
            computed,
            of_model["decay_peak"],
            of_model["decay_peak_elapsed"],
            style_of(model).marker,
            style_of(model).colour,
        ),
    ):
        matched = np.isfinite(peaks.values)
        time, size = at.values[matched], MILLIMETRES * peaks.values[matched]
        side = np.sign(np.interp(time, elapsed, np.nan_to_num(values)))
        edge = MEASURED["color"] if face == "white" else face
        axes.plot(
            time, side * size, linestyle="none", marker=marker, markerfacecolor=face, markeredgecolor=edge, zorder=3
        )
    if model == REFERENCE:
        parameter = f"$e = {float(validation['restitution']):g}$"
    else:
        parameter = f"$\\xi = {float(of_model['damping_ratio']):.4f}$"
    axes.set_title(f"{title_of(model)}, {parameter}", color=style_of(model).colour, fontweight="bold")
    axes.text(0.99, 0.03, _misfit(of_model), transform=axes.transAxes, ha="right", va="bottom", fontsize=7)
    axes.set_ylabel("$u$ [mm]")
    _phases(axes, validation)


def _misfit(of_model: xr.Dataset) -> str:
    if bool(of_model["collapsed"]):
        return "collapsed"
    misfit, ratio = MILLIMETRES * float(of_model["rms_misfit"]), float(of_model["peak_ratio_to_measured"])
    return f"peak {ratio:.2f} of the measured\nrms misfit {misfit:.1f} mm"
