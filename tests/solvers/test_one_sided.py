"""Walls that rock to one side, by closed forms, by the two-sided solvers, and by SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rockdamp as rd
from rockdamp.solvers import event_driven, one_sided

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)


@pytest.mark.nojit
@pytest.mark.parametrize("e", [0.3, 0.7, 0.95])
def test_each_impact_leaves_the_square_of_restitution(e):
    history = one_sided.history(CURVE, e, [8.0], release_amplitude=0.7)
    energy = CURVE.energy([0.7, *history.of_kind("turn")[:, 1]])
    energy = energy[energy > 1e-9]
    assert len(energy) >= 3
    assert energy[1:] / energy[:-1] == pytest.approx(e**2, rel=1e-7)


@pytest.mark.nojit
def test_under_a_constant_push_the_bounces_are_a_geometric_series():
    e, v, push = 0.6, 1e-4, -1.5
    history = one_sided.history(CURVE, e, [0.1], release_velocity=v, load=[push, push], load_step=10.0)
    impacts, rest = history.of_kind("impact"), history.of_kind("rest")
    # The force of the first branch is 1e-7 of the push and less, so high does it bounce.
    first = 2 * v / -push
    assert impacts[:8, 0] == pytest.approx(first * (1 - e ** np.arange(1, 9)) / (1 - e), rel=1e-5)
    assert rest[0, 0] == pytest.approx(first / (1 - e), abs=4e-6)
    assert len(rest) == 1


@pytest.mark.nojit
def test_a_wall_at_rest_lifts_when_the_load_turns():
    history = one_sided.history(CURVE, 0.5, [0.0, 0.4, 0.6], load=[-0.5, 0.5], load_step=1.0)
    assert history.of_kind("lift")[0, 0] == pytest.approx(0.5, abs=1e-9)
    assert history.displacement[:2].tolist() == [0.0, 0.0]
    # x'' = t - k x on the first branch, to fifth order.
    stiffness = float(CURVE.initial_stiffness)
    assert history.displacement[2] == pytest.approx(0.1**3 / 6 - stiffness * 0.1**5 / 120, rel=1e-3)


@pytest.mark.nojit
@pytest.mark.parametrize("load", [0.2, 0.5, 0.7])
def test_a_step_load_from_rest_goes_to_where_its_work_is_stored(load):
    peak = brentq(lambda x: float(CURVE.energy(x)) - load * x, 1e-6, 0.3)
    found = one_sided.history(CURVE, 0.5, [1.5], load=[load, load], load_step=9.0)
    assert found.of_kind("turn")[0, 1] == pytest.approx(peak, rel=1e-12)


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_in_free_decay_it_is_the_mirrored_two_sided_motion(e):
    times = np.linspace(0, 15, 500)
    one = one_sided.history(CURVE, e, times, release_amplitude=0.6)
    two = event_driven.history(CURVE, rd.Damping.cr(e), times, release_amplitude=0.6)
    assert one.displacement == pytest.approx(np.abs(two.displacement), abs=1e-8)


@pytest.mark.nojit
def test_collapse_ends_a_history():
    history = one_sided.history(CURVE, 0.5, np.linspace(0, 10, 50), load=[2.0, 2.0], load_step=20.0)
    assert history.ends.outcome == 1
    assert np.isnan(history.displacement[-1])
    assert np.nanmax(history.displacement) <= 1.0


def test_times_that_are_asked_for_change_nothing():
    random, dt, samples = np.random.default_rng(0), 0.02, 500
    load = 0.8 * np.sin(2 * dt * np.arange(samples)) + 0.2 * random.normal(size=samples)
    few, many = (
        one_sided.history(CURVE, 0.6, times, load=load, load_step=dt)
        for times in ([499 * dt], np.linspace(0, 499 * dt, 999))
    )
    np.testing.assert_array_equal(few.events, many.events)
    assert few.displacement[-1] == many.displacement[-1] and len(few.of_kind("impact")) > 5


def by_brute_force(e, load, dt, times):
    """Integrate by DOP853 from event to event: impact, turn of the load at rest, samples; x at the times."""
    k1, b1, ks, _, _, a3 = (float(value) for value in CURVE.parameters())
    x, v, found = 0.0, 0.0, [0.0]

    def rates(t, y):
        z = max(y[0], 0.0)
        return y[1], p + slope * (t - start) - min(k1 * z, b1, ks * (a3 - z))

    def hits(t, y):
        return y[0] if t > begun or y[1] <= 0 else 1.0

    hits.terminal, hits.direction = True, -1
    for segment, start in enumerate(times[:-1]):
        p = load[segment]
        slope, begun = (load[segment + 1] - p) / dt, start
        while begun < times[segment + 1]:
            now = p + slope * (begun - start)
            if x == 0.0 and v == 0.0 and now <= 1e-12:
                begun = min(begun - now / slope if slope > 0 else np.inf, times[segment + 1]) + 1e-15
                if begun >= times[segment + 1]:
                    break
            ended = solve_ivp(
                rates,
                (begun, times[segment + 1]),
                (x, v),
                events=hits,
                method="DOP853",
                rtol=1e-10,
                atol=1e-13,
                max_step=dt / 4,
            )
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
    for seed in range(8):
        random = np.random.default_rng(seed)
        dt = random.choice([0.05, 0.1])
        load = 10 ** random.uniform(-0.5, 0.3) * np.sin(random.uniform(0.1, 2.0) * np.arange(60))
        times = dt * np.arange(60)
        exact = one_sided.history(CURVE, e, times, load=load, load_step=dt).displacement
        found = np.array(by_brute_force(e, load, dt, times))
        largest = max(largest, np.nanmax(exact))
        differences.append(1.0 if np.any(np.isnan(exact) != np.isnan(found)) else np.nanmax(np.abs(exact - found)))
    assert np.median(differences) < 1e-6
    assert np.sum(np.array(differences) > 1e-3) <= 1  # a history of many impacts forks
    assert largest > 0.1


def test_bad_input_is_refused():
    with pytest.raises(rd.InputError, match="release_amplitude is 1.5; it must be at least 0 and less than a3"):
        one_sided.history(CURVE, 0.5, [1.0], release_amplitude=1.5)
    with pytest.raises(rd.InputError, match="release_amplitude is -0.1"):
        one_sided.history(CURVE, 0.5, [1.0], release_amplitude=-0.1)
    with pytest.raises(rd.InputError, match=r"restitution \(e\) is 0.0; it must be greater than 0"):
        one_sided.history(CURVE, 0.0, [1.0])
