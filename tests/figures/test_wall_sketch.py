"""The sketch of a wall: its bodies, its sizes and its curve."""

import numpy as np
import xarray as xr
from figure_reading import all_text, texts
from matplotlib.patches import Polygon

from rockdamp.figures.wall_sketch import wall_figure


def facts(hinge_ratio=0.6, overburden_ratio=0.5):
    displacement = np.linspace(0, 200, 50)
    return xr.Dataset(
        {
            "thickness": 0.25,
            "height": 3.0,
            "hinge_ratio": hinge_ratio,
            "overburden_ratio": overburden_ratio,
            "force": ("displacement", np.minimum(displacement, 5.0)),
            "rigid_force": ("displacement", 7.0 - displacement * 7 / 200),
            "corner_displacement": ("corner", [12.0, 55.0, 200.0]),
            "corner_force": ("corner", [5.0, 5.0, 0.0]),
        },
        coords={"displacement": displacement},
    )


def test_a_wall_has_two_bodies_at_rest_and_two_displaced_and_a_parapet_one():
    for hinge, bodies in ((0.6, 4), (np.nan, 2)):
        sketch, _ = wall_figure(facts(hinge)).axes
        assert sum(isinstance(patch, Polygon) for patch in sketch.patches) == bodies


def test_sizes_and_load_are_written_beside_it():
    shown = all_text(wall_figure(facts()))
    assert "$h$ = 3 m" in shown and "$t$ = 0.25 m" in shown and "$h_1$ = 1.8 m" in shown and "$O$ = 0.5 $W$" in shown
    shown = all_text(wall_figure(facts(np.nan, 0.0)))
    assert "hinge" not in shown and "$O$" not in shown


def test_the_curve_is_drawn_whole_beside_the_rigid_law():
    made = facts()
    figure = wall_figure(made)
    figure.draw_without_rendering()
    _, curve = figure.axes
    rigid, own, corners = curve.get_lines()
    np.testing.assert_array_equal(own.get_ydata(), made["force"])
    np.testing.assert_array_equal(rigid.get_ydata(), made["rigid_force"])
    np.testing.assert_array_equal(corners.get_xdata(), made["corner_displacement"])
    assert curve.get_ylim()[0] == 0 and curve.get_ylim()[1] >= float(made["rigid_force"].max())
    assert min(text.get_fontsize() for text in texts(figure)) >= 7


def test_a_slender_and_a_squat_wall_fit_into_the_panel():
    for thickness in (0.1, 1.0):
        figure = wall_figure(facts().assign(thickness=thickness))
        figure.draw_without_rendering()
        sketch = figure.axes[0]
        corners = np.concatenate([patch.get_xy() for patch in sketch.patches if isinstance(patch, Polygon)])
        for axis, (low, high) in enumerate((sketch.get_xlim(), sketch.get_ylim())):
            assert low <= corners[:, axis].min() and corners[:, axis].max() <= high
