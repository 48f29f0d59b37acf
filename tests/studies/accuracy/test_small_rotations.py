"""What the small-rotation theory leaves out, on cases whose answer is known."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from rockdamp.mechanics import rigid_bodies
from rockdamp.mechanics.wall import Wall
from rockdamp.studies.accuracy import small_rotations


def test_features_are_the_first_impact_and_the_peaks_after_it():
    times = np.linspace(0, 9, 3601)
    decaying = 0.8 * np.cos(2 * times) * 0.9 ** np.floor((2 * times + np.pi / 2) / np.pi)
    found = small_rotations.features(times, decaying, 3)
    np.testing.assert_allclose(found, [np.pi / 4, 0.8 * 0.9, 0.8 * 0.81, 0.8 * 0.729], rtol=1e-5)
    short = small_rotations.features(times[:1200], decaying[:1200], 3)
    assert np.isfinite(short).tolist() == [True, True, False, False]


def test_peaks_are_found_between_the_samples():
    """The largest sample is up to (w h)^2/8 = 1.2e-3 too low; a parabola leaves the fourth order."""
    times = 0.05 * np.arange(200)
    found = small_rotations.features(times, np.cos(2 * times), 4)
    np.testing.assert_allclose(found[1:], 1, atol=2e-5)


@pytest.mark.parametrize("hinge", [0.5, 0.7])
@pytest.mark.parametrize("slenderness", [5, 15])
def test_p_falls_by_the_mass_that_the_slender_limit_leaves_out(hinge, slenderness):
    more = (3 - 2 * hinge) / (hinge**2 * (1 - hinge)) / slenderness**2
    wall = Wall(0.5, 0.5 * slenderness, hinge_ratio=hinge)
    assert small_rotations.frequency_difference(wall) == pytest.approx((1 + more) ** -0.5 - 1, rel=1e-9)


def test_differences_are_those_of_the_energy_integrals():
    """First impact: p times the integral of sqrt(M/(2 (U0 - U))); peaks: U falls by e^2 at each impact."""
    wall, e, x0 = Wall(0.4, 2.4, hinge_ratio=0.6), 0.9, 0.7
    bodies, p, scale = rigid_bodies.TwoBodies(wall), float(wall.frequency_parameter), 0.4
    rest, top = bodies.potential(0.0), bodies.potential(x0 * scale)

    def rate(s):  # u = u0 - s^2 takes the singularity away
        u = x0 * scale - s * s
        return 2 * s * np.sqrt(bodies.inertia(u) / (2 * max(top - bodies.potential(u), 1e-300)))

    impact = p * quad(rate, 0, np.sqrt(x0 * scale), epsabs=1e-12)[0] / np.arccosh(1 / (1 - x0)) - 1
    peaks = []
    for n in (1, 2):
        kept = rest + e ** (2 * n) * (top - rest)
        large = brentq(lambda u, kept=kept: bodies.potential(u) - kept, 0, x0 * scale) / scale
        peaks.append(large / (1 - np.sqrt(1 - e ** (2 * n) * x0 * (2 - x0))) - 1)
    found = small_rotations.differences(wall, e, x0, 2)
    assert found[0] == pytest.approx(impact, rel=1e-3)
    assert found[1] == pytest.approx(max(peaks, key=abs), rel=1e-3)
    assert found[2] == small_rotations.frequency_difference(wall)


@pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # 80 times as high as thick, for the limit
def test_differences_fall_with_the_square_of_the_slenderness():
    one, other = (small_rotations.differences(Wall(0.4, 0.4 * h, hinge_ratio=0.5), 0.955, 0.5, 2) for h in (40, 80))
    np.testing.assert_allclose(one / other, 4, rtol=0.03)


@pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # 80 times as high as thick, for the limit
def test_small_rotations_over_predict_a_forced_peak_by_what_falls_with_the_square_of_the_slenderness():
    walls = [Wall(0.4, 0.4 * h, hinge_ratio=0.7) for h in (8, 40, 80)]
    squat, one, other = (small_rotations.forced_difference(wall, 0.5) for wall in walls)
    assert squat < other < 0 and one / other == pytest.approx(4, rel=0.05)


def test_a_forced_peak_of_the_slender_limit_is_that_of_a_kernel_that_knows_no_bodies():
    """x'' - x = 2 sin(w t) - 1 has a closed form, from when the load reaches the strength to the end of the pulse."""
    duration = 0.9
    w, start = np.pi / duration, duration * np.arcsin(0.5) / np.pi
    particular = lambda t: 1 - 2 * np.sin(w * t) / (1 + w**2)  # noqa: E731
    rate = lambda t: -2 * w * np.cos(w * t) / (1 + w**2)  # noqa: E731
    a, b = -particular(start), -rate(start)
    x = particular(duration) + a * np.cosh(duration - start) + b * np.sinh(duration - start)
    v = rate(duration) + a * np.sinh(duration - start) + b * np.cosh(duration - start)
    peak = 1 - np.sqrt((1 - x) ** 2 - v**2)
    found = small_rotations._first_peak(lambda x: 1.0, lambda x: 0.0, lambda x: 1.0 - x, duration)
    assert 0.1 < found < 0.9 and found == pytest.approx(peak, rel=1e-7)


def test_the_least_slenderness_is_where_the_difference_stays_below():
    h = np.array([4.0, 8.0, 16.0, 32.0])
    law = 4 / h**2  # within 5 % from sqrt(80) on, within 1 % from 20 on
    assert small_rotations.least_slenderness(h, law, 0.05) == pytest.approx(np.sqrt(80))
    assert small_rotations.least_slenderness(h, -law, 0.01) == pytest.approx(20)
    assert np.isnan(small_rotations.least_slenderness(h, law, 0.001))
    assert small_rotations.least_slenderness(h, law, 0.5) == 4
    back = np.array([0.001, 0.02, 0.005, 0.005])  # below once is not staying below
    assert 8 < small_rotations.least_slenderness(h, back, 0.01) < 16


def test_fig4_is_compared_with_both_references(looped):
    tau = looped["tau"].values
    histories = {"tri-linear": np.cos(tau), "slender": np.cos(1.02 * tau), "large rotation": 0.9 * np.cos(tau)}
    known = looped.copy(deep=True)
    for name, history in histories.items():
        known["rocking_displacement"].loc[{"rocking_model": name}] = history
    wall = Wall(0.4, 4.0, hinge_ratio=0.5)
    found = small_rotations.rotations(
        known, wall, restitution=0.955, slenderness=[8, 20], hinge_ratio=[0.5], release_amplitude=[0.5], peaks=4
    )["fig4_difference"]
    np.testing.assert_allclose(found.sel(rocking_reference="slender"), [0.02, 0, 0], atol=1e-4)
    np.testing.assert_allclose(found.sel(rocking_reference="large rotation")[:2], [0, 1 / 0.9 - 1], atol=1e-4)
    ratio = 1 / (1 + small_rotations.frequency_difference(wall))
    assert float(found.sel(rocking_reference="large rotation", rocking_feature="p")) == pytest.approx(ratio - 1)
