"""Which damping ratio stands for which restitution: exact where it can be, else read off the matched ratios."""

import re

import numpy as np
import pytest
import xarray as xr
from figure_functions import FIGURES
from made_up_studies import VISCOUS, made_up
from matplotlib.colors import to_rgb
from repository import ROOT

from rockdamp.figures.code_checks import (
    LEVELS,
    ORDERS,
    fig_code_damping_caption,
    released_as_the_paper,
    restitution_of,
    secant_restitution_of,
)
from rockdamp.figures.style import style_of
from rockdamp.mechanics.damping.ecd import log_decrement
from rockdamp.text import number
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER


def test_a_damping_ratio_stands_for_the_e_that_it_is_matched_to_and_between_them_for_one_between():
    e = [0.7, 0.8, 0.98]
    ratio = {"damping_ratio": (("damping_model", "restitution"), [[0.09, 0.05, 0.01]])}
    secant = {"damping_ratio_secant": (("release_amplitude", "restitution"), [[0.09, 0.05, 0.01]])}
    coords = {"damping_model": ["CDR"], "restitution": e, "release_amplitude": [0.5]}
    match = xr.Dataset(ratio | secant, coords=coords)
    for xi, e in ((0.09, 0.7), (0.07, 0.75), (0.05, 0.8), (0.02, 0.935), (0.01, 0.98)):
        assert restitution_of(match, "CDR", xi) == pytest.approx(e, rel=1e-12)
        assert secant_restitution_of(match, 0.5, xi) == pytest.approx(e, rel=1e-12)
    assert np.isnan([restitution_of(match, "CDR", xi) for xi in (0.0, 0.0099, 0.0901, 0.5)]).all()


def test_exact_dampers_are_drawn_exactly_and_the_others_as_matched_with_the_levels_marked():
    amplitude = made_up()["match/amplitude"]
    match = released_as_the_paper(amplitude)
    assert float(match["release_amplitude"]) == 0.5
    (axes,) = FIGURES["fig_code_damping"](amplitude).axes
    for model in VISCOUS:
        lines = [line for line in axes.get_lines() if to_rgb(line.get_color()) == to_rgb(style_of(model).colour)]
        (curve,) = (line for line in lines if line.get_marker() == "None")
        (marks,) = (line for line in lines if line.get_marker() == ".")
        np.testing.assert_array_equal(curve.get_xdata(), match["restitution"])
        np.testing.assert_allclose(marks.get_ydata(), 100 * np.array(LEVELS))
        if model in ORDERS:
            e = np.exp(-log_decrement(curve.get_ydata() / 100, ORDERS[model]))
            np.testing.assert_allclose(e, curve.get_xdata(), rtol=1e-12)
        else:
            np.testing.assert_allclose(curve.get_ydata(), 100 * match["damping_ratio"].sel(damping_model=model))
        of_line = np.interp(marks.get_ydata(), curve.get_ydata()[::-1], curve.get_xdata()[::-1])
        known = np.isfinite(marks.get_xdata())
        assert known.any()
        np.testing.assert_allclose(marks.get_xdata()[known], of_line[known], atol=1e-4)


def test_the_figure_has_the_numbers_of_the_page():
    page = (ROOT / "docs/howto/order-m-damper-elsewhere.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| (0\.\d{4}) \| (0\.\d{4}) \|", page, flags=re.MULTILINE)
    assert [float(xi) / 100 for xi, *_ in rows] == list(LEVELS)
    for xi, *columns in rows:
        for model, e in zip(ORDERS, columns, strict=True):
            assert f"{restitution_of(None, model, float(xi) / 100):.4f}" == e


def test_the_caption_says_which_e_five_per_cent_stand_for_in_each_reading():
    amplitude = made_up()["match/amplitude"]
    caption = " ".join(fig_code_damping_caption(amplitude).split()).replace("\u00a0", " ")
    assert f"e&nbsp;=&nbsp;{np.exp(-log_decrement(0.05, RECOMMENDED_ORDER)):.4f} under {RECOMMENDED}" in caption
    match = released_as_the_paper(amplitude)
    for model in PAPER_MODELS:
        ratio = match["damping_ratio"].sel(damping_model=model)
        e = np.interp(0.05, ratio.values[::-1], ratio["restitution"].values[::-1])
        assert f"{number(e)} ({model})" in caption
