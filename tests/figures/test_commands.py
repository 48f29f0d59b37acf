"""Pictures of the commands show what was computed, in the units of their axes."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

import rockdamp as rd
from rockdamp.figures.commands import decay_figure, fragility_figure, response_figure

CURVE, WALL = (
    rd.TrilinearCurve(0.04, 0.85),
    rd.Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=0.5),
)
DAMPINGS = [rd.Damping("CR", 0.85), rd.Damping("SDR", 0.0625)]


@pytest.mark.parametrize("wall", [None, WALL])
def test_a_decay_is_drawn_against_tau_or_seconds(wall):
    decay = rd.free_decay(CURVE, DAMPINGS, wall=wall, release_amplitude=0.5, length=4.0)
    (axes,) = decay_figure(decay).axes
    for line, damper in zip(axes.get_lines(), range(2), strict=False):
        np.testing.assert_array_equal(line.get_xdata(), decay["tau" if wall is None else "elapsed"])
        np.testing.assert_array_equal(line.get_ydata(), decay["displacement"][damper])
    assert [line.get_label() for line in axes.get_lines()[:2]] == [
        "CR, $e = 0.85$",
        "SDR, $\\xi = 0.0625$",
    ]


def test_a_response_is_drawn_in_millimetres_up_to_a_collapse():
    elapsed = 0.01 * np.arange(101)
    record = rd.Record(elapsed, 12.0 * np.sin(2 * np.pi * elapsed))
    response = rd.respond(WALL, CURVE, DAMPINGS, record, scale=2.0)
    figure = response_figure(response)
    ground, axes = figure.axes
    np.testing.assert_array_equal(
        ground.get_lines()[0].get_ydata(), response["ground_acceleration"]
    )
    lines = {line.get_label().split(",")[0]: line for line in axes.get_lines()}
    for model in ("CR", "SDR"):
        run = response.sel(damping_model=model)
        np.testing.assert_allclose(lines[model].get_ydata(), 1000 * run["control_displacement"])
        assert run["collapsed"] and lines[model].get_label().endswith(
            f"at {float(run['end_elapsed']):.2f} s"
        )
    assert sum(line.get_marker() == "x" for line in axes.get_lines()) == 2
    figure.draw_without_rendering()
    over_u_ins = axes.get_ylim()[1] / (1000 * float(WALL.instability_displacement))
    assert axes.child_axes[0].get_ylim()[1] == pytest.approx(over_u_ins)
    assert figure.get_suptitle().endswith("(times 2)")


@pytest.mark.parametrize("measure", ["pgv", "pga"])
def test_fragility_has_its_curve_stripes_and_interval(measure):
    counts = np.stack([np.linspace(0, 40, 16).astype(int), np.linspace(0, 30, 16).astype(int)])
    interval = [[[0.1, 0.4], [0.3, 0.7]], [[0.1, 0.3], [0.2, 0.6]]]
    answer = xr.Dataset(
        {
            measure: ("intensity", [0.3, 0.6]),
            f"stripe_{measure}": ("stripe", np.geomspace(0.1, 5.0, 16)),
            "stripe_collapses": (("damping_model", "stripe"), counts),
            f"median_{measure}": ("damping_model", [0.5, np.nan]),
            "dispersion": ("damping_model", [0.4, np.nan]),
            "collapse_probability": (("damping_model", "intensity"), [[0.25, 0.5], [0.2, 0.4]]),
            "collapse_probability_interval": (("damping_model", "intensity", "bound"), interval),
            "records": 40,
        },
        coords={"damping_model": ["CR", "BAND"]},
        attrs={"intensity_measure": measure.upper()},
    )
    (axes,) = fragility_figure(answer).axes
    curve = next(
        line for line in axes.get_lines() if str(line.get_label()).startswith("CR: median 0.5")
    )
    np.testing.assert_allclose(curve.get_ydata(), norm.cdf(np.log(curve.get_xdata() / 0.5) / 0.4))
    assert "BAND: no lognormal curve" in axes.get_legend_handles_labels()[1]
    stripes = [line.get_ydata() for line in axes.get_lines() if len(line.get_xdata()) == 16]
    np.testing.assert_allclose(stripes, counts / 40)
    np.testing.assert_allclose(
        [bar[:, 1] for bar in axes.containers[0][2][0].get_segments()], interval[0]
    )
    assert measure.upper() in axes.get_xlabel() and "40 records" in axes.get_ylabel()
