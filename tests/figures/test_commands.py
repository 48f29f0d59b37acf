"""Pictures of the commands show the computed values in the units of their axes."""

import numpy as np
import pytest
from made_datasets import make_dataset
from scipy.stats import norm

import rockdamp as rd
from rockdamp.figures.commands import decay_figure, fragility_figure, response_figure

CURVE = rd.TrilinearCurve(0.04, 0.85)
WALL = rd.Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=0.5)
# Collapses at each stripe, and intervals of the probability, of CR and BAND.
COUNTS = np.stack([np.linspace(0, 40, 16).astype(int), np.linspace(0, 30, 16).astype(int)])
INTERVALS = np.array([[[0.1, 0.4], [0.3, 0.7]], [[0.1, 0.3], [0.2, 0.6]]])
DAMPINGS = [rd.Damping("CR", 0.85), rd.Damping("SDR", 0.0625)]


@pytest.mark.parametrize(("wall", "time"), [(None, "tau"), (WALL, "elapsed")])
def test_decay_is_drawn_against_tau_or_seconds(wall, time):
    decay = rd.free_decay(CURVE, DAMPINGS, wall=wall, release_amplitude=0.5, length=4.0)
    (axes,) = decay_figure(decay).axes
    lines = axes.get_lines()[:2]
    for line, displacement in zip(lines, decay["displacement"], strict=True):
        np.testing.assert_array_equal(line.get_xdata(), decay[time])
        np.testing.assert_array_equal(line.get_ydata(), displacement)
    assert [line.get_label() for line in lines] == ["CR, $e = 0.85$", "SDR, $\\xi = 0.0625$"]


@pytest.fixture(scope="module")
def response():
    elapsed = 0.01 * np.arange(101)
    record = rd.Record(elapsed, 12.0 * np.sin(2 * np.pi * elapsed))
    return rd.respond(WALL, CURVE, DAMPINGS, record, scale=2.0)


def test_response_shows_the_motion_of_the_ground(response):
    ground = response_figure(response).axes[0]
    drawn = ground.get_lines()[0].get_ydata()
    np.testing.assert_array_equal(drawn, response["ground_acceleration"])


@pytest.mark.parametrize("model", ["CR", "SDR"])
def test_response_is_in_millimetres_up_to_a_collapse(response, model):
    axes = response_figure(response).axes[1]
    (line,) = (line for line in axes.get_lines() if f"({model}," in line.get_label())
    history = response.sel(damping_model=model)
    np.testing.assert_allclose(line.get_ydata(), 1000 * history["control_displacement"])
    assert history["collapsed"]
    assert line.get_label().endswith(f"at {float(history['end_elapsed']):.2f} s")


def test_each_collapse_has_a_cross(response):
    axes = response_figure(response).axes[1]
    assert sum(line.get_marker() == "x" for line in axes.get_lines()) == 2


@pytest.mark.parametrize(
    ("collapsed", "outcomes"),
    [([0, 0], {"peak"}), ([0, 1], {"peak", "collapse"}), ([1, 1], {"collapse"})],
    ids=["survived", "both", "collapsed"],
)
def test_legend_explains_dot_and_cross(response, collapsed, outcomes):
    outcome = response.assign(collapsed=("damping_model", collapsed))
    (legend,) = response_figure(outcome).legends
    labels = {text.get_text() for text in legend.get_texts()}
    assert labels & {"peak", "collapse"} == outcomes


def test_second_axis_is_over_the_instability_displacement(response):
    figure = response_figure(response)
    axes = figure.axes[1]
    figure.draw_without_rendering()
    over_u_ins = axes.get_ylim()[1] / (1000 * float(WALL.instability_displacement))
    assert axes.child_axes[0].get_ylim()[1] == pytest.approx(over_u_ins)


def test_title_states_the_factor_on_the_record(response):
    assert response_figure(response).get_suptitle().endswith("(times 2)")


@pytest.fixture(params=["pgv", "pga"])
def answer(request):
    """An assessment with a lognormal curve of CR, and none of BAND."""
    measure = request.param
    unit = 9.80665 if measure == "pga" else 1.0  # PGA is drawn in g
    values = {
        "damper_family": ("damping_model", ["CR", "BAND"]),
        f"median_{measure}": ("damping_model", [0.5 * unit, np.nan]),
        measure: ("intensity", [0.3 * unit, 0.6 * unit]),
        f"stripe_{measure}": ("stripe", unit * np.geomspace(0.1, 5.0, 16)),
        "stripe_collapses": (("damping_model", "stripe"), COUNTS),
        "dispersion": ("damping_model", [0.4, np.nan]),
        "collapse_probability": (("damping_model", "intensity"), [[0.25, 0.5], [0.2, 0.4]]),
        "collapse_probability_interval": (("damping_model", "intensity", "bound"), INTERVALS),
    }
    dataset = make_dataset("assessment", {"damping_model": ["CR", "BAND"]}, records=40, **values)
    return dataset.assign_attrs(intensity_measure=measure.upper())


def test_fragility_curve_is_lognormal(answer):
    (axes,) = fragility_figure(answer).axes
    labels = {str(line.get_label()): line for line in axes.get_lines()}
    (curve,) = (line for label, line in labels.items() if label.startswith("CR: median 0.5"))
    expected = norm.cdf(np.log(curve.get_xdata() / 0.5) / 0.4)
    np.testing.assert_allclose(curve.get_ydata(), expected)


def test_fragility_without_a_curve_says_so(answer):
    (axes,) = fragility_figure(answer).axes
    assert "BAND: no lognormal curve" in axes.get_legend_handles_labels()[1]


def test_fragility_shows_the_share_at_each_stripe(answer):
    (axes,) = fragility_figure(answer).axes
    stripes = [line.get_ydata() for line in axes.get_lines() if len(line.get_xdata()) == 16]
    np.testing.assert_allclose(stripes, COUNTS / 40)


def test_fragility_shows_the_interval_of_the_first_model(answer):
    (axes,) = fragility_figure(answer).axes
    bars = axes.containers[0][2][0].get_segments()
    np.testing.assert_allclose([bar[:, 1] for bar in bars], INTERVALS[0])


@pytest.mark.parametrize("answer", ["pga"], indirect=True)
def test_fragility_is_in_the_unit_asked_for(answer):
    (in_g,) = fragility_figure(answer, "g").axes
    (in_si,) = fragility_figure(answer, "m/s2").axes
    assert (in_g.get_xlabel(), in_si.get_xlabel()) == ("PGA [g]", "PGA [m/s2]")
    assert in_si.get_xlim()[1] / in_g.get_xlim()[1] == pytest.approx(9.80665)


def test_fragility_names_measure_and_records(answer):
    (axes,) = fragility_figure(answer).axes
    assert answer.attrs["intensity_measure"] in axes.get_xlabel()
    assert axes.get_ylabel() == "share of 40 records that cause collapse"
