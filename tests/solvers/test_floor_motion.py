"""Floor motions against time integrations that share nothing with them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from rockdamp import Record
from rockdamp.solvers.oscillator import LEFT, POINTS, Ramps, floor_response

STEP, XI = 0.01, 0.05


@pytest.fixture(scope="module")
def record():
    random = np.random.default_rng(7)
    elapsed = STEP * np.arange(400)
    shaking = np.convolve(random.normal(size=400), np.ones(5), "same") * np.hanning(400)
    return Record(elapsed, shaking)


def integrated(record, mass, stiffness, damping):
    """Absolute accelerations and relative displacements of a structure, by SciPy's adaptive integrator."""
    count = len(mass)

    def ground(t):
        return np.interp(t, record.elapsed, record.ground_acceleration)

    def internal(u, v):
        return -(stiffness @ u + damping @ v) / mass

    def rate(t, state):
        u, v = state[:count], state[count:]
        return np.concatenate([v, internal(u, v) - ground(t)])

    options = {"rtol": 1e-8, "atol": 1e-10, "max_step": STEP, "t_eval": record.elapsed}
    solved = solve_ivp(rate, record.elapsed[[0, -1]], np.zeros(2 * count), **options)
    u, v = solved.y[:count], solved.y[count:]
    return np.stack([internal(*at) for at in zip(u.T, v.T, strict=True)], axis=1), u


def shear_frame(storeys, period):
    """Masses and stiffness of a frame of equal storeys, half a storey's mass on the roof, with a natural period."""
    mass = np.ones(storeys)
    mass[-1] = 0.5
    stiffness = 2 * np.eye(storeys) - np.eye(storeys, k=1) - np.eye(storeys, k=-1)
    stiffness[-1, -1] = 1
    square, vectors = eigh(stiffness, np.diag(mass))
    return mass, stiffness * (2 * np.pi / period) ** 2 / square[0], np.sqrt(square / square[0]), vectors


def at_samples(values, record):
    finer = round(record.step / values.step)
    return [each[:, : record.elapsed.size * finer : finer] for each in (values.acceleration, values.displacement)]


def test_the_modal_sums_of_a_frame_of_ten_storeys_are_its_time_integration(record):
    period = 0.8
    mass, stiffness, ratios, vectors = shear_frame(10, period)
    scaled = vectors / np.sqrt((vectors**2 * mass[:, None]).sum(axis=0))
    # Damping of XI in every mode: M Phi diag(2 xi w) Phi^T M.
    weighted = mass[:, None] * scaled
    damping = weighted @ np.diag(2 * XI * 2 * np.pi / period * ratios) @ weighted.T
    acceleration, displacement = integrated(record, mass, stiffness, damping)
    contribution = scaled * (mass @ scaled)
    found = at_samples(floor_response(record, period / ratios, contribution, XI), record)
    assert found[0] == pytest.approx(acceleration, abs=1e-5 * np.abs(acceleration).max())
    assert found[1] == pytest.approx(displacement, abs=1e-5 * np.abs(displacement).max())


def test_a_stiff_building_and_its_base_move_with_the_ground(record):
    ground = record.ground_acceleration
    stiff = at_samples(floor_response(record, np.array([1e-4]), np.array([[1.3]]), XI), record)[0]
    assert stiff[0] == pytest.approx(ground, abs=1e-12)
    base = at_samples(floor_response(record, np.array([0.3]), np.array([[0.0]]), XI), record)
    assert base[0][0] == pytest.approx(ground, abs=1e-12) and not base[1].any()
    rigid = floor_response(record, np.array([]), np.empty((2, 0)), XI)
    assert rigid.step == record.step and (rigid.acceleration == ground).all()


def test_a_finer_step_changes_nothing_at_the_samples(record):
    padded = np.concatenate([[0.0], record.ground_acceleration, np.zeros(20)])
    coarse, fine = (Ramps.from_samples(padded, STEP, finer) for finer in (1, 8))
    for name in ("lag", "displacement"):
        values, finer = (getattr(ramps, name)(0.3, XI) for ramps in (coarse, fine))
        assert finer[::8] == pytest.approx(values, abs=1e-11 * np.abs(values).max())


def test_the_free_vibration_is_followed_until_it_has_died_down(record):
    answer = floor_response(record, np.array([0.5]), np.array([[1.0]]), XI)
    w = 2 * np.pi / 0.5
    after = answer.step * answer.acceleration.shape[1] - record.step * record.elapsed.size
    assert np.exp(-XI * w * after) <= LEFT < np.exp(-XI * w * (after - 2 * record.step))


def test_the_shortest_period_has_its_points_whatever_the_longest_is():
    record = Record(0.02 * np.arange(50), np.sin(np.arange(50.0)))
    response = floor_response(record, np.array([1.0, 0.06]), np.ones((2, 2)), XI)
    assert POINTS <= 0.06 / response.step < 2 * POINTS
    after = response.step * response.acceleration.shape[1] - 0.02 * 50
    assert np.exp(-XI * 2 * np.pi / 1.0 * after) <= LEFT  # and the longest is followed until it has died down
