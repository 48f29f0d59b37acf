"""What a fit leaves of a record: a right record is answered, and one that it does not explain is refused."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.histories.measured_test import rest_samples
from rockdamp.laboratory import least_squares
from rockdamp.laboratory.calibration import Misfit, calibrate, require_possible
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.motions.record import Record, read_record

SHIPPED = read_record(ROOT / "tests/data/cr-half.csv")
# Every other sample of the first 1.6 s, for speed.
RIGHT = Record(*(column[:410:2] for column in (SHIPPED.elapsed, SHIPPED.ground_acceleration, SHIPPED.displacement)))
MOTION, SHOWN = RIGHT.ground_acceleration, RIGHT.displacement


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """A coarser scan, for speed."""
    monkeypatch.setitem(least_squares.GRID, "strength_ratio", np.linspace(0.42, 0.94, 27))
    monkeypatch.setattr(least_squares, "REFINEMENTS", 4)


def fit_of(record):
    return RecordFit.from_record(record, WALL, ultimate_displacement_ratio=1.0, softening="steeper", step=0.03)


def test_of_a_right_record_the_misfit_is_the_sensors_noise():
    misfit = Misfit.from_solution(fit_of(RIGHT).solution())
    assert misfit.residual_rms == pytest.approx(1.5e-4, rel=0.1)  # the sensor's noise
    assert misfit.residual_over_peak == pytest.approx(misfit.residual_rms / np.abs(SHOWN - SHOWN[0]).max(), rel=0.02)


def test_neither_a_drift_nor_the_first_motion_of_the_wall_is_noise_of_the_sensor():
    count = rest_samples(RIGHT)
    moving = np.where(np.arange(SHOWN.size) < 0.8 * count, 0.0, 2e-3)  # while the ground's is within noise
    drifting = replace(RIGHT, displacement=SHOWN + 0.01 * RIGHT.elapsed + moving)
    right, shown = fit_of(RIGHT), fit_of(drifting)
    assert shown.rest_deviation == pytest.approx(right.rest_deviation, rel=1e-6)
    assert right.rest_deviation == pytest.approx(1.5e-4, rel=0.3)  # the sensor's noise


@pytest.mark.parametrize(
    "changes",
    [
        {"ground_acceleration": -MOTION},
        {"ground_acceleration": MOTION / 9.80665},
        {"displacement": np.abs(SHOWN - SHOWN[0])},  # it never crosses its rest
    ],
)
def test_a_record_that_the_best_fit_does_not_explain_is_refused(changes):
    with pytest.raises(InputError, match="the best fit leaves .*at most 10 % of the peak: are its units, signs and"):
        calibrate(replace(RIGHT, **changes), WALL, step=0.03)


def test_a_displacement_that_the_wall_does_not_come_back_from_is_refused():
    far = replace(RIGHT, displacement=SHOWN + np.linspace(0, 0.4, SHOWN.size))
    with pytest.raises(InputError, match=r"the largest measured displacement is 0\.[34].* the wall collapses"):
        require_possible(far, WALL)
    for displacement, words in ((1000 * SHOWN, "times u_ins = "), (0 * SHOWN, "the measured displacement is constant")):
        with pytest.raises(InputError, match=words):
            require_possible(replace(RIGHT, displacement=displacement), WALL)


def test_a_clean_record_has_no_noise_to_compare_with():
    assert str(Misfit(1e-3, 0.02, None)) == "1 mm, 2 % of the peak"
    assert Misfit(1e-3, 0.02, None).exceeds(0.01) and not Misfit(1e-3, 0.02, 1.2).exceeds(0.01)


def test_an_uncertain_size_adds_what_another_size_changes():
    """Of both estimates, half of the difference by a thicker and a thinner wall."""
    exact, uncertain = (calibrate(RIGHT, WALL, step=0.03, uncertain=sizes) for sizes in (None, {"thickness": 1e-3}))
    sides = (replace(WALL, thickness=WALL.thickness + side) for side in (1e-3, -1e-3))
    thick, thin = (calibrate(RIGHT, wall, step=0.03)["estimate"].values for wall in sides)
    added = np.diag(uncertain["covariance"] - exact["covariance"])
    np.testing.assert_allclose(np.sqrt(added), np.abs(thick - thin) / 2, rtol=0.2)  # the misfit is rough
