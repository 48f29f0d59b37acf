"""A model beside a test: the series of amplitudes, and Fig. 8."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    by_model,
    columns_of,
    line_of,
    literal,
    new_figure,
    paper_models,
    style_of,
    styled,
)
from rockdamp.text import listed, percent, plain, span
from rockdamp.vocabulary import REFERENCE

# --- the specimen -----------------------------------------------------------------------------------------------------


RIGHT = 0.1  # of the record's value: as far as a model may be off to be called right
BAND = "#E8E8E8"


def amplitudes(validation: xr.Dataset) -> Array:
    """Return the largest displacement of each record, u/u_ins. [-]"""
    peaks: Array = (validation["measured_peak_displacement"] / validation["instability_displacement"]).values
    return peaks


def series_by_maker(validation: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the records by what made them, each test series from its lowest level up."""
    makers = [str(maker) for maker in validation["record_made_by"].values]
    levels = {maker: [i for i, other in enumerate(makers) if other == maker] for maker in dict.fromkeys(makers)}
    return {
        maker: validation.isel(record=sorted(indices, key=lambda i: amplitudes(validation)[i]))
        for maker, indices in levels.items()
    }


def off(validation: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return computed ``peak`` or ``decrement`` over measured; NaN after a collapse or without a free decay."""
    if quantity == "peak":
        return validation["peak_ratio_to_measured"].where(validation["collapsed"] == 0)
    return validation["log_decrement"] / validation["measured_log_decrement"]


def is_synthetic(validation: xr.Dataset) -> bool:
    """Say whether the record was computed: only one that says it was not counts as a test."""
    return str(validation.attrs.get("record_synthetic", "yes")) != "no"


def heading(validation: xr.Dataset) -> str:
    """Return the heading of a figure of records: their kind and specimen."""
    kind = "SYNTHETIC records" if is_synthetic(validation) else "Records"
    return fill(literal(f"{kind}: {validation.attrs.get('record_specimen', 'specimen not stated')}"), 120)


def measured_name(validation: xr.Dataset) -> str:
    """Return what the record's displacement is called: a synthetic one was not measured."""
    return "SYNTHETIC record" if is_synthetic(validation) else "measured"


@styled
def fig_test_series(validation: xr.Dataset) -> Figure:
    """Draw peak and decrement of every model over those of the record, against the amplitude, for each test series."""
    models = [str(model) for model in validation["damping_model"].values]
    by_maker = series_by_maker(validation)
    figure = new_figure(105.0)
    grid = figure.subplots(2, len(by_maker), sharex=True, sharey="row", squeeze=False)
    for panels, (maker, test_series) in zip(grid.T, by_maker.items(), strict=True):
        for axes, quantity in zip(panels, ("peak", "decrement"), strict=True):
            _right(axes, test_series, quantity, models)
        panels[0].set_title(literal("a test" if maker == "measured" else f"made by {maker}"))
        panels[1].set_xlabel(f"peak of the record\n{DISPLACEMENT}")
    for axes, quantity in zip(grid[:, 0], ("peak", "decrement"), strict=True):
        axes.set(ylabel=f"{quantity} over\nthat of the record [-]", ylim=(0, 1.75))
    handles: list[Line2D | Patch] = [
        Line2D([], [], label=model, marker=style_of(model).marker, markersize=3.5, **line_of(model)) for model in models
    ]
    handles.append(Patch(facecolor=BAND, label=f"within {percent(RIGHT)} of the record"))
    figure.suptitle(heading(validation), fontsize=8)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns_of(len(handles), 7))
    return figure


def _right(axes: Axes, test_series: xr.Dataset, quantity: str, models: list[str]) -> None:
    """Draw a quantity of every model over that of the record, against the amplitude of the levels."""
    axes.axhspan(1 - RIGHT, 1 + RIGHT, color=BAND, zorder=0, linewidth=0)
    values = off(test_series, quantity)
    for model in models:
        style = {"marker": style_of(model).marker, "markersize": 3.5, **line_of(model)}
        axes.plot(amplitudes(test_series), values.sel(damping_model=model), label=model, **style)
    axes.set_xlim(0, 1)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def fig_test_series_caption(validation: xr.Dataset) -> str:
    """Write the caption, HTML."""
    by_maker = series_by_maker(validation)
    (maker, first), *_ = by_maker.items()
    peaks = {name: off(levels, "peak").sel(damping_model=REFERENCE) for name, levels in by_maker.items()}
    ratios = listed(f"{float(ratio.min()):.2f} to {float(ratio.max()):.2f} ({name})" for name, ratio in peaks.items())
    return f"""
    Against the records made by {maker}, by their peak over u<sub>ins</sub>, the peak is right within {percent(RIGHT)}
    under {_right_at(first, "peak")}; the
    decrement of the free decay, under {_right_at(first, "decrement")}. The peaks of {REFERENCE} are {ratios} times
    those of the records, by what made them.
    """


def _right_at(levels: xr.Dataset, quantity: str) -> str:
    """Name each model with the amplitudes at which a quantity of it is right: "CR at 0.50 and 0.88, CDC at none"."""
    near = abs(off(levels, quantity) - 1) <= RIGHT
    reached = amplitudes(levels)
    return ", ".join(
        f"{model} at {listed(f'{value:.2f}' for value in reached[near.sel(damping_model=model)]) or 'none'}"
        for model in near["damping_model"].values
    )


# --- Fig. 8 -----------------------------------------------------------------------------------------------------------


MILLIMETRES = 1000.0
MEASURED: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 2.2}
FREE: dict[str, Any] = {"color": GREY, "linewidth": 0.6, "linestyle": "dotted"}
MOST_LEVELS = 4  # whose histories are drawn
SHOWN_FROM = 0.05  # of the table's peak: what is drawn starts shortly before the motion exceeds it
MARGIN = 0.05  # of what is shown, before the motion and after the last peak
ROW = 22.0  # [mm]


@styled
def fig8(validation: xr.Dataset) -> Figure:
    """Draw the table's motion, and below it the displacement of each model beside that of the record.

    Of several records, the first test series has a column for each of its levels.
    """
    (maker, first), *others = series_by_maker(paper_models(validation)).items()
    chosen = np.unique(np.linspace(0, first.sizes["record"] - 1, MOST_LEVELS).astype(int))
    levels = first.isel(record=chosen)
    models = [str(model) for model in levels["damping_model"].values]
    figure = new_figure(25 + ROW * (1 + len(models)))
    grid = figure.subplots(1 + len(models), chosen.size, sharex=True, sharey="row", squeeze=False)
    for column, panels in enumerate(grid.T):
        level = levels.isel(record=column)
        _motion(panels[0], level)
        for axes, model in zip(panels[1:], models, strict=True):
            _history(axes, level.sel(damping_model=model), model)
            axes.set_ylim(-1.35, 1.35)
        panels[-1].set_xlabel("time $t$ [s]")
    for axes in grid[1:, 0]:
        axes.set_ylabel("$u$ over peak\nof record [-]")
    grid[0, 0].set(ylabel="$\\ddot u_g$\n[m s$^{-2}$]", xlim=shown(levels))
    figure.suptitle(heading(validation) + (f"; made by {literal(maker)}" if others else ""), fontsize=8)
    handles = [
        Line2D([], [], label=measured_name(validation), **MEASURED),
        Line2D([], [], label="computed with the study's wall and e, not the record's", **line_of(REFERENCE)),
    ]
    if np.isfinite(levels["free_phase_start"]).any():
        handles.append(Line2D([], [], label="start of the free decay", **FREE))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def shown(records: xr.Dataset) -> tuple[float, float]:
    """Return the first and last time drawn: the motion and the decays, not the rest before and after. [s]"""
    motion, elapsed = np.abs(records["ground_acceleration"].values), records["elapsed"].values
    moving = np.nanmax(motion >= SHOWN_FROM * np.nanmax(motion, axis=1, keepdims=True), axis=0)
    start, end = elapsed[np.argmax(moving)], float(records["measured_decay_peak_elapsed"].max())
    margin = MARGIN * (end - start)
    return max(float(elapsed[0]), start - margin), min(float(elapsed[-1]), end + margin)


def _motion(axes: Axes, level: xr.Dataset) -> None:
    axes.plot(level["elapsed"], level["ground_acceleration"], color="black", linewidth=0.8)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    peak = float(level["measured_peak_displacement"] / level["instability_displacement"])
    axes.set_title(f"peak {peak:.2f} $u_\\mathrm{{ins}}$")
    axes.yaxis.set_major_locator(MaxNLocator(2))


def _history(axes: Axes, of_model: xr.Dataset, model: str) -> None:
    """Draw one model on one level, over the largest displacement of the record."""
    largest = float(of_model["measured_peak_displacement"])
    axes.plot(of_model["elapsed"], of_model["measured"] / largest, label="measured", zorder=1, **MEASURED)
    axes.plot(of_model["elapsed"], of_model["control_displacement"] / largest, label=model, zorder=2, **line_of(model))
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    start = float(of_model["free_phase_start"])
    if np.isfinite(start):
        axes.axvline(start, zorder=0, **FREE)
    ratio = float(of_model["peak_ratio_to_measured"])
    outcome = "collapsed" if bool(of_model["collapsed"]) else f"peak {ratio:.2f} of the record's"
    colour = style_of(model).colour
    axes.text(0.02, 0.96, model, transform=axes.transAxes, va="top", fontsize=7, color=colour, weight="bold")
    axes.text(0.98, 0.04, outcome, transform=axes.transAxes, ha="right", va="bottom", fontsize=7)


def fig8_caption(validation: xr.Dataset) -> str:
    """Write the caption of Fig. 8, HTML."""
    specimen = escape(validation.attrs.get("record_specimen", "not stated"))
    synthetic = f"<strong>The records are synthetic</strong>: computed in the style of the test ({specimen})."
    first = next(iter(series_by_maker(paper_models(validation)).values()))
    return f"""
    {synthetic if is_synthetic(validation) else f"Specimen: {specimen}."} The models, at
    e&nbsp;=&nbsp;{plain(validation["restitution"])} and with ξ of the polynomials whatever the wall's b<sub>1</sub>,
    reach {by_model(first["peak_ratio_to_measured"], span)} times the largest displacements of the records shown.
    """
