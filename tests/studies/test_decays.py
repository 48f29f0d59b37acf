"""The studies' decays under restitution."""

import numpy as np
import pytest

from rockdamp.constants import STUDIES
from rockdamp.studies.decays import step_count


def test_a_length_of_so_many_steps_takes_as_many_whatever_their_rounding():
    assert step_count(0.3, 0.1) == step_count(0.7, 0.1) - 4 == 3  # 0.3/0.1 is a little less than 3
    assert all(step_count(count * step, step) == count for step in (0.0025, 0.01, 1 / 3) for count in range(1, 400))


@pytest.mark.parametrize("name", STUDIES)
def test_decay_peaks_follow_the_energy_of_each_impact(name, decays, config):
    """V(x_n) = e^{2n} V(x0): the fifth peak, to the second order of a step of 0.01."""
    study, data = config.study(name), decays[name]
    for i in range(study.values.size):
        curve = study.curve.map(lambda p, i=i: p[i])
        for j, e in enumerate(data["restitution"].values):
            u = np.abs(data["displacement"].values[i, j])
            peaks = np.flatnonzero((u[1:-1] >= u[:-2]) & (u[1:-1] > u[2:])) + 1
            expected = float(curve.energy(study.release_amplitude[i])) * e ** (2 * 3)
            if peaks.size >= 3:
                assert float(curve.energy(u[peaks[2]])) == pytest.approx(expected, rel=0.02)


def test_decays_run_to_the_longest_response_that_is_matched_to_them(decays, config):
    """The amplitudes run to response_lengths.stop; the others last 8, or its seconds on another wall."""
    frequency = decays["slenderness"]["frequency_parameter"]
    own = frequency.sel(slenderness=float(config.wall.slenderness))
    ends = {name: float(decays[name]["tau"][-1]) for name in STUDIES}
    assert ends["amplitude"] == pytest.approx(16) and ends["cracked_stiffness"] == pytest.approx(8)
    assert ends["slenderness"] == pytest.approx(8 * float(frequency.max() / own), abs=0.01)
    assert 8.5 < ends["slenderness"] < 16
