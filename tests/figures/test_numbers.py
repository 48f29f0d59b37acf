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

PAPER = ("CDC", "CDR", "SDR")
TRACES = ("CR", *PAPER)


@pytest.fixture(scope="module")
def draw(minimal):
    """Draw a figure of the minimal build; return its panels and its datasets."""

    def panels(name):
        module, names = FIGURES[name]
        data = [dataset.read(minimal / f"{each}.nc") for each in names]
        return getattr(import_module(f"rockdamp.{module}"), name)(*data).axes, *data

    return panels


def assert_shown(axes, x, y):
    """One of the lines of a panel is these points."""
    lines = [line for line in axes.get_lines() if np.shape(line.get_xdata()) == np.shape(x)]
    assert any(
        np.allclose([line.get_xdata(), line.get_ydata()], [x, y], equal_nan=True) for line in lines
    )


def middle(study):
    """Select the middle e, and the damping ratio of least error if there are several."""
    found = study.sel(restitution=0.85, method="nearest")
    return (
        found.sel(damping_ratio_source="least error")
        if "damping_ratio_source" in found.dims
        else found
    )


def curves(panel, x, variable, values, dim="damping_model"):
    """Return a panel's curves: panel, x, y."""
    return [(panel, x, variable.sel({dim: value})) for value in values]


def order_curves(data):
    study = middle(data)
    for family in ("ECD", "BAND", "CQD"):
        rows = study.isel(
            damper=[str(damper).startswith(family) for damper in study["damper"].values]
        )
        for panel, name in enumerate(("log_error_median", "log_error_90")):
            yield panel, rows["crossing_force"].sel(wall="paper"), rows[name]


def convergence_curves(data):
    for row, scheme in enumerate(("newmark", "paper")):
        for column, excitation in enumerate(("free", "forced")):
            errors = data["solver_error"].sel(scheme=scheme, excitation=excitation)
            yield from curves(
                2 * row + column, data["step"], errors, errors["damping_model"].values
            )


def amplitude_curves(data):
    ratio = middle(data)["damping_ratio_peaks"]
    return curves(
        0, data["release_amplitude"], ratio / ratio.sel(damping_model="ECD"), (*PAPER, "ECD")
    )


def rocking_curves(data):
    likelihood = data["log_likelihood"]
    return curves(
        1, data["impacts_used"], likelihood - likelihood.sel(damping_model="power law"), TRACES
    )


# For a figure a function of its datasets that returns curves: panel, x, y.
CURVES = {
    "fig2": lambda data: [
        *curves(0, data["displacement"], data["force"], ("bi-linear", "tri-linear"), "curve_name"),
        *curves(
            1,
            data["displacement"],
            data["force"],
            ("bi-linear", "steeper", "translated"),
            "curve_name",
        ),
        *curves(
            2,
            data["displacement"],
            data["force"],
            ("bi-linear", "new", "moderate", "severe"),
            "curve_name",
        ),
    ],
    "fig3": lambda data: curves(
        0, data["frequency_ratio"], data["damping_ratio_law"], PAPER, "viscous_model"
    ),
    "fig4": lambda data: [
        *curves(
            0,
            data["tau"],
            data["rocking_displacement"],
            data["rocking_model"].values,
            "rocking_model",
        ),
        *curves(1, data["tau"], data["displacement"], ("CR", "CDR")),
        *curves(2, data["tau"], data["velocity"], ("CR", "CDR")),
    ],
    "fig5": lambda data: [
        (panel, data["restitution"], curve)
        for panel, model in enumerate(PAPER)
        for name in ("damping_ratio", "damping_ratio_energy")
        for curve in data[name].sel(damping_model=model)
    ],
    "fig6": lambda *studies: [
        (3 * row + panel, study["restitution"], study["damping_ratio"].sel(damping_model=model)[0])
        for row, study in enumerate(studies)
        for panel, model in enumerate(PAPER)
    ],
    "fig6_error": lambda data: curves(
        0, data["restitution"], data["error"].sel(release_amplitude=0.5) ** 0.5, PAPER
    ),
    "fig7": lambda data: [
        *((panel, data["restitution"], data["giannini_masiani"]) for panel in range(4)),
        *(
            (2, data["restitution"], curve)
            for curve in data["damping_ratio_fit"].sel(damping_model="CDR")
        ),
    ],
    "fig8": lambda data: [
        (0, data["elapsed"], data["ground_acceleration"]),
        (1, data["elapsed"], 1000 * data["measured"]),
        *curves(1, data["elapsed"], 1000 * data["control_displacement"], TRACES),
    ],
    "fig_amplitude": amplitude_curves,
    "fig_fragility": lambda data: [
        (
            panel,
            data["velocity_ratio"],
            middle(data)["collapse_fraction"].sel(wall=wall, damping_model="CR"),
        )
        for panel, wall in enumerate(data["wall"].values)
    ],
    "fig_order": order_curves,
    "fig_convergence": convergence_curves,
    "fig_measured_rocking": rocking_curves,
}


@pytest.mark.parametrize("name", CURVES)
def test_curves_are_those_of_the_dataset(draw, name):
    panels, *data = draw(name)
    for panel, x, y in CURVES[name](*data):
        assert_shown(panels[panel], x, y)


# Figure, and a function of its dataset that returns error bars: panel, their number in it, interval, 0 for those of x.
BARS = {
    "fig_earthquakes": lambda data: [
        (panel, index, middle(data)[f"{name}_interval"].sel(damping_model=model), 1)
        for panel, name in enumerate(("median_ratio", "log_error"))
        for index, model in enumerate(("CDC", "CDR", "SDR", "ECD", "BAND"))
    ],
    "fig_supports": lambda data: [
        (
            panel,
            0,
            data["median_intensity_ratio_interval"].sel(wall="all").isel(assumption=assumptions),
            axis,
        )
        for panel, assumptions, axis in (
            (0, np.isfinite(data["diaphragm_period"].values), 1),
            (1, np.isnan(data["diaphragm_period"].values), 0),
        )
    ],
    "fig_loss_law": lambda data: [
        *(
            (0, i, interval, 1)
            for i, interval in enumerate(data["median_intensity_ratio_interval"].sel(wall="all"))
        ),
        *(
            (1, i, interval, 1)
            for i, interval in enumerate(
                data["median_ratio_interval"]
                .sel(wall="all", loss_exponent=0.26)
                .transpose("reference_amplitude", ...)
            )
        ),
    ],
    "fig_measured_rocking": lambda data: [
        (0, 0, data["amplitude_exponent_interval"], 0),
        (2, 0, data["restitution_over_housner_interval"], 1),
    ],
}


@pytest.mark.parametrize("name", BARS)
def test_error_bars_end_at_the_intervals(draw, name):
    panels, data = draw(name)
    for panel, index, interval, axis in BARS[name](data):
        bars = [container for container in panels[panel].containers if len(container) == 3][index][
            2
        ][0]
        ends = [segment[:, axis] for segment in bars.get_segments() if len(segment)]
        np.testing.assert_allclose(
            np.reshape(ends, (-1, 2)), interval.values[np.isfinite(interval.values).all(-1)]
        )


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2])
def test_the_drawn_bodies_keep_their_shape_and_touch_at_the_hinge(offset):
    lower, upper = wall_corners(0.3, 4.0, 0.7, offset)
    for corners, height in ((lower, 2.8), (upper, 1.2)):
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        np.testing.assert_allclose(sides, [0.3, height, 0.3, height])
    np.testing.assert_allclose(lower[3], upper[3], atol=1e-12)  # the hinge
    np.testing.assert_allclose(lower[3, 0], offset - 0.15, atol=1e-12)
    np.testing.assert_allclose(
        lower[1], [0.15, 0.0], atol=1e-12
    )  # the base corner that it turns about
    np.testing.assert_allclose(upper[1, 0], 0.15)  # the support holds the top


def test_a_synthetic_record_is_called_so(draw):
    panels, _ = draw("fig8")
    assert "SYNTHETIC" in panels[0].get_figure().get_suptitle()
    assert "SYNTHETIC record" in panels[1].get_legend_handles_labels()[1]


def test_a_calibration_is_drawn_with_its_residual(minimal):
    fit = dataset.read(minimal / "calibration.nc")
    history, residual = calibration_figure(fit).axes
    run = fit.isel(sample=(fit["sample_run"] == 1).values)
    assert_shown(history, run["elapsed"], 1000 * run["control_displacement"])
    assert_shown(residual, run["elapsed"], 1000 * (run["measured"] - run["control_displacement"]))
    assert (
        f"$e$ = {float(fit['estimate'].sel(parameter='restitution')):.4f} ±" in history.get_title()
    )


def test_small_changes_of_cr_are_bars(draw):
    panels, data = draw("fig_earthquakes")
    for axes, name in zip(panels, ("median_ratio", "log_error"), strict=True):
        tops = [patch.get_y() + patch.get_height() for patch in axes.patches]
        np.testing.assert_allclose(tops, middle(data)[f"varied_{name}"].max("variation"))


def test_fragility_curves_are_lognormal_and_their_band_holds_all_within_both_intervals(draw):
    panels, data = draw("fig_fragility")
    for axes, wall in zip(panels, data["wall"].values, strict=True):
        for model in data["damping_model"].values:
            one = middle(data).sel(wall=wall, damping_model=model)
            curve = next(line for line in axes.get_lines() if line.get_label() == model)
            depth = np.log(curve.get_xdata() / float(one["wall_median_velocity_ratio"])) / float(
                one["wall_dispersion"]
            )
            np.testing.assert_allclose(curve.get_ydata(), norm.cdf(depth))
    level, median, dispersion = np.geomspace(0.2, 5, 41), np.array([0.7, 0.9]), np.array([0.3, 0.5])
    curves = [
        norm.cdf(np.log(level / m) / s)
        for m in np.linspace(*median, 9)
        for s in np.linspace(*dispersion, 9)
    ]
    np.testing.assert_allclose(
        envelope(level, median, dispersion), [np.min(curves, axis=0), np.max(curves, axis=0)]
    )


def test_force_and_velocity_at_the_crossing(draw):
    (*_, force, velocity), data = draw("fig_order")
    (line,) = (line for line in velocity.get_lines() if line.get_label() == "BAND0.2")
    assert np.isin(line.get_ydata(), data["velocity"].sel(crossing_damper="BAND0.2")).all()
    lowest = min(line.get_ydata().min() for line in force.get_lines() if len(line.get_xdata()) > 2)
    assert lowest == float(data["damping_force"].min())


def test_a_model_has_one_colour_in_every_figure(draw):
    for name in ("fig4", "fig8", "fig_amplitude", "fig_convergence", "fig_fragility"):
        for axes in draw(name)[0]:
            for line in axes.get_lines():
                assert (
                    line.get_color()
                    == LOOK.get(line.get_label(), {"color": line.get_color()})["color"]
                )
