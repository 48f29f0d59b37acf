"""A record to look at: the motion of the supports and, where it was measured, the wall's displacement."""

from __future__ import annotations

from textwrap import fill

from matplotlib.figure import Figure

from rockdamp.figures.single import ACCELERATION, TIME
from rockdamp.figures.style import PALE, literal, new_figure, styled
from rockdamp.figures.validation import MILLIMETRES
from rockdamp.motions.free_rocking import FreeRocking
from rockdamp.motions.records import Record


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
