"""Free decays of the studies: their impacts and their lengths."""

import numpy as np
import pytest

from rockdamp.constants import STUDIES
from rockdamp.studies.decays import step_count
from rockdamp.studies.study import make_study


@pytest.mark.parametrize(("length", "count"), [(0.3, 3), (0.7, 7)])
def test_length_a_little_short_takes_all_its_steps(length, count):
    """0.3/0.1 is a little less than 3."""
    assert step_count(length, 0.1) == count


@pytest.mark.parametrize("step", [0.0025, 0.01, 1 / 3])
def test_multiple_of_a_step_takes_that_many(step):
    counts = list(range(1, 400))
    assert [step_count(count * step, step) for count in counts] == counts


@pytest.mark.parametrize("name", STUDIES)
def test_peaks_follow_the_energy_of_each_impact(name, decays, config):
    """V(x_n) = e^{2n} V(x0): the third peak, to the second order of a step of 0.01."""
    study = make_study(name, config)
    dataset = decays[name]
    for wall, column in np.ndindex(dataset["impacts"].shape):
        curve = study.curve.map(lambda parameter, wall=wall: parameter[wall])
        e = float(dataset["restitution"][column])
        u = np.abs(dataset["displacement"].values[wall, column])
        peaks = u[1:-1][(u[1:-1] >= u[:-2]) & (u[1:-1] > u[2:])]
        if peaks.size >= 3:
            expected = float(curve.energy(study.release_amplitude[wall])) * e**6
            assert float(curve.energy(peaks[2])) == pytest.approx(expected, rel=0.02), (wall, e)


@pytest.mark.parametrize(("name", "length"), [("amplitude", 16), ("cracked_stiffness", 8)])
def test_decays_run_to_their_length_in_tau(decays, name, length):
    """The amplitudes run to response_lengths.stop, the others to the length of the matching."""
    assert float(decays[name]["tau"][-1]) == pytest.approx(length)


def test_decays_of_other_walls_run_as_long_in_seconds(decays, config):
    dataset = decays["slenderness"]
    frequency = dataset["frequency_parameter"]
    reference = frequency.sel(slenderness=float(config.wall.slenderness))
    end = float(dataset["tau"][-1])
    assert end == pytest.approx(8 * float(frequency.max() / reference), abs=0.01)
    assert 8.5 < end < 16
