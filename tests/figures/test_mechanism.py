"""Figs 1 and 2: the two bodies and the force curves."""

import numpy as np
import pytest
from figure_reading import drawn, labelled, shows
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_studies import made_up

from rockdamp.figures.mechanism import bodies

# --- Fig. 1 ----------------------------------------------------------------------------------------------------------


WALLS = {
    "thickness": st.floats(0.05, 1.0),
    "slenderness": st.floats(4.0, 30.0),
    "hinge_ratio": st.floats(0.3, 0.75),
    "part": st.floats(0.0, 1.0),
}


@settings(max_examples=50, deadline=None)
@given(**WALLS)
def test_bodies_keep_their_dimensions_and_pivots(thickness, slenderness, hinge_ratio, part):
    height = slenderness * thickness
    lower, upper = bodies(thickness, height, hinge_ratio, part * thickness)
    for body, tall in ((lower, hinge_ratio * height), (upper, (1 - hinge_ratio) * height)):
        edges = np.diff(np.vstack([body, body[:1]]), axis=0)
        assert np.hypot(*edges.T) == pytest.approx([thickness, tall, thickness, tall])
        assert np.hypot(*(body[2] - body[0])) == pytest.approx(np.hypot(thickness, tall))  # right angles
    assert lower[1] == pytest.approx([thickness, 0.0])  # C' stays
    assert upper[0] == pytest.approx(lower[3])  # both meet at B
    assert lower[3, 0] == pytest.approx(part * thickness)  # which moves by u
    assert upper[2, 0] == pytest.approx(thickness)  # A' moves up, not sideways
    assert upper[2, 1] >= height - 1e-9 * height
    assert lower[:, 1].min() >= -1e-9 * height  # nothing goes into the ground
    assert upper[:, 1].max() == pytest.approx(upper[2, 1])  # nor through the top support


# --- Fig. 2 ----------------------------------------------------------------------------------------------------------


def test_fig2_draws_every_curve_of_the_dataset():
    panels, curves = drawn("fig2").axes, made_up()["mechanism"]
    for name, places in {
        "bi-linear": (0, 1, 2),
        "tri-linear": (0,),
        "steeper": (1,),
        "translated": (1,),
        "new": (2,),
        "moderate": (2,),
        "severe": (2,),
    }.items():
        for place in places:
            assert shows(panels[place], curves["displacement"], curves["force"].sel(curve_name=name)), name


def test_the_secant_of_fig2_runs_from_the_origin_to_the_curve():
    secant = labelled(drawn("fig2").axes[0], "secant")
    (x0, x1), (y0, y1) = secant.get_data()
    curve = made_up()["mechanism"]["force"].sel(curve_name="tri-linear")
    assert (x0, y0) == (0, 0)
    assert y1 == pytest.approx(float(curve.interp(displacement=x1)))
