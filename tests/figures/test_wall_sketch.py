"""The sketch of a wall: its bodies, its sizes and its curve."""

import numpy as np
from figure_reading import all_text
from matplotlib.patches import Polygon

import rockdamp as rd
from rockdamp.figures.mechanism import wall_figure

CURVE = rd.TrilinearCurve(0.04, 0.85)
WALL = rd.Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=0.5)
PARAPET = rd.Parapet(0.25, 3.0)


def test_a_wall_has_two_bodies_at_rest_and_two_displaced_and_a_parapet_one():
    for wall, bodies in ((WALL, 4), (PARAPET, 2)):
        sketch, _ = wall_figure(wall, CURVE).axes
        assert sum(isinstance(patch, Polygon) for patch in sketch.patches) == bodies


def test_sizes_and_load_are_written_beside_it():
    shown = all_text(wall_figure(WALL, CURVE))
    assert "$h$ = 3 m" in shown and "$t$ = 0.25 m" in shown and "$h_1$ = 1.8 m" in shown and "$O$ = 0.5 $W$" in shown
    shown = all_text(wall_figure(PARAPET, CURVE))
    assert "hinge" not in shown and "$O$" not in shown


def test_the_curve_is_drawn_whole_beside_the_rigid_law():
    _, axes = wall_figure(WALL, CURVE).axes
    u_ins, strength = 1000 * float(WALL.instability_displacement), float(WALL.rigid_strength) / 1000
    rigid, trilinear, corners = axes.get_lines()
    ratio = trilinear.get_xdata() / u_ins
    np.testing.assert_allclose(trilinear.get_ydata(), strength * CURVE.force(ratio))
    np.testing.assert_allclose(rigid.get_ydata(), strength * (1 - ratio), atol=1e-12)
    np.testing.assert_allclose(corners.get_xdata(), u_ins * np.array([0.04, 0.15, 1.0]))
    assert axes.get_ylim()[0] == 0 and axes.get_ylim()[1] >= strength
