"""Text from outside is drawn as it is: no formula, no error, nothing that a reader of SVG refuses."""

import io
import re
import xml.etree.ElementTree as xml

import matplotlib
import pytest
from matplotlib.figure import Figure

from rockdamp.figures.style import literal

HOSTILE = ["$\\frac$", "a $ b $ c", "{x} \\frac{", "\\$ $", "<b>&amp;", "a\x1b[2J\x00", "a\nb\u2028"]


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
    shown = " ".join(text.split()).replace("\x1b", "\\x1b").replace("\x00", "\\x00")
    if "\\$" not in text:
        assert shown in texts
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028]", "".join(texts))
