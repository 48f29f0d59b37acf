"""Free decays as excursions of undamped motion, joined at crossings of zero.

Between impacts a wall under restitution moves freely, in closed form. A test therefore has these
unknowns: a1, b1, and for each release the time of the first crossing and the amplitudes. Two
amplitudes give the loss of the impact between them; no law of the losses is assumed. Least squares
of the whole history average the noise over the samples of a peak, and the half periods determine a1
and b1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from rockdamp.arrays import Array
from rockdamp.errors import check
from rockdamp.laboratory.record_fit import strength_bounds
from rockdamp.laboratory.releases import Release
from rockdamp.laboratory.uncertainty import (
    DIFFERENCE_STEP,
    covariance_by_sensor,
    differentiate,
)
from rockdamp.mechanics.curve import TrilinearCurve, plateau_end
from rockdamp.mechanics.free_motion import displacement_from_peak

# ASSUME: the range of a1/a2 and b1. Blocks that rock nearly rigidly reach further than walls do.
RATIO_RANGE = (0.004, 0.90)
STRENGTH_RANGE = (0.30, 0.98)
SMALLEST_AMPLITUDE = 1e-6  # u/u_ins, whose logarithm is finite
LARGEST_SHARE = 1 - 1e-6  # of an amplitude over a3, where the period is infinite


class Excursions(NamedTuple):
    """Excursions of a release, for a batch of points.

    Parameters
    ----------
    crossing : ndarray, shape (batch, impacts)
        Crossings of zero. [tau]
    peak : ndarray, shape (batch, impacts + 1)
        Times of the peaks around the crossings. [tau]
    amplitude : ndarray, shape (batch, impacts + 1)
        Peaks without their sign. [u_ins]
    """

    crossing: Array
    peak: Array
    amplitude: Array


@dataclass(frozen=True)
class FreeDecay:
    """Releases of one specimen to be fitted.

    A *point* holds a1/a2, b1, and for each release the first crossing [tau], the sensor's zero and
    drift over the release [u_ins], and the logarithms of the amplitudes [u_ins].

    Parameters
    ----------
    releases : sequence of Release
        Free decays of the specimen.
    p : float
        Frequency parameter. [rad s-1]
    u_ins : float
        Displacement of instability. [m]
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of the softening branch.
    """

    releases: Sequence[Release]
    p: float
    u_ins: float
    ultimate_displacement_ratio: float
    softening: str

    def curve(self, ratio: Array, b1: Array) -> TrilinearCurve:
        """Return the curve of a1/a2 and b1, which may be arrays."""
        a3 = self.ultimate_displacement_ratio
        a1 = ratio * plateau_end(b1, a3, self.softening)
        return TrilinearCurve(a1, b1, a3, self.softening)

    def curves(self, points: Array) -> TrilinearCurve:
        """Return the curves of a batch of points, of shape (batch, 1)."""
        return self.curve(points[:, :1], points[:, 1:2])

    @property
    def largest_amplitude(self) -> float:
        """Largest amplitude, just below a3. [u_ins]"""
        return LARGEST_SHARE * self.ultimate_displacement_ratio

    @cached_property
    def strength_bounds(self) -> tuple[float, float]:
        """Lowest and highest b1."""
        return strength_bounds(*STRENGTH_RANGE, self.ultimate_displacement_ratio, self.softening)

    @cached_property
    def slices(self) -> list[slice]:
        """Part of a point that belongs to each release."""
        start = 2
        slices = []
        for release in self.releases:
            end = start + 3 + release.peaks.size
            slices.append(slice(start, end))
            start = end
        return slices

    @cached_property
    def measured(self) -> list[Array]:
        """Displacements of each release from its zero. [u_ins]"""
        return [(release.displacement - release.zero) / self.u_ins for release in self.releases]

    # --- motion of a point ------------------------------------------------------------------------

    def excursions(self, points: Array, index: int) -> Excursions:
        """Return the excursions of a release for a batch of points."""
        part = points[:, self.slices[index]]
        amplitude = np.minimum(np.exp(part[:, 3:]), self.largest_amplitude)
        quarter = self.curves(points).period(amplitude) / 4
        since_first = np.cumsum(2 * quarter[:, 1:-1], axis=1)
        crossing = part[:, :1] + np.concatenate([np.zeros((len(points), 1)), since_first], axis=1)
        first_peak = crossing[:, :1] - quarter[:, :1]
        peak = np.concatenate([first_peak, crossing + quarter[:, 1:]], axis=1)
        return Excursions(crossing, peak, amplitude)

    def trend(self, points: Array, index: int) -> Array:
        """Return the sensor's zero and drift over a release, shape (batch, samples). [u_ins]"""
        elapsed = self.releases[index].elapsed
        part = points[:, self.slices[index]]
        return part[:, 1:2] + part[:, 2:3] * ((elapsed - elapsed[0]) / np.ptp(elapsed) - 0.5)

    def computed(self, points: Array, index: int) -> Array:
        """Return the displacement without the trend, shape (batch, samples). [u_ins]"""
        release = self.releases[index]
        tau = self.p * (release.elapsed - release.elapsed[0])
        crossing, peak, amplitude = self.excursions(points, index)
        excursion = (tau[None, :, None] >= crossing[:, None, :]).sum(axis=2)
        from_peak = tau - np.take_along_axis(peak, excursion, axis=1)
        sample_amplitude = np.take_along_axis(amplitude, excursion, axis=1)
        displacement = displacement_from_peak(self.curves(points), sample_amplitude, from_peak)
        side = np.where(excursion % 2 == 0, 1, -1)
        return np.sign(release.peaks[0]) * side * displacement

    def sensed(self, points: Array, index: int) -> Array:
        """Return the displacement as the sensor shows it, shape (batch, samples). [u_ins]"""
        return self.computed(points, index) + self.trend(points, index)

    def residual(self, point: Array) -> Array:
        """Return computed less measured displacements of all releases in order. [u_ins]"""
        residuals = []
        for index, measured in enumerate(self.measured):
            residuals.append(self.sensed(point[None], index)[0] - measured)
        return np.concatenate(residuals)

    def derivative(self, point: Array) -> Array:
        """Return the derivative of the residual by the point, shape (samples, parameters)."""
        blocks = []
        for index, part in enumerate(self.slices):
            columns = [0, 1, *range(part.start, part.stop)]
            block = np.zeros((self.measured[index].size, point.size))
            block[:, columns] = differentiate(partial(self.sensed, index=index), point, columns)
            blocks.append(block)
        return np.concatenate(blocks)

    # --- search -----------------------------------------------------------------------------------

    def start(self) -> Array:
        """Return a point from the measured peaks, and from the best a1 and b1 of a grid.

        The grid is compared by the half periods between crossings.
        """
        # Inside the bounds, and fine enough for the descent to find the minimum.
        ratios = np.geomspace(0.006, 0.8, 24)
        strengths = np.clip(np.linspace(0.32, 0.97, 40), *self.strength_bounds)
        grid = np.meshgrid(ratios, strengths, indexing="ij")
        ratio, b1 = (values.reshape(-1) for values in grid)
        curve = self.curve(ratio[:, None], b1[:, None])
        misfit = 0.0
        release_points = []
        quotients = []
        for release in self.releases:
            sizes = np.abs(release.peaks) / self.u_ins
            amplitude = np.clip(sizes, SMALLEST_AMPLITUDE, self.largest_amplitude)
            expected = curve.period(amplitude[1:-1]) / 2
            measured = self.p * np.diff(release.crossings)
            misfit = misfit + ((expected - measured) ** 2).sum(axis=1)
            quotients.append(measured / expected)
            first_crossing = self.p * (release.crossings[0] - release.elapsed[0])
            release_points += [first_crossing, 0.0, 0.0, *np.log(amplitude)]
        best = int(np.argmin(misfit))
        best_quotients = np.concatenate(quotients, axis=1)[best]
        # ASSUME: beyond this range sizes or units are wrong, not the shape of the curve.
        check(
            "half periods over the half periods of the nearest curve",
            float(np.median(best_quotients)),
            lambda quotient: (quotient > 1 / 1.3) & (quotient < 1.3),
            "0.77 to 1.3, with the wall, and the units of time and displacement",
        )
        return np.array([ratio[best], b1[best], *release_points])

    def bounds(self) -> tuple[Array, Array]:
        """Return the lowest and the highest point."""
        size = self.slices[-1].stop
        low = np.full(size, -np.inf)
        high = np.full(size, np.inf)
        low[0], high[0] = RATIO_RANGE
        low[1], high[1] = self.strength_bounds
        for part in self.slices:
            low[part.start + 3 : part.stop] = np.log(SMALLEST_AMPLITUDE)
            high[part.start + 3 : part.stop] = np.log(self.largest_amplitude)
        return low, high

    def solution(self) -> tuple[Array, Array]:
        """Return the point of the least squares and its covariance.

        Raises
        ------
        InputError
            If b1 lies at a bound of the search, or a1/a2 at its upper bound.
        """
        start = self.start()
        low, high = self.bounds()
        # Central differences stay inside the bounds.
        inner_low = low + DIFFERENCE_STEP
        inner_high = high - DIFFERENCE_STEP
        best = least_squares(
            self.residual,
            np.clip(start, low + 1e-9, high - 1e-9),  # a start must lie inside the bounds
            lambda point: self.derivative(np.clip(point, inner_low, inner_high)),
            bounds=(low, high),
            # The curve's a1/a2 and b1 are known less well than times and amplitudes.
            x_scale=np.where(np.arange(start.size) < 2, 0.1, 0.01),
            max_nfev=200,
            xtol=1e-10,
            ftol=1e-12,
            gtol=None,
        )
        # The search stops just inside a bound.
        ratio_margin, strength_margin = 1e-3 * (high - low)[:2]
        check(
            "a1/a2 of the best fit",
            best.x[0],
            lambda ratio: ratio < high[0] - ratio_margin,
            f"less than {high[0]:g}",
        )
        check(
            "b1 of the best fit",
            best.x[1],
            lambda b1: (b1 > low[1] + strength_margin) & (b1 < high[1] - strength_margin),
            f"between {low[1]:g} and {high[1]:g} (a rigid block has b1 = 1): check the sizes, the"
            " unit and the frame rate",
        )
        return best.x, _covariance(best.jac, best.fun)


def _covariance(derivative: Array, residual: Array) -> Array:
    """Return the covariance by correlated residuals, and at least that by white noise.

    With this many parameters the fit itself gives neighbouring residuals a negative correlation.
    The estimate for correlated residuals mistakes it for the sensor's and becomes too small.
    Therefore each variance is the larger one of the two (Angrist and Pischke 2009, section 8.1).
    """
    correlated = covariance_by_sensor(derivative, residual)
    samples, parameters = derivative.shape
    scale = np.linalg.norm(derivative, axis=0)
    inverse = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    white = np.diag(inverse) / scale**2 * (residual @ residual) / (samples - parameters)
    inflation = np.sqrt(np.maximum(white / np.diag(correlated), 1.0))
    return correlated * np.outer(inflation, inflation)
