"""Pictures that the command line draws of a test: its record, and the least squares fitted to it."""

from __future__ import annotations

from textwrap import fill

import xarray as xr
from matplotlib.figure import Figure

from rockdamp.figures.single import ACCELERATION, TIME, record_title
from rockdamp.figures.style import GREY, PALE, line_of, literal, new_figure, styled
from rockdamp.figures.test_series import measured_name
from rockdamp.figures.validation import MEASURED, MILLIMETRES
from rockdamp.laboratory.free_rocking_record import FreeRocking
from rockdamp.motions.records import Record
from rockdamp.vocabulary import REFERENCE

PARAMETERS = {
    "yield_displacement_ratio": "$a_1 = {:.4f} \\pm {:.4f}$",
    "strength_ratio": "$b_1 = {:.4f} \\pm {:.4f}$",
    "restitution": "$e = {:.4f} \\pm {:.4f}$",
}


@styled
def record_figure(record: Record | FreeRocking) -> Figure:
    """Draw the histories of a record, or that of a free-rocking test."""
    shown = [(ACCELERATION, record.ground_acceleration)] if isinstance(record, Record) else []
    if record.displacement is not None:
        shown.append(("$u$ [mm]", MILLIMETRES * record.displacement))
    if isinstance(record, FreeRocking) and record.rotation is not None:
        shown.append((r"rotation [rad]", record.rotation))
    figure = new_figure(20.0 + 42.0 * len(shown))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False).ravel()
    for axes, (label, values) in zip(panels, shown, strict=True):
        axes.plot(record.elapsed, values, color="black", linewidth=0.8)
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
        axes.set_ylabel(label)
    panels[-1].set_xlabel(TIME)
    figure.align_ylabels(panels)
    kind = "SYNTHETIC record" if record.synthetic else "Record"
    figure.suptitle(fill(literal(f"{kind}: {record.header.get('source', 'not stated')}"), 120, max_lines=2), fontsize=8)
    return figure


@styled
def calibration_figure(calibration: xr.Dataset) -> Figure:
    """Draw the measured response and the fitted one, and what is left between them."""
    figure = new_figure(105.0)
    axes, left = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [2.6, 1.0]})
    measured, fitted = (MILLIMETRES * calibration[name] for name in ("measured", "displacement"))
    axes.plot(calibration["elapsed"], measured, label=measured_name(calibration), **MEASURED)
    axes.plot(calibration["elapsed"], fitted, label="fitted, CR", **line_of(REFERENCE))
    values = [calibration[name].sel(parameter=list(PARAMETERS)).values for name in ("estimate", "standard_error")]
    estimates = ",  ".join(text.format(*of_name) for text, *of_name in zip(PARAMETERS.values(), *values, strict=True))
    axes.set(ylabel="$u$ [mm]", title=estimates)
    axes.legend(loc="upper right")
    left.plot(calibration["elapsed"], measured - fitted, color=GREY, linewidth=0.8)
    left.set(ylabel="residual [mm]", xlabel=TIME)
    for each in (axes, left):
        each.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    figure.align_ylabels([axes, left])
    figure.suptitle(record_title(calibration), fontsize=8)
    return figure
