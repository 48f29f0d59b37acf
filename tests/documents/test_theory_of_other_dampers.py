"""docs/theory.md, sections 4 and 8: what others had, and local damping, which is exact in free decay too."""

import re

import numpy as np
import pytest
import sympy as sp
from repository import ROOT

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.plausibility import as_meant
from rockdamp.solvers import event_driven
from rockdamp.vocabulary import LOCAL, RECOMMENDED

PAGE = (ROOT / "docs/theory.md").read_text(encoding="utf-8")
CURVE = TrilinearCurve(0.04, 0.85)
NAMES = ("ECD", RECOMMENDED, LOCAL)  # of the table


def test_ecd_meets_chiellini_s_condition_on_any_curve():
    """d/dx (f/C) = k C, with f = V' of any potential V; and no other power of V does."""
    x, xi = sp.symbols("x xi", positive=True)
    potential = sp.Function("V", positive=True)(x)
    force = sp.diff(potential, x)

    def k(power):
        coefficient = 2 * xi * force / (2 * potential) ** power
        return sp.simplify(sp.diff(force / coefficient, x) / coefficient)

    half = sp.Rational(1, 2)
    assert sp.simplify(k(half) - 1 / (4 * xi**2)) == 0  # a residual of zero, whatever V
    assert all(sp.simplify(sp.diff(k(half + change), x)) != 0 for change in (-half / 3, half / 4))


def test_local_damping_is_the_tangent_of_the_phase():
    """The force alpha f against v is C v with C = w_E D; y = sqrt(2V) = r sin phi, v = r cos phi: D = alpha tan phi."""
    alpha, r, phi, f = sp.symbols("alpha r phi f", positive=True)
    y, v = r * sp.sin(phi), r * sp.cos(phi)
    assert sp.simplify((alpha * f / v) / (f / y) - alpha * sp.tan(phi)) == 0
    delta, e = sp.symbols("delta e", positive=True)
    loss = ((1 - alpha) / (1 + alpha)).subs(alpha, sp.tanh(delta)).rewrite(sp.exp)
    assert sp.simplify(loss - sp.exp(-2 * delta)) == 0


@as_meant()
def test_local_damping_leaves_the_same_fraction_from_any_amplitude_on_any_curve():
    """By the event-driven solver: the energy at a peak over that at the one before is e^2, alpha = tanh(-ln e)."""
    random = np.random.default_rng(30)
    for softening in ("steeper", "translated") * 10:
        b1 = random.uniform(0.4, 0.9)
        a1 = random.uniform(0.01, 0.8 * (1 - b1))
        a3 = random.uniform(max(1 - b1, a1 + b1) + 0.02, 1.0) if softening == "translated" else random.uniform(0.97, 1)
        curve = TrilinearCurve(a1, b1, min(a3, 1.0), softening)
        x0, e = random.uniform(0.001, 0.98) * float(curve.ultimate_displacement_ratio), random.uniform(0.1, 0.99)
        damping = Damping.of_restitution(e, LOCAL)
        assert float(damping.local_damping) == pytest.approx(np.tanh(-np.log(e)), rel=1e-14)
        run = event_driven.history(curve, damping, [4 * float(curve.period(x0))], release_amplitude=x0)
        peaks = np.array([x0, *np.abs(run.turning_displacement)])
        assert peaks.size > 3
        np.testing.assert_allclose(curve.energy(peaks[1:]) / curve.energy(peaks[:-1]), e**2, rtol=1e-9)


@as_meant()
def test_what_the_defaults_of_programs_stand_for():
    told = re.search(r"\$\\alpha\$ = 0\.2, Yade's, is \$e\$ = (.+); 0\.7 and 0\.8 are (.+) and\s(\d\.\d+)", PAGE)
    for alpha, e in zip((0.2, 0.7, 0.8), map(float, told.groups()), strict=True):
        assert np.sqrt((1 - alpha) / (1 + alpha)) == pytest.approx(e, abs=5e-4)
        assert float(Damping.of_restitution(np.sqrt((1 - alpha) / (1 + alpha)), LOCAL).local_damping) == pytest.approx(
            alpha
        )


def test_the_first_peaks_of_four_dampers_under_a_half_sine():
    """p = 2 sin(pi tau/0.7) up to tau = 0.7, on the paper's curve at e = 0.85."""
    row = re.search(
        r"^\| restitution \| order 16 \| ECD \| local damping \|\n.*\n\| (.*) \|$", PAGE, flags=re.MULTILINE
    )
    step = 0.7 / 256
    load = 2 * np.sin(np.pi * np.linspace(0, 1, 257))
    for model, peak in zip(("CR", RECOMMENDED, "ECD", LOCAL), map(float, row[1].split(" | ")), strict=True):
        damping = Damping.of_restitution(0.85, model)
        run = event_driven.history(CURVE, damping, [2.0], load=load, load_step=step)
        assert run.turning_displacement[0] == pytest.approx(peak, abs=6e-4)


def test_what_the_page_says_of_local_damping_under_load_is_in_its_table():
    block = PAGE.partition("local_damping -->")[2].partition("<!-- end -->")[0]
    rows = {cells[0]: cells for line in block.splitlines() if (cells := line.strip("| ").split(" | "))[0] in NAMES}
    median, error, safe = ({name: float(rows[name][column].split()[0]) for name in NAMES} for column in (4, 5, 6))
    assert median[LOCAL] == pytest.approx(0.95, abs=0.01) == float(rows[LOCAL][1])
    assert error[LOCAL] == pytest.approx(error["ECD"], rel=0.1)
    assert error[LOCAL] / error[RECOMMENDED] == pytest.approx(3, abs=0.5)
    assert safe[LOCAL] > max(safe["ECD"], safe[RECOMMENDED])
