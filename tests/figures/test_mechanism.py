"""Figs 1 and 2: the two bodies and the force curves."""

import numpy as np
import pytest
from figure_reading import all_text, drawn, labelled, shows
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_studies import made_up
from matplotlib.patches import Polygon

from rockdamp.figures.bodies import rotation
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


def test_rotations_are_those_of_section_2_for_small_displacements():
    u = 1e-4
    for height in (0.7 * 4.5, 0.3 * 4.5):
        assert rotation(0.3, height, u) == pytest.approx(u / height, rel=1e-3)


def test_fig1_draws_the_wall_rigid_in_both_states():
    rest, displaced = drawn("fig1").axes
    for axes in (rest, displaced):
        assert axes.get_aspect() == 1.0
    shapes = [
        [patch.get_xy()[:4] for patch in axes.patches if isinstance(patch, Polygon) and patch.get_fill()][:2]
        for axes in (rest, displaced)
    ]
    for still, moved in zip(*shapes, strict=True):
        sides = [np.hypot(*np.diff(np.vstack([body, body[:1]]), axis=0).T) for body in (still, moved)]
        assert sides[0] == pytest.approx(sides[1])
    lower, upper = shapes[0]
    assert (lower[3] - lower[0])[1] / (upper[3] - lower[0])[1] == pytest.approx(0.7)  # h1/h of the dataset


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


def test_fig2_marks_the_corners_and_gives_the_presets():
    figure = drawn("fig2")
    above, beside = figure.axes[0].child_axes
    assert above.get_xticks() == pytest.approx([0.04, 0.15, 1.0])
    assert beside.get_yticks() == pytest.approx([0.85, 1.0])
    assert "severe: $a_1 = 0.20$" in all_text(figure)
