"""Pulses as functions of time: where their formulas put peaks, zeros and side lobes, and what they leave behind."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from rockdamp.motions.pulse_shapes import ricker, table_pulse, wavelet


def test_a_ricker_wavelet_has_its_peak_zeros_and_troughs_where_the_formula_puts_them():
    assert ricker(0.0, 2.0, 3.0) == 3.0
    zero = 1 / (np.pi * 2.0 * np.sqrt(2))
    assert 2 * zero == pytest.approx(0.225, abs=5e-4)  # the width that physics gives a 2 Hz wavelet
    np.testing.assert_allclose(ricker([-zero, zero], 2.0, 3.0), 0, atol=1e-15)
    trough = minimize_scalar(lambda t: float(ricker(t, 2.0, 3.0)), bounds=(zero, 0.5), method="bounded")
    assert trough.fun == pytest.approx(-3.0 * 2 * np.exp(-1.5), rel=1e-9)


@pytest.mark.parametrize(("width", "side_lobe"), [(0.29, 0.23), (0.29, 0.18), (0.25, 0.28), (0.4, 0.4)])
def test_a_table_pulse_has_the_width_and_side_lobes_asked_for(width, side_lobe):
    def pulse(t):
        return float(table_pulse(t, 5.0, width=width, side_lobe=side_lobe))

    assert pulse(0.0) == pytest.approx(5.0, rel=1e-14)
    assert brentq(pulse, 0.01, width) == pytest.approx(width / 2, rel=1e-10)
    trough = minimize_scalar(pulse, bounds=(width / 2, 2 * width), method="bounded")
    assert trough.fun == pytest.approx(-5.0 * side_lobe, rel=1e-8)
    assert trough.x == pytest.approx(np.sqrt(3) * width / 2, rel=1e-4)


@pytest.mark.parametrize("side_lobe", [0.18, 0.23, 0.28])
def test_a_table_pulse_leaves_no_velocity_and_no_displacement(side_lobe):
    lobe = quad(table_pulse, -0.145, 0.145, args=(1.0,))[0]
    velocity = 2 * sum(quad(lambda t: table_pulse(t, 1.0, side_lobe=side_lobe), *ends)[0] for ends in ((0, 1), (1, 9)))
    assert abs(velocity) < 1e-9 * lobe
    t = np.linspace(0, 2, 500)
    np.testing.assert_array_equal(table_pulse(t, 1.0), table_pulse(-t, 1.0))  # even: no displacement either


def test_a_table_pulse_tends_to_a_ricker_wavelet_as_its_side_lobes_deepen():
    t = np.linspace(-1, 1, 2001)
    wavelet = ricker(t, 2.0, 1.0)
    width = 2 / (np.pi * 2.0 * np.sqrt(2))
    apart = [np.abs(table_pulse(t, 1.0, width=width, side_lobe=s) - wavelet).max() for s in (0.40, 0.44, 0.4459)]
    # Near r = 1 the pulse and its side lobe both depart from the wavelet in proportion to (1 - r)^2.
    assert apart[2] < 2e-3  # the side lobe itself is 4e-4 short
    assert apart[0] > 3 * apart[1] > 9 * apart[2]


def test_the_wavelet_leaves_the_table_at_rest_where_it_was():
    f, cycles = 6.0, 3.5
    half = cycles / (2 * f)
    assert wavelet(0.0, f, cycles, 3.0) == 3.0
    velocity = 2 * quad(wavelet, 0, half, args=(f, cycles, 1.0))[0]
    lobe = quad(wavelet, 0, 0.25 / f, args=(f, cycles, 1.0))[0]
    assert abs(velocity) < 1e-9 * lobe
    t = np.linspace(0, 1, 300)
    np.testing.assert_array_equal(wavelet(t, f, cycles, 1.0), wavelet(-t, f, cycles, 1.0))  # so no displacement either
    assert np.all(wavelet(t[t > half], f, cycles, 1.0) == 0)
