"""Laws that hold for every wall, curve, damper and load: found broken, hypothesis shows the smallest example."""

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

SCHEMES = ("newmark", "paper")
TAU = np.linspace(0, 8, 161)


def numbers(low, high):
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def curves(draw, softening=("steeper", "translated")):
    """Any admissible curve with branches of some length, so that steps of 0.01 are well below the stability limit."""
    kind = draw(st.sampled_from(softening))
    b1 = draw(numbers(0.2, 0.9))
    a3 = draw(numbers(1 - b1 + 0.05 if kind == "steeper" else b1 + 0.06, 1.0))
    a2 = 1 - b1 if kind == "steeper" else a3 - b1
    a1 = draw(numbers(0.02, max(0.95 * a2, 0.02)))
    assume(a1 < a2 - 0.005)
    return TrilinearCurve(a1, b1, a3, kind)


@st.composite
def dampings(draw, models=MODELS):
    model = draw(st.sampled_from(models))
    return Damping(model, draw(numbers(0.5, 1.0) if model == "CR" else numbers(0.0, 0.4)))


# In proportion to the velocity: of these C depends on the state as a whole and not on its size.
LINEAR = [model for model in MODELS if model in ("CR", *PAPER_MODELS, "ECD")]


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


def load(seed):
    """A smooth load of some strength, and its samples."""
    amplitude, frequency, phase = (
        np.random.default_rng(seed).uniform([0, 0.3, 0], [0.3, 4, 2 * np.pi], (4, 3)).T
    )
    return (amplitude * np.sin(frequency * TAU[:, None] + phase)).sum(axis=1)


seeds = st.integers(0, 10**6)
starts = st.tuples(numbers(-0.95, 0.95), numbers(-0.5, 0.5))


def respond(curve, damping, start, ground, scheme, scale=1.0):
    x0, v0 = start
    release = {
        "release_amplitude": x0 * curve.ultimate_displacement_ratio,
        "release_velocity": v0 * scale,
    }
    return simulate(
        curve, damping, **release, scheme=scheme, load=Load(scale * ground, 1.0, 0.05, 5)
    )


# --- symmetry and scaling, to the bit ---------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
@given(curve=curves(), damping=dampings(), start=starts, seed=seeds)
@settings(max_examples=60)
def test_a_mirrored_start_and_load_give_the_mirrored_history_bit_for_bit(
    scheme, curve, damping, start, seed
):
    ground = load(seed)
    one = respond(curve, damping, start, ground, scheme)
    other = respond(curve, damping, (-start[0], -start[1]), -ground, scheme)
    np.testing.assert_array_equal(other.displacement, -one.displacement)
    np.testing.assert_array_equal(other.velocity, -one.velocity)
    for name in ("collapsed", "end_tau", "peak", "peak_tau", "impacts"):
        np.testing.assert_array_equal(getattr(other, name), getattr(one, name))


@pytest.mark.parametrize("scheme", SCHEMES)
@given(
    curve=curves(("translated",)),
    damping=dampings(LINEAR),
    start=starts,
    seed=seeds,
    halvings=st.integers(1, 3),
)
@settings(max_examples=60)
def test_a_translated_curve_shrunk_in_both_axes_shrinks_the_history(
    scheme, curve, damping, start, seed, halvings
):
    # With slope -K0 kept, a1, b1 and a3 times s is the same curve at scale s: x, x' and the load scale with it.
    s = 0.5**halvings
    small = curve.map(lambda parameter: s * parameter)
    ground = load(seed)
    one = respond(curve, damping, start, ground, scheme)
    other = respond(small, damping, start, ground, scheme, scale=s)
    # A power of two scales without rounding, but where a2 = a3 - b1 is formed; a collapse may fall on the next step.
    if not (one.collapsed or other.collapsed):
        assume(np.abs(one.displacement).max() < 0.98 * curve.ultimate_displacement_ratio)
        np.testing.assert_allclose(other.displacement / s, one.displacement, atol=1e-9)


@given(wall=walls(), size=numbers(0.2, 5))
def test_walls_of_one_shape_differ_in_time_as_the_root_of_their_size(wall, size):
    other = replace(
        wall,
        **{name: getattr(wall, name) * size for name in ("thickness", "height", "eccentricity")},
    )
    assert other.frequency_parameter == pytest.approx(
        wall.frequency_parameter / np.sqrt(size), rel=1e-12
    )
    assert other.instability_displacement == pytest.approx(
        wall.instability_displacement * size, rel=1e-12
    )
    # The same acceleration does the same: strength goes with weight.
    assert other.load_factor == pytest.approx(wall.load_factor, rel=1e-12)
    assert other.restitution_rigid == pytest.approx(wall.restitution_rigid, abs=1e-14)
    assert other.restitution_impulsive == pytest.approx(wall.restitution_impulsive, abs=1e-14)


# --- dampers ----------------------------------------------------------------------------------------------------------


@given(curve=curves(), damping=dampings(), x0=numbers(0.01, 0.95))
@settings(max_examples=100)
def test_a_free_decay_never_exceeds_its_release_nor_collapses(curve, damping, x0):
    step = float(stable_step(curve)) / 40
    release = x0 * float(curve.ultimate_displacement_ratio)
    response = simulate(curve, damping, release_amplitude=release, step=step, steps=2000)
    assert not response.collapsed
    # A corner inside a step costs at most the fraction (w1 step)^2/4 = 6e-4 of the energy, in either direction; a half
    # cycle passes four.
    assert curve.energy(response.peak) <= curve.energy(release) * (
        1 + 6e-4 * 4 * (response.impacts + 1)
    )
