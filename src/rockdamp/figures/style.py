"""The look that all figures share: colours, panels, axes, error bars, legends, and saving."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator, StrMethodFormatter

from rockdamp.storage.files import replace_file

WIDTH = 190.0  # of a page's text [mm]
COLUMN = 90.0  # of one of its two columns [mm]

# Colours that the colour-blind tell apart (Okabe and Ito); in grey, lines and markers still differ.
LOOK: dict[str, dict[str, Any]] = {
    "CR": {"color": "#1A1A1A", "linestyle": "solid", "marker": "o"},
    "CDC": {"color": "#0072B2", "linestyle": (0, (3.0, 1.4)), "marker": "s"},
    "CDR": {"color": "#D55E00", "linestyle": (0, (8.0, 1.6)), "marker": "^"},
    "SDR": {"color": "#009E73", "linestyle": "dashdot", "marker": "D"},
    "ECD": {"color": "#9A4C95", "linestyle": "dotted", "marker": "v"},
    "BAND": {"color": "#D0267F", "linestyle": (0, (6.0, 1.2, 1.0, 1.2, 1.0, 1.2)), "marker": "X"},
    "CQD": {"color": "#7F7F7F", "linestyle": (0, (3.0, 4.0)), "marker": "<"},
}
GREY = "#6E6E6E"
PALE = "#DADADA"
COLOURS = [
    "#0072B2",
    "#D0267F",
    "#E69F00",
    "#009E73",
    "#56B4E9",
    "#8C6D1F",
    "#9A4C95",
    "#6E6E6E",
]
MARKERS = ["o", "s", "D", "^", "v", "X", "P", "<", ">"]
POINTS: dict[str, Any] = {
    "color": "#1A1A1A",
    "linestyle": "none",
    "marker": "o",
    "markersize": 3.5,
}

RESTITUTION = 0.85  # of the paper's case, where a figure shows one e

DISPLACEMENT = r"$u/u_\mathrm{ins}$ [-]"
TAU = r"dimensionless time $\tau = p\,t$ [-]"

# fontTools warns at every PDF that the fonts of Matplotlib have an early date.
logging.getLogger("fontTools.ttLib.tables._h_e_a_d").setLevel(logging.ERROR)


def look(model: str, **changes: Any) -> dict[str, Any]:
    """Return colour, line and marker of a damping model."""
    return {**LOOK[model], **changes}


def series(index: int, **changes: Any) -> dict[str, Any]:
    """Return colour and marker of one of many curves: the same pair comes back after 72."""
    colour = COLOURS[index % len(COLOURS)]
    marker = MARKERS[index % len(MARKERS)]
    return {"color": colour, "marker": marker, **changes}


def tints(colour: str, count: int) -> list[Any]:
    """Return `count` tints of a colour, light to dark."""
    red_green_blue = np.array(to_rgb(colour))
    # Share of white if positive, of black if negative.
    share = np.linspace(0.55, -0.55, count)[:, None]
    return list(red_green_blue * (1 - abs(share)) + np.maximum(share, 0))


def panels(
    rows: int, columns: int, height: float, width: float = WIDTH, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure in the style of the paper, and its panels, shape (rows, columns).

    Parameters
    ----------
    rows, columns : int
        Number of panels.
    height, width : float
        Size [mm]. Printed at this width, the text has 7 pt or more.
    **options
        Options of `Figure.subplots`.
    """
    matplotlib.style.use(["default", Path(__file__).with_name("paper.mplstyle")])
    figure = Figure(figsize=(width / 25.4, height / 25.4), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def zero_line(axes: Axes) -> None:
    """Draw a pale line at zero, below the curves."""
    axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)


def unit_line(axes: Axes) -> None:
    """Draw a grey line at one, below the curves."""
    axes.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)


def log_ticks(axis: XAxis | YAxis, ticks: Any = None) -> None:
    """Make an axis logarithmic with plain numbers: at `ticks`, or at 1, 2, 5, 10, 20, ..."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    if ticks is None:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    else:
        axis.set_major_locator(FixedLocator(ticks))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))


def error_bars(
    axes: Axes, x: Any, y: Any, interval: xr.DataArray, upright: bool = True, **look: Any
) -> None:
    """Draw points with their intervals.

    Parameters
    ----------
    axes : Axes
        Panel to draw in.
    x, y : array
        Points.
    interval : xarray.DataArray
        Ends of the intervals, along the dimension ``bound``.
    upright : bool
        Whether the intervals are those of y; else of x.
    **look
        Colour, marker and label.
    """
    centre = np.asarray(y if upright else x)
    lengths = np.abs(interval.transpose("bound", ...).values - centre)
    direction = "yerr" if upright else "xerr"
    axes.errorbar(x, y, **{direction: lengths}, elinewidth=0.9, capsize=1.5, **look)


def legend(
    place: Figure | Axes, entries: Iterable[Any], columns: int = 0, title: str | None = None
) -> None:
    """Put a legend where it covers nothing: below a figure, to the right of a panel.

    A figure's legend has one row if `columns` is 0; a panel's has one column.
    """
    entries = list(entries)
    if isinstance(place, Figure):
        columns = columns or len(entries)
        place.legend(handles=entries, loc="outside lower center", ncols=columns, title=title)
        return
    right: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.02, 0.5)}
    place.legend(handles=entries, title=title, alignment="left", **right)


def handles(*axes: Axes) -> list[Any]:
    """Return the labelled curves of some panels, for a legend."""
    entries = []
    for panel in axes:
        panel_handles, _ = panel.get_legend_handles_labels()
        entries += panel_handles
    return entries


def save(figure: Figure, files: Iterable[str | Path], resolution: float) -> None:
    """Write a figure in the formats of the suffixes, the same bytes each time.

    Parameters
    ----------
    figure : Figure
        Figure to write.
    files : sequence of path
        Files to write, each complete or not at all.
    resolution : float
        Dots per inch of raster formats.
    """
    figure.dpi = resolution
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # one layout for all formats
    for file in map(Path, files):
        date = {".pdf": "CreationDate", ".svg": "Date"}.get(file.suffix)
        metadata: dict[str, Any] | None = {date: None} if date else None
        image = io.BytesIO()
        with matplotlib.rc_context({"svg.hashsalt": file.stem}):
            figure.savefig(image, format=file.suffix[1:], dpi=resolution, metadata=metadata)
        file.parent.mkdir(parents=True, exist_ok=True)
        with replace_file(file) as temporary:
            temporary.write_bytes(image.getvalue())
