"""Figs 3 and 4: loops of the dampers and decays."""

import numpy as np
import pytest
from figure_reading import drawn, labelled, lines, shows
from made_up_studies import made_up

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.style import style_of


def test_fig3_shows_the_law_of_each_model():
    laws, data = drawn("fig3").axes[0], made_up()["damping_force"]
    for model in PAPER_MODELS:
        assert shows(laws, data["frequency_ratio"], data["damping_ratio_law"].sel(viscous_model=model))


def test_fig3_shows_the_whole_loop_of_every_model_with_its_damping_ratio():
    axes, data = drawn("fig3").axes[1], made_up()["damping_force"]
    for model in PAPER_MODELS:
        one = data.sel(damping_model=model)
        pale, strong = lines(axes, style_of(model).colour)
        assert f"{float(one['damping_ratio']):.4f}" in strong.get_label()
        together = np.concatenate([strong.get_xdata()[:-1], pale.get_xdata()])
        assert together == pytest.approx(one["displacement"].values)
        together = np.concatenate([strong.get_ydata()[:-1], pale.get_ydata()])
        assert together == pytest.approx(one["damping_force"].values)


def test_the_strong_loop_of_fig3_ends_at_the_second_peak_after_the_release():
    strong = lines(drawn("fig3").axes[1], style_of("CDC").colour)[1].get_xdata()
    # The made-up decay has its peaks every pi/1.3 in tau, a little early for its damping.
    assert strong.size * 0.01 == pytest.approx(2 * np.pi / 1.3, rel=0.02)


def test_fig4_shows_three_rocking_decays_in_tau_and_in_seconds():
    axes, data = drawn("fig4").axes[0], made_up()["damping_force"]
    for name in data["rocking_model"].values:
        assert shows(axes, data["tau"], data["rocking_displacement"].sel(rocking_model=name))
    seconds = axes.child_axes[0]
    assert seconds.get_xlim()[1] == pytest.approx(axes.get_xlim()[1] / 3.8)


def test_fig4_shows_the_jump_of_cr_and_the_smooth_velocity_of_cdr():
    _, upper, lower = drawn("fig4").axes
    data = made_up()["damping_force"]
    for axes, variable in ((upper, "displacement"), (lower, "velocity")):
        for model in ("CR", "CDR"):
            line = labelled(axes, model)
            shown_part = data.isel(tau=slice(0, len(line.get_xdata())))
            assert line.get_xdata() == pytest.approx(shown_part["tau"].values)
            assert line.get_ydata() == pytest.approx(shown_part[variable].sel(damping_model=model).values)
    (inset,) = lower.child_axes
    jumps = [np.abs(np.diff(line.get_ydata())).max() for line in inset.get_lines()]
    assert jumps[0] > 5 * jumps[1]  # the inset is where CR jumps
