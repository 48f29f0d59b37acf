"""The tri-linear curve against its drawing, its integral, mpmath's quadrature of its period, and bad input."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.vocabulary import PRESETS, SOFTENING

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
def test_the_force_is_the_drawn_curve_odd_and_zero_beyond_its_end(case):
    x = np.linspace(-1.3, 1.3, 2601)
    drawn = np.sign(x) * np.interp(np.abs(x), *corners(case))
    np.testing.assert_allclose(TrilinearCurve(*case).force(x), drawn, atol=4e-15)


@curves
def test_the_tangent_is_the_slope_of_the_force_between_the_corners(case):
    curve, (at, _) = TrilinearCurve(*case), corners(case)
    x = np.concatenate([np.linspace(a, b, 9)[1:-1] for a, b in pairwise([*at, 1.2])])
    x = np.concatenate([-x, x])
    half = 1e-6
    slope = (curve.force(x + half) - curve.force(x - half)) / (2 * half)
    np.testing.assert_allclose(curve.tangent(x), slope, atol=1e-8)


@curves
def test_at_a_corner_the_tangent_is_that_of_the_branch_further_out(case):
    curve = TrilinearCurve(*case)
    at = np.array([0.0, curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio])
    expected = [curve.initial_stiffness, 0.0, -curve.softening_stiffness, 0.0]
    np.testing.assert_array_equal(curve.tangent(at), expected)
    np.testing.assert_array_equal(curve.tangent(-at), expected)


def test_steeper_softening_starts_on_the_bilinear_law_and_translated_softening_keeps_its_slope():
    steeper, translated = (TrilinearCurve(0.05, 0.6, 0.8, softening) for softening in SOFTENING)
    assert steeper.plateau_end == pytest.approx(1 - 0.6)  # where F0 - K0 u is F_y
    assert steeper.softening_stiffness == pytest.approx(0.6 / 0.4)
    assert translated.plateau_end == pytest.approx(0.8 - 0.6)
    assert translated.softening_stiffness == pytest.approx(1.0)
    at_one = [TrilinearCurve(0.05, 0.6, 1.0, softening).parameters() for softening in SOFTENING]
    np.testing.assert_allclose(*at_one, rtol=1e-15)


@curves
def test_the_secant_is_the_force_over_the_displacement_and_at_rest_the_first_branch_s_stiffness(case):
    curve = TrilinearCurve(*case)
    x = np.linspace(-1.1, 1.1, 44)
    np.testing.assert_allclose(curve.secant(x) * x, curve.force(x), atol=1e-15)
    assert curve.secant(0.0) == pytest.approx(curve.initial_frequency**2, rel=1e-15)
    assert curve.secant(-1e-300) == pytest.approx(curve.initial_stiffness, rel=1e-15)


@curves
def test_the_energy_is_the_integral_of_the_force_even_and_constant_beyond_the_end(case):
    curve, (at, force) = TrilinearCurve(*case), corners(case)
    for x in (*at[1:] / 2, *at[1:], 0.5 * (at[2] + at[3]), 1.2):
        integral, _ = quad(lambda s: np.interp(s, at, force), 0, x, points=at[1:], epsabs=1e-13)
        assert curve.energy(x) == pytest.approx(integral, rel=1e-12)
        assert curve.energy(-x) == curve.energy(x)


@curves
def test_the_amplitude_is_the_inverse_of_the_energy_on_every_branch(case):
    curve = TrilinearCurve(*case)
    x = np.linspace(0, 1, 101)[:-1] * curve.ultimate_displacement_ratio
    # Near a3 the energy is flat: an error of eps V moves x by eps V/f.
    tolerance = 8 * np.finfo(float).eps * (1 + curve.energy(x) / np.maximum(curve.force(x), 1e-3))
    assert np.all(np.abs(curve.amplitude(curve.energy(x)) - x) <= tolerance)
    assert curve.amplitude(curve.energy(curve.ultimate_displacement_ratio)) == pytest.approx(
        curve.ultimate_displacement_ratio, abs=1e-7
    )


@pytest.mark.parametrize("energy", [-1e-9, 0.6, np.inf])
def test_an_energy_that_the_curve_cannot_store_is_refused(energy):
    curve = TrilinearCurve(0.04, 0.85)  # stores less than b1 (1 - b1/2 - a1/2) = 0.47
    with pytest.raises(InputError, match=r"energy is .*; it must be between 0 and V\(a3\)"):
        curve.amplitude(energy)


@curves
def test_the_free_period_is_the_quadrature_of_its_integral_on_every_branch(case, quarter_period):
    curve, (at, _) = TrilinearCurve(*case), corners(case)
    for x0 in (0.5 * at[1], at[1], 0.5 * (at[1] + at[2]), at[2], 0.5 * (at[2] + at[3]), 0.98 * at[3]):
        # At a corner x0 - a1 is rounding, and the period moves as its root.
        tolerance = 1e-7 if x0 in at else 1e-12
        with mp.workdps(30):
            expected = 4 * quarter_period(*([mp.mpf(float(v)) for v in values] for values in corners(case)), mp.mpf(x0))
        assert curve.period(x0) == pytest.approx(float(expected), rel=tolerance)


@curves
def test_the_free_period_is_that_of_the_first_branch_inside_it_and_grows_without_bound_towards_the_end(case):
    curve = TrilinearCurve(*case)
    inside = curve.yield_displacement_ratio * np.array([1e-6, 0.1, 0.5, 1.0])
    np.testing.assert_allclose(curve.period(inside), 2 * np.pi / curve.initial_frequency, rtol=1e-7)
    x0 = np.linspace(1.001 * curve.yield_displacement_ratio, 0.999 * curve.ultimate_displacement_ratio, 500)
    assert np.all(np.diff(curve.period(x0)) > 0)
    # Ten times nearer to the end takes 4 ln(10)/sqrt(ks) longer: the state leaves a saddle exponentially.
    near = curve.period(curve.ultimate_displacement_ratio - np.array([1e-6, 1e-7]))
    assert np.diff(near) == pytest.approx(4 * np.log(10) / np.sqrt(curve.softening_stiffness), rel=1e-6)


@pytest.mark.parametrize("x0", [0.0, -0.2, 1.0, 1.5, np.nan])
def test_a_period_needs_an_amplitude_between_rest_and_collapse(x0):
    with pytest.raises(InputError, match=r"release_amplitude is .*; it must be greater than 0 and less than a3"):
        TrilinearCurve(0.04, 0.85).period(x0)


def test_the_presets_are_doherty_s_three_stages():
    # Section 3: b1 of 0.72, 0.60 and 0.50, a1 of 0.06, 0.13 and 0.20.
    assert list(PRESETS) == ["new", "moderate", "severe"]
    for name, b1, a1 in zip(PRESETS, (0.72, 0.60, 0.50), (0.06, 0.13, 0.20), strict=True):
        curve = TrilinearCurve.preset(name)
        assert (curve.strength_ratio, curve.yield_displacement_ratio, curve.ultimate_displacement_ratio) == (
            b1,
            a1,
            1.0,
        )
    assert TrilinearCurve.preset(
        "severe", ultimate_displacement_ratio=0.9, softening="translated"
    ).plateau_end == pytest.approx(0.4)
    with pytest.raises(InputError, match=r"preset is 'old'; it must be one of new, moderate, severe"):
        TrilinearCurve.preset("old")


def test_arrays_of_curves_give_what_each_gives_alone():
    a1, x = np.array([[0.02], [0.05], [0.10]]), np.array([0.01, 0.07, 0.4, 0.9])
    together = TrilinearCurve(a1, 0.8, 0.95)
    assert together.shape == (3, 1)
    for name in ("force", "tangent", "secant", "energy", "period"):
        both = getattr(together, name)(x)
        assert both.shape == (3, 4)
        for i in range(3):
            np.testing.assert_array_equal(both[i], getattr(TrilinearCurve(a1[i, 0], 0.8, 0.95), name)(x))


BAD = [
    ({"yield_displacement_ratio": 0.0}, r"yield_displacement_ratio \(a1\) is 0\.0; it must be greater than 0"),
    ({"yield_displacement_ratio": 0.15}, r"yield_displacement_ratio \(a1\) is 0\.15; it must be less than a2"),
    ({"strength_ratio": 0.0}, r"strength_ratio \(b1\) is 0\.0; it must be between 0 and 1"),
    ({"strength_ratio": 1.0}, r"strength_ratio \(b1\) is 1\.0; it must be between 0 and 1"),
    (
        {"ultimate_displacement_ratio": 1.01},
        r"ultimate_displacement_ratio \(a3\) is 1\.01; it must be greater than 0 and at most 1",
    ),
    # 1 - 0.9 is just below 0.1 in floating point: a last branch of no length is refused all the same.
    (
        {"strength_ratio": 0.9, "ultimate_displacement_ratio": 0.1},
        r"ultimate_displacement_ratio \(a3\) is 0\.1; it must be greater than 1 - b1",
    ),
    (
        {"ultimate_displacement_ratio": 0.88, "softening": "translated"},
        r"ultimate_displacement_ratio \(a3\) is 0\.88; it must be greater than a1 \+ b1",
    ),
    ({"softening": "steep"}, r"softening is 'steep'; it must be one of steeper, translated"),
]


@pytest.mark.parametrize(("change", "message"), BAD, ids=[message.split(";")[0] for _, message in BAD])
def test_a_bad_curve_is_refused_with_the_name_the_value_and_what_is_allowed(change, message):
    given = {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85, **change}
    with pytest.raises(InputError, match=message):
        TrilinearCurve(**given)
