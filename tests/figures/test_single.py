"""Pictures of one wall: what the command line draws is what was computed, in the units of its axes."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.figures.single import decay_figure, response_figure

U_INS, P = 0.25, 2.5
MODELS = {"CR": (0.85, np.nan), "SDR": (np.nan, 0.0625)}


def histories(clock, **attrs):
    """Two models: the first stands, the second collapses at half of the time."""
    time = np.linspace(0.0, 4.0, 81)
    displacement = np.stack([0.1 * np.cos(time), np.where(time <= 2.0, 0.2 * time, np.nan)])
    e, xi = np.array(list(MODELS.values())).T
    return xr.Dataset(
        {
            "displacement" if clock == "tau" else "control_displacement": (("damping_model", clock), displacement),
            "restitution": ("damping_model", e),
            "damping_ratio": ("damping_model", xi),
            "collapsed": ("damping_model", [0, 1]),
            "end_elapsed": ("damping_model", [4.0, 2.0]),
            "ground_acceleration": (clock, np.sin(time)),
            "instability_displacement": U_INS,
            "frequency_parameter": P,
        },
        coords={"damping_model": list(MODELS), clock: time},
        attrs=attrs,
    )


def test_a_decay_is_drawn_in_tau_and_with_a_wall_in_seconds_too():
    bare = decay_figure(histories("tau"))
    assert not bare.axes[0].child_axes
    decay = histories("tau")
    figure = decay_figure(decay.assign_coords(elapsed=("tau", decay["tau"].values / P)))
    figure.draw_without_rendering()
    (axes,) = figure.axes
    for model, line in zip(MODELS, axes.get_lines(), strict=False):
        np.testing.assert_array_equal(line.get_ydata(), decay["displacement"].sel(damping_model=model))
    assert [line.get_label() for line in axes.get_lines()[:2]] == ["CR, $e = 0.85$", "SDR, $\\xi = 0.0625$"]
    (seconds,) = axes.child_axes
    assert seconds.get_xlim()[1] == pytest.approx(axes.get_xlim()[1] / P)


def test_a_response_is_drawn_in_millimetres_and_over_u_ins_up_to_a_collapse():
    response = histories("elapsed", record_synthetic="yes", record_specimen="a wall").assign(scale_factor=2.0)
    figure = response_figure(response)
    figure.draw_without_rendering()
    ground, axes = figure.axes
    np.testing.assert_array_equal(ground.get_lines()[0].get_ydata(), response["ground_acceleration"])
    stands, falls = (line for line in axes.get_lines() if not str(line.get_label()).startswith("_"))
    np.testing.assert_allclose(stands.get_ydata(), 1000 * response["control_displacement"].sel(damping_model="CR"))
    (cross,) = (line for line in axes.get_lines() if line.get_marker() == "x")
    assert (cross.get_xdata()[0], cross.get_ydata()[0]) == pytest.approx((2.0, 400.0))
    assert falls.get_label().endswith("collapses at 2.00 s")
    (beside,) = axes.child_axes
    assert beside.get_ylim()[1] == pytest.approx(axes.get_ylim()[1] / (1000 * U_INS))
    assert figure.get_suptitle() == "SYNTHETIC record: a wall (times 2)"
