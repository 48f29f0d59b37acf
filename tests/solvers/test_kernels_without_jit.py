"""The kernels as plain Python, against the compiled ones and against the schemes written down a second time.

Small cases: a step of a block of 64 lanes takes milliseconds in Python. With NUMBA_DISABLE_JIT=1 the compiled kernel is
the plain one, and the comparison with the textbook remains.
"""

import numpy as np
import pytest
from numba import config

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import newmark_kernel as kernel
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.newmark_kernel import impact_within
from rockdamp.solvers.response import Reference
from rockdamp.vocabulary import MODELS

pytestmark = pytest.mark.nojit

STEP, STEPS, SUBSTEPS = 0.04, 60, 2
CHECKPOINTS = [7, 8, 57]  # the last before the end: the sum goes on, and nothing is stored any more
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
RESTITUTION, RATIO = 0.8, 0.12
ORDERS = {"ECD of order 8": 8.0, "ECD of order 2.5": 2.5}
CASES = [(model, scheme) for model in (*MODELS, *ORDERS) for scheme in ("newmark", "paper")]
each_kind = pytest.mark.parametrize(("model", "scheme"), CASES)


def damping_of(model, damping_ratio=RATIO, restitution=RESTITUTION):
    if model in ORDERS:
        return Damping("ECD", damping_ratio, order=ORDERS[model])
    return Damping.from_values(model, restitution=restitution, damping_ratio=damping_ratio)


def run(model, scheme, **changes):
    a1, b1, a3, x0, v0, factor = LANES.T
    given = {
        "release_amplitude": x0,
        "release_velocity": v0,
        "load_factor": factor,
        "ground_acceleration": GROUND,
        "substeps": SUBSTEPS,
        "step": STEP,
        "steps": STEPS,
        "store_every": 1,
        "reference": Reference(np.full((1, STEPS + 1), 0.1), 0, CHECKPOINTS),
        "scheme": scheme,
        "threads": 1,
        **changes,
    }
    return solve(TrilinearCurve(a1, b1, a3), damping_of(model), **given)


# --- the schemes, a second time ---------------------------------------------------------------------------------------


class Textbook:
    """One lane, by the formulas of Newmark's method as textbooks print them and of the paper's Eqs (8) to (12)."""

    def __init__(self, model, lane):
        self.model = model
        a1, b1, a3, self.x, self.v, self.factor = lane
        self.curve = TrilinearCurve(a1, b1, a3)
        self.corners = np.array([0, a1, 1 - b1, a3])
        self.values = np.array([0, b1, b1, 0])
        self.a = self.factor * GROUND[0] - self.force(self.x) - self.c(self.x, self.v) * self.v

    def force(self, x):
        return np.sign(x) * np.interp(abs(x), self.corners, self.values)

    def tangent(self, x):
        branch = np.searchsorted(self.corners, abs(x), side="right")
        slopes = np.diff(self.values) / np.diff(self.corners)
        return slopes[branch - 1] if branch < 4 else 0.0

    def energy(self, x):
        fine = np.union1d(np.clip(self.corners, 0, abs(x)), [abs(x)])
        return np.trapezoid(np.interp(fine, self.corners, self.values), fine)

    def c(self, x, v):
        if self.model == "CR":
            return 0.0
        w1 = np.sqrt(self.values[1] / self.corners[1])
        w = np.sqrt(self.force(x) / x) if x else w1
        if self.model == "ECD":
            w = abs(self.force(x)) / np.sqrt(2 * self.energy(x)) if x else w1
        exponents = {"CDC": 0, "CDR": 1, "ECD": 1, "SDR": 2}
        if self.model in exponents:
            return 2 * w1 * RATIO * (w / w1) ** exponents[self.model]
        away = -v if x < 0 else v
        x = max(abs(x), 1e-100)
        damping = damping_of(self.model)
        return damping.law(x, self.force(x), 2 * self.energy(x), away, damping.law_parameters(self.curve))

    def explicit(self, p0, p1):
        """Step by beta 0, gamma 1/2; CR is split where the parabola of the displacement crosses zero."""
        x = self.x + STEP * self.v + STEP**2 / 2 * self.a
        left = STEP
        if self.model == "CR" and self.x * x <= 0 and self.x != 0:
            roots = np.roots([self.a / 2, self.v, self.x])
            s = min(root.real for root in roots if abs(root.imag) < 1e-12 and 0 < root.real <= STEP * (1 + 1e-12))
            load = p0 + (p1 - p0) * s / STEP
            self.v = RESTITUTION * (self.v + s / 2 * (self.a + load))
            self.a, left = load, STEP - s
            x = left * self.v + left**2 / 2 * self.a
        c, half = self.c(x, self.v + left * self.a), self.v + left / 2 * self.a
        self.a = (p1 - self.force(x) - c * half) / (1 + left / 2 * c)
        self.x, self.v = x, half + left / 2 * self.a

    def printed(self, p0, p1):
        """Step by beta 1/6, gamma 1/2 in increments, with the tangent and C of the step's start, without iteration."""
        beta, gamma, h = 1 / 6, 1 / 2, STEP
        k, c = self.tangent(self.x), self.c(self.x, self.v)
        stiffness = k + gamma / (beta * h) * c + 1 / (beta * h**2)
        load = p1 - p0 + (1 / (beta * h) + gamma / beta * c) * self.v
        load += (1 / (2 * beta) + h * (gamma / (2 * beta) - 1) * c) * self.a
        dx = load / stiffness
        dv = gamma / (beta * h) * dx - gamma / beta * self.v + h * (1 - gamma / (2 * beta)) * self.a
        crossed = self.x * (self.x + dx) <= 0 and self.x != 0
        self.x, self.v = self.x + dx, self.v + dv
        if self.model == "CR" and crossed:
            self.v *= RESTITUTION  # Eq. (8), at the end of the step
        self.a = p1 - self.force(self.x) - self.c(self.x, self.v) * self.v

    def history(self, scheme):
        """Displacements at all steps, NaN from a collapse on, and the step of the end."""
        ground = self.factor * np.interp(np.arange(STEPS + 1) / SUBSTEPS, np.arange(GROUND.size), GROUND)
        x = np.full(STEPS + 1, np.nan)
        x[0] = self.x
        for step in range(1, STEPS + 1):
            (self.explicit if scheme == "newmark" else self.printed)(ground[step - 1], ground[step])
            if abs(self.x) > self.corners[-1]:
                return x, step
            x[step] = self.x
        return x, STEPS


@each_kind
@pytest.mark.parametrize("way", ["plain", "compiled"])
def test_every_kind_of_step_is_its_textbook_scheme(monkeypatch, model, scheme, way):
    if way == "plain":
        monkeypatch.setattr(kernel, "compiled_march", kernel.plain_march)
    elif config.DISABLE_JIT:
        pytest.skip("NUMBA_DISABLE_JIT is set: nothing is compiled")
    response = run(model, scheme)
    expected = [Textbook(model, lane).history(scheme) for lane in LANES]
    x = np.array([history for history, _ in expected])
    # Rounding, grown over 2.4 in tau by the unstable branch.
    np.testing.assert_allclose(response.displacement, x, atol=1e-12)
    np.testing.assert_array_equal(response.outcome, np.isnan(x[:, -1]))
    assert response.outcome.tolist() == [0, 0, 0, 0, 1, 1]
    np.testing.assert_allclose(response.outcome_tau, [step * STEP for _, step in expected], rtol=1e-15)
    terms = (0.1 - np.abs(x[:4, 1:])) ** 2
    np.testing.assert_allclose(
        response.error[:, :4], np.cumsum(terms, axis=1)[:, np.array(CHECKPOINTS) - 1].T, rtol=1e-10
    )
    changes = (x[:4, :-1] * x[:4, 1:] <= 0) & (x[:4, :-1] != 0)
    np.testing.assert_array_equal(response.impacts[:4], changes.sum(axis=1))
    np.testing.assert_allclose(response.peak[:4], np.abs(x[:4]).max(axis=1), atol=1e-12)
    np.testing.assert_allclose(response.peak_tau[:4], np.abs(x[:4]).argmax(axis=1) * STEP, rtol=1e-15)


def test_an_impact_time_is_the_first_root_of_the_parabola_from_either_side():
    cases = [(0.1, -2.0, 0.0), (0.1, -2.0, 9.0), (0.1, 0.5, -40.0), (0.1, 0.0, -80.0), (1e-9, -1.0, 3.0)]
    for x, v, a in cases:
        roots = np.roots([a / 2, v, x])
        first = min(root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 0)
        for sign in (1, -1):
            found = impact_within(sign * x, sign * v, sign * a, 0.3)
            assert found == pytest.approx(first, rel=1e-9)
    # Rounding must not put it beyond the step.
    assert impact_within(0.1, -0.1 / 0.3 * (1 - 1e-15), 0.0, 0.3) == 0.3
