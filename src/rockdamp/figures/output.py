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
from rockdamp.storage.files import replace_file

# fontTools warns at every PDF that the fonts of Matplotlib have an early date.
logging.getLogger("fontTools.ttLib.tables._h_e_a_d").setLevel(logging.ERROR)

# The fields in which formats store the moment of writing; None leaves them out.
_DATES = {"pdf": "CreationDate", "svg": "Date"}
LAID_OUT: dict[Any, Any] = {"figure.constrained_layout.use": False}  # or a figure without a layout engine gets one


def save(figure: Figure, path: str | os.PathLike[str], formats: Iterable[str], resolution: float) -> list[Path]:
    """Write a figure in every format, each file complete or not at all, and return the files.

    `path` is without a suffix; pixel formats have `resolution` dots per inch.
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
            with replace_file(target) as temporary:
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
