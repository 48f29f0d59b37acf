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
    assert len(energy) >= 3
    assert history.peak == 0.7
    assert energy[1:] / energy[:-1] == pytest.approx(e**2, rel=1e-7)


@pytest.mark.nojit
def test_bounces_under_a_push_are_a_geometric_series():
    """The force of the first branch is at most 1e-7 of the push, so low are the bounces."""
    e, v, push = 0.6, 1e-4, -1.5
    history = run(e, [2e-4, 5e-4, 0.1], release_velocity=v, load=[push, push], sampling=10.0)
    first = 2 * v / -push
    series = first * (1 - e ** np.arange(1, 9)) / (1 - e)
    assert history.impacts[:8] == pytest.approx(series, rel=1e-5)
    assert history.impacts[-1] == pytest.approx(first / (1 - e), abs=4e-6)  # then it rests
    assert history.impacts.size < 12
    assert (history.displacement == 0).tolist() == [False, True, True]


@pytest.mark.nojit
@pytest.mark.parametrize("slope", [1.0, 0.05])
def test_wall_at_rest_lifts_when_the_load_turns(slope):
    load = [-0.5 * slope, 0.5 * slope]
    history = run(0.5, [0.0, 0.4, 0.6], load=load, sampling=1.0)
    assert history.displacement[:2].tolist() == [0.0, 0.0]
    assert not history.impacts.size
    # x'' = slope t - k x on the first branch from 0.5 on, to fifth order.
    expected = slope * (0.1**3 / 6 - CURVE.initial_stiffness * 0.1**5 / 120)
    assert history.displacement[2] == pytest.approx(expected, rel=1e-3)


@pytest.mark.nojit
@pytest.mark.parametrize("load", [0.2, 0.5, 0.7])
def test_step_load_goes_to_where_its_work_is_stored(load):
    expected = brentq(lambda x: float(CURVE.energy(x)) - load * x, 1e-6, 0.3)
    history = run(0.5, [1.5], load=[load, load], sampling=9.0)
    assert history.peak == pytest.approx(expected, rel=1e-12)
    assert history.turning_displacement[0] == history.peak


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_free_decay_is_the_mirrored_two_sided_motion(e):
    times = np.linspace(0, 15, 500)
    two_sided = exact_history(CURVE, rd.Damping("CR", e), times, release_amplitude=0.6)
    one_sided = run(e, times, release_amplitude=0.6)
    assert one_sided.displacement == pytest.approx(np.abs(two_sided.displacement), abs=1e-8)


def integrate(e, load, dt, times):
    """Return x at the times by DOP853 from event to event.

    Events are impacts, the turn of the load at rest, and samples.
    """
    k1, b1, ks, _, _, a3 = (float(value) for value in CURVE.parameters())
    x = 0.0
    v = 0.0
    displacement = [0.0]

    def rates(t, y):
        z = max(y[0], 0.0)
        return y[1], p + slope * (t - start) - min(k1 * z, b1, ks * (a3 - z))

    def hits(t, y):
        return y[0] if t > begin or y[1] <= 0 else 1.0

    hits.terminal = True
    hits.direction = -1
    options = {"events": hits, "method": "DOP853", "rtol": 1e-10, "atol": 1e-13, "max_step": dt / 4}
    for segment, start in enumerate(times[:-1]):
        p = load[segment]
        slope = (load[segment + 1] - p) / dt
        end = times[segment + 1]
        begin = start
        while begin < end:
            current_p = p + slope * (begin - start)
            if x == 0.0 and v == 0.0 and current_p <= 1e-12:
                lift = begin - current_p / slope if slope > 0 else np.inf
                begin = min(lift, end) + 1e-15
                if begin >= end:
                    break
            part = solve_ivp(rates, (begin, end), (x, v), **options)
            begin = part.t[-1]
            x, v = part.y[:, -1]
            if x > a3:
                missing = len(times) - len(displacement)
                return np.array([*displacement, *[np.nan] * missing])
            if part.status == 1:
                x = 0.0
                v = -e * v
                if v < 1e-6 and p + slope * (begin - start) <= 0:
                    v = 0.0
        displacement.append(x)
    return np.array(displacement)


@pytest.mark.parametrize("e", [0.3, 0.6])
def test_random_loads_move_a_wall_as_by_brute_force(e):
    differences = []
    peaks = []
    for seed in range(6):
        random = np.random.default_rng(seed)
        dt = random.choice([0.05, 0.1])
        amplitude = 10 ** random.uniform(-0.5, 0.3)
        load = amplitude * np.sin(random.uniform(0.1, 2.0) * np.arange(60))
        times = dt * np.arange(60)
        displacement = run(e, times, load=load, sampling=dt).displacement
        expected = integrate(e, load, dt, times)
        peaks.append(np.nanmax(displacement))
        same_outcome = np.array_equal(np.isnan(displacement), np.isnan(expected))
        difference = np.nanmax(np.abs(displacement - expected))
        differences.append(difference if same_outcome else 1.0)
    assert np.median(differences) < 1e-6
    assert np.sum(np.array(differences) > 1e-3) <= 1  # a history of many impacts forks
    assert 0.1 < max(peaks) <= 1.0


@pytest.mark.parametrize("release", [1.5, -0.1])
def test_release_outside_the_curve_is_refused(release):
    with pytest.raises(rd.InputError, match="release_amplitude"):
        run(0.5, [1.0], release_amplitude=release)


def test_viscous_damper_is_refused():
    with pytest.raises(rd.InputError, match="damping_model"):
        exact_history(CURVE, rd.Damping("CDC", 0.05), [1.0], one_sided=True)
