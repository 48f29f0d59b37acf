"""Random facades with ties, by a third integrator: small Runge-Kutta steps, with impacts located by halves."""

import numpy as np
import pytest
from numba import njit

import rockdamp as rd
from rockdamp.mechanics.one_sided import RIGID, OneSidedForce, Stop
from rockdamp.solvers import one_sided_events

STILL = 1e-7  # speed after an impact below which a pressed wall rests
SAMPLES, REST, STEP = 80, 20, 2e-5


@njit
def acceleration(w, x, largest, load):
    """The tie remembers by the largest displacement so far alone."""
    slope, initial, b1, ks, _, _, a3, stiffness, strength, gap, rupture = w
    own = min(initial + slope * x, b1, ks * (a3 - x))
    at = max(x, largest)
    if stiffness == 0.0 or at > gap + rupture:
        return load - own
    return load - own - max(stiffness * (x - max(gap, at - strength / stiffness)), 0.0)


@njit
def step(w, x, v, largest, load, slope, h):
    a = acceleration(w, x, largest, load)
    xb, vb = x + 0.5 * h * v, v + 0.5 * h * a
    b = acceleration(w, xb, largest, load + 0.5 * h * slope)
    xc, vc = x + 0.5 * h * vb, v + 0.5 * h * b
    c = acceleration(w, xc, largest, load + 0.5 * h * slope)
    xd, vd = x + h * vc, v + h * c
    d = acceleration(w, xd, largest, load + h * slope)
    return x + h / 6 * (v + 2 * vb + 2 * vc + vd), v + h / 6 * (a + 2 * b + 2 * c + d)


@njit
def move(w, e, load, slope, h, x, v, largest):
    """Move on by h, through whatever impacts there are, and the tie's rupture."""
    while h > 0.0:
        if x == 0.0 and v == 0.0 and max(load, load + slope * h) <= w[1]:
            return x, v, largest
        breaks = w[9] + w[10] if largest <= w[9] + w[10] else np.inf
        x_end, v_end = step(w, x, v, largest, load, slope, h)
        if 0.0 <= x_end <= breaks:
            return x_end, v_end, max(largest, x_end)
        low, high = 0.0, h
        for _ in range(60):
            middle = 0.5 * (low + high)
            if 0.0 <= step(w, x, v, largest, load, slope, middle)[0] <= breaks:
                low = middle
            else:
                high = middle
        x, v = step(w, x, v, largest, load, slope, low)
        h, load = h - low, load + slope * low
        if x_end > breaks:
            largest = breaks + 1e-12
            continue
        x, v = 0.0, -e * min(v, 0.0)
        if v < STILL and load <= w[1]:
            v = 0.0
            if slope <= 0.0:
                return x, v, largest
            waited = min((w[1] - load) / slope, h)
            h, load = h - waited, load + slope * waited
    return x, v, largest


@njit
def by_brute_force(w, e, load, dt, steps, history):
    x = v = largest = 0.0
    for sample in range(history.size - 1):
        start = load[sample] if sample < load.size - 1 else 0.0
        slope = (load[sample + 1] - start) / dt if sample < load.size - 1 else 0.0
        for part in range(steps):
            x, v, largest = move(w, e, start + slope * part * dt / steps, slope, dt / steps, x, v, largest)
            if x > w[6]:
                return
        history[sample + 1] = x


def random_facade(seed):
    random = np.random.default_rng(seed)
    a1 = random.choice([0.04, 0.13])
    b1 = random.uniform(0.5, 0.95 * (1 - a1))
    stiffness = 10 ** random.uniform(0, 2)
    strength = random.choice([10.0, 10 ** random.uniform(-1.5, 0.5)])  # some never yield
    stretch = strength / stiffness
    force = OneSidedForce(
        rd.TrilinearCurve(a1, b1),
        random.choice([0.0, b1 * random.random()]),
        tie_stiffness=stiffness,
        tie_strength=strength,
        tie_gap=random.choice([0.0, 0.05 * random.random()]),
        tie_rupture=random.choice([RIGID, stretch, stretch * random.uniform(1, 5)]),
    )
    load = 10 ** random.uniform(-0.3, 0.6) * np.sin(random.uniform(0.1, 2.0) * np.arange(SAMPLES))
    return force, random.choice([0.1, 0.3, 0.5, 0.7]), load, random.choice([0.03, 0.1])


@pytest.mark.parametrize("first", range(0, 80, 20))
def test_random_facades_with_ties_move_as_by_brute_force(first):
    differences, moved = [], 0.0
    for seed in range(first, first + 20):
        force, e, load, dt = random_facade(seed)
        times = dt * np.arange(SAMPLES + REST)
        exact = one_sided_events.history(force, Stop(RIGID, e), times, load=load, load_step=dt).displacement
        found = np.r_[0.0, np.full(times.size - 1, np.nan)]
        w = tuple(float(value) for value in force.parameters())
        by_brute_force(w, e, load, dt, int(dt / STEP), found)
        moved = max(moved, np.nanmax(exact))
        differences.append(1.0 if np.any(np.isnan(exact) != np.isnan(found)) else np.nanmax(np.abs(exact - found)))
    assert np.median(differences) < 1e-6
    assert np.sum(np.array(differences) > 1e-3) <= 1  # a history of many impacts forks
    assert moved > 0.1
