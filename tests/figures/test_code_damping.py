"""Which restitution a code's damping ratio stands for: read off the matched ratios, and nothing beyond them."""

import numpy as np
import pytest
import xarray as xr
from figure_functions import FIGURES
from made_up_studies import VISCOUS, made_up
from matplotlib.colors import to_rgb

from rockdamp.figures.code_damping import LEVELS, released_as_the_paper, restitution_of
from rockdamp.figures.style import style_of


def test_a_damping_ratio_stands_for_the_e_that_it_is_matched_to_and_between_them_for_one_between():
    match = xr.Dataset(
        {"damping_ratio": (("damping_model", "restitution"), [[0.09, 0.05, 0.01]])},
        coords={"damping_model": ["CDR"], "restitution": [0.7, 0.8, 0.98]},
    )
    for xi, e in ((0.09, 0.7), (0.07, 0.75), (0.05, 0.8), (0.02, 0.935), (0.01, 0.98)):
        assert restitution_of(match, "CDR", xi) == pytest.approx(e, rel=1e-12)
    assert np.isnan([restitution_of(match, "CDR", xi) for xi in (0.0, 0.0099, 0.0901, 0.5)]).all()


def test_the_levels_of_codes_are_marked_on_each_damper_s_line_at_the_paper_s_amplitude():
    amplitude = made_up()["match/amplitude"]
    match = released_as_the_paper(amplitude)
    assert float(match["release_amplitude"]) == 0.5
    (axes,) = FIGURES["fig_code_damping"](amplitude).axes
    for model in VISCOUS:
        lines = [line for line in axes.get_lines() if to_rgb(line.get_color()) == to_rgb(style_of(model).colour)]
        (curve,) = (line for line in lines if line.get_marker() == "None")
        np.testing.assert_allclose(curve.get_xdata(), 100 * match["damping_ratio"].sel(damping_model=model))
        np.testing.assert_array_equal(curve.get_ydata(), match["restitution"])
        (marks,) = (line for line in lines if line.get_marker() == ".")
        np.testing.assert_allclose(marks.get_xdata(), 100 * np.array(LEVELS))
        of_line = np.interp(marks.get_xdata(), curve.get_xdata()[::-1], curve.get_ydata()[::-1])
        known = np.isfinite(marks.get_ydata())
        assert known.any()
        np.testing.assert_allclose(marks.get_ydata()[known], of_line[known])
