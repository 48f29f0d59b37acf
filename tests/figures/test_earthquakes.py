"""What the figures on earthquakes show: the made-up numbers, and NaN without complaint."""

import made_up_earthquakes as earthquakes
import numpy as np
import pytest
from figure_functions import FIGURES
from figure_reading import begins
from matplotlib.colors import to_rgb
from scipy.special import ndtr

from rockdamp.figures.collapse import envelope
from rockdamp.figures.style import style_of

VISCOUS = earthquakes.MODELS[1:]


@pytest.fixture(scope="module")
def comparison():
    return earthquakes.comparison()


def panel(figure, start):
    (found,) = (axes for axes in figure.axes if begins(axes.get_title(), start))
    return found


def coloured(axes, model):
    colour = pytest.approx(to_rgb(style_of(model).colour))
    return [line for line in axes.get_lines() if to_rgb(line.get_color()) == colour]


def test_each_history_of_the_pooled_walls_is_a_cell_or_a_mark_at_the_margin(comparison):
    study = earthquakes.earthquakes()
    figure = FIGURES["fig_earthquakes"](study, comparison)
    pooled = comparison["pooled"].sel(damping_ratio_source="least error").values == 1
    one = study.sel(restitution=0.85, damping_ratio_source="least error").isel(wall=pooled)
    fell = (one["collapsed"].sel(damping_model="CR") == 1).values.ravel()
    for model in VISCOUS:
        axes = panel(figure, model)
        other = (one["collapsed"].sel(damping_model=model) == 1).values.ravel()
        cells = axes.collections[0].get_array()
        assert cells.sum() == (~fell & ~other).sum()
        marks = {line.get_marker(): len(line.get_xdata()) for line in coloured(axes, model)}
        assert marks == {"|": (~fell & other).sum(), "_": (fell & ~other).sum()}
        assert f"missed {(fell & ~other).sum()} of {fell.sum()} collapses" in axes.get_title()
    assert sum((~fell & (one["collapsed"].sel(damping_model=model) == 1).values.ravel()).sum() for model in VISCOUS)


@pytest.mark.parametrize("place, name", [(0, "median_ratio"), (1, "log_error")])
def test_bands_show_every_damper_its_interval_and_what_moves_cr_itself(comparison, place, name):
    axes = FIGURES["fig_earthquakes_ratio"](comparison).axes[place]
    one = comparison.sel(restitution=0.85)
    for model in VISCOUS:
        values = one.sel(damping_model=model, damping_ratio_source="least error")
        (markers,) = coloured(axes, model)
        assert markers.get_ydata() == pytest.approx(values[name].values)
        ends = [
            [segment[:, 1] for segment in lines.get_segments()]
            for lines in axes.collections
            if to_rgb(lines.get_color()[0][:3]) == pytest.approx(to_rgb(style_of(model).colour))
        ]
        assert np.array(ends[0]) == pytest.approx(values[f"{name}_interval"].values)
    tops = [patch.get_y() + patch.get_height() for patch in axes.patches]
    assert tops == pytest.approx(one[f"varied_{name}"].max("variation").values)


def test_the_misfit_is_drawn_against_the_scale_with_the_share_that_stands(comparison):
    _, _, axes, share = FIGURES["fig_earthquakes_ratio"](comparison).axes
    one = comparison.sel(restitution=0.85, damping_ratio_source="least error")
    for model in VISCOUS:
        (line,) = coloured(axes, model)
        assert line.get_xdata() == pytest.approx(earthquakes.SCALE)
        assert line.get_ydata() == pytest.approx(one["median_decay_misfit"].sel(damping_model=model).values)
    pooled = one.isel(wall=np.flatnonzero(one["pooled"].values == 1))
    collapsed = pooled["collapse_fraction"].sel(damping_model="CR").mean("wall")
    assert share.lines[0].get_ydata() == pytest.approx(100 * (1 - collapsed.values))


def test_medians_of_the_analyses_end_with_a_marker_where_the_wall_last_stands(comparison):
    figure = FIGURES["fig_ida"](comparison, earthquakes.walls())
    for wall in earthquakes.WALLS:
        one = comparison["fractile"].sel(
            restitution=0.85, damping_ratio_source="least error", wall=wall, fractile_probability=0.5
        )
        for model in earthquakes.MODELS:
            peaks = one.sel(damping_model=model).values
            (median,) = (
                line for line in coloured(panel(figure, wall), model) if line.get_marker() == style_of(model).marker
            )
            assert median.get_ydata() == pytest.approx(earthquakes.SCALE)
            assert median.get_xdata() == pytest.approx(peaks, nan_ok=True)
            (last,) = median.get_markevery()
            assert np.isfinite(peaks[last]) and not np.isfinite(peaks[last + 1 :]).any()


def test_fragility_curves_are_the_stored_lognormal_ones_with_the_share_of_records(comparison):
    figure = FIGURES["fig_fragility"](comparison, earthquakes.walls())
    one = comparison.sel(restitution=0.85, damping_ratio_source="least error", wall="church")
    axes = panel(figure, "church")
    for model in earthquakes.MODELS:
        curve = next(line for line in coloured(axes, model) if line.get_label() == model)
        median, beta = (
            float(one.sel(damping_model=model)[f"wall_{name}"]) for name in ("median_velocity_ratio", "dispersion")
        )
        assert curve.get_ydata() == pytest.approx(ndtr(np.log(curve.get_xdata() / median) / beta))
    (points,) = (line for line in axes.get_lines() if line.get_linestyle() == "None")
    assert points.get_ydata() == pytest.approx(one["collapse_fraction"].sel(damping_model="CR").values)


def test_the_ratios_of_medians_stand_at_every_e_with_their_intervals(comparison):
    figure = FIGURES["fig_fragility"](comparison, earthquakes.walls())
    for e in earthquakes.E:
        axes = panel(figure, f"$e = {e:g}$")
        one = comparison.sel(restitution=e)
        for model in VISCOUS:
            drawn = coloured(axes, model)
            points = [line.get_xdata()[0] for line in drawn if line.get_marker() != "None"]
            ends = [list(line.get_xdata()) for line in drawn if line.get_marker() == "None"]
            assert points == pytest.approx(one["median_intensity_ratio"].sel(damping_model=model).values)
            assert np.array(ends) == pytest.approx(
                one["median_intensity_ratio_interval"].sel(damping_model=model).values
            )


def test_the_band_of_a_fragility_curve_holds_every_curve_within_both_intervals():
    s, median, beta = np.geomspace(0.2, 5, 41), np.array([0.7, 0.9]), np.array([0.3, 0.5])
    low, high = envelope(s, median, beta)
    touched = []
    for m in np.linspace(*median, 9):
        for b in np.linspace(*beta, 9):
            curve = ndtr(np.log(s / m) / b)
            assert np.all(low <= curve + 1e-12) and np.all(curve <= high + 1e-12)
            touched.append(curve)
    assert np.min(touched, axis=0) == pytest.approx(low) and np.max(touched, axis=0) == pytest.approx(high)


@pytest.mark.parametrize("name", ["fig_earthquakes_ratio", "fig_ida", "fig_fragility"])
def test_a_study_too_small_for_any_statistic_is_drawn_empty(comparison, name):
    statistics = [key for key, values in comparison.data_vars.items() if values.dtype.kind == "f"]
    empty = comparison.assign({key: comparison[key] * np.nan for key in statistics})
    inputs = [empty.isel(restitution=slice(2), wall=slice(2))]
    inputs += [earthquakes.walls()] if name in ("fig_ida", "fig_fragility") else []
    FIGURES[name](*inputs).draw_without_rendering()


@pytest.mark.parametrize(("name", "side"), [("fig_ida", "y"), ("fig_fragility", "x")])
def test_a_second_axis_has_the_ground_velocity_of_each_scale(comparison, name, side):
    """PGV = s p u_ins/lambda, lambda = 1.5."""
    walls = earthquakes.walls()
    figure = FIGURES[name](comparison, walls)
    figure.draw_without_rendering()
    for wall in earthquakes.WALLS:
        axes = panel(figure, wall)
        of_wall = walls.sel(wall=wall)
        unit = float(of_wall["frequency_parameter"] * of_wall["instability_displacement"]) / 1.5
        (second,) = axes.child_axes
        scales, velocities = (getattr(each, f"get_{side}lim")() for each in (axes, second))
        assert velocities == pytest.approx([unit * scale for scale in scales])
