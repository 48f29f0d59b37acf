"""Fig. 8: the displacement of a wall on a shaking table, and that of each of the paper's models."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from markupsafe import escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from rockdamp.figures.style import GREY, PALE, by_model, line_of, literal, new_figure, papers, style_of, styled
from rockdamp.figures.test_series import amplitudes, heading, is_synthetic, measured_name, series_by_maker
from rockdamp.text import listed, plain, span
from rockdamp.vocabulary import REFERENCE

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
    (maker, first), *others = series_by_maker(papers(validation)).items()
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
        Line2D([], [], label="computed; peak over that of the record", **line_of(REFERENCE)),
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
    outcome = "collapsed" if bool(of_model["collapsed"]) else f"peak × {ratio:.2f}"
    colour = style_of(model).colour
    axes.text(0.02, 0.96, model, transform=axes.transAxes, va="top", fontsize=7, color=colour, weight="bold")
    axes.text(0.98, 0.04, outcome, transform=axes.transAxes, ha="right", va="bottom", fontsize=7)


def fig8_caption(validation: xr.Dataset) -> str:
    """Write the caption of Fig. 8, HTML."""
    specimen = escape(validation.attrs.get("record_specimen", "not stated"))
    synthetic = (
        f"<strong>The records are synthetic</strong>: computed in the style of the test, since the laboratory's is not "
        f"public ({specimen})."
    )
    first = next(iter(series_by_maker(papers(validation)).values()))
    free = int((first["half_cycle_free"] == 1).sum())
    misfits = by_model(1000 * first["decay_peak_misfit"], span)
    decay = f"Over the {free} half cycles of free decay, their peaks are off by {misfits}&nbsp;mm (root mean square)."
    pushed = (
        "No half cycle of the decay is free: the motion pushes the wall until its response is lost in the noise of the "
        "sensor. So the record says nothing of peaks in a free decay."
    )
    return f"""
    {synthetic if is_synthetic(validation) else f"Specimen: {specimen}."} The largest displacement of the records is
    {listed(f"{amplitude:.2f}" for amplitude in amplitudes(first))}&nbsp;u<sub>ins</sub>. The models, at
    e&nbsp;=&nbsp;{plain(validation["restitution"])} and with ξ of Fig.&nbsp;7, for its b<sub>1</sub> whatever the
    wall's, reach {by_model(first["peak_ratio_to_measured"], span)} times that. {decay if free else pushed}
    """
