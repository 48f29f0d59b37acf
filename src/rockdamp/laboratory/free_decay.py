"""Free decays as excursions of undamped motion, each with its own amplitude, joined at the crossings of zero.

Between impacts a wall under restitution moves freely, in closed form. A test therefore has these unknowns: a1, b1, and
for each release the time of the first crossing and the amplitudes. Two amplitudes give the loss of the impact between
them; no law of the losses is assumed. Least squares of the whole history average the noise over the samples of a peak,
and the half periods determine a1 and b1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from rockdamp.arrays import Array
from rockdamp.errors import check
from rockdamp.laboratory.record_fit import strength_bounds
from rockdamp.laboratory.releases import Release
from rockdamp.laboratory.uncertainty import covariance_by_sensor
from rockdamp.mechanics.curve import TrilinearCurve, plateau_end
from rockdamp.mechanics.free_motion import displacement_from_peak

# ASSUME: the range of a1/a2 and b1. Blocks that rock nearly rigidly reach further than walls do.
RATIO, STRENGTH = (0.004, 0.90), (0.30, 0.98)
SMALLEST, BELOW_A3 = 1e-6, 1 - 1e-6  # amplitudes: over u_ins, and over a3
DIFFERENCE = 1e-5  # of a parameter: step of the central differences


@dataclass(frozen=True)
class FreeDecay:
    """Releases of one specimen to be fitted: `p` in rad s-1, u_ins in m, and the shape of the last branch.

    A *point* holds a1/a2, b1, and for each release the first crossing [tau], the sensor's zero and drift over the
    release [u_ins], and the logarithms of the amplitudes [u_ins].
    """

    releases: Sequence[Release]
    p: float
    u_ins: float
    ultimate_displacement_ratio: float
    softening: str

    def curve(self, ratio: Array, b1: Array) -> TrilinearCurve:
        """Return the curve of a1/a2 and b1, which may be arrays."""
        a3 = self.ultimate_displacement_ratio
        a2 = plateau_end(b1, a3, self.softening)
        return TrilinearCurve(ratio * a2, b1, a3, self.softening)

    @cached_property
    def strength_bounds(self) -> tuple[float, float]:
        """Least and largest b1."""
        return strength_bounds(*STRENGTH, self.ultimate_displacement_ratio, self.softening)

    @cached_property
    def slices(self) -> list[slice]:
        """The part of a point that belongs to each release."""
        ends = np.cumsum([2, *(3 + release.peaks.size for release in self.releases)]).tolist()
        return [slice(start, end) for start, end in zip(ends[:-1], ends[1:], strict=True)]

    @cached_property
    def measured(self) -> list[Array]:
        """Displacements of each release from its zero. [u_ins]"""
        return [(release.displacement - release.zero) / self.u_ins for release in self.releases]

    def times(self, points: Array, index: int) -> tuple[Array, Array, Array]:
        """Return crossings of zero, and peaks around them, of a release in tau; and its amplitudes. [u_ins]"""
        part = points[:, self.slices[index]]
        amplitude = np.minimum(np.exp(part[:, 3:]), BELOW_A3 * self.ultimate_displacement_ratio)
        quarter = self.curve(points[:, :1], points[:, 1:2]).period(amplitude) / 4
        half_periods = np.cumsum(2 * quarter[:, 1:-1], axis=1)
        crossing = part[:, :1] + np.concatenate([np.zeros((len(points), 1)), half_periods], axis=1)
        peak = np.concatenate([crossing[:, :1] - quarter[:, :1], crossing + quarter[:, 1:]], axis=1)
        return crossing, peak, amplitude

    def trend(self, points: Array, index: int) -> Array:
        """Return the sensor's zero and drift over a release, shape (batch, samples). [u_ins]"""
        elapsed, part = self.releases[index].elapsed, points[:, self.slices[index]]
        return part[:, 1:2] + part[:, 2:3] * ((elapsed - elapsed[0]) / np.ptp(elapsed) - 0.5)

    def computed(self, points: Array, index: int) -> Array:
        """Return the displacement of a release without the trend, shape (batch, samples). [u_ins]"""
        release = self.releases[index]
        tau = self.p * (release.elapsed - release.elapsed[0])
        crossing, peak, amplitude = self.times(points, index)
        excursion = (tau[None, :, None] >= crossing[:, None, :]).sum(axis=2)
        from_peak = tau - np.take_along_axis(peak, excursion, axis=1)
        curve = self.curve(points[:, :1], points[:, 1:2])
        x = displacement_from_peak(
            curve, np.take_along_axis(amplitude, excursion, axis=1), from_peak
        )
        return np.sign(release.peaks[0]) * np.where(excursion % 2 == 0, 1, -1) * x

    def residual(self, point: Array) -> Array:
        """Return computed less measured displacements of all releases, one after the other. [u_ins]"""
        one = point[None]
        pairs = enumerate(self.measured)
        return np.concatenate(
            [(self.computed(one, i) + self.trend(one, i))[0] - measured for i, measured in pairs]
        )

    def derivative(self, point: Array) -> Array:
        """Return the derivative of the residual by the point, shape (samples, parameters)."""
        rows = []
        for index, part in enumerate(self.slices):
            own = [0, 1, *range(part.start, part.stop)]
            h = DIFFERENCE * np.eye(point.size)[own]
            points = np.concatenate([point + h, point - h])
            sides = self.computed(points, index) + self.trend(points, index)
            block = np.zeros((sides.shape[1], point.size))
            block[:, own] = ((sides[: len(h)] - sides[len(h) :]) / (2 * DIFFERENCE)).T
            rows.append(block)
        return np.concatenate(rows)

    def start(self) -> Array:
        """Return a point by the measured peaks, and by a1 and b1 whose half periods fit best on a grid."""
        lowest, highest = self.strength_bounds
        strengths = np.clip(np.linspace(0.32, 0.97, 40), lowest, highest)
        ratio, b1 = (
            axis.reshape(-1)
            for axis in np.meshgrid(np.geomspace(0.006, 0.8, 24), strengths, indexing="ij")
        )
        curve, misfit, parts, quotients = self.curve(ratio[:, None], b1[:, None]), 0.0, [], []
        for release in self.releases:
            largest = BELOW_A3 * self.ultimate_displacement_ratio
            amplitude = np.clip(np.abs(release.peaks) / self.u_ins, SMALLEST, largest)
            expected, measured = (
                curve.period(amplitude[1:-1]) / 2,
                self.p * np.diff(release.crossings),
            )
            misfit = misfit + ((expected - measured) ** 2).sum(axis=1)
            quotients.append(measured / expected)
            parts += [
                self.p * (release.crossings[0] - release.elapsed[0]),
                0.0,
                0.0,
                *np.log(amplitude),
            ]
        best = int(np.argmin(misfit))
        check(
            "half periods over the half periods of the nearest curve",
            float(np.median(np.concatenate(quotients, axis=1)[best])),
            lambda quotient: (quotient > 1 / 1.3) & (quotient < 1.3),
            "0.77 to 1.3, with the wall, and the units of time and displacement",
        )
        return np.array([ratio[best], b1[best], *parts])

    def solution(self) -> tuple[Array, Array]:
        """Return the point of the least squares and its covariance; refuse b1, or a1 from above, at a bound."""
        start = self.start()
        low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
        (low[0], high[0]), (low[1], high[1]) = RATIO, self.strength_bounds
        for part in self.slices:
            low[part.start + 3 : part.stop] = np.log(SMALLEST)
            high[part.start + 3 : part.stop] = np.log(BELOW_A3 * self.ultimate_displacement_ratio)
        found = least_squares(
            self.residual,
            np.clip(start, low + 1e-9, high - 1e-9),
            lambda point: self.derivative(np.clip(point, low + DIFFERENCE, high - DIFFERENCE)),
            bounds=(low, high),
            x_scale=np.where(np.arange(start.size) < 2, 0.1, 0.01),
            max_nfev=200,
            xtol=1e-10,
            ftol=1e-12,
            gtol=None,
        )
        (ratio, b1), near = found.x[:2], 1e-3 * (high - low)[:2]
        check(
            "a1/a2 of the best fit",
            ratio,
            lambda r: r < high[0] - near[0],
            f"less than {high[0]:g}",
        )
        between = f"between {low[1]:g} and {high[1]:g}; a rigid block has b1 = 1"
        check(
            "b1 of the best fit",
            b1,
            lambda b: (b > low[1] + near[1]) & (b < high[1] - near[1]),
            between,
        )
        return found.x, _covariance(found.jac, found.fun)


def _covariance(derivative: Array, residual: Array) -> Array:
    """Return the covariance by residuals that may be correlated in time, and at least the covariance by white noise.

    With this many parameters the fit itself gives neighbouring residuals a negative correlation. The estimate for
    correlated residuals mistakes it for the sensor's, so the larger of the two holds (Angrist and Pischke 2009, section
    8.1).
    """
    correlated = covariance_by_sensor(derivative, residual)
    samples, parameters = derivative.shape
    scale = np.linalg.norm(derivative, axis=0)
    inverse = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    white = np.diag(inverse) / scale**2 * (residual @ residual) / (samples - parameters)
    larger = np.sqrt(np.maximum(white / np.diag(correlated), 1.0))
    return correlated * np.outer(larger, larger)
