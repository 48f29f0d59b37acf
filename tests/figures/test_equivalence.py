"""Figs 5 to 7: matched damping ratios, their errors and polynomials."""

import numpy as np
import pytest
from figure_reading import all_text, drawn, labelled, lines, shows
from made_up_studies import STEPS, E, made_up

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.equivalence import PAPER_RANGE
from rockdamp.figures.style import style_of


def test_fig5_shows_the_papers_amplitudes_and_no_others_with_the_closed_form():
    data = made_up()["match/amplitude"]
    for model, axes in zip(PAPER_MODELS, drawn("fig5").axes, strict=True):
        assert axes.get_title().startswith(model)
        assert len(lines(axes)) == 6
        for amplitude in (0.9, 0.5, 0.3):
            one = data.sel(damping_model=model, release_amplitude=amplitude)
            assert shows(axes, E, one["damping_ratio"])
            assert shows(axes, E, one["damping_ratio_energy"])
            matched = labelled(axes, rf"$u_0/u_\mathrm{{ins}} = {amplitude:g}$")
            assert matched.get_ydata() == pytest.approx(one["damping_ratio"].values)


def test_fig6_shows_every_wall_and_what_a_length_in_seconds_changes():
    panels = np.reshape(drawn("fig6").axes, (5, len(PAPER_MODELS)))
    for strips, row, name, parameter in (
        (panels[0], panels[1], "slenderness", "slenderness"),
        (panels[2], panels[3], "overburden", "overburden_ratio"),
    ):
        data = made_up()[f"match/{name}"]
        for column, model in enumerate(PAPER_MODELS):
            for value in data[parameter].values:
                one = data.sel({"damping_model": model, parameter: value})
                fixed = one["damping_ratio_fixed_seconds"]
                assert shows(row[column], E, one["damping_ratio"])
                assert shows(row[column], E, fixed)
                assert shows(strips[column], E, 1000 * (fixed - one["damping_ratio"]))


def test_fig6_shows_a1_only_where_the_plateau_is_the_first_ones():
    row, data = np.reshape(drawn("fig6").axes, (5, len(PAPER_MODELS)))[4], made_up()["match/cracked_stiffness"]
    for axes, model in zip(row, PAPER_MODELS, strict=True):
        assert len(lines(axes)) == 3
        for a1 in (0.02, 0.04, 0.14):
            assert shows(axes, E, data["damping_ratio"].sel(damping_model=model, yield_displacement_ratio=a1))
    legend = row[-1].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["0.02", "0.04", "0.14"]
    assert "0.85" in legend.get_title().get_text()


def test_fig6_error_shows_the_root_of_err_and_the_papers_range():
    axes, data = drawn("fig6_error").axes[0], made_up()["match/amplitude"].sel(release_amplitude=0.5)
    for model in PAPER_MODELS:
        assert labelled(axes, model).get_ydata() == pytest.approx(
            np.sqrt(data["error"].sel(damping_model=model).values)
        )
    (shaded,) = axes.patches
    assert (shaded.get_x(), shaded.get_x() + shaded.get_width()) == pytest.approx(PAPER_RANGE)
    assert PAPER_RANGE == (0.80, 0.91)  # Section 6
    # The second axis is the root mean square, in thousandths.
    assert f"k = {STEPS}" in axes.get_title()
    (beside,) = axes.child_axes
    assert beside.get_ylim()[1] == pytest.approx(1000 * axes.get_ylim()[1] / np.sqrt(STEPS))


def test_fig6_error_names_the_model_with_the_lowest_error():
    axes = drawn("fig6_error").axes[0]
    rows = {line.get_marker(): line.get_xdata() for line in axes.get_lines() if line.get_linestyle() == "None"}
    assert rows[style_of("SDR").marker] == pytest.approx(E[E < 0.795])
    assert rows[style_of("CDR").marker] == pytest.approx(E[E > 0.795])
    assert rows[style_of("CDC").marker].size == 0


def test_fig7_shows_polynomials_matched_points_and_equation_15():
    together, *panels = drawn("fig7").axes
    data = made_up()["equivalence"]
    for axes in (together, *panels):
        assert shows(axes, E, data["giannini_masiani"])
    for axes, model in zip(panels, PAPER_MODELS, strict=True):
        assert axes.get_title().startswith(model)
        markers = [line.get_marker() for line in axes.get_legend().get_lines()]
        assert len(set(markers)) == data.sizes["yield_displacement_ratio"]  # told apart without colour
        for a1, marker in zip(data["yield_displacement_ratio"].values, markers, strict=True):
            one = data.sel(damping_model=model, yield_displacement_ratio=a1)
            assert shows(axes, E, one["damping_ratio_fit"])
            (points,) = (
                line
                for line in axes.get_lines()
                if line.get_marker() == marker and line.get_ydata()[0] == float(one["damping_ratio"][0])
            )
            assert np.all(np.isin(points.get_ydata(), one["damping_ratio"]))
        fit = data["damping_ratio_fit"].sel(damping_model=model)
        assert labelled(together, model).get_ydata() == pytest.approx(fit.sel(yield_displacement_ratio=0.04).values)
    # Rounded down: a figure must not claim more than the least fit.
    assert "0.9987" in all_text(drawn("fig7"))
