"""The kernel against the schemes written down a second time, and its machine code against edits of its source.

Small cases: with NUMBA_DISABLE_JIT=1 they run the kernel as plain Python.
"""

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import exact, kernel
from rockdamp.solvers.newmark import Load, Reference, peaks, simulate, uneven_collapses

STEP, STEPS, SUBSTEPS = 0.04, 60, 2
GROUND = np.random.default_rng(8).normal(size=STEPS // SUBSTEPS + 1)
# a1, b1, a3, x0, v0, load factor: a decay, a crossing under load, the first branch, rest, and two collapses.
LANES = np.array(
    [
        [0.04, 0.85, 1.00, 0.50, 0.0, 0.00],
        [0.06, 0.72, 0.90, -0.30, 0.4, 0.05],
        [0.13, 0.60, 0.95, 0.05, 0.1, 0.01],
        [0.10, 0.50, 1.00, 0.00, 0.0, 0.10],
        [0.20, 0.50, 1.00, 0.70, 0.9, 0.02],
        [0.05, 0.80, 0.80, -0.75, -0.5, 0.02],
    ]
)
DAMPERS = {
    "cr": Damping("CR", 0.8),
    "cr_law": Damping("CR", 0.8, loss_exponent=0.2),
    **{
        model.lower(): Damping(model, 0.12) for model in ("CDC", "CDR", "SDR", "ECD", "BAND", "CQD")
    },
    **{
        f"ecd{order:g}": Damping("ECD", 0.12, order=order)
        for order in (1, 2, 2.5, 4, 8, 16, 32, 64, 128)
    },
    "ecd_law": Damping("ECD", 0.12, order=4, loss_exponent=0.1, reference_amplitude=0.5),
}


# --- the schemes, a second time ---------------------------------------------------------------------------------------


class Textbook:
    """One lane, by the formulas of Newmark's method as textbooks print them and of the paper's Eqs (8) to (12)."""

    def __init__(self, damping, lane):
        self.damping = damping
        a1, b1, a3, self.x, self.v, self.factor = lane
        self.curve = TrilinearCurve(a1, b1, a3)
        self.corners, self.values = np.array([0, a1, 1 - b1, a3]), np.array([0, b1, b1, 0])
        self.parameters = exact.LAWS[damping.model](self.curve, damping)[0].parameters
        self.a = (
            self.factor * GROUND[0] - self.force(self.x) - self.c(self.x, self.v, None) * self.v
        )

    def force(self, x):
        return np.sign(x) * np.interp(abs(x), self.corners, self.values)

    def tangent(self, x):
        branch = np.searchsorted(self.corners, abs(x), side="right")
        slopes = np.diff(self.values) / np.diff(self.corners)
        return slopes[branch - 1] if branch < 4 else 0.0

    def energy(self, x):
        fine = np.union1d(np.clip(self.corners, 0, abs(x)), [abs(x)])
        return np.trapezoid(np.interp(fine, self.corners, self.values), fine)

    def c(self, x, v, h):
        """C; that of CQD is the mean of mu |v| over the way that a step h takes it."""
        away, z, (p, q, n, _) = (-v if x < 0 else v), max(abs(x), 1e-100), self.parameters
        if self.damping.model == "CR":
            return 0.0
        if self.damping.model == "BAND":
            return p * max(1 - (z / (q * max(abs(v), 1e-90))) ** 2, 0)
        if self.damping.model == "CQD":
            way = np.clip((z + (h or 0) * away * np.array([-0.5, 0.5])) / q, -1, 1)
            return (
                p * abs(np.diff(way - way**3 / 3).item()) / h
                if h
                else p / q * max(1 - (z / q) ** 2, 0) * abs(v)
            )
        if self.damping.model == "ECD":
            return exact.ecd_coefficient(
                abs(self.force(z)), 2 * self.energy(z), away, *self.parameters
            )
        return p * (self.force(z) / z / q) ** n

    def explicit(self, p0, p1):
        """Step by beta 0, gamma 1/2; CR is split where the parabola of the displacement crosses zero."""
        x = self.x + STEP * self.v + STEP**2 / 2 * self.a
        left = STEP
        if self.damping.model == "CR" and self.x * x <= 0 and self.x != 0:
            roots = np.roots([self.a / 2, self.v, self.x])
            s = min(
                root.real
                for root in roots
                if abs(root.imag) < 1e-12 and 0 < root.real <= STEP * (1 + 1e-12)
            )
            load = p0 + (p1 - p0) * s / STEP
            v = self.v + s / 2 * (self.a + load)
            self.v = exact.restitution_factor(v, *self.parameters[:3]) * v
            self.a, left = load, STEP - s
            x = left * self.v + left**2 / 2 * self.a
        c, half = self.c(x, self.v + left * self.a, left), self.v + left / 2 * self.a
        self.a = (p1 - self.force(x) - c * half) / (1 + left / 2 * c)
        self.x, self.v = x, half + left / 2 * self.a

    def printed(self, p0, p1):
        """Step by beta 1/6, gamma 1/2 in increments, with the tangent and C of the step's start, without iteration."""
        beta, gamma, h = 1 / 6, 1 / 2, STEP
        k, c = self.tangent(self.x), self.c(self.x, self.v, h)
        stiffness = k + gamma / (beta * h) * c + 1 / (beta * h**2)
        load = p1 - p0 + (1 / (beta * h) + gamma / beta * c) * self.v
        load += (1 / (2 * beta) + h * (gamma / (2 * beta) - 1) * c) * self.a
        dx = load / stiffness
        dv = gamma / (beta * h) * dx - gamma / beta * self.v + h * (1 - gamma / (2 * beta)) * self.a
        crossed = self.x * (self.x + dx) <= 0 and self.x != 0
        self.x, self.v = self.x + dx, self.v + dv
        if self.damping.model == "CR" and crossed:
            self.v *= exact.restitution_factor(
                self.v, *self.parameters[:3]
            )  # Eq. (8), at the end of the step
        self.a = p1 - self.force(self.x) - self.c(self.x, self.v, h) * self.v

    def history(self, scheme):
        """Displacements at all steps, NaN from a collapse on, and the step of the end."""
        ground = self.factor * np.interp(
            np.arange(STEPS + 1) / SUBSTEPS, np.arange(GROUND.size), GROUND
        )
        x = np.full(STEPS + 1, np.nan)
        x[0] = self.x
        for step in range(1, STEPS + 1):
            (self.explicit if scheme == "newmark" else self.printed)(ground[step - 1], ground[step])
            if abs(self.x) > self.corners[-1]:
                return x, step
            x[step] = self.x
        return x, STEPS


@pytest.mark.nojit
@pytest.mark.parametrize("scheme", ["newmark", "paper"])
@pytest.mark.parametrize("damping", DAMPERS.values(), ids=DAMPERS)
def test_every_damper_s_march_is_its_textbook_scheme(damping, scheme):
    a1, b1, a3, x0, v0, factor = LANES.T
    curve, start = (
        TrilinearCurve(a1, b1, a3),
        {"release_amplitude": x0, "release_velocity": v0, "scheme": scheme},
    )
    found = simulate(curve, damping, load=Load(GROUND, factor, STEP * SUBSTEPS, SUBSTEPS), **start)
    expected = [Textbook(damping, lane).history(scheme) for lane in LANES]
    x = np.array([history for history, _ in expected])
    # Rounding, grown over 2.4 in tau by the unstable branch.
    np.testing.assert_allclose(found.displacement, x, atol=1e-12)
    assert found.collapsed.tolist() == np.isnan(x[:, -1]).tolist() == [False] * 4 + [True] * 2
    np.testing.assert_allclose(found.end_tau, [step * STEP for _, step in expected], rtol=1e-15)
    changes = (x[:4, :-1] * x[:4, 1:] <= 0) & (x[:4, :-1] != 0)
    np.testing.assert_array_equal(found.impacts[:4], changes.sum(axis=1))
    np.testing.assert_allclose(found.peak[:4], np.abs(x[:4]).max(axis=1), atol=1e-12)
    np.testing.assert_allclose(found.peak_tau[:4], np.abs(x[:4]).argmax(axis=1) * STEP, rtol=1e-15)
    checkpoints = [7, 8, 57]
    reference = Reference(np.full((1, STEPS + 1), 0.1), 0, checkpoints)
    compared = peaks(
        curve,
        damping,
        load=Load(GROUND, factor, STEP * SUBSTEPS, SUBSTEPS),
        reference=reference,
        **start,
    )
    np.testing.assert_array_equal(compared.collapsed, found.collapsed)
    np.testing.assert_array_equal(compared.peak, np.where(found.collapsed, a3, found.peak))
    sums = np.cumsum((0.1 - np.abs(x[:4, 1:])) ** 2, axis=1)[:, np.array(checkpoints) - 1]
    np.testing.assert_allclose(compared.error[:, :4], sums.T, rtol=1e-10)
    assert np.isinf(compared.error[:, 4:]).all()


@pytest.mark.nojit
def test_a_free_decay_reads_no_motion():
    found = peaks(
        TrilinearCurve(0.04, 0.85),
        Damping("CR", 0.8),
        release_amplitude=0.5,
        step=STEP,
        steps=STEPS,
    )
    assert found.peak == 0.5 and not found.collapsed


@pytest.mark.nojit
def test_an_impact_time_is_the_first_root_of_the_parabola_from_either_side():
    for x, v, a in [
        (0.1, -2.0, 0.0),
        (0.1, -2.0, 9.0),
        (0.1, 0.5, -40.0),
        (0.1, 0.0, -80.0),
        (1e-9, -1.0, 3.0),
    ]:
        roots = np.roots([a / 2, v, x])
        first = min(root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 0)
        for sign in (1, -1):
            assert kernel.time_to_impact(sign * x, sign * v, sign * a, 0.3) == pytest.approx(
                first, rel=1e-9
            )
    # Rounding must not put it beyond the step.
    assert kernel.time_to_impact(0.1, -0.1 / 0.3 * (1 - 1e-15), 0.0, 0.3) == 0.3


def test_the_kernel_and_the_curve_have_the_same_force_and_energy_and_the_tangent_is_the_slope():
    for curve in (TrilinearCurve(0.06, 0.72, 0.9), TrilinearCurve(0.06, 0.72, 0.9, "translated")):
        x = np.concatenate([np.linspace(0, 1.2, 200), curve.parameters()[3:]])
        np.testing.assert_array_equal(kernel.force(x, curve.parameters()), curve.force(x))
        slope = (
            curve.force(x + 1e-9) - curve.force(x)
        ) / 1e-9  # at a corner that of the branch further out
        np.testing.assert_allclose(kernel.tangent(x, curve.parameters()), slope, atol=1e-5)
        np.testing.assert_array_equal(
            kernel.double_energy(x, curve.parameters()), 2 * curve.energy(x)
        )


# --- walls of an uneven force -----------------------------------------------------------------------------------------

CURVE = TrilinearCurve(0.06, 0.72)
SIZE, SAMPLES = np.linspace(0.3, 3.0, 60), 400
SINE = np.sin(0.045 * np.arange(SAMPLES)) * np.hanning(SAMPLES)


def uneven(lift=0.0, side=(1.0, 1.0), load=1.0, rate=1.0, vertical=None):
    """Collapses of many lanes under a sine that grows with the lane."""
    run = {
        "step": rate * 0.02,
        "substeps": 5,
        "load": load * SIZE,
        "ground": SINE,
        "lift": lift,
        "side": side,
    }
    return uneven_collapses(
        CURVE, 0.85, vertical=np.ones(SAMPLES) if vertical is None else vertical, **run
    )


def test_an_even_wall_collapses_as_in_the_solver_and_others_by_the_laws_of_scale():
    plain = uneven()
    assert 5 < plain.sum() < 55
    many = np.linspace(0.3, 3.0, 3000)
    found = uneven_collapses(CURVE, 0.85, step=0.1, substeps=1, load=many, ground=SINE)
    np.testing.assert_array_equal(
        found, peaks(CURVE, Damping("CR", 0.85), load=Load(SINE, many, 0.1)).collapsed
    )
    # Twice the force at every u is the wall as it was, in a time that runs by sqrt(2), under half of the load.
    np.testing.assert_array_equal(uneven(lift=1.0, load=2.0, rate=1 / np.sqrt(2)), plain)
    # A curve that is larger by a half in force and displacement alike needs a load that is larger by a half.
    np.testing.assert_array_equal(uneven(side=(1.5, 1.5), load=1.5), plain)
    # A wall that is stronger to one side only lies between, and the sides change places with the sign of the load.
    one, both = uneven(side=(1.2, 1.0)), uneven(side=(1.2, 1.2))
    assert both.sum() <= one.sum() <= plain.sum() and both.sum() < plain.sum()
    np.testing.assert_array_equal(uneven(side=(1.0, 1.2), load=-1.0), one)
    np.testing.assert_array_equal(uneven(lift=5.0, vertical=np.zeros(SAMPLES)), plain)


@pytest.mark.nojit
def test_a_wall_without_weight_flies_off_and_both_motions_are_linear_between_samples():
    # Nothing restores: x = load t^2/2 passes a3 after sqrt(2 a3/load).
    load, step, ground = 0.05 * np.array([0.99, 1.01]), np.sqrt(2 / 0.05) / 40, np.ones(41)
    run = {"lift": -2.0, "vertical": ground, "ground": ground}
    assert uneven_collapses(CURVE, 0.85, step=step, substeps=1, load=load, **run).tolist() == [
        False,
        True,
    ]
    # A load that grows from 0 over T moves the wall by load T^2/6; the vertical motion grows tenfold meanwhile.
    load, run = (
        6 / 25 * np.array([0.99, 1.01]),
        {"ground": np.array([0.0, 0, 1]), "vertical": np.array([0.0, 1, 10])},
    )
    found = uneven_collapses(CURVE, 0.85, step=5 / 400, substeps=400, load=load, lift=-2.0, **run)
    assert found.tolist() == [False, True]
