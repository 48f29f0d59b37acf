"""Walls that rock to one side, by closed forms, by the two-sided motion, and by SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rockdamp as rd
from rockdamp.solvers.exact import exact_history

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)


def run(e, times, **start):
    return exact_history(CURVE, rd.Damping("CR", e), times, one_sided=True, **start)


@pytest.mark.nojit
@pytest.mark.parametrize("e", [0.3, 0.7, 0.95])
def test_each_impact_leaves_the_square_of_restitution(e):
    history = run(e, [8.0], release_amplitude=0.7)
    energy = CURVE.energy([0.7, *history.turning_displacement])
    energy = energy[energy > 1e-9]
    assert len(energy) >= 3 and history.peak == 0.7
    assert energy[1:] / energy[:-1] == pytest.approx(e**2, rel=1e-7)


@pytest.mark.nojit
def test_under_a_constant_push_the_bounces_are_a_geometric_series_and_end():
    e, v, push = 0.6, 1e-4, -1.5
    history = run(e, [2e-4, 5e-4, 0.1], release_velocity=v, load=[push, push], sampling=10.0)
    # The force of the first branch is 1e-7 of the push and less, so high does it bounce.
    first = 2 * v / -push
    assert history.impacts[:8] == pytest.approx(
        first * (1 - e ** np.arange(1, 9)) / (1 - e), rel=1e-5
    )
    assert history.impacts[-1] == pytest.approx(first / (1 - e), abs=4e-6)  # then it rests
    assert history.impacts.size < 12 and (history.displacement == 0).tolist() == [False, True, True]


@pytest.mark.nojit
def test_a_wall_at_rest_lifts_when_the_load_turns():
    history = run(0.5, [0.0, 0.4, 0.6], load=[-0.5, 0.5], sampling=1.0)
    assert history.displacement[:2].tolist() == [0.0, 0.0] and not history.impacts.size
    # x'' = t - k x on the first branch from 0.5 on, to fifth order.
    assert history.displacement[2] == pytest.approx(
        0.1**3 / 6 - CURVE.initial_stiffness * 0.1**5 / 120, rel=1e-3
    )


@pytest.mark.nojit
@pytest.mark.parametrize("load", [0.2, 0.5, 0.7])
def test_a_step_load_from_rest_goes_to_where_its_work_is_stored(load):
    peak = brentq(lambda x: float(CURVE.energy(x)) - load * x, 1e-6, 0.3)
    found = run(0.5, [1.5], load=[load, load], sampling=9.0)
    assert found.peak == found.turning_displacement[0] == pytest.approx(peak, rel=1e-12)


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_in_free_decay_it_is_the_mirrored_two_sided_motion(e):
    times = np.linspace(0, 15, 500)
    two = exact_history(CURVE, rd.Damping("CR", e), times, release_amplitude=0.6)
    assert run(e, times, release_amplitude=0.6).displacement == pytest.approx(
        np.abs(two.displacement), abs=1e-8
    )


def integrate(e, load, dt, times):
    """Return x at the times by DOP853 from event to event: impact, turn of the load at rest, samples."""
    k1, b1, ks, _, _, a3 = (float(value) for value in CURVE.parameters())
    x, v, found = 0.0, 0.0, [0.0]

    def rates(t, y):
        z = max(y[0], 0.0)
        return y[1], p + slope * (t - start) - min(k1 * z, b1, ks * (a3 - z))

    def hits(t, y):
        return y[0] if t > begun or y[1] <= 0 else 1.0

    hits.terminal, hits.direction = True, -1
    options = {"events": hits, "method": "DOP853", "rtol": 1e-10, "atol": 1e-13, "max_step": dt / 4}
    for segment, start in enumerate(times[:-1]):
        p, end = load[segment], times[segment + 1]
        slope, begun = (load[segment + 1] - p) / dt, start
        while begun < end:
            now = p + slope * (begun - start)
            if x == 0.0 and v == 0.0 and now <= 1e-12:
                begun = min(begun - now / slope if slope > 0 else np.inf, end) + 1e-15
                if begun >= end:
                    break
            ended = solve_ivp(rates, (begun, end), (x, v), **options)
            begun, (x, v) = ended.t[-1], ended.y[:, -1]
            if x > a3:
                return [*found, *[np.nan] * (len(times) - len(found))]
            if ended.status == 1:
                x, v = 0.0, -e * v
                v = 0.0 if v < 1e-6 and p + slope * (begun - start) <= 0 else v
        found.append(x)
    return found


@pytest.mark.parametrize("e", [0.3, 0.6])
def test_random_loads_move_a_wall_as_by_brute_force(e):
    differences, largest = [], 0.0
    for seed in range(6):
        random = np.random.default_rng(seed)
        dt = random.choice([0.05, 0.1])
        load = 10 ** random.uniform(-0.5, 0.3) * np.sin(random.uniform(0.1, 2.0) * np.arange(60))
        times = dt * np.arange(60)
        found, expected = (
            run(e, times, load=load, sampling=dt).displacement,
            np.array(integrate(e, load, dt, times)),
        )
        largest = max(largest, np.nanmax(found))
        same = np.array_equal(np.isnan(found), np.isnan(expected))
        differences.append(np.nanmax(np.abs(found - expected)) if same else 1.0)
    assert np.median(differences) < 1e-6
    assert np.sum(np.array(differences) > 1e-3) <= 1  # a history of many impacts forks
    assert 0.1 < largest <= 1.0


def test_restitution_of_a_facade_is_sorrentinos():
    # 0.478 at h/t = 8 by hand: sin^2 = 1/65.
    facade = rd.OneSidedWall(rd.Parapet(thickness=0.5, height=4.0))
    assert facade.restitution_measured == pytest.approx(
        1.05 * (1 - 1.5 / 65) ** 2 * (1.5 * 64 / 65 - 1)
    )
    assert facade.restitution_measured == pytest.approx(0.478, abs=5e-4)


def test_a_release_outside_the_curve_and_a_viscous_damper_are_refused():
    for release in (1.5, -0.1):
        with pytest.raises(rd.InputError, match="release_amplitude"):
            run(0.5, [1.0], release_amplitude=release)
    with pytest.raises(rd.InputError, match="damping_model"):
        exact_history(CURVE, rd.Damping("CDC", 0.05), [1.0], one_sided=True)
