"""The rest before a measured motion: noise does not end it, and a motion is no rest."""

import numpy as np
import pytest
from experimental_style import ricker

from rockdamp.errors import InputError
from rockdamp.histories.record_rest import (
    measured_displacement,
    motion_noise,
    quiet_level,
    rest_samples,
)
from rockdamp.motions.record import Record

ELAPSED = np.arange(600) / 200
FREQUENCY = 2.0  # of the pulse [Hz]
CENTRE = 1.5  # of the pulse [s]


def make_record(noise, seed=1, displacement=None):
    pulse = ricker(ELAPSED - CENTRE, FREQUENCY, 1.0)
    samples = np.random.RandomState(seed).standard_normal(ELAPSED.size)
    return Record(ELAPSED, pulse + noise * samples, displacement)


def rest(noise, seed=1):
    """Return the length of the rest. [s]"""
    return ELAPSED[rest_samples(make_record(noise, seed))]


def test_rest_ends_at_a_share_of_the_peak():
    assert quiet_level(make_record(1e-4)) == pytest.approx(0.02, rel=1e-3)
    assert rest(1e-4) == pytest.approx(rest(0), abs=0.01)


def test_noise_beyond_that_share_does_not_end_the_rest():
    """The noise of ten samples is known to a quarter: some rests end earlier."""
    rests = [rest(0.03, seed) for seed in range(20)]
    assert np.median(rests) > rest(0) - 0.1


def test_rest_ends_before_the_main_lobe_however_noisy():
    main_lobe = CENTRE - 1 / (np.sqrt(2) * np.pi * FREQUENCY)
    assert max(rest(0.03, seed) for seed in range(20)) < main_lobe


def test_motion_from_the_first_sample_has_no_rest():
    with pytest.raises(InputError, match="samples at rest"):
        rest_samples(Record(ELAPSED, np.sin(2 * np.pi * ELAPSED)))


def test_still_ground_has_a_quiet_level_of_zero():
    assert quiet_level(Record(ELAPSED, np.zeros(ELAPSED.size))) == 0.0


def test_noise_of_the_sensor():
    assert motion_noise(make_record(1e-3)) == pytest.approx(1e-3, rel=0.1)


def test_displacement_is_taken_from_its_level_at_rest():
    response = 0.02 * ricker(ELAPSED - CENTRE, FREQUENCY, 1.0)
    record = make_record(0.0, displacement=response + 0.005)
    displacement, zero = measured_displacement(record)
    assert zero == pytest.approx(0.005, abs=1e-4)
    np.testing.assert_allclose(displacement, response, atol=1e-4)


def test_record_without_a_response_is_refused():
    with pytest.raises(InputError, match="displacement_m"):
        measured_displacement(make_record(0.0))
