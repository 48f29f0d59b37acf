"""The rest before a measured motion: noise is none of the motion, and a motion is no rest."""

import numpy as np
import pytest
from experimental_style import ricker

from rockdamp.errors import InputError
from rockdamp.histories.record_rest import QUIET_SHARE, quiet_level, rest_samples
from rockdamp.motions.record import Record

ELAPSED = np.arange(600) / 200


def record(noise, seed=1, centre=1.5):
    motion = ricker(ELAPSED - centre, 2.0, 1.0)
    return Record(
        ELAPSED, motion + noise * np.random.RandomState(seed).standard_normal(ELAPSED.size)
    )


def test_rest_ends_at_a_share_of_the_peak():
    assert quiet_level(record(1e-4)) == pytest.approx(QUIET_SHARE, rel=1e-3)
    assert ELAPSED[rest_samples(record(1e-4))] == pytest.approx(
        ELAPSED[rest_samples(record(0))], abs=0.01
    )


def test_noise_beyond_that_share_does_not_end_the_rest():
    begins = ELAPSED[rest_samples(record(0))]
    rests = [ELAPSED[rest_samples(record(0.03, seed))] for seed in range(20)]
    assert (
        np.median(rests) > begins - 0.1
    )  # the noise of ten samples is known to a quarter: some rests end earlier
    assert max(rests) < 1.5 - 1 / (np.sqrt(2) * np.pi * 2.0)  # before the main lobe


def test_motion_from_the_first_sample_has_no_rest():
    with pytest.raises(InputError, match="samples at rest"):
        rest_samples(Record(ELAPSED, np.sin(2 * np.pi * ELAPSED)))
