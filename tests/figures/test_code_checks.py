"""The figure of a code's check shows the stored medians with their intervals, and its caption says them."""

import numpy as np
from figure_reading import drawn
from made_up_studies import made_up

from rockdamp.figures.code_checks import fig_code_checks_caption
from rockdamp.text import number


def test_marks_and_bars_are_the_medians_and_their_intervals():
    study = made_up()["code_checks"].isel(period_range=0)
    for axes, state in zip(drawn("fig_code_checks").axes, ("SLV", "SLC"), strict=True):
        at = study.sel(limit_state=state)
        for bars, factor in zip(axes.containers, at["confidence_factor"], strict=True):
            of = at.sel(confidence_factor=factor, restitution_rule="measured")
            line, _, (lengths,) = bars
            np.testing.assert_allclose(line.get_xdata(), of["median_demand_ratio"])
            known = np.isfinite(of["median_demand_ratio"].values)
            ends = [segment[:, 0] for segment in lengths.get_segments() if len(segment)]
            np.testing.assert_allclose(ends, of["median_demand_ratio_interval"].values[known])
        (crosses,) = [line for line in axes.lines if line.get_marker() == "x"]
        alike = at.isel(confidence_factor=0).sel(restitution_rule="one for all")
        np.testing.assert_allclose(crosses.get_xdata(), alike["median_demand_ratio"])


def test_the_caption_says_where_the_formulas_come_from_and_what_they_give():
    study = made_up()["code_checks"]
    caption = " ".join(fig_code_checks_caption(study).split())
    assert "after a transcription that has not been compared with the official gazette" in caption
    whole = study["median_demand_ratio"].sel(wall="all", period_range="from the first branch on")
    for state in ("SLV", "SLC"):
        for factor in (1.0, 1.35):
            value = whole.sel(limit_state=state, confidence_factor=factor, restitution_rule="measured")
            assert f"{number(value)} (" in caption
    assert number(whole.sel(limit_state="SLV", confidence_factor=1.0, restitution_rule="one for all")) in caption
