"""Local damping beside ECD and ECD16: what the figure shows is what was measured."""

import numpy as np
import pytest
from figure_reading import drawn
from report_content import of_name


def test_each_damper_has_its_medians_by_band_and_bars_of_one_standard_deviation():
    figure, data = drawn("fig_local_damping"), of_name("local_damping")
    assert len(figure.axes) == data.sizes["loading"]
    for axes, name in zip(figure.axes, data["loading"].values, strict=True):
        bars = axes.containers
        assert [container.get_label() for container in bars] == list(data["damping_model"].values)
        for container, model in zip(bars, data["damping_model"].values, strict=True):
            one = data.sel(loading=name, damping_model=model)
            line, _, (lengths,) = container
            np.testing.assert_allclose(line.get_ydata(), one["band_median_ratio"])
            for segment, median, spread in zip(
                lengths.get_segments(), one["band_median_ratio"].values, one["band_log_dispersion"].values, strict=True
            ):
                assert np.log(segment[:, 1] / median) == pytest.approx([-spread, spread])
