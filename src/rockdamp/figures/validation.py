"""Fig. 8: the models beside a test."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rockdamp.figures.style import (
    DISPLACEMENT,
    PALE,
    line_of,
    literal,
    new_figure,
    paper_models,
    scaling,
    styled,
)

MILLIMETRES = 1000.0
MEASURED: dict[str, Any] = {"color": "#B0B0B0", "linewidth": 2.8}
SHOWN = 0.1  # of the largest motion and displacement: what is drawn begins and ends where they pass it
MARGIN = 0.1  # of what is shown, before and after


def is_synthetic(dataset: xr.Dataset) -> bool:
    """Say whether the record was computed: only one that says it was not counts as a test."""
    return str(dataset.attrs.get("record_synthetic", "yes")) != "no"


def heading(dataset: xr.Dataset) -> str:
    """Return the heading of a figure of a record: its kind and specimen."""
    kind = "SYNTHETIC record" if is_synthetic(dataset) else "Record"
    return fill(literal(f"{kind}: {dataset.attrs.get('record_specimen', 'specimen not stated')}"), 120)


def measured_name(dataset: xr.Dataset) -> str:
    """Return what the record's displacement is called: a synthetic one was not measured."""
    return "SYNTHETIC record" if is_synthetic(dataset) else "measured"


@styled
def fig8(validation: xr.Dataset) -> Figure:
    """Draw the table's motion, and below it the displacement of the record and under each of the paper's models."""
    elapsed, measured = validation["elapsed"], MILLIMETRES * validation["measured"]
    figure = new_figure(120.0)
    above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 2.6]})
    above.plot(elapsed, validation["ground_acceleration"], color="black", linewidth=0.8)
    below.plot(elapsed, measured, label=measured_name(validation), **MEASURED)
    models = paper_models(validation)
    for model in map(str, models["damping_model"].values):
        computed = MILLIMETRES * models["control_displacement"].sel(damping_model=model)
        below.plot(elapsed, computed, label=model, **line_of(model))
    for axes in (above, below):
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    largest = 1.15 * float(np.abs(measured).max())
    above.set(ylabel="$\\ddot u_g$ [m s$^{-2}$]", xlim=shown(validation))
    above.yaxis.set_major_locator(MaxNLocator(4))
    below.set(xlabel="time $t$ [s]", ylabel="mid-height displacement $u$ [mm]", ylim=(-largest, largest))
    u_ins = MILLIMETRES * float(validation["instability_displacement"])
    below.secondary_yaxis("right", functions=scaling(1 / u_ins)).set_ylabel(DISPLACEMENT)
    figure.align_ylabels([above, below])
    figure.suptitle(heading(validation), fontsize=8)
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def shown(validation: xr.Dataset) -> tuple[float, float]:
    """Return the first and last time drawn: the motion and the decay, not the rest before and after. [s]"""
    elapsed = validation["elapsed"].values
    motion, measured = (np.abs(validation[name].values) for name in ("ground_acceleration", "measured"))
    start = elapsed[np.argmax(motion >= SHOWN * motion.max())]
    end = elapsed[np.flatnonzero(measured >= SHOWN * measured.max())[-1]]
    margin = MARGIN * (end - start)
    return max(float(elapsed[0]), start - margin), min(float(elapsed[-1]), end + margin)
