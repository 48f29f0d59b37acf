"""What a constant e costs: the figure shows what was measured."""

import numpy as np
from figure_reading import drawn
from made_up_studies import made_up


def test_each_exponent_has_its_medians_and_each_amplitude_its_peaks_with_their_intervals():
    figure, data = drawn("fig_loss_law"), made_up()["loss_law"].isel(wall=0)
    left, right = figure.axes
    for axes, dimension, name, other in (
        (left, "loss_exponent", "median_intensity_ratio", {}),
        (right, "reference_amplitude", "median_ratio", {"loss_exponent": data.sizes["loss_exponent"] // 2}),
    ):
        assert len(axes.containers) == data.sizes[dimension]
        for container, value in zip(axes.containers, data[dimension].values, strict=True):
            one = data.isel(other).sel({dimension: value})
            line, _, (lengths,) = container
            np.testing.assert_allclose(line.get_ydata(), one[name].values.ravel())
            ends = np.array([segment[:, 1] for segment in lengths.get_segments()])
            np.testing.assert_allclose(ends, one[f"{name}_interval"].values.reshape(-1, 2))
