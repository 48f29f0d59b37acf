"""The kernel against the schemes written down a second time.

Small cases: with NUMBA_DISABLE_JIT=1 they run the kernel as plain Python.
"""

from functools import cache

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import exact, kernel
from rockdamp.solvers.newmark import Load, Reference, peaks, simulate, uneven_collapses

STEP = 0.04
STEPS = 60
SUBSTEPS = 2
GROUND = np.random.default_rng(8).normal(size=STEPS // SUBSTEPS + 1)
LANES = np.array(
    [  # a1, b1, a3, x0, v0, load factor
        [0.04, 0.85, 1.00, 0.50, 0.0, 0.00],  # a free decay
        [0.06, 0.72, 0.90, -0.30, 0.4, 0.05],  # a crossing under load
        [0.13, 0.60, 0.95, 0.05, 0.1, 0.01],  # on the first branch
        [0.10, 0.50, 1.00, 0.00, 0.0, 0.10],  # from rest
        [0.20, 0.50, 1.00, 0.70, 0.9, 0.02],  # two collapses
        [0.05, 0.80, 0.80, -0.75, -0.5, 0.02],
    ]
)
A1, B1, A3, X0, V0, FACTOR = LANES.T
CURVES = TrilinearCurve(A1, B1, A3)
STANDING = slice(4)  # lanes that do not collapse
VISCOUS = ("CDC", "CDR", "SDR", "ECD", "BAND", "CQD")
DAMPINGS = {
    "cr": Damping("CR", 0.8),
    "cr_law": Damping("CR", 0.8, loss_exponent=0.2),
    "ecd_law": Damping("ECD", 0.12, order=4, loss_exponent=0.1, reference_amplitude=0.5),
}
DAMPINGS |= {model.lower(): Damping(model, 0.12) for model in VISCOUS}
DAMPINGS |= {
    f"ecd{order:g}": Damping("ECD", 0.12, order=order)
    for order in (1, 2, 2.5, 4, 8, 16, 32, 64, 128)
}


# --- the schemes, a second time -------------------------------------------------------------------


class Textbook:
    """One lane, by Newmark's method as textbooks print it and the paper's Eqs (8) to (12)."""

    def __init__(self, damping, lane):
        self.model = damping.model
        a1, b1, a3, self.x, self.v, self.factor = lane
        self.corners = np.array([0, a1, 1 - b1, a3])
        self.forces = np.array([0, b1, b1, 0])
        law, _ = exact.LAWS[damping.model](TrilinearCurve(a1, b1, a3), damping)
        self.parameters = law.parameters
        damping_force = self.c(self.x, self.v, None) * self.v
        self.a = self.factor * GROUND[0] - self.force(self.x) - damping_force

    def force(self, x):
        return np.sign(x) * np.interp(abs(x), self.corners, self.forces)

    def tangent(self, x):
        branch = np.searchsorted(self.corners, abs(x), side="right")
        slopes = np.diff(self.forces) / np.diff(self.corners)
        return slopes[branch - 1] if branch < 4 else 0.0

    def energy(self, x):
        points = np.union1d(np.clip(self.corners, 0, abs(x)), [abs(x)])
        return np.trapezoid(np.interp(points, self.corners, self.forces), points)

    def c(self, x, v, h):
        """Return C; for CQD the mean of mu |v| over the way that a step h takes it."""
        outward_v = -v if x < 0 else v
        z = max(abs(x), 1e-100)
        p, q, n, _ = self.parameters
        if self.model == "CR":
            return 0.0
        if self.model == "BAND":
            return p * max(1 - (z / (q * max(abs(v), 1e-90))) ** 2, 0)
        if self.model == "CQD" and not h:
            return p / q * max(1 - (z / q) ** 2, 0) * abs(v)
        if self.model == "CQD":
            ends = z + h * outward_v * np.array([-0.5, 0.5])
            way = np.clip(ends / q, -1, 1)
            return p * abs(np.diff(way - way**3 / 3).item()) / h
        if self.model == "ECD":
            energy = 2 * self.energy(z)
            return exact.ecd_coefficient(abs(self.force(z)), energy, outward_v, *self.parameters)
        return p * (self.force(z) / z / q) ** n

    def restitution(self, v):
        return exact.restitution_factor(v, *self.parameters[:3])

    def step_newmark(self, p0, p1):
        """Step by beta 0, gamma 1/2; CR is split where the parabola of x crosses zero."""
        h = STEP
        x = self.x + h * self.v + h**2 / 2 * self.a
        if self.model == "CR" and self.x * x <= 0 and self.x != 0:
            roots = np.roots([self.a / 2, self.v, self.x])
            real_roots = roots.real[np.abs(roots.imag) < 1e-12]
            s = min(root for root in real_roots if 0 < root <= h * (1 + 1e-12))
            load = p0 + (p1 - p0) * s / h
            v = self.v + s / 2 * (self.a + load)
            self.v = self.restitution(v) * v
            self.a = load
            h -= s
            x = h * self.v + h**2 / 2 * self.a
        c = self.c(x, self.v + h * self.a, h)
        half_v = self.v + h / 2 * self.a
        self.x = x
        self.a = (p1 - self.force(x) - c * half_v) / (1 + h / 2 * c)
        self.v = half_v + h / 2 * self.a

    def step_paper(self, p0, p1):
        """Step by beta 1/6, gamma 1/2 in increments, tangent and C of the start, no iteration."""
        beta = 1 / 6
        gamma = 1 / 2
        h = STEP
        k = self.tangent(self.x)
        c = self.c(self.x, self.v, h)
        stiffness = k + gamma / (beta * h) * c + 1 / (beta * h**2)
        load = p1 - p0 + (1 / (beta * h) + gamma / beta * c) * self.v
        load += (1 / (2 * beta) + h * (gamma / (2 * beta) - 1) * c) * self.a
        dx = load / stiffness
        dv = gamma / (beta * h) * dx - gamma / beta * self.v + h * (1 - gamma / (2 * beta)) * self.a
        crosses = self.x * (self.x + dx) <= 0 and self.x != 0
        self.x += dx
        self.v += dv
        if self.model == "CR" and crosses:
            self.v *= self.restitution(self.v)  # Eq. (8), at the end of the step
        self.a = p1 - self.force(self.x) - self.c(self.x, self.v, h) * self.v

    def history(self, scheme):
        """Return displacements at all steps, NaN from a collapse on."""
        advance = self.step_newmark if scheme == "newmark" else self.step_paper
        samples = np.arange(STEPS + 1) / SUBSTEPS
        load = self.factor * np.interp(samples, np.arange(GROUND.size), GROUND)
        x = np.full(STEPS + 1, np.nan)
        x[0] = self.x
        for step in range(1, STEPS + 1):
            advance(load[step - 1], load[step])
            if abs(self.x) > self.corners[-1]:
                break
            x[step] = self.x
        return x


@cache
def textbook_histories(name, scheme):
    return np.array([Textbook(DAMPINGS[name], lane).history(scheme) for lane in LANES])


def kernel_run(scheme):
    load = Load(GROUND, FACTOR, STEP * SUBSTEPS, SUBSTEPS)
    return {"load": load, "release_amplitude": X0, "release_velocity": V0, "scheme": scheme}


every_damping = pytest.mark.parametrize("name", DAMPINGS)
every_scheme = pytest.mark.parametrize("scheme", ["newmark", "paper"])


@pytest.mark.nojit
@every_scheme
@every_damping
def test_march_is_its_textbook_scheme(name, scheme):
    history = simulate(CURVES, DAMPINGS[name], **kernel_run(scheme))
    x = textbook_histories(name, scheme)
    # Rounding, grown over 2.4 in tau by the unstable branch.
    np.testing.assert_allclose(history.displacement, x, atol=1e-12)
    assert history.collapsed.tolist() == [False] * 4 + [True] * 2
    np.testing.assert_array_equal(np.isnan(x[:, -1]), history.collapsed)


@pytest.mark.nojit
@every_scheme
@every_damping
def test_march_notes_end_peak_and_impacts(name, scheme):
    history = simulate(CURVES, DAMPINGS[name], **kernel_run(scheme))
    x = textbook_histories(name, scheme)
    last_step = np.minimum(np.isfinite(x).sum(axis=1), STEPS)
    np.testing.assert_allclose(history.end_tau, last_step * STEP, rtol=1e-15)
    x = x[STANDING]
    crosses = (x[:, :-1] * x[:, 1:] <= 0) & (x[:, :-1] != 0)
    np.testing.assert_array_equal(history.impacts[STANDING], crosses.sum(axis=1))
    np.testing.assert_allclose(history.peak[STANDING], np.abs(x).max(axis=1), atol=1e-12)
    peak_tau = np.abs(x).argmax(axis=1) * STEP
    np.testing.assert_allclose(history.peak_tau[STANDING], peak_tau, rtol=1e-15)


@pytest.mark.nojit
@every_scheme
@every_damping
def test_march_of_peaks_is_its_textbook_scheme(name, scheme):
    full = simulate(CURVES, DAMPINGS[name], **kernel_run(scheme))
    checkpoints = np.array([7, 8, 57])
    reference = Reference(np.full((1, STEPS + 1), 0.1), 0, checkpoints)
    result = peaks(CURVES, DAMPINGS[name], reference=reference, **kernel_run(scheme))
    np.testing.assert_array_equal(result.collapsed, full.collapsed)
    np.testing.assert_array_equal(result.peak, np.where(full.collapsed, A3, full.peak))
    x = textbook_histories(name, scheme)[STANDING]
    sums = np.cumsum((0.1 - np.abs(x[:, 1:])) ** 2, axis=1)
    np.testing.assert_allclose(result.error[:, STANDING], sums[:, checkpoints - 1].T, rtol=1e-10)
    assert np.isinf(result.error[:, 4:]).all()


@pytest.mark.nojit
def test_free_decay_reads_no_motion():
    curve = TrilinearCurve(0.04, 0.85)
    result = peaks(curve, Damping("CR", 0.8), release_amplitude=0.5, step=STEP, steps=STEPS)
    assert result.peak == 0.5
    assert not result.collapsed


# --- formulas -------------------------------------------------------------------------------------


@pytest.mark.nojit
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("x", "v", "a"),
    [(0.1, -2.0, 0.0), (0.1, -2.0, 9.0), (0.1, 0.5, -40.0), (0.1, 0.0, -80.0), (1e-9, -1.0, 3.0)],
)
def test_time_to_impact_is_the_first_root_of_the_parabola(x, v, a, sign):
    roots = np.roots([a / 2, v, x])
    real_roots = roots.real[np.abs(roots.imag) < 1e-12]
    first = min(root for root in real_roots if root > 0)
    s = kernel.time_to_impact(sign * x, sign * v, sign * a, 0.3)
    assert s == pytest.approx(first, rel=1e-9)


@pytest.mark.nojit
def test_rounding_puts_no_impact_beyond_the_step():
    assert kernel.time_to_impact(0.1, -0.1 / 0.3 * (1 - 1e-15), 0.0, 0.3) == 0.3


@pytest.mark.parametrize("softening", ["steeper", "translated"])
def test_force_energy_and_tangent_are_those_of_the_curve(softening):
    curve = TrilinearCurve(0.06, 0.72, 0.9, softening)
    parameters = curve.parameters()
    x = np.concatenate([np.linspace(0, 1.2, 200), parameters[3:]])
    np.testing.assert_array_equal(kernel.force(x, parameters), curve.force(x))
    np.testing.assert_array_equal(kernel.double_energy(x, parameters), 2 * curve.energy(x))
    slope = (curve.force(x + 1e-9) - curve.force(x)) / 1e-9  # at a corner of the outer branch
    np.testing.assert_allclose(kernel.tangent(x, parameters), slope, atol=1e-5)


# --- walls with an uneven force -------------------------------------------------------------------

CURVE = TrilinearCurve(0.06, 0.72)
SIZES = np.linspace(0.3, 3.0, 60)
SAMPLES = 400
SINE = np.sin(0.045 * np.arange(SAMPLES)) * np.hanning(SAMPLES)


def uneven(lift=0.0, side=(1.0, 1.0), load=1.0, rate=1.0, vertical=None):
    """Return the collapses of many lanes under a sine that grows with the lane."""
    return uneven_collapses(
        CURVE,
        0.85,
        step=rate * 0.02,
        substeps=5,
        load=load * SIZES,
        ground=SINE,
        lift=lift,
        vertical=np.ones(SAMPLES) if vertical is None else vertical,
        side=side,
    )


def test_uneven_march_has_lanes_that_collapse_and_stand():
    assert 5 < uneven().sum() < 55


def test_even_wall_collapses_as_in_the_solver():
    sizes = np.linspace(0.3, 3.0, 3000)
    collapsed = uneven_collapses(CURVE, 0.85, step=0.1, substeps=1, load=sizes, ground=SINE)
    result = peaks(CURVE, Damping("CR", 0.85), load=Load(SINE, sizes, 0.1))
    np.testing.assert_array_equal(collapsed, result.collapsed)


def test_double_weight_is_a_faster_time_under_half_the_load():
    np.testing.assert_array_equal(uneven(lift=1.0, load=2.0, rate=1 / np.sqrt(2)), uneven())


def test_scaled_curve_needs_a_scaled_load():
    np.testing.assert_array_equal(uneven(side=(1.5, 1.5), load=1.5), uneven())


def test_wall_that_is_stronger_to_one_side_lies_between():
    even = uneven().sum()
    one_side = uneven(side=(1.2, 1.0)).sum()
    both_sides = uneven(side=(1.2, 1.2)).sum()
    assert both_sides <= one_side <= even
    assert both_sides < even


def test_sides_change_places_with_the_sign_of_the_load():
    mirrored = uneven(side=(1.0, 1.2), load=-1.0)
    np.testing.assert_array_equal(mirrored, uneven(side=(1.2, 1.0)))


def test_vertical_motion_of_zeros_changes_nothing():
    np.testing.assert_array_equal(uneven(lift=5.0, vertical=np.zeros(SAMPLES)), uneven())


@pytest.mark.nojit
def test_wall_without_weight_flies_off():
    """Nothing restores: x = load t^2/2 passes a3 after sqrt(2 a3/load)."""
    load = 0.05 * np.array([0.99, 1.01])
    step = np.sqrt(2 / 0.05) / 40
    ones = np.ones(41)
    options = {"ground": ones, "vertical": ones, "lift": -2.0}
    collapsed = uneven_collapses(CURVE, 0.85, step=step, substeps=1, load=load, **options)
    assert collapsed.tolist() == [False, True]


@pytest.mark.nojit
def test_both_motions_are_linear_between_samples():
    """A load that grows from 0 over T moves a wall without weight by load T^2/6.

    The vertical motion grows tenfold meanwhile.
    """
    load = 6 / 25 * np.array([0.99, 1.01])
    options = {"ground": np.array([0.0, 0, 1]), "vertical": np.array([0.0, 1, 10]), "lift": -2.0}
    collapsed = uneven_collapses(CURVE, 0.85, step=5 / 400, substeps=400, load=load, **options)
    assert collapsed.tolist() == [False, True]


def test_vertical_motion_of_another_length_is_refused():
    with pytest.raises(ValueError, match="vertical has 9 samples"):
        uneven(vertical=np.zeros(9))
