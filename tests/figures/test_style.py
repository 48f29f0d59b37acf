"""Text from outside is drawn as it is, and many walls differ."""

import io
import xml.etree.ElementTree as xml

import matplotlib
import pytest
from matplotlib.figure import Figure

from rockdamp.figures.style import literal, pick_look

HOSTILE = ["$\\frac$", "a $ b $ c", "<b>&amp;"]


@pytest.mark.parametrize("text", HOSTILE)
def test_a_name_from_outside_is_drawn_letter_by_letter(text):
    figure = Figure()
    figure.suptitle(literal(text))
    figure.text(0.5, 0.5, f"{literal(text)}, $\\xi = 0.05$")  # beside a formula of ours
    drawn = io.BytesIO()
    with matplotlib.rc_context({"svg.fonttype": "none"}):
        figure.savefig(drawn, format="svg")
    root = xml.fromstring(drawn.getvalue())
    texts = ["".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert text in texts


def test_the_walls_of_a_figure_differ_in_colour_and_marker():
    looks = [pick_look(index) for index in range(24)]
    assert len({(look["color"], look["marker"]) for look in looks}) == 24
    assert len({(look["color"], look["linestyle"]) for look in looks}) == 24
