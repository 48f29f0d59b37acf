"""The damping ratio by the words under Eq. (17)."""

import numpy as np
import pytest

from rockdamp.equivalence.matching import least_absolute
from rockdamp.equivalence.minima import Cases
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve

STEP, STEPS = 0.01, 800


def cases(*restitution):
    e = np.array(restitution)
    curve = TrilinearCurve(np.full(e.size, 0.04), np.full(e.size, 0.85))
    return Cases.released(curve, np.full(e.size, 0.5), e, step=STEP, steps=STEPS)


@pytest.mark.parametrize("start", [0.8, 1.0, 1.3])
def test_no_ratio_near_it_has_a_smaller_sum_of_absolute_differences(start):
    decays = cases(0.75, 0.9)
    found = least_absolute(decays, "CDC", start * np.array([0.045, 0.018]), STEPS, "newmark")
    for case, best in enumerate(found):
        ratios = best * np.linspace(0.9, 1.1, 201)
        histories = solve(
            decays.curve_of(case),
            Damping("CDC", ratios),
            step=STEP,
            steps=STEPS,
            release_amplitude=0.5,
            store_every=1,
        ).displacement
        sums = np.abs(np.abs(histories) - np.abs(decays.displacement[case])).sum(axis=-1)
        assert best == pytest.approx(ratios[sums.argmin()], rel=2e-3)
