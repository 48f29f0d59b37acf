"""What holds a wall: the figure shows what was measured."""

import numpy as np
from figure_reading import drawn
from made_up_studies import made_up


def test_the_floor_of_each_period_and_each_other_assumption_have_their_ratios_with_intervals():
    figure, data = drawn("fig_supports"), made_up()["supports"]
    floor = np.isfinite(data["diaphragm_period"].values)
    left, right = figure.axes
    parts = data.isel(assumption=floor), data.isel(assumption=~floor)
    for axes, part, value in zip((left, right), parts, ("get_ydata", "get_xdata"), strict=True):
        (container,) = axes.containers
        line, _, (lengths,) = container
        whole = part.sel(wall="all")
        np.testing.assert_allclose(getattr(line, value)(), whole["median_intensity_ratio"].values)
        column = 1 if axes is left else 0
        ends = np.array([segment[:, column] for segment in lengths.get_segments()])
        np.testing.assert_allclose(ends, whole["median_intensity_ratio_interval"].values, rtol=1e-12)
        marks = [each for each in axes.lines if each.get_marker() in ("o", "^") and each is not line]
        for wall, of_wall in zip(("tested", "veneer"), marks, strict=True):
            ratio = part["median_intensity_ratio"].sel(wall=wall).values
            np.testing.assert_allclose(getattr(of_wall, value)()[-ratio.size :], ratio)
    np.testing.assert_allclose(left.containers[0][0].get_xdata(), data["diaphragm_period"].values[floor])
    assert [label.get_text() for label in right.get_yticklabels()] == data["assumption"].values[~floor].tolist()
    assert left.lines[1].get_ydata()[0] == 1.0 and left.lines[1].get_xdata()[0] == 0.0  # a rigid floor
