"""The march of walls whose force is not odd or changes with time, by laws of scale and beside `newmark`."""

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED
from rockdamp.solvers.uneven_march import collapses

CURVE = TrilinearCurve(0.06, 0.72)
LANES, SAMPLES = 60, 400
SIZE = np.linspace(0.3, 3.0, LANES)
GROUND = np.sin(0.045 * np.arange(SAMPLES)) * np.hanning(SAMPLES)


def march(lift=0.0, side=(1.0, 1.0), load=1.0, rate=1.0, vertical=None):
    """Collapses of many lanes under a sine that grows with the lane."""
    return collapses(
        CURVE,
        0.85,
        step=rate * 0.02,
        substeps=5,
        load=load * SIZE,
        ground=GROUND,
        lift=lift,
        vertical=np.ones(SAMPLES) if vertical is None else vertical,
        side=side,
    )


def test_an_even_wall_collapses_as_in_the_solver():
    run = {"load_factor": SIZE, "ground_acceleration": GROUND, "step": 0.02, "substeps": 5}
    expected = solve(CURVE, Damping.cr(0.85), steps=5 * (SAMPLES - 1), peaks_only=True, **run)
    assert 5 < march().sum() < 55
    np.testing.assert_array_equal(march(), expected.outcome == COLLAPSED)


def test_the_march_obeys_the_laws_of_scale():
    plain = march()
    # Twice the force at every u is the wall as it was, in a time that runs by sqrt(2), under half of the load.
    np.testing.assert_array_equal(march(lift=1.0, load=2.0, rate=1 / np.sqrt(2)), plain)
    # A curve that is larger by a half in force and displacement alike needs a load that is larger by a half.
    np.testing.assert_array_equal(march(side=(1.5, 1.5), load=1.5), plain)
    # A wall that is stronger to one side only lies between, and the sides change places with the sign of the load.
    one, both = march(side=(1.2, 1.0)), march(side=(1.2, 1.2))
    assert both.sum() <= one.sum() <= plain.sum() and both.sum() < plain.sum()
    np.testing.assert_array_equal(march(side=(1.0, 1.2), load=-1.0), one)
    np.testing.assert_array_equal(march(lift=5.0, vertical=np.zeros(SAMPLES)), plain)


@pytest.mark.nojit
def test_a_wall_without_weight_flies_off():
    """Where shaking takes all weight away nothing restores: x = load t^2/2 passes a3 after sqrt(2 a3/load)."""
    load, ground = 0.05 * np.array([0.99, 1.01]), np.ones(41)
    a3 = float(CURVE.ultimate_displacement_ratio)
    step = np.sqrt(2 * a3 / 0.05) / 40
    fell = collapses(CURVE, 0.85, step=step, substeps=1, load=load, ground=ground, lift=-2.0, vertical=np.ones(41))
    assert fell.tolist() == [False, True]


@pytest.mark.nojit
def test_both_motions_are_linear_between_their_samples():
    """Without weight a load that grows from 0 over one long interval T moves the wall by load T^2/6.

    The vertical motion, which takes all weight from 0.5 on, grows tenfold meanwhile. Before, nothing loads the wall.
    """
    duration, steps = 5.0, 400
    load = 6 * float(CURVE.ultimate_displacement_ratio) / duration**2 * np.array([0.99, 1.01])
    motions = {"ground": np.array([0.0, 0.0, 1.0]), "vertical": np.array([0.0, 1.0, 10.0])}
    fell = collapses(CURVE, 0.85, step=duration / steps, substeps=steps, load=load, lift=-2.0, **motions)
    assert fell.tolist() == [False, True]
