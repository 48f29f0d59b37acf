"""The tri-linear curve against its drawing, its integral, mpmath's quadrature of its period, and bad input."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve

# a1, b1, a3, softening: the paper's, steep and flat ones, and both variants of softening for a3 < 1.
CASES = [
    (0.04, 0.85, 1.0, "steeper"),
    (0.02, 0.50, 1.0, "translated"),
    (0.20, 0.50, 0.9, "steeper"),
    (0.13, 0.60, 0.8, "steeper"),
    (0.06, 0.72, 0.9, "translated"),
    (0.10, 0.40, 0.7, "translated"),
]
curves = pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))


def corners(case):
    """Corner points of the drawn curve (Fig. 2), from the origin to the end, in x and f."""
    a1, b1, a3, softening = case
    a2 = 1 - b1 if softening == "steeper" else a3 - b1
    return np.array([0, a1, a2, a3]), np.array([0, b1, b1, 0])


@curves
def test_the_force_is_that_of_the_drawn_curve(case):
    curve, x = TrilinearCurve(*case), np.linspace(-1.3, 1.3, 2602)
    drawn = np.sign(x) * np.interp(np.abs(x), *corners(case))
    np.testing.assert_allclose(curve.force(x), drawn, atol=4e-15)


@curves
def test_the_energy_is_the_integral_of_the_force_and_the_amplitude_its_inverse(case):
    curve, (at, force) = TrilinearCurve(*case), corners(case)
    for x in (*at[1:] / 2, *at[1:], 0.5 * (at[2] + at[3]), 1.2):
        integral, _ = quad(lambda s: np.interp(s, at, force), 0, x, points=at[1:], epsabs=1e-13)
        assert curve.energy(x) == curve.energy(-x) == pytest.approx(integral, rel=1e-12)
    x = np.linspace(0, 1, 101)[:-1] * at[3]
    # Near a3 the energy is flat: an error of eps V moves x by eps V/f.
    tolerance = 8 * np.finfo(float).eps * (1 + curve.energy(x) / np.maximum(curve.force(x), 1e-3))
    assert np.all(np.abs(curve.amplitude(curve.energy(x)) - x) <= tolerance)
    assert curve.amplitude(curve.energy(at[3])) == pytest.approx(at[3], abs=1e-7)


@curves
def test_the_free_period_is_the_quadrature_of_its_integral_on_every_branch(case, quarter_period):
    curve, (at, _) = TrilinearCurve(*case), corners(case)
    for x0 in (
        0.5 * at[1],
        at[1],
        0.5 * (at[1] + at[2]),
        at[2],
        0.5 * (at[2] + at[3]),
        0.98 * at[3],
    ):
        # At a corner x0 - a1 is rounding, and the period moves as its root.
        tolerance = 1e-7 if x0 in at else 1e-12
        with mp.workdps(30):
            expected = 4 * quarter_period(
                *([mp.mpf(float(v)) for v in values] for values in corners(case)), mp.mpf(x0)
            )
        assert curve.period(x0) == pytest.approx(float(expected), rel=tolerance)
    # Ten times nearer to the end takes 4 ln(10)/sqrt(ks) longer: the state leaves a saddle exponentially.
    near = curve.period(curve.ultimate_displacement_ratio - np.array([1e-6, 1e-7]))
    assert np.diff(near) == pytest.approx(
        4 * np.log(10) / np.sqrt(curve.softening_stiffness), rel=1e-6
    )


def test_the_presets_are_doherty_s_three_stages():
    for name, b1, a1 in (
        ("new", 0.72, 0.06),
        ("moderate", 0.60, 0.13),
        ("severe", 0.50, 0.20),
    ):  # section 3
        curve = TrilinearCurve.preset(name)
        assert (curve.strength_ratio, curve.yield_displacement_ratio) == (b1, a1)
    softer = TrilinearCurve.preset(
        "severe", ultimate_displacement_ratio=0.9, softening="translated"
    )
    assert softer.plateau_end == pytest.approx(0.4)


def test_arrays_of_curves_give_what_each_gives_alone():
    a1, x = np.array([[0.02], [0.05], [0.10]]), np.array([0.01, 0.07, 0.4, 0.9])
    together = TrilinearCurve(a1, 0.8, 0.95)
    assert together.shape == (3, 1)
    for name in ("force", "energy", "period"):
        alone = [getattr(TrilinearCurve(each, 0.8, 0.95), name)(x) for each in a1[:, 0]]
        np.testing.assert_array_equal(getattr(together, name)(x), alone)


A1, B1, A3 = "yield_displacement_ratio", "strength_ratio", "ultimate_displacement_ratio"
BAD = [
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


@pytest.mark.parametrize(("name", "change"), BAD)
def test_a_bad_curve_is_refused_by_the_name_of_its_ratio(name, change):
    with pytest.raises(InputError, match=name):
        TrilinearCurve(**{A1: 0.04, B1: 0.85, **change})


def test_bad_arguments_of_its_methods_are_refused():
    curve = TrilinearCurve(0.04, 0.85)  # it stores less than b1 (1 - b1/2 - a1/2) = 0.47
    for name, method, values in (
        ("energy", curve.amplitude, (-1e-9, 0.6, np.inf)),
        ("release_amplitude", curve.period, (0.0, -0.2, 1.0, np.nan)),
        ("preset", TrilinearCurve.preset, ("old",)),
    ):
        for value in values:
            with pytest.raises(InputError, match=name):
                method(value)
