"""Free-rocking tests of a wall, by the event-driven solver, as a sensor measures them."""

import numpy as np

import rockdamp as rd
from rockdamp.solvers.exact import exact_history

WALL = rd.Wall(thickness=0.25, height=3.0, hinge_ratio=0.6)
U_INS = float(WALL.instability_displacement)
P = float(WALL.frequency_parameter)
CURVE = rd.TrilinearCurve(0.05, 0.8)
E = 0.86
STEP = 0.002
NOISE = 2e-4
ZERO = 0.003


def free_motion(elapsed, curve=CURVE, damping=None, release=0.5):
    """Return the displacement at times after a release. [m]"""
    damping = damping or rd.Damping("CR", E)
    history = exact_history(curve, damping, P * elapsed, release_amplitude=release)
    return U_INS * history.displacement


def white_noise(size, seed=1, noise=NOISE):
    return noise * np.random.RandomState(seed).standard_normal(size)


def decay(damping=None, release=0.5, sign=1.0, seed=1, noise=NOISE, held_samples=250):
    """Return the measured displacement of a specimen that is held, released and comes to rest."""
    free = free_motion(STEP * np.arange(3000), damping=damping, release=release)
    held = np.full(held_samples, release * U_INS)
    displacement = sign * np.concatenate([held, free, np.zeros(300)])
    return displacement + ZERO + white_noise(displacement.size, seed, noise)


def make_test(displacement, **options):
    return rd.FreeRocking(STEP * np.arange(displacement.size), displacement, **options)
