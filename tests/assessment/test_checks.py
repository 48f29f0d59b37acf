"""The checks in the engineer's words, from the histories of one wall."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.checks import checks


def test_the_checks_state_what_the_histories_did(answer, wall, motions):
    u_ins = float(wall.instability_displacement)
    low, high = checks(answer, wall, motions)
    cr = answer.sel(damping_model="CR")
    for index, check in enumerate((low, high)):
        peaks = np.nan_to_num(cr["peak_ratio"].isel(intensity=index).values, nan=np.inf)
        # Half, and 84 %, of the records do not pass these peaks, and fewer do not pass the next smaller ones.
        assert np.mean(u_ins * peaks <= check.median_peak) >= 0.5 > np.mean(u_ins * peaks < check.median_peak)
        assert np.mean(u_ins * peaks <= check.upper_peak) >= 0.84 > np.mean(u_ins * peaks < check.upper_peak)
    assert low.capacity == pytest.approx(0.4 * u_ins)
    assert low.margin == pytest.approx(2 * high.margin) == pytest.approx(float(cr["median_pgv"]) / 0.4)
    shaken = [0.4 / m.pgv * m.pga for m in (rd.intensity_measures(motion.record) for motion in motions)]
    assert low.support_acceleration == pytest.approx(np.median(shaken))
    assert low.rocks == (low.support_acceleration >= low.rocking_onset)


def test_a_capacity_of_ones_own_decides(answer, wall, motions):
    peak = checks(answer, wall, motions)[0].median_peak / float(wall.instability_displacement)
    for capacity, met in ((0.99 * peak, False), (1.01 * peak, True)):
        assert checks(answer, wall, motions, capacity)[0].median_met is met
    with pytest.raises(rd.InputError, match=r"capacity is 40.0; .* was it in per cent \(0.4\)"):
        checks(answer, wall, motions, 40)


def test_a_wall_that_collapses_meets_no_capacity(wall, motions):
    answer = rd.assess(wall, rd.TrilinearCurve.preset("severe"), motions, pgv=3.5, restitution=0.85)
    (check,) = checks(answer, wall, motions, 1.0)
    assert check.median_peak == np.inf and not check.median_met and not check.upper_met
