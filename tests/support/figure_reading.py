"""Figures drawn from the made-up datasets, and what can be read from a drawn figure."""

from functools import cache

import numpy as np
import pytest
from figure_functions import FIGURES, INPUTS
from made_up_studies import made_up
from matplotlib.axis import Axis
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from report_content import of_name

# --- made-up datasets: smooth functions of the right shape, no solver ------------------------------------------------


def draw(name):
    """Draw a figure; a dataset of which no smooth one was made up has values of chance."""
    smooth = made_up()
    return FIGURES[name](*(smooth[source] if source in smooth else of_name(source) for source in INPUTS[name]))


@cache
def drawn(name):
    """A figure with everything in its final place."""
    figure = draw(name)
    figure.draw_without_rendering()
    return figure


# --- reading a figure ------------------------------------------------------------------------------------------------


def lines(axes, colour=None):
    found = [line for line in axes.get_lines() if line.get_xdata().__len__() > 2]
    return [line for line in found if colour is None or to_rgb(line.get_color()) == pytest.approx(to_rgb(colour))]


def shows(axes, x, y):
    """Whether one of the lines of a panel is exactly these points."""
    return any(
        np.shape(line.get_ydata()) == np.shape(y)
        and np.allclose(line.get_xdata(), x, rtol=1e-12)
        and np.allclose(line.get_ydata(), y, rtol=1e-12, atol=1e-15, equal_nan=True)
        for line in axes.get_lines()
    )


def begins(text, start):
    """Whether a text begins with whole words: "ECD" and "ECD (exact)" with "ECD", "ECDX" not."""
    return str(text).startswith(start) and not str(text)[len(start) :][:1].isalnum()


def labelled(axes, start):
    (found,) = (line for line in axes.get_lines() if begins(line.get_label(), start))
    return found


def texts(figure):
    """Every text that is seen, tick labels and legends included."""
    on_ticks, seen = set(), []
    for axis in figure.findobj(Axis):
        low, high = sorted(axis.get_view_interval())
        slack = 1e-6 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            on_ticks |= {tick.label1, tick.label2}
            if axis.axes.axison and axis.get_visible() and low - slack <= tick.get_loc() <= high + slack:
                seen += [tick.label1, tick.label2]
    seen += [text for text in figure.findobj(Text) if text not in on_ticks]
    off = {axes.xaxis.label for axes in figure.axes if not axes.axison}
    off |= {axes.yaxis.label for axes in figure.axes if not axes.axison}
    return [text for text in seen if text.get_text().strip() and text.get_visible() and text not in off]


def all_text(figure):
    """Every text that is seen, a line each: a title broken into several lines is one text."""
    return "\n".join(" ".join(text.get_text().split()) for text in texts(figure))


def panel_titled(figure, start):
    (found,) = (axes for axes in figure.axes if begins(axes.get_title(), start))
    return found
