"""The ensemble on which the solver is measured: walls, loads and histories."""

import numpy as np
import pytest

from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.studies.accuracy import convergence
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS


def test_each_curve_and_release_of_the_studies_is_there_once(drawn):
    rows = zip(
        drawn.curve.yield_displacement_ratio[:, 0],
        drawn.curve.strength_ratio[:, 0],
        drawn.release_amplitude[:, 0],
        strict=True,
    )
    assert sorted(rows) == [(0.04, 0.85, 0.3), (0.04, 0.85, 0.5), (0.10, 0.85, 0.5), (0.20, 0.75, 0.5)]
    assert drawn.restitution.tolist() == [0.8, 0.9]


def test_the_walls_have_their_published_damping_ratios(drawn, matches):
    case = drawn.curve.yield_displacement_ratio[:, 0].tolist().index(0.10)
    published = matches["cracked_stiffness"]["damping_ratio"].sel(yield_displacement_ratio=0.10, restitution=[0.8, 0.9])
    for model in VISCOUS_MODELS:
        assert drawn.ratio[model][case].tolist() == published.sel(damping_model=model).values.tolist()


def test_loads_are_seeded_of_unit_peak_and_within_their_band():
    load = convergence.band_limited(3, 2, 4000, 0.2)
    np.testing.assert_array_equal(load, convergence.band_limited(3, 2, 4000, 0.2))
    assert np.abs(load).max(axis=1).tolist() == [1.0, 1.0]
    assert np.abs(load[0] - load[1]).max() > 0.1
    power = np.abs(np.fft.rfft(load * np.hanning(4000))) ** 2
    frequency = 2 * np.pi * np.fft.rfftfreq(4000, 0.2)
    low, high = convergence.LOAD_FREQUENCIES
    outside = (frequency < low - 0.05) | (frequency > high + 0.05)
    assert power[:, outside].sum() < 1e-6 * power.sum()


def test_the_forced_peaks_are_the_largest_below_the_releases(drawn, config):
    step = config.solver.step
    peak = np.max([drawn.forced_peaks(model, step, drawn.factor) for model in MODELS], axis=0)
    assert (peak <= drawn.release_amplitude).all()
    for larger in convergence.FACTORS[:, None, None] * np.ones_like(drawn.factor):
        beyond = np.max([drawn.forced_peaks(model, step, larger) for model in MODELS], axis=0)
        assert ((larger <= drawn.factor) | (beyond > drawn.release_amplitude)).all()


def test_histories_are_those_of_the_pipelines_solver(drawn):
    many = round(drawn.sample / 0.01)
    steps = (drawn.load.shape[1] - 1) * many
    options = {"step": 0.01, "steps": steps, "store_every": 2}
    case, e = 2, 1
    curve, damping = drawn.curve.map(lambda p: p[case, 0]), Damping("SDR", drawn.ratio["SDR"][case, e])
    free = solve(curve, damping, release_amplitude=drawn.release_amplitude[case, 0], **options)
    load = {"load_factor": drawn.factor[case, e], "ground_acceleration": drawn.load[case], "substeps": many}
    for excitation, expected in (("free", free), ("forced", solve(curve, damping, **load, **options))):
        displacement, velocity = drawn.histories("SDR", excitation, 0.01, 2)
        np.testing.assert_array_equal(displacement[case, e], expected.displacement)
        np.testing.assert_array_equal(velocity[case, e], expected.velocity)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_order_is_the_slope_of_the_error(power):
    steps = np.array([0.04, 0.02, 0.01])
    error = np.array([[3.0], [0.5]]) * steps**power
    np.testing.assert_allclose(convergence.fitted_order(steps, error), power)
