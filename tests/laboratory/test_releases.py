"""Releases of a test: where they begin and end, and samples and gaps that are refused."""

import numpy as np
import pytest
from rocking_decays import NOISE, STEP, U_INS, decay, free_motion, white_noise

import rockdamp as rd
from rockdamp.laboratory.releases import find_releases, sensor_noise


def releases_of(displacement, least=None):
    return find_releases(STEP * np.arange(displacement.size), displacement, least)


@pytest.fixture(scope="module")
def two_decays():
    """A release to one side, and one to the other side."""
    return np.concatenate([decay(), decay(sign=-1.0, release=0.4)])


def test_each_pull_begins_a_release(two_decays):
    first, second = releases_of(two_decays)
    assert first.peaks[0] > 0 > second.peaks[0]


def test_peaks_alternate_around_crossings(two_decays):
    release, _ = releases_of(two_decays)
    np.testing.assert_array_equal(np.sign(release.peaks[1:]), -np.sign(release.peaks[:-1]))
    assert release.crossings.size == release.peaks.size - 1


def test_peaks_exceed_ten_times_the_noise(two_decays):
    release, _ = releases_of(two_decays)
    assert np.abs(release.peaks).min() > 10 * NOISE * 0.9


def test_least_peak_is_respected(two_decays):
    release, _ = releases_of(two_decays, least=0.02)
    assert np.abs(release.peaks).min() > 0.02


def test_noise_is_that_of_the_sensor(two_decays):
    assert sensor_noise(two_decays) == pytest.approx(NOISE, rel=0.1)


@pytest.fixture(scope="module")
def filtered():
    """White noise, most of which a filter removed: differences of samples hardly show it."""
    return np.convolve(decay(noise=1e-3), np.full(25, 1 / 25), mode="valid")


def test_filtered_noise_is_seen_at_rest(filtered):
    assert sensor_noise(filtered) > 5e-5


def test_filtered_noise_makes_no_peaks(filtered):
    (release,) = releases_of(filtered)
    assert np.abs(release.peaks).min() > 5e-4
    assert release.elapsed[-1] < 6.6  # the rest begins at 6.5 s


# --- lost samples ---------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1, 2, 5])
@pytest.mark.parametrize("value", [0.0, 0.2], ids=["at zero", "far away"])
@pytest.mark.parametrize("first", [120, 500, 900, 1500])
def test_lost_marker_is_refused_with_its_time(first, value, width):
    displacement = decay()
    displacement[first : first + width] = value
    with pytest.raises(rd.InputError, match=f"jump of the displacement at {STEP * first:.6g} s"):
        releases_of(displacement)


def test_two_lost_frames_far_apart_are_refused():
    displacement = decay()
    displacement[[500, 1500]] = -0.02
    with pytest.raises(rd.InputError, match="jump"):
        releases_of(displacement)


def test_spike_within_the_noise_is_allowed():
    displacement = decay()
    displacement[900] += 5 * NOISE
    assert len(releases_of(displacement)) == 1


@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-4, 4e-4])
@pytest.mark.parametrize("frame_rate", [30, 60, 240, 1000])
def test_clean_test_has_no_lost_samples(frame_rate, noise):
    """Impacts of e = 0.75 and half cycles of a few samples are no spikes."""
    for seed, release in enumerate((0.3, 0.5, 0.9)):
        held = np.full(frame_rate // 3, release * U_INS)
        elapsed = np.arange(5 * frame_rate) / frame_rate
        free = free_motion(elapsed, damping=rd.Damping("CR", 0.75), release=release)
        displacement = np.concatenate([held, free])
        displacement += white_noise(displacement.size, seed, noise)
        times = np.arange(displacement.size) / frame_rate
        assert len(find_releases(times, displacement)) == 1


def test_gap_that_hides_an_impact_is_refused():
    frames = np.delete(np.arange(420) / 60, range(48, 63))
    displacement = free_motion(frames)
    with pytest.raises(
        rd.InputError, match=r"gap after 0\.783[0-9]* s is [0-9.]+ s; it must be at most [0-9.]+ s"
    ):
        find_releases(frames, displacement + white_noise(frames.size))
