"""Figures to files, complete or not at all and the same bytes each time."""

from __future__ import annotations

import io
import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rockdamp.figures.style import STYLE
from rockdamp.storage.atomic import replacing

# The fonts that matplotlib brings carry an early date of their making, which fontTools remarks on at every PDF.
logging.getLogger("fontTools.ttLib.tables._h_e_a_d").setLevel(logging.ERROR)

# What each format would store of the moment of writing; None leaves it out.
_DATES = {"pdf": "CreationDate", "svg": "Date"}
LAID_OUT: dict[Any, Any] = {"figure.constrained_layout.use": False}  # or a figure without a layout engine gets one


def save(figure: Figure, path: str | os.PathLike[str], formats: Iterable[str], resolution: float) -> list[Path]:
    """Write a figure in every format.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : path
        Without suffix: that of each format is appended. Files are replaced only by complete ones.
    formats : iterable of str
        E.g. ``("pdf", "png")``.
    resolution : float
        Of pixel formats. [dots per inch]

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ValueError
        If matplotlib does not know a format.
    OSError
        If a file cannot be written.
    """
    written = []
    base = Path(path)
    base.parent.mkdir(parents=True, exist_ok=True)
    settings: dict[Any, Any] = {**LAID_OUT, "svg.hashsalt": base.name}
    with matplotlib.style.context([STYLE, settings], after_reset=True), _laid_out(figure, resolution):
        for suffix in formats:
            target = base.with_name(f"{base.name}.{suffix}")
            metadata = {_DATES[suffix]: None} if suffix in _DATES else {}
            drawn = io.BytesIO()  # matplotlib's writers hide what went wrong with a disk
            figure.savefig(drawn, format=suffix, dpi=resolution, metadata=metadata)
            with replacing(target) as temporary:
                temporary.write_bytes(drawn.getvalue())
            written.append(target)
    return written


@contextmanager
def _laid_out(figure: Figure, resolution: float) -> Iterator[None]:
    """Lay a figure out once for all formats; each would do it anew, and draw all of it once more for that."""
    engine, dpi = figure.get_layout_engine(), figure.dpi
    if engine is None:
        yield
        return
    FigureCanvasAgg(figure)  # measures the text
    figure.dpi = resolution
    try:
        engine.execute(figure)
        figure.set_layout_engine(None)
        yield
    finally:
        figure.dpi = dpi
        figure.set_layout_engine(engine)
