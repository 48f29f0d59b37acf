"""The tri-linear curve against its drawing, quadratures of its energy and period, and bad input."""

import mpmath
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


def draw(case):
    """Return the corners of the drawn curve (Fig. 2), from the origin to the end: x and f."""
    a1, b1, a3, softening = case
    a2 = 1 - b1 if softening == "steeper" else a3 - b1
    return np.array([0, a1, a2, a3]), np.array([0, b1, b1, 0])


def quarter_period(corners, force, x0):
    """Integrate dx/sqrt(2 (V(x0) - V(x))) from 0 to x0, for the curve through four corners."""
    k1 = force[1] / corners[1]
    ks = force[2] / (corners[3] - corners[2])

    def area(high, d):
        """Return the area from high - d to high, both on one branch."""
        if high <= corners[1]:
            return k1 * d * (2 * high - d) / 2
        if high <= corners[2]:
            return force[1] * d
        return ks * d * (2 * (corners[3] - high) + d) / 2

    ends = [*(x for x in corners if x < x0), x0]
    total = outer = mpmath.mpf(0)
    for low, high in zip(ends[-2::-1], ends[:0:-1], strict=True):
        # In s = sqrt(high - x) the integrand is smooth at the turning point too.
        total += mpmath.quad(
            lambda s, high=high, outer=outer: 2 * s / mpmath.sqrt(2 * (outer + area(high, s * s))),
            [0, mpmath.sqrt(high - low)],
        )
        outer += area(high, high - low)
    return total


@every_case
def test_force_follows_the_drawn_curve(case):
    x = np.linspace(-1.3, 1.3, 2602)
    corners, forces = draw(case)
    expected = np.sign(x) * np.interp(np.abs(x), corners, forces)
    np.testing.assert_allclose(TrilinearCurve(*case).force(x), expected, atol=4e-15)


@every_case
def test_energy_is_the_integral_of_the_force(case):
    curve = TrilinearCurve(*case)
    corners, forces = draw(case)
    middle_of_softening = 0.5 * (corners[2] + corners[3])
    for x in (*corners[1:] / 2, *corners[1:], middle_of_softening, 1.2):
        integral, _ = quad(
            lambda s: np.interp(s, corners, forces), 0, x, points=corners[1:], epsabs=1e-13
        )
        assert curve.energy(x) == pytest.approx(integral, rel=1e-12), x
        assert curve.energy(-x) == curve.energy(x), x


@every_case
def test_amplitude_is_the_inverse_of_the_energy(case):
    curve = TrilinearCurve(*case)
    a3 = draw(case)[0][3]
    x = np.linspace(0, 1, 101)[:-1] * a3
    energy = curve.energy(x)
    # Near a3 the energy is flat: an error of eps V moves x by eps V/f.
    flatness = energy / np.maximum(curve.force(x), 1e-3)
    tolerance = 8 * np.finfo(float).eps * (1 + flatness)
    assert np.all(np.abs(curve.amplitude(energy) - x) <= tolerance)
    assert curve.amplitude(curve.energy(a3)) == pytest.approx(a3, abs=1e-7)


@every_case
def test_period_is_the_quadrature_of_its_integral(case):
    curve = TrilinearCurve(*case)
    corners, forces = draw(case)
    middles = 0.5 * (corners[:-1] + corners[1:])
    for x0 in (*middles, *corners[1:3], 0.98 * corners[3]):
        # At a corner x0 - a1 is rounding, and the period moves as its root.
        tolerance = 1e-7 if x0 in corners else 1e-12
        with mpmath.workdps(30):
            expected = [
                [mpmath.mpf(float(value)) for value in values] for values in (corners, forces)
            ]
            expected = 4 * quarter_period(*expected, mpmath.mpf(float(x0)))
        assert curve.period(x0) == pytest.approx(float(expected), rel=tolerance), x0


@every_case
def test_period_grows_with_the_log_of_the_distance_to_collapse(case):
    """Ten times nearer takes 4 ln(10)/sqrt(ks) longer: a state leaves a saddle exponentially."""
    curve = TrilinearCurve(*case)
    periods = curve.period(curve.ultimate_displacement_ratio - np.array([1e-6, 1e-7]))
    growth = 4 * np.log(10) / np.sqrt(curve.softening_stiffness)
    assert np.diff(periods) == pytest.approx(growth, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "b1", "a1"),
    [("new", 0.72, 0.06), ("moderate", 0.60, 0.13), ("severe", 0.50, 0.20)],  # section 3
)
def test_presets_are_dohertys_stages(name, b1, a1):
    curve = TrilinearCurve.preset(name)
    assert curve.strength_ratio == b1
    assert curve.yield_displacement_ratio == a1


def test_preset_takes_the_other_parameters():
    curve = TrilinearCurve.preset("severe", ultimate_displacement_ratio=0.9, softening="translated")
    assert curve.plateau_end == pytest.approx(0.4)


@pytest.mark.parametrize("method", ["force", "energy", "period"])
def test_curves_in_an_array_are_those_alone(method):
    a1 = np.array([[0.02], [0.05], [0.10]])
    x = np.array([0.01, 0.07, 0.4, 0.9])
    curves = TrilinearCurve(a1, 0.8, 0.95)
    single = [getattr(TrilinearCurve(value, 0.8, 0.95), method)(x) for value in a1[:, 0]]
    assert curves.shape == (3, 1)
    np.testing.assert_array_equal(getattr(curves, method)(x), single)


def test_map_keeps_order_and_softening():
    curve = TrilinearCurve(np.array([0.04, 0.06]), 0.72, [0.95, 0.9], "translated")
    last = curve.map(lambda ratio: ratio[1])
    assert repr(last) == repr(TrilinearCurve(0.06, 0.72, 0.9, "translated"))


def test_smallest_yield_displacement_is_allowed():
    assert TrilinearCurve(1e-5, 0.85).yield_displacement_ratio == 1e-5


A1 = "yield_displacement_ratio"
B1 = "strength_ratio"
A3 = "ultimate_displacement_ratio"
BAD_CURVES = [
    (A1, {A1: 0.99e-5}),
    (A1, {A1: np.nan}),
    (A1, {A1: [0.04, 0.15]}),  # the plateau ends there
    (B1, {B1: 0.0}),
    (B1, {B1: 1.0}),
    (A3, {A3: 1.01}),
    (A3, {B1: 0.9, A3: 0.1}),  # 1 - 0.9 is just below 0.1 in floating point
    (A3, {A3: 0.88, "softening": "translated"}),
]


@pytest.mark.parametrize(("name", "change"), BAD_CURVES)
def test_bad_curve_is_refused_by_name(name, change):
    with pytest.raises(InputError, match=name):
        TrilinearCurve(**{A1: 0.04, B1: 0.85, **change})


# The curve stores b1 (1 - b1/2 - a1/2) = 0.47.
@pytest.mark.parametrize("energy", [-1e-9, 0.6, np.inf])
def test_energy_that_the_curve_cannot_store_is_refused(energy):
    with pytest.raises(InputError, match="energy"):
        TrilinearCurve(0.04, 0.85).amplitude(energy)


@pytest.mark.parametrize("x0", [0.0, -0.2, 1.0, np.nan])
def test_amplitude_outside_the_curve_is_refused(x0):
    with pytest.raises(InputError, match="release_amplitude"):
        TrilinearCurve(0.04, 0.85).period(x0)
