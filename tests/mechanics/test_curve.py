"""The tri-linear curve against its drawing, its integral, and the quadrature of its period."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve

# a1, b1, a3, softening: the paper's curve, steep and flat ones, and both variants for a3 < 1.
CASES = [
    (0.04, 0.85, 1.0, "steeper"),
    (0.02, 0.50, 1.0, "translated"),
    (0.20, 0.50, 0.9, "steeper"),
    (0.13, 0.60, 0.8, "steeper"),
    (0.06, 0.72, 0.9, "translated"),
    (0.10, 0.40, 0.7, "translated"),
]
every_case = pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))


def corners(case):
    """Return the corners of the drawn curve (Fig. 2), from the origin to the end, in x and f."""
    a1, b1, a3, softening = case
    a2 = 1 - b1 if softening == "steeper" else a3 - b1
    return np.array([0, a1, a2, a3]), np.array([0, b1, b1, 0])


def branch_points(case):
    """Return a point on each branch and each corner but the origin."""
    (_, a1, a2, a3), _ = corners(case)
    return [0.5 * a1, a1, 0.5 * (a1 + a2), a2, 0.5 * (a2 + a3)]


@every_case
def test_force_of_the_drawn_curve(case):
    x = np.linspace(-1.3, 1.3, 2602)
    drawn = np.sign(x) * np.interp(np.abs(x), *corners(case))
    np.testing.assert_allclose(TrilinearCurve(*case).force(x), drawn, atol=4e-15)


@every_case
def test_energy_is_the_integral_of_the_force(case):
    curve = TrilinearCurve(*case)
    xs, forces = corners(case)
    for x in (*branch_points(case), xs[3], 1.2):
        integral, _ = quad(lambda s: np.interp(s, xs, forces), 0, x, points=xs[1:], epsabs=1e-13)
        assert curve.energy(x) == pytest.approx(integral, rel=1e-12)
        assert curve.energy(-x) == curve.energy(x)


@every_case
def test_amplitude_is_the_inverse_of_the_energy(case):
    curve = TrilinearCurve(*case)
    a3 = case[2]
    x = np.linspace(0, 1, 101)[:-1] * a3
    # Near a3 the energy is flat: an error of eps V moves x by eps V/f.
    slope = np.maximum(curve.force(x), 1e-3)
    tolerance = 8 * np.finfo(float).eps * (1 + curve.energy(x) / slope)
    assert np.all(np.abs(curve.amplitude(curve.energy(x)) - x) <= tolerance)
    assert curve.amplitude(curve.energy(a3)) == pytest.approx(a3, abs=1e-7)


@every_case
def test_period_is_the_quadrature_of_its_integral(case, quarter_period):
    curve = TrilinearCurve(*case)
    xs, forces = corners(case)
    with mp.workdps(30):
        exact_corners = [[mp.mpf(float(v)) for v in values] for values in (xs, forces)]
        for x0 in (*branch_points(case), 0.98 * xs[3]):
            expected = float(4 * quarter_period(*exact_corners, mp.mpf(x0)))
            # At a corner x0 - a1 is rounding, and the period moves as its root.
            tolerance = 1e-7 if x0 in xs else 1e-12
            assert curve.period(x0) == pytest.approx(expected, rel=tolerance)


@every_case
def test_period_grows_with_the_logarithm_near_the_end(case):
    """Ten times nearer to the saddle takes 4 ln(10)/sqrt(ks) longer."""
    curve = TrilinearCurve(*case)
    periods = curve.period(curve.ultimate_displacement_ratio - np.array([1e-6, 1e-7]))
    expected = 4 * np.log(10) / np.sqrt(curve.softening_stiffness)
    assert np.diff(periods) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "b1", "a1"), [("new", 0.72, 0.06), ("moderate", 0.60, 0.13), ("severe", 0.50, 0.20)]
)
def test_presets_of_doherty(name, b1, a1):
    curve = TrilinearCurve.preset(name)
    assert curve.strength_ratio == b1
    assert curve.yield_displacement_ratio == a1


def test_preset_takes_another_end():
    curve = TrilinearCurve.preset("severe", ultimate_displacement_ratio=0.9, softening="translated")
    assert curve.plateau_end == pytest.approx(0.4)


@pytest.mark.parametrize("name", ["force", "energy", "period"])
def test_each_curve_of_an_array_as_alone(name):
    a1 = np.array([[0.02], [0.05], [0.10]])
    x = np.array([0.01, 0.07, 0.4, 0.9])
    together = TrilinearCurve(a1, 0.8, 0.95)
    alone = [getattr(TrilinearCurve(value, 0.8, 0.95), name)(x) for value in a1[:, 0]]
    assert together.shape == (3, 1)
    np.testing.assert_array_equal(getattr(together, name)(x), alone)


A1, B1, A3 = "yield_displacement_ratio", "strength_ratio", "ultimate_displacement_ratio"
BAD_CURVES = [
    (A1, {A1: 0.99e-5}),
    (A1, {A1: np.nan}),
    (A1, {A1: [0.04, 0.15]}),  # the plateau ends there
    (B1, {B1: 0.0}),
    (B1, {B1: 1.0}),
    (A3, {A3: 1.01}),
    (A3, {B1: 0.9, A3: 0.1}),  # 1 - 0.9 is just below 0.1 in floating point
    (A3, {A3: 0.88, "softening": "translated"}),
    ("softening", {"softening": "steep"}),
]


@pytest.mark.parametrize(("name", "change"), BAD_CURVES)
def test_bad_curve_is_refused_by_name(name, change):
    with pytest.raises(InputError, match=name):
        TrilinearCurve(**{A1: 0.04, B1: 0.85, **change})


CURVE = TrilinearCurve(0.04, 0.85)  # it stores less than b1 (1 - b1/2 - a1/2) = 0.47
BAD_ARGUMENTS = [
    *(("energy", CURVE.amplitude, value) for value in (-1e-9, 0.6, np.inf)),
    *(("release_amplitude", CURVE.period, value) for value in (0.0, -0.2, 1.0, np.nan)),
    ("preset", TrilinearCurve.preset, "old"),
]


@pytest.mark.parametrize(("name", "method", "value"), BAD_ARGUMENTS)
def test_bad_argument_of_a_method_is_refused(name, method, value):
    with pytest.raises(InputError, match=name):
        method(value)
