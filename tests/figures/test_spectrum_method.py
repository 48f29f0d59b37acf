"""The figure of the spectrum method shows the stored ratios, and its caption their statistics."""

import numpy as np
from figure_reading import drawn
from made_up_studies import made_up

from rockdamp.figures.code_checks import QUANTILES, fig_spectrum_method_caption
from rockdamp.text import percent


def test_marks_are_the_medians_of_the_walls_and_bars_their_quantiles():
    study = made_up()["spectrum_method"].sel(spectrum_damping="5 %", restitution=0.85)
    panels = drawn("fig_spectrum_method").axes[:2]
    for axes, support in zip(panels, ("ground", "storey"), strict=True):
        at = study.sel(support=support)
        marks = [line for line in axes.get_lines() if line.get_linestyle() == "None"]
        bars = axes.collections
        for mark, bar, capacity in zip(marks, bars, at["capacity"], strict=True):
            of = at.sel(capacity=capacity)
            np.testing.assert_allclose(mark.get_xdata(), of["bias"])
            ends = of["demand_ratio"].quantile(QUANTILES, "record").transpose("wall", "quantile")
            np.testing.assert_allclose([segment[:, 0] for segment in bar.get_segments()], ends)


def test_lines_are_the_shares_that_pass_and_fail_and_the_caption_says_them():
    study = made_up()["spectrum_method"].sel(capacity=0.4)
    axes = drawn("fig_spectrum_method").axes[2]
    lines = [line for line in axes.get_lines() if line.get_label()[0] != "_"]
    shares = study["overall_unsafe_share"].values.reshape(4, -1)
    np.testing.assert_allclose([line.get_ydata() for line in lines], 100 * shares)
    caption = fig_spectrum_method_caption(made_up()["spectrum_method"])
    at = study["overall_unsafe_share"].sel(spectrum_damping="5 %", restitution=0.85)
    assert percent(at.sel(support="ground")) in caption and percent(at.sel(support="storey")) in caption
