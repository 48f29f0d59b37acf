"""What a fit leaves of a record: slips in the record are refused with the word for them, and a right record is not."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.histories.measured_test import rest_samples
from rockdamp.laboratory import least_squares
from rockdamp.laboratory.calibration import Misfit, require_explained, require_possible, slips, table_displacement
from rockdamp.laboratory.candidates import Candidate
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.named_tests import require_possible_tests
from rockdamp.motions.pulse_shapes import table_pulse
from rockdamp.motions.records import Record, read_record, write_record
from rockdamp.vocabulary import STANDARD_GRAVITY

SHIPPED = read_record(ROOT / "data/test_series/cr-half.csv")
# Every other sample of the first 1.6 s, for speed.
RIGHT = Record(*(column[:410:2] for column in (SHIPPED.elapsed, SHIPPED.ground_acceleration, SHIPPED.displacement)))
MOTION, SHOWN = RIGHT.ground_acceleration, RIGHT.displacement
TOP = 0.6 * np.abs(SHOWN).max()


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """A coarser scan, for speed."""
    monkeypatch.setitem(least_squares.GRID, "strength_ratio", np.linspace(0.42, 0.94, 27))
    monkeypatch.setattr(least_squares, "REFINEMENTS", 4)


def judged(record):
    require_possible(record, WALL)
    fit = RecordFit.from_record(
        record, WALL, Candidate("CR"), ultimate_displacement_ratio=1.0, softening="steeper", step=0.03
    )
    return require_explained(fit.solution())


def test_of_a_right_record_the_misfit_is_the_sensors_noise():
    misfit = judged(RIGHT)
    assert misfit.residual_rms == pytest.approx(1.5e-4, rel=0.1)  # data/test_series: the sensor's noise
    assert misfit.residual_over_peak == pytest.approx(misfit.residual_rms / np.abs(SHOWN - SHOWN[0]).max(), rel=0.02)
    assert not misfit.doubts


def test_neither_a_drift_nor_the_first_motion_of_the_wall_is_noise_of_the_sensor():
    count = rest_samples(RIGHT)
    moving = np.where(np.arange(SHOWN.size) < 0.8 * count, 0.0, 2e-3)  # while the ground's is within noise
    drifting = replace(RIGHT, displacement=SHOWN + 0.01 * RIGHT.elapsed + moving)
    right, shown = (
        RecordFit.from_record(
            record, WALL, Candidate("CR"), ultimate_displacement_ratio=1.0, softening="steeper", step=0.03
        )
        for record in (RIGHT, drifting)
    )
    assert shown.rest_deviation == pytest.approx(right.rest_deviation, rel=1e-6)
    assert right.rest_deviation == pytest.approx(1.5e-4, rel=0.3)  # data/test_series: the sensor's noise


@pytest.mark.parametrize(
    "changes, words",
    [
        (
            {"ground_acceleration": -MOTION},
            "If the sign of the acceleration, or of the displacement, is wrong, it leaves 0.14",
        ),
        ({"displacement": SHOWN + table_displacement(RIGHT)}, "If the table's displacement is not subtracted from"),
        ({"displacement": SHOWN - table_displacement(RIGHT)}, "the table's displacement is subtracted once too often"),
        ({"ground_acceleration": MOTION / STANDARD_GRAVITY}, "If the acceleration is in g, it leaves 0.14"),
        (
            {"ground_acceleration": 100 * MOTION / STANDARD_GRAVITY},
            "If the acceleration is in per cent of g, it leaves 0.14",
        ),
        (
            {"ground_acceleration": STANDARD_GRAVITY * MOTION, "unit_of_file": "g"},
            "If the acceleration is in m s-2, it leaves 0.14",
        ),
        ({"displacement": np.clip(SHOWN, -TOP, TOP)}, "is the displacement clipped, of which .* samples are all"),
        ({"displacement": 1000 * SHOWN}, "times u_ins = .*, beyond which the wall collapses; was it in millimetres?"),
        (
            {"displacement": MOTION, "ground_acceleration": SHOWN},
            "were its column and that of the acceleration exchang",
        ),
        ({"displacement": 0 * SHOWN}, "the measured displacement is constant"),
    ],
)
def test_a_slip_is_refused_with_the_word_for_it(changes, words):
    with pytest.raises(InputError, match=words):
        judged(replace(RIGHT, **changes))


def test_a_forgotten_displacement_of_a_table_that_moves_far_is_no_slip_of_the_unit():
    at, width = RIGHT.elapsed - 1.0, 0.15
    moved = 0.5 * np.exp(-((at / width) ** 2))
    acceleration = moved * ((2 * at / width**2) ** 2 - 2 / width**2)
    far = replace(RIGHT, ground_acceleration=MOTION + acceleration, displacement=SHOWN + moved)
    with pytest.raises(InputError, match="the wall collapses; was the table's displacement not subtracted from"):
        require_possible(far, WALL)


def test_of_a_displacement_that_the_wall_does_not_come_back_from_the_file_is_named(tmp_path):
    require_possible_tests([str(ROOT / "data/test_series/cr-half.csv")], WALL)
    far = tmp_path / "far.csv"
    write_record(str(far), replace(RIGHT, displacement=SHOWN + np.linspace(0, 0.4, SHOWN.size)))
    with pytest.raises(InputError, match=r"far.csv: the largest measured displacement is 0\.[34].* the wall collapses"):
        require_possible_tests([str(far)], WALL)


def test_the_flat_top_that_a_coarse_logger_makes_of_a_slow_peak_is_not_clipped(monkeypatch):
    coarse = replace(RIGHT, displacement=np.round(SHOWN, 3))
    worse = np.random.RandomState(1).uniform(-2e-3, 2e-3, SHOWN.size).round(3)
    assert not judged(replace(coarse, displacement=coarse.displacement + worse)).residual_over_noise > 3


def test_a_record_that_no_wall_and_no_slip_explains_is_refused():
    other = np.abs(SHOWN - SHOWN[0])  # it never crosses its rest
    with pytest.raises(InputError, match="at most 10 %.* It fits no better if the sign .* sizes and load right"):
        judged(replace(RIGHT, displacement=other))


def test_the_table_moves_as_its_pulse_says_but_for_what_its_mean_at_rest_adds():
    """By a finer sum; what remains of a mean at rest grows as a parabola, and the fit's trend takes that."""
    elapsed, fine = np.arange(1001) / 250, np.arange(100_001) / 25_000
    moved = table_displacement(Record(elapsed, table_pulse(elapsed - 1.5, 10.0)))
    exact = (np.cumsum(np.cumsum(table_pulse(fine - 1.5, 10.0))) / 25_000**2)[::100]
    trend = np.vander(elapsed, 3)
    left = (moved - exact) - trend @ np.linalg.lstsq(trend, moved - exact, rcond=None)[0]
    assert np.abs(left).max() < 0.01 * np.abs(exact).max()


def test_a_clean_record_has_no_noise_to_compare_with():
    assert str(Misfit(1e-3, 0.02, None)) == "1 mm, 2 % of the peak"
    (doubt,) = Misfit(1e-3, 0.02, None).doubts
    assert "under this model and these sizes alone" in doubt and not Misfit(1e-3, 0.02, 1.2).doubts


def test_the_displacement_of_the_table_in_place_of_the_walls_is_named():
    noise = 1e-4 * np.random.default_rng(1).standard_normal(SHOWN.size)
    own = replace(RIGHT, displacement=table_displacement(RIGHT) + noise)
    with pytest.raises(InputError, match="is the displacement that of the table itself"):
        judged(own)


def test_the_displacement_of_a_table_that_moves_far_is_named_with_what_was_done_with_it():
    at, width = RIGHT.elapsed - 1.0, 0.15
    moved = 0.5 * np.exp(-((at / width) ** 2))
    far = replace(RIGHT, ground_acceleration=MOTION + moved * ((2 * at / width**2) ** 2 - 2 / width**2))
    for times, words in ((-1, "subtracted once too often from"), (2, "added in place of subtracted from")):
        with pytest.raises(InputError, match=f"was the table's displacement {words} the wall's"):
            require_possible(replace(far, displacement=SHOWN + times * moved), WALL)
    with pytest.raises(InputError, match=r"and PGA is .*, over 3 g, .*: are the columns right\?"):
        require_possible(replace(far, ground_acceleration=1000 * MOTION, displacement=SHOWN + moved), WALL)


def test_the_unit_that_is_named_is_in_place_of_that_which_was_typed():
    """m s-2 typed as g: taken as m s-2 the record would be "in per cent of g", 2 % off."""
    made = {"table_acceleration_channel": f"a, times {STANDARD_GRAVITY:.9g}"}
    record = replace(RIGHT, ground_acceleration=STANDARD_GRAVITY * MOTION, header=made)
    fit = RecordFit.from_record(
        record, WALL, Candidate("CR"), ultimate_displacement_ratio=1.0, softening="steeper", step=0.03
    )
    moved = dict(slips(fit))["the acceleration is in m s-2"].record.ground_acceleration
    np.testing.assert_allclose(moved, MOTION, rtol=1e-8)
