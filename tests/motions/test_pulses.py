"""The Ricker wavelet: where its formula puts peak, zeros and side lobes, and that it leaves the table at rest."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from rockdamp.motions.pulses import ricker


def test_a_ricker_wavelet_has_its_peak_zeros_and_troughs_where_the_formula_puts_them():
    assert ricker(0.0, 2.0, 3.0) == 3.0
    zero = 1 / (np.pi * 2.0 * np.sqrt(2))
    assert 2 * zero == pytest.approx(0.225, abs=5e-4)  # the width that physics gives a 2 Hz wavelet
    np.testing.assert_allclose(ricker([-zero, zero], 2.0, 3.0), 0, atol=1e-15)
    trough = minimize_scalar(lambda t: float(ricker(t, 2.0, 3.0)), bounds=(zero, 0.5), method="bounded")
    assert trough.fun == pytest.approx(-3.0 * 2 * np.exp(-1.5), rel=1e-9)
    velocity, lobe = (2 * quad(ricker, 0, end, args=(2.0, 1.0))[0] for end in (2.0, zero))
    assert abs(velocity) < 1e-9 * lobe
