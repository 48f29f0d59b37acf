"""Text from outside is drawn as it is: no formula, no error, nothing that a reader of SVG refuses."""

import io
import xml.etree.ElementTree as xml

import matplotlib
import pytest
from matplotlib.figure import Figure

from rockdamp.figures.style import literal

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
