"""Figures show the numbers of their datasets, in the units of the axes."""

from importlib import import_module

import numpy as np
import pytest
from scipy.stats import norm

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.figures import FIGURES
from rockdamp.figures.commands import calibration_figure
from rockdamp.figures.earthquakes import envelope
from rockdamp.figures.mechanism import wall_corners
from rockdamp.figures.style import LOOK
from rockdamp.storage import dataset

PAPER = ("CDC", "CDR", "SDR")
TRACES = ("CR", *PAPER)


@pytest.fixture(scope="module")
def draw(minimal):
    """Draw a figure of the minimal build; return its panels and its datasets."""

    def draw_figure(name):
        module, sources = FIGURES[name]
        data = [dataset.read(minimal / f"{source}.nc") for source in sources]
        figure = getattr(import_module(f"rockdamp.{module}"), name)(*data)
        return figure.axes, *data

    return draw_figure


def assert_curve(axes, x, y):
    """Assert that one of the lines of a panel is these points."""
    lines = [line for line in axes.get_lines() if np.shape(line.get_xdata()) == np.shape(x)]
    points = [[line.get_xdata(), line.get_ydata()] for line in lines]
    assert any(np.allclose(point, [x, y], equal_nan=True) for point in points)


def middle(study):
    """Select the middle e, and the damping ratio of least error if there are several."""
    at_restitution = study.sel(restitution=0.85, method="nearest")
    if "damping_ratio_source" in at_restitution.dims:
        return at_restitution.sel(damping_ratio_source="least error")
    return at_restitution


# --- curves ------------------------------------------------------------------------------------


def list_curves(panel, x, values, names, dim="damping_model"):
    """Return a panel's curves: panel, x, y."""
    return [(panel, x, values.sel({dim: name})) for name in names]


def fig2_curves(data):
    x = data["displacement"]
    names = [
        ("bi-linear", "tri-linear"),
        ("bi-linear", "steeper", "translated"),
        ("bi-linear", "new", "moderate", "severe"),
    ]
    for panel, panel_names in enumerate(names):
        yield from list_curves(panel, x, data["force"], panel_names, "curve_name")


def fig3_curves(data):
    x = data["frequency_ratio"]
    return list_curves(0, x, data["damping_ratio_law"], PAPER, "viscous_model")


def fig4_curves(data):
    tau = data["tau"]
    rocking = data["rocking_displacement"]
    yield from list_curves(0, tau, rocking, rocking["rocking_model"].values, "rocking_model")
    yield from list_curves(1, tau, data["displacement"], ("CR", "CDR"))
    yield from list_curves(2, tau, data["velocity"], ("CR", "CDR"))


def fig5_curves(data):
    for panel, model in enumerate(PAPER):
        for name in ("damping_ratio", "damping_ratio_energy"):
            for curve in data[name].sel(damping_model=model):
                yield panel, data["restitution"], curve


def fig6_curves(*studies):
    for row, study in enumerate(studies):
        for panel, model in enumerate(PAPER):
            curve = study["damping_ratio"].sel(damping_model=model)[0]
            yield 3 * row + panel, study["restitution"], curve


def fig6_error_curves(data):
    error = data["error"].sel(release_amplitude=0.5)
    return list_curves(0, data["restitution"], error**0.5, PAPER)


def fig7_curves(data):
    for panel in range(4):
        yield panel, data["restitution"], data["giannini_masiani"]
    for curve in data["damping_ratio_fit"].sel(damping_model="CDR"):
        yield 2, data["restitution"], curve


def fig8_curves(data):
    elapsed = data["elapsed"]
    yield 0, elapsed, data["ground_acceleration"]
    yield 1, elapsed, 1000 * data["measured"]
    yield from list_curves(1, elapsed, 1000 * data["control_displacement"], TRACES)


def amplitude_curves(data):
    ratio = middle(data)["damping_ratio_peaks"]
    relative = ratio / ratio.sel(damping_model="ECD")
    return list_curves(0, data["release_amplitude"], relative, (*PAPER, "ECD"))


def fragility_curves(data):
    share = middle(data)["collapse_fraction"].sel(damping_model="CR")
    for panel, wall in enumerate(data["wall"].values):
        yield panel, data["velocity_ratio"], share.sel(wall=wall)


def order_curves(data):
    study = middle(data)
    for family in ("ECD", "BAND", "CQD"):
        is_family = (study["damper_family"] == family).values
        rows = study.isel(damper=is_family)
        force = rows["crossing_force"].sel(wall="paper")
        yield 0, force, rows["log_error_median"]
        yield 1, force, rows["log_error_90"]


def convergence_curves(data):
    models = data["damping_model"].values
    for row, scheme in enumerate(("newmark", "paper")):
        for column, excitation in enumerate(("free", "forced")):
            errors = data["solver_error"].sel(scheme=scheme, excitation=excitation)
            yield from list_curves(2 * row + column, data["step"], errors, models)


def rocking_curves(data):
    likelihood = data["log_likelihood"]
    relative = likelihood - likelihood.sel(damping_model="power law")
    return list_curves(1, data["impacts_used"], relative, TRACES)


def supports_curves(data):
    ratio = data["median_intensity_ratio"]
    period = data["diaphragm_period"]
    floors = ratio.isel(assumption=np.isfinite(period.values))
    for wall in data["wall"].values[1:]:
        yield 0, [0.0, *period.values[np.isfinite(period)]], [1.0, *floors.sel(wall=wall).values]


CURVES = {
    "fig2": fig2_curves,
    "fig3": fig3_curves,
    "fig4": fig4_curves,
    "fig5": fig5_curves,
    "fig6": fig6_curves,
    "fig6_error": fig6_error_curves,
    "fig7": fig7_curves,
    "fig8": fig8_curves,
    "fig_amplitude": amplitude_curves,
    "fig_fragility": fragility_curves,
    "fig_order": order_curves,
    "fig_convergence": convergence_curves,
    "fig_supports": supports_curves,
    "fig_measured_rocking": rocking_curves,
}


@pytest.mark.parametrize("name", CURVES)
def test_curves_are_those_of_the_dataset(draw, name):
    panels, *data = draw(name)
    for panel, x, y in CURVES[name](*data):
        assert_curve(panels[panel], x, y)


# --- error bars --------------------------------------------------------------------------------

X, Y = 0, 1  # direction of the intervals


def earthquake_bars(data):
    for panel, name in enumerate(("median_ratio", "log_error")):
        intervals = middle(data)[f"{name}_interval"]
        for index, model in enumerate(VISCOUS_MODELS):
            yield panel, index, intervals.sel(damping_model=model), Y


def supports_bars(data):
    intervals = data["median_intensity_ratio_interval"].sel(wall="all")
    is_floor = np.isfinite(data["diaphragm_period"].values)
    yield 0, 0, intervals.isel(assumption=is_floor), Y
    yield 1, 0, intervals.isel(assumption=~is_floor), X


def loss_law_bars(data):
    collapse = data["median_intensity_ratio_interval"].sel(wall="all")
    for index, interval in enumerate(collapse):
        yield 0, index, interval, Y
    peaks = data["median_ratio_interval"].sel(wall="all", loss_exponent=0.26)
    for index, interval in enumerate(peaks.transpose("reference_amplitude", ...)):
        yield 1, index, interval, Y


def rocking_bars(data):
    yield 0, 0, data["amplitude_exponent_interval"], X
    yield 2, 0, data["restitution_over_housner_interval"], Y


BARS = {
    "fig_earthquakes": earthquake_bars,
    "fig_supports": supports_bars,
    "fig_loss_law": loss_law_bars,
    "fig_measured_rocking": rocking_bars,
}


@pytest.mark.parametrize("name", BARS)
def test_error_bars_end_at_the_intervals(draw, name):
    panels, data = draw(name)
    for panel, index, interval, direction in BARS[name](data):
        containers = [bars for bars in panels[panel].containers if len(bars) == 3]
        segments = containers[index][2][0].get_segments()
        ends = [segment[:, direction] for segment in segments if len(segment)]
        is_finite = np.isfinite(interval.values).all(axis=-1)
        np.testing.assert_allclose(np.reshape(ends, (-1, 2)), interval.values[is_finite])


def test_small_changes_of_cr_are_bars(draw):
    panels, data = draw("fig_earthquakes")
    for axes, name in zip(panels, ("median_ratio", "log_error"), strict=True):
        tops = [patch.get_y() + patch.get_height() for patch in axes.patches]
        np.testing.assert_allclose(tops, middle(data)[f"varied_{name}"].max("variation"))


# --- single figures ----------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2])
def test_drawn_bodies_keep_their_shape(offset):
    lower, upper = wall_corners(0.3, 4.0, 0.7, offset)
    for corners, height in ((lower, 2.8), (upper, 1.2)):
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        np.testing.assert_allclose(sides, [0.3, height, 0.3, height])


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2])
def test_drawn_bodies_touch_at_hinge_and_supports(offset):
    lower, upper = wall_corners(0.3, 4.0, 0.7, offset)
    np.testing.assert_allclose(lower[3], upper[3], atol=1e-12)  # the hinge
    np.testing.assert_allclose(lower[3, 0], offset - 0.15, atol=1e-12)
    np.testing.assert_allclose(lower[1], [0.15, 0.0], atol=1e-12)  # the base corner it turns about
    np.testing.assert_allclose(upper[1, 0], 0.15)  # the support holds the top


def test_synthetic_record_is_called_so(draw):
    panels, _ = draw("fig8")
    assert "SYNTHETIC" in panels[0].get_figure().get_suptitle()
    assert "SYNTHETIC record" in panels[1].get_legend_handles_labels()[1]


def test_calibration_is_drawn_with_its_residual(minimal):
    fit = dataset.read(minimal / "calibration.nc")
    history, residual = calibration_figure(fit).axes
    first = fit.isel(sample=(fit["sample_run"] == 1).values)
    assert_curve(history, first["elapsed"], 1000 * first["control_displacement"])
    difference = first["measured"] - first["control_displacement"]
    assert_curve(residual, first["elapsed"], 1000 * difference)
    e = float(fit["estimate"].sel(parameter="restitution"))
    assert f"$e$ = {e:.4f} ±" in history.get_title()


def test_fragility_curves_are_lognormal(draw):
    panels, data = draw("fig_fragility")
    for axes, wall in zip(panels, data["wall"].values, strict=True):
        for model in data["damping_model"].values:
            fragility = middle(data).sel(wall=wall, damping_model=model)
            (curve,) = (line for line in axes.get_lines() if line.get_label() == model)
            median = float(fragility["wall_median_velocity_ratio"])
            depth = np.log(curve.get_xdata() / median) / float(fragility["wall_dispersion"])
            np.testing.assert_allclose(curve.get_ydata(), norm.cdf(depth))


def test_fragility_band_holds_all_within_both_intervals():
    level = np.geomspace(0.2, 5, 41)
    curves = []
    for median in np.linspace(0.7, 0.9, 9):
        for dispersion in np.linspace(0.3, 0.5, 9):
            curves.append(norm.cdf(np.log(level / median) / dispersion))
    band = envelope(level, np.array([0.7, 0.9]), np.array([0.3, 0.5]))
    np.testing.assert_allclose(band, [np.min(curves, axis=0), np.max(curves, axis=0)])


def test_velocity_at_the_crossing_is_that_of_the_dataset(draw):
    (*_, velocity), data = draw("fig_order")
    (line,) = (line for line in velocity.get_lines() if line.get_label() == "BAND0.2")
    assert np.isin(line.get_ydata(), data["velocity"].sel(crossing_damper="BAND0.2")).all()


def test_force_at_the_crossing_reaches_its_lowest(draw):
    (*_, force, _), data = draw("fig_order")
    histories = [line for line in force.get_lines() if len(line.get_xdata()) > 2]
    lowest = min(line.get_ydata().min() for line in histories)
    assert lowest == float(data["damping_force"].min())


@pytest.mark.parametrize(
    "name", ["fig4", "fig8", "fig_amplitude", "fig_convergence", "fig_fragility"]
)
def test_model_has_one_colour_in_every_figure(draw, name):
    for axes in draw(name)[0]:
        for line in axes.get_lines():
            if line.get_label() in LOOK:
                assert line.get_color() == LOOK[line.get_label()]["color"]
