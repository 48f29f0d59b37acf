"""Laws that hold for every wall, curve, damper and load.

Where hypothesis finds one broken, it shows the smallest example.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rockdamp.constants import MODELS, PAPER_MODELS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.newmark import Load, simulate, stable_step

# Force in proportion to the velocity: C depends on the form of the state and not on its size.
LINEAR = [model for model in MODELS if model in ("CR", *PAPER_MODELS, "ECD")]
TAU = np.linspace(0, 8, 161)
both_schemes = pytest.mark.parametrize("scheme", ("newmark", "paper"))


def numbers(low, high):
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def curves(draw, softening=("steeper", "translated")):
    """Draw a curve whose branches are long enough for steps of 0.01 to be stable."""
    variant = draw(st.sampled_from(softening))
    b1 = draw(numbers(0.2, 0.9))
    least = 1 - b1 + 0.05 if variant == "steeper" else b1 + 0.06
    a3 = draw(numbers(least, 1.0))
    a2 = 1 - b1 if variant == "steeper" else a3 - b1
    a1 = draw(numbers(0.02, max(0.95 * a2, 0.02)))
    assume(a1 < a2 - 0.005)
    return TrilinearCurve(a1, b1, a3, variant)


@st.composite
def dampings(draw, models=MODELS):
    model = draw(st.sampled_from(models))
    values = numbers(0.5, 1.0) if model == "CR" else numbers(0.0, 0.4)
    return Damping(model, draw(values))


@st.composite
def walls(draw):
    t = draw(numbers(0.1, 0.5))
    return Wall(
        t,
        t * draw(numbers(8, 30)),
        width=draw(numbers(0.5, 3)),
        density=draw(numbers(1500, 2300)),
        hinge_ratio=draw(numbers(0.4, 0.8)),
        overburden_ratio=draw(numbers(0, 8)),
        eccentricity=t * draw(numbers(-0.5, 0.5)),
    )


def smooth_ground(seed):
    """Return the samples of four sines of random amplitude, frequency and phase."""
    rng = np.random.default_rng(seed)
    amplitude, frequency, phase = rng.uniform([0, 0.3, 0], [0.3, 4, 2 * np.pi], (4, 3)).T
    return (amplitude * np.sin(frequency * TAU[:, None] + phase)).sum(axis=1)


grounds = st.integers(0, 10**6).map(smooth_ground)
starts = st.tuples(numbers(-0.95, 0.95), numbers(-0.5, 0.5))


def shake(curve, damping, start, ground, scheme, scale=1.0):
    """Start at shares of a3 and of a velocity, both times a scale, under the scaled ground."""
    x0, v0 = start
    return simulate(
        curve,
        damping,
        release_amplitude=x0 * curve.ultimate_displacement_ratio,
        release_velocity=v0 * scale,
        scheme=scheme,
        load=Load(scale * ground, 1.0, 0.05, 5),
    )


# --- symmetry and scaling, to the bit ------------------------------------------------------------


@both_schemes
@given(curve=curves(), damping=dampings(), start=starts, ground=grounds)
@settings(max_examples=60)
def test_mirrored_motion_to_the_last_bit(scheme, curve, damping, start, ground):
    history = shake(curve, damping, start, ground, scheme)
    mirrored = shake(curve, damping, (-start[0], -start[1]), -ground, scheme)
    np.testing.assert_array_equal(mirrored.displacement, -history.displacement)
    np.testing.assert_array_equal(mirrored.velocity, -history.velocity)
    for name in ("collapsed", "end_tau", "peak", "peak_tau", "impacts"):
        np.testing.assert_array_equal(getattr(mirrored, name), getattr(history, name))


@both_schemes
@given(
    curve=curves(("translated",)),
    damping=dampings(LINEAR),
    start=starts,
    ground=grounds,
    halvings=st.integers(1, 3),
)
@settings(max_examples=60)
def test_smaller_curve_shrinks_the_history(scheme, curve, damping, start, ground, halvings):
    """With slope -K0 kept, a1, b1 and a3 times s are the same curve at the scale s."""
    s = 0.5**halvings
    small = curve.map(lambda parameter: s * parameter)
    history = shake(curve, damping, start, ground, scheme)
    shrunk = shake(small, damping, start, ground, scheme, scale=s)
    # A power of two rounds only a2 = a3 - b1; a collapse may fall on the next step.
    if not (history.collapsed or shrunk.collapsed):
        largest = np.abs(history.displacement).max()
        assume(largest < 0.98 * curve.ultimate_displacement_ratio)
        np.testing.assert_allclose(shrunk.displacement / s, history.displacement, atol=1e-9)


@given(wall=walls(), size=numbers(0.2, 5))
def test_time_goes_with_the_root_of_the_size(wall, size):
    """The same acceleration does the same, as strength goes with weight."""
    names = ("thickness", "height", "eccentricity")
    large = replace(wall, **{name: getattr(wall, name) * size for name in names})
    frequency = wall.frequency_parameter / np.sqrt(size)
    assert large.frequency_parameter == pytest.approx(frequency, rel=1e-12)
    u_ins = wall.instability_displacement * size
    assert large.instability_displacement == pytest.approx(u_ins, rel=1e-12)
    assert large.load_factor == pytest.approx(wall.load_factor, rel=1e-12)
    assert large.restitution_rigid == pytest.approx(wall.restitution_rigid, abs=1e-14)
    assert large.restitution_impulsive == pytest.approx(wall.restitution_impulsive, abs=1e-14)


# --- dampers -------------------------------------------------------------------------------------


@given(curve=curves(), damping=dampings(), x0=numbers(0.01, 0.95))
@settings(max_examples=100)
def test_free_decay_never_exceeds_its_release(curve, damping, x0):
    step = float(stable_step(curve)) / 40
    release = x0 * float(curve.ultimate_displacement_ratio)
    decay = simulate(curve, damping, release_amplitude=release, step=step, steps=2000)
    assert not decay.collapsed
    # A corner inside a step costs at most the fraction (w1 step)^2/4 = 6e-4 of the energy, in
    # either direction; a half cycle passes four.
    rounding = 6e-4 * 4 * (decay.impacts + 1)
    assert curve.energy(decay.peak) <= curve.energy(release) * (1 + rounding)
