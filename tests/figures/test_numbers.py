"""What figures show is what their datasets hold, in the units of the axes."""

from importlib import import_module

import numpy as np
import pytest
from scipy.stats import norm

from rockdamp.figures import FIGURES
from rockdamp.figures.commands import calibration_figure
from rockdamp.figures.earthquakes import envelope
from rockdamp.figures.mechanism import wall_corners
from rockdamp.figures.style import LOOK
from rockdamp.storage import dataset


@pytest.fixture(scope="module")
def draw(minimal):
    """Draw a figure of the minimal build; return its panels and its datasets."""

    def panels(name):
        module, names = FIGURES[name]
        data = [dataset.read(minimal / f"{each}.nc") for each in names]
        return getattr(import_module(f"rockdamp.{module}"), name)(*data).axes, *data

    return panels


def shows(axes, x, y):
    """Whether one of the lines of a panel is these points."""
    return any(
        np.shape(line.get_xdata()) == np.shape(x)
        and np.allclose(line.get_xdata(), x)
        and np.allclose(line.get_ydata(), y, equal_nan=True)
        for line in axes.get_lines()
    )


def assert_bars(axes, index, interval, column=1):
    """The error bars of a set end at an interval, of y unless `column` is 0; what is not finite has none."""
    sets = [container for container in axes.containers if len(container) == 3]
    ends = [segment[:, column] for segment in sets[index][2][0].get_segments() if len(segment)]
    np.testing.assert_allclose(np.reshape(ends, (-1, 2)), interval.values[np.isfinite(interval.values).all(-1)])


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2])
def test_the_drawn_bodies_keep_their_shape_and_touch_at_the_hinge(offset):
    lower, upper = wall_corners(0.3, 4.0, 0.7, offset)
    for corners, height in ((lower, 2.8), (upper, 1.2)):
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        np.testing.assert_allclose(sides, [0.3, height, 0.3, height])
    np.testing.assert_allclose(lower[3], upper[3], atol=1e-12)  # the hinge
    np.testing.assert_allclose(lower[3, 0], offset - 0.15, atol=1e-12)
    np.testing.assert_allclose(lower[1], [0.15, 0.0], atol=1e-12)  # the base corner that it turns about
    np.testing.assert_allclose(upper[1, 0], 0.15)  # the support holds the top


def test_curves_of_the_mechanism(draw):
    panels, data = draw("fig2")
    for axes, names in zip(
        panels, (["tri-linear"], ["steeper", "translated"], ["new", "moderate", "severe"]), strict=True
    ):
        for name in ("bi-linear", *names):
            assert shows(axes, data["displacement"], data["force"].sel(curve_name=name))


def test_laws_and_decays(draw):
    (law, _), data = draw("fig3")
    (rocking, displacement, velocity, _), _ = draw("fig4")
    for model in data["viscous_model"].values[:3]:
        assert shows(law, data["frequency_ratio"], data["damping_ratio_law"].sel(viscous_model=model))
    for model in data["rocking_model"].values:
        assert shows(rocking, data["tau"], data["rocking_displacement"].sel(rocking_model=model))
    for model in ("CR", "CDR"):
        assert shows(displacement, data["tau"], data["displacement"].sel(damping_model=model))
        assert shows(velocity, data["tau"], data["velocity"].sel(damping_model=model))


def test_damping_ratios(draw):
    panels, data = draw("fig5")
    assert len(panels) == 3
    for axes, model in zip(panels, ("CDC", "CDR", "SDR"), strict=True):
        for release in data["release_amplitude"].values:
            one = data.sel(damping_model=model, release_amplitude=release)
            assert shows(axes, data["restitution"], one["damping_ratio"])
            assert shows(axes, data["restitution"], one["damping_ratio_energy"])
        assert axes.get_xticks()[[0, -1]].tolist() == data["restitution"].values[[0, -1]].tolist()
    panels, *studies = draw("fig6")
    for row, study in zip(np.reshape(panels, (3, 3)), studies, strict=True):
        parameter = study["damping_ratio"].dims[1]
        assert shows(row[1], study["restitution"], study["damping_ratio"].sel(damping_model="CDR").isel({parameter: 0}))
    ((axes,), data) = draw("fig6_error")
    error = data["error"].sel(release_amplitude=0.5)
    for model in ("CDC", "CDR", "SDR"):
        assert shows(axes, data["restitution"], error.sel(damping_model=model) ** 0.5)
    (together, *columns), data = draw("fig7")
    for axes in (together, *columns):
        assert shows(axes, data["restitution"], data["giannini_masiani"])
    for index in range(data.sizes["yield_displacement_ratio"]):
        fit = data["damping_ratio_fit"].sel(damping_model="SDR").isel(yield_displacement_ratio=index)
        assert shows(columns[2], data["restitution"], fit)
    ((axes,), data) = draw("fig_amplitude")
    ratio = data["damping_ratio_peaks"].sel(restitution=0.85, method="nearest")
    relative = ratio.sel(damping_model="CDC") / ratio.sel(damping_model="ECD")
    assert shows(axes, data["release_amplitude"], relative)


def test_the_record_is_called_synthetic_and_the_models_lie_beside_it(draw):
    (motion, response), data = draw("fig8")
    assert shows(motion, data["elapsed"], data["ground_acceleration"])
    assert shows(response, data["elapsed"], 1000 * data["measured"])
    for model in ("CR", "CDC", "CDR", "SDR"):
        assert shows(response, data["elapsed"], 1000 * data["control_displacement"].sel(damping_model=model))
    figure = motion.get_figure()
    assert "SYNTHETIC" in figure.get_suptitle() and "SYNTHETIC record" in response.get_legend_handles_labels()[1]


def test_a_calibration_is_drawn_with_what_it_leaves(minimal):
    fit = dataset.read(minimal / "calibration.nc")
    history, residual = calibration_figure(fit).axes
    run = fit.isel(sample=(fit["sample_run"] == 1).values)
    left = 1000 * (run["measured"] - run["control_displacement"])
    assert shows(history, run["elapsed"], 1000 * run["control_displacement"]) and shows(residual, run["elapsed"], left)
    assert f"$e$ = {float(fit['estimate'].sel(parameter='restitution')):.4f} ±" in history.get_title()


def test_errors_under_earthquakes_have_their_intervals(draw):
    panels, data = draw("fig_earthquakes")
    study = data.sel(restitution=0.85, method="nearest").sel(damping_ratio_source="least error")
    for axes, name in zip(panels, ("median_ratio", "log_error"), strict=True):
        for index, model in enumerate(("CDC", "CDR", "SDR", "ECD", "BAND")):
            interval = study[f"{name}_interval"].sel(damping_model=model)
            assert_bars(axes, index, interval)
        tops = [patch.get_y() + patch.get_height() for patch in axes.patches]
        np.testing.assert_allclose(tops, study[f"varied_{name}"].max("variation"))


def test_fragility_curves_are_the_stored_ones(draw):
    panels, data = draw("fig_fragility")
    study = data.sel(restitution=0.85, method="nearest").sel(damping_ratio_source="least error")
    for axes, wall in zip(panels, study["wall"].values, strict=True):
        for model in study["damping_model"].values:
            one = study.sel(wall=wall, damping_model=model)
            curve = next(line for line in axes.get_lines() if line.get_label() == model)
            depth = np.log(curve.get_xdata() / float(one["wall_median_velocity_ratio"])) / float(one["wall_dispersion"])
            np.testing.assert_allclose(curve.get_ydata(), norm.cdf(depth))
        assert shows(axes, study["velocity_ratio"], study["collapse_fraction"].sel(wall=wall, damping_model="CR"))


def test_the_band_of_fragility_holds_every_curve_within_both_intervals():
    level, median, dispersion = np.geomspace(0.2, 5, 41), np.array([0.7, 0.9]), np.array([0.3, 0.5])
    low, high = envelope(level, median, dispersion)
    curves = [norm.cdf(np.log(level / m) / s) for m in np.linspace(*median, 9) for s in np.linspace(*dispersion, 9)]
    np.testing.assert_allclose([low, high], [np.min(curves, axis=0), np.max(curves, axis=0)])


def test_error_against_force(draw):
    (median, quantile, force, velocity), data = draw("fig_order")
    study = data.sel(restitution=0.85, method="nearest")
    for axes, name in ((median, "log_error_median"), (quantile, "log_error_90")):
        for family in ("ECD", "BAND", "CQD"):
            rows = study.isel(damper=np.char.startswith(data["damper"].values.astype(str), family))
            assert shows(axes, rows["crossing_force"].sel(wall="paper"), rows[name])
    decay = data.sel(crossing_damper="BAND0.2")
    (line,) = (line for line in velocity.get_lines() if line.get_label() == "BAND0.2")
    assert np.isin(line.get_ydata(), decay["velocity"]).all()
    lowest = min(line.get_ydata().min() for line in force.get_lines() if len(line.get_xdata()) > 2)
    assert lowest == float(data["damping_force"].min())


def test_assumptions_have_their_ratios_with_intervals(draw):
    (floor, other), data = draw("fig_supports")
    flexible = np.isfinite(data["diaphragm_period"].values)
    for axes, chosen, column in ((floor, flexible, 1), (other, ~flexible, 0)):
        part = data.isel(assumption=chosen)
        assert_bars(axes, 0, part["median_intensity_ratio_interval"].sel(wall="all"), column)
    (collapse, peaks), data = draw("fig_loss_law")
    study = data.sel(wall="all")
    for index, g in enumerate(study["loss_exponent"].values):
        interval = study["median_intensity_ratio_interval"].sel(loss_exponent=g)
        assert_bars(collapse, index, interval)
    middle = study.isel(loss_exponent=study.sizes["loss_exponent"] // 2)
    for index, interval in enumerate(middle["median_ratio_interval"].transpose("reference_amplitude", ...)):
        assert_bars(peaks, index, interval)


def test_convergence_and_slopes(draw):
    panels, data = draw("fig_convergence")
    for axes, (scheme, excitation) in zip(
        panels, [(s, x) for s in ("newmark", "paper") for x in ("free", "forced")], strict=True
    ):
        errors = data["solver_error"].sel(scheme=scheme, excitation=excitation)
        for model in errors["damping_model"].values:
            assert shows(axes, data["step"], errors.sel(damping_model=model))
        guides = [line for line in axes.get_lines() if str(line.get_label()).startswith("slope")]
        slopes = [np.polyfit(np.log(line.get_xdata()), np.log(line.get_ydata()), 1)[0] for line in guides]
        assert slopes == pytest.approx([1, 2])


def test_measured_rocking(draw):
    (exponent, likelihood, restitution), data = draw("fig_measured_rocking")
    assert_bars(exponent, 0, data["amplitude_exponent_interval"], 0)
    behind = data["log_likelihood"] - data["log_likelihood"].sel(damping_model="power law")
    for model in ("CR", "CDC", "CDR", "SDR"):
        assert shows(likelihood, data["impacts_used"], behind.sel(damping_model=model))
    assert_bars(restitution, 0, data["restitution_over_housner_interval"])


def test_a_model_has_one_colour_in_every_figure(draw):
    for name in ("fig4", "fig8", "fig_amplitude", "fig_convergence", "fig_fragility"):
        for axes in draw(name)[0]:
            for line in axes.get_lines():
                if line.get_label() in LOOK:
                    assert line.get_color() == LOOK[line.get_label()]["color"]
