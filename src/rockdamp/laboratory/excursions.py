r"""Free decays as excursions of undamped motion, each with an amplitude of its own, joined at the crossings of zero.

Between impacts a wall under restitution moves freely, in closed form; so all that a test says is a1, b1, and for each
release the time of the first crossing and the amplitudes. The loss of each impact follows from two amplitudes, and no
law of the losses is assumed. Least squares of the whole history take each sample once: noise averages out over the
samples of a peak, and half periods tell a1 and b1.

The losses of a specimen's impacts: their mean, their scatter, and how they depend on the amplitude.

The loss delta = -ln e of impact k, measured with a known covariance C, is taken as

.. math:: \delta_k = \delta \, m_k + s \, \epsilon_k + \text{error}_k, \qquad \epsilon_k \sim N(0, 1),
          \qquad \text{error} \sim N(0, C)

with m_k = 1 for one coefficient of restitution, delta m_k the law of loss by the energy V_k before the impact, or m_k
what a viscous damper loses on this curve. The scatter s of a real impact from the next
is estimated too: it is what a large specimen's e is uncertain by, once the sensor is good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, least_squares, minimize_scalar
from scipy.stats import t as student

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.laboratory.releases import Release
from rockdamp.laboratory.uncertainty import covariance_by_sensor
from rockdamp.mechanics.curve import TrilinearCurve

# --- free decays ------------------------------------------------------------------------------------------------------

# ASSUME: where a1/a2 and b1 are looked for. Blocks that rock nearly rigidly reach further than walls do.
LOWEST, HIGHEST = np.array([0.004, 0.30]), np.array([0.90, 0.98])
STARTS = (np.geomspace(0.006, 0.8, 24), np.linspace(0.32, 0.97, 40))
MOST_UNLIKE = 1.3  # half periods, over those of the nearest curve or below: beyond it the wall is another one
LEAST = 1e-6  # of u_ins: the smallest amplitude
BELOW_A3 = 1 - 1e-6  # of a3: the largest amplitude
DIFFERENCE = 1e-5  # of a parameter: step of the central differences
AT_BOUND = 1e-3  # of a parameter's range: nearer to a bound is at it


@dataclass(frozen=True)
class Excursions:
    """Releases of one specimen, to be fitted: `p` in rad s-1, u_ins in m, and the shape of the last branch.

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
        end = (1.0 if self.softening == "steeper" else a3) - b1
        return TrilinearCurve(ratio * end, b1, a3, self.softening)

    @cached_property
    def slices(self) -> list[slice]:
        """Where the parameters of each release stand in a point."""
        ends = 2 + np.cumsum([3 + release.peaks.size for release in self.releases])
        return [slice(int(start), int(end)) for start, end in zip([2, *ends[:-1]], ends, strict=True)]

    @cached_property
    def measured(self) -> list[Array]:
        """Displacements of each release from its zero. [u_ins]"""
        return [(release.displacement - release.zero) / self.u_ins for release in self.releases]

    def computed(self, points: Array, index: int) -> Array:
        """Return the displacement of a release for points, shape (batch, ...); shape (batch, samples). [u_ins]"""
        release, part = self.releases[index], points[:, self.slices[index]]
        tau, side = self.p * (release.elapsed - release.elapsed[0]), np.sign(release.peaks[0])
        curve = self.curve(points[:, 0, None], points[:, 1, None])
        amplitude = np.minimum(np.exp(part[:, 3:]), BELOW_A3 * self.ultimate_displacement_ratio)
        quarter = curve.period(amplitude) / 4
        crossing = part[:, :1] + np.concatenate(
            [np.zeros((len(points), 1)), np.cumsum(2 * quarter[:, 1:-1], axis=1)], axis=1
        )
        peak = np.concatenate([crossing[:, :1] - quarter[:, :1], crossing + quarter[:, 1:]], axis=1)
        excursion = (tau[None, :, None] >= crossing[:, None, :]).sum(axis=2)
        from_peak = tau - np.take_along_axis(peak, excursion, axis=1)
        x = displacement_from_peak(curve, np.take_along_axis(amplitude, excursion, axis=1), from_peak)
        trend = part[:, 1:2] + part[:, 2:3] * (tau / tau[-1] - 0.5)
        return side * np.where(excursion % 2 == 0, 1, -1) * x + trend

    def residual(self, point: Array) -> Array:
        """Return measured less computed displacements of all releases, one after the other. [u_ins]"""
        parts = [self.measured[index] - self.computed(point[None], index)[0] for index in range(len(self.releases))]
        return np.concatenate(parts)

    def derivative(self, point: Array) -> Array:
        """Return the derivative of the computed displacements by the point, shape (samples, parameters)."""
        rows = []
        for index, part in enumerate(self.slices):
            of_release = [0, 1, *range(part.start, part.stop)]
            h = DIFFERENCE * np.eye(point.size)[of_release]
            sides = self.computed(np.concatenate([point + h, point - h]), index)
            block = np.zeros((sides.shape[1], point.size))
            block[:, of_release] = ((sides[: len(h)] - sides[len(h) :]) / (2 * DIFFERENCE)).T
            rows.append(block)
        return np.concatenate(rows)

    def start(self) -> Array:
        """Return a point by the measured peaks, and by a1 and b1 whose half periods fit best on a grid."""
        ratio, b1 = (axis.reshape(-1) for axis in np.meshgrid(*STARTS, indexing="ij"))
        curve = self.curve(ratio[:, None], b1[:, None])
        misfit = np.zeros(ratio.size)
        own = []
        for release in self.releases:
            amplitude = np.clip(np.abs(release.peaks) / self.u_ins, LEAST, BELOW_A3 * self.ultimate_displacement_ratio)
            expected = curve.period(amplitude[1:-1]) / 2
            misfit += ((expected - self.p * release.half_periods) ** 2).sum(axis=1)
            crossing = self.p * (release.crossings[0] - release.elapsed[0])
            own += [crossing, 0.0, 0.0, *np.log(amplitude)]
        best = int(np.argmin(misfit))
        self._check_half_periods(self.curve(ratio[best], b1[best]))
        return np.array([ratio[best], b1[best], *own])

    def _check_half_periods(self, curve: TrilinearCurve) -> None:
        """Raise `InputError` where no curve has half periods like the measured ones."""
        release = self.releases[0]
        amplitude = np.minimum(np.abs(release.peaks[1:-1]) / self.u_ins, BELOW_A3 * self.ultimate_displacement_ratio)
        ratio = float(np.median(self.p * release.half_periods / (curve.period(amplitude) / 2)))
        if not 1 / MOST_UNLIKE < ratio < MOST_UNLIKE:
            raise InputError(
                f"half periods are {ratio:.3g} times those of the wall whose curve is nearest;"
                " are the wall, and the units of time and displacement, right?"
            )

    def solution(self) -> Solution:
        """Return the least squares."""
        start = self.start()
        low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
        low[:2], high[:2] = LOWEST, HIGHEST
        for part in self.slices:
            low[part.start + 3 : part.stop] = np.log(LEAST)
            high[part.start + 3 : part.stop] = np.log(BELOW_A3 * self.ultimate_displacement_ratio)
        start = np.clip(start, low + 1e-9, high - 1e-9)
        scale = np.full(start.size, 0.01)
        scale[:2] = 0.1
        found = least_squares(
            self.residual,
            start,
            lambda point: -self.derivative(np.clip(point, low + DIFFERENCE, high - DIFFERENCE)),
            bounds=(low, high),
            x_scale=scale,
            max_nfev=200,
            xtol=1e-10,
            ftol=1e-12,
            gtol=None,
        )
        return Solution(self, found.x)


@dataclass(frozen=True)
class Solution:
    """The least squares of a test: losses of its impacts, and what surrounds them."""

    test: Excursions
    point: Array

    @cached_property
    def residual(self) -> Array:
        """Measured less fitted displacement. [u_ins]"""
        return self.test.residual(self.point)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the point by the residuals, which may follow each other, and at least that of white noise.

        With so many parameters neighbouring residuals are correlated negatively by the fit itself, which the estimate
        that takes them as they are would mistake for the sensor's (the larger of the two: Angrist and Pischke 2009,
        section 8.1).
        """
        inside = np.clip(self.point[:2], LOWEST + DIFFERENCE, HIGHEST - DIFFERENCE)
        derivative = self.test.derivative(np.concatenate([inside, self.point[2:]]))
        following = covariance_by_sensor(derivative, self.residual)
        samples, parameters = derivative.shape
        scale = np.linalg.norm(derivative, axis=0)
        inverse = np.linalg.inv((derivative / scale).T @ (derivative / scale))
        white = np.diag(inverse) / scale**2 * (self.residual @ self.residual) / (samples - parameters)
        larger = np.sqrt(np.maximum(white / np.diag(following), 1.0))
        return following * np.outer(larger, larger)

    @property
    def curve(self) -> TrilinearCurve:
        """The fitted curve."""
        return self.test.curve(*self.point[:2])

    def check_inside(self) -> None:
        """Raise `InputError` where b1, or a1 from above, lies at a bound of the search."""
        names = ("yield_displacement_ratio over the plateau's end (a1/a2)", "strength_ratio (b1)")
        near = AT_BOUND * (HIGHEST - LOWEST)
        for index, name in enumerate(names):
            value = self.point[index]
            if value > HIGHEST[index] - near[index] or (index == 1 and value < LOWEST[index] + near[index]):
                raise InputError(
                    f"the best fit has {name} {value:.3g}; it must lie inside {LOWEST[index]:g} to {HIGHEST[index]:g}:"
                    " are the wall, and the units of time and displacement, right?"
                    + (
                        " A rigid block has b1 = 1; its e^2 is V of a peak over V of the one before,"
                        " V = x - x^2/2, x = u/u_ins"
                        if index == 1 and value > LOWEST[1] + near[1]
                        else ""
                    )
                )


# --- losses of the impacts --------------------------------------------------------------------------------------------

LEVEL = 0.90
SPACING = 0.1
EXPONENTS = SPACING * np.arange(-30, 31)  # g that are looked at
LARGEST_SCATTER = 1.0  # of ln e
LAW_EXPONENTS, LAW_GRIDS = np.linspace(-1.0, 1.5, 26), 3  # by whose likelihood e at an amplitude is weighted; refined
NEGLIGIBLE_WEIGHT = 1e-6
LAW_ROUNDS, CONVERGED, LARGEST_SHAPE, SMALLEST_LOSS, LARGEST_LOSS = 5, 1e-5, 50.0, 1e-6, 10.0


@dataclass(frozen=True)
class Line:
    """A fitted multiple of a shape: delta and its standard error, the scatter s, and ln of the likelihood."""

    decrement: float
    standard_error: float
    scatter: float
    log_likelihood: float


@dataclass(frozen=True)
class Losses:
    """Losses of impacts, shape (impacts,), and their covariance by the sensor."""

    decrement: Array
    covariance: Array

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Variances by the sensor, and the independent sums of losses that have them."""
        values, vectors = np.linalg.eigh(self.covariance)
        return values, vectors

    def of(self, chosen: Array) -> Losses:
        """Return the losses of some impacts, by their indices or by True and False."""
        return Losses(self.decrement[chosen], self.covariance[chosen][:, chosen])

    @property
    def quantile(self) -> float:
        """Return Student's quantile of an interval, by the impacts that are left once the mean is known."""
        return float(student.ppf(0.5 + LEVEL / 2, self.decrement.size - 1))

    def line(self, shape: Array, restricted: bool = True, apart: Array | float = 0.0) -> Line:
        """Fit a multiple of a shape beside losses `apart`, by generalised least squares with the most likely scatter.

        The likelihood of the scatter is restricted (REML), which leaves no bias from the mean's estimation, or plain,
        by which shapes are compared. The standard error is Hartung and Knapp's (doi:10.1002/sim.791): it takes the
        residuals as they are, where they are larger than expected.
        """
        values, vectors = self._directions
        y, m = vectors.T @ (self.decrement - apart), vectors.T @ shape

        def parts(scatter: float) -> tuple[float, float, float, float]:
            variance = np.maximum(values, 0.0) + scatter**2
            precision = float(np.sum(m**2 / variance))
            mean = float(np.sum(m * y / variance)) / precision
            square = float(np.sum((y - mean * m) ** 2 / variance))
            log_likelihood = -0.5 * (square + float(np.sum(np.log(2 * np.pi * variance))))
            return mean, precision, square, log_likelihood

        def cost(scatter: float) -> float:
            _, precision, _, log_likelihood = parts(scatter)
            return -log_likelihood + (0.5 * np.log(precision) if restricted else 0.0)

        floor = 1e-6  # keeps the variance of what the sensor measures exactly above zero
        found = minimize_scalar(cost, bounds=(floor, LARGEST_SCATTER), method="bounded", options={"xatol": 1e-7})
        scatter = float(found.x) if cost(float(found.x)) < cost(floor) else floor
        mean, precision, square, log_likelihood = parts(scatter)
        inflation = max(square / max(y.size - 1, 1), 1.0)
        return Line(mean, float(np.sqrt(inflation / precision)), scatter, log_likelihood)

    @property
    def threshold(self) -> float:
        """Fall of the log-likelihood at the end of an interval of a parameter, exact for equal variances."""
        left = max(self.decrement.size - 2, 1)
        quantile = float(student.ppf(0.5 + LEVEL / 2, left))
        return 0.5 * self.decrement.size * float(np.log1p(quantile**2 / left))


def law_of_loss(log_energy: Array, decrement: float, g: float) -> Array:
    """Return the losses by the energies before the impacts, ln E less ln of that at which the loss is `decrement`.

    The energy left to the power g falls by the same at each impact, docs/theory.md, section 8:
    delta(E) = -ln(1 - (1 - exp(-2 g delta_r)) (E_r/E)^g) / (2 g). A wall that the impact stops loses infinitely much.
    """
    return _law_and_slope(log_energy, decrement, g)[0]


def _law_and_slope(log_energy: Array, decrement: float, g: float) -> tuple[Array, Array]:
    """Return the losses by the law and their derivative by `decrement`, infinite where the impact stops the wall."""
    if abs(g) < 1e-9:
        return np.full(log_energy.shape, decrement), np.ones(log_energy.shape)
    power = np.exp(-g * log_energy)
    change = np.maximum(power * np.expm1(-2 * g * decrement), -1.0)  # of E^g, over it
    with np.errstate(divide="ignore"):
        return -np.log1p(change) / (2 * g), power * np.exp(-2 * g * decrement) / (1 + change)


def restitution_at(losses: Losses, log_energy: Array, at: float) -> tuple[float, tuple[float, float]]:
    """Return e at an energy, of logarithm `at`, and its interval, by the law of loss whose exponent is unknown too.

    Each exponent counts by its likelihood. The interval has the spread of the loss at each, and from one to the other.
    """
    away, exponents = log_energy - at, LAW_EXPONENTS
    for _ in range(LAW_GRIDS):
        found, error, likelihood = np.array([_law_line(losses, away, float(g)) for g in exponents]).T
        weight = np.exp(likelihood - likelihood.max())
        near = np.flatnonzero(weight > NEGLIGIBLE_WEIGHT)
        ends = exponents[max(near[0] - 1, 0)], exponents[min(near[-1] + 1, exponents.size - 1)]
        exponents = np.linspace(*ends, exponents.size)
    weight /= weight.sum()
    mean = float(weight @ found)
    deviation = float(np.sqrt(weight @ (error**2 + (found - mean) ** 2)))
    reach = float(student.ppf(0.5 + LEVEL / 2, max(losses.decrement.size - 2, 1))) * deviation
    return float(np.exp(-mean)), (float(np.exp(-mean - reach)), float(np.exp(min(reach - mean, 0.0))))


def _law_line(losses: Losses, log_energy: Array, g: float) -> tuple[float, float, float]:
    """Return the loss at the energy of logarithm 0 of a law, its standard error, and ln of the likelihood.

    Newton's steps start from the law that has the mean loss at the mean energy.
    """
    mean = np.array([max(float(losses.decrement.mean()), SMALLEST_LOSS)])
    decrement = min(float(law_of_loss(-log_energy.mean(keepdims=True), mean[0], g)[0]), LARGEST_LOSS)
    for _ in range(LAW_ROUNDS):
        loss, slope = _law_and_slope(log_energy, decrement, g)
        stops = loss > LARGEST_SHAPE * decrement
        loss = np.where(stops, LARGEST_SHAPE * decrement, loss)
        slope = np.where(stops, LARGEST_SHAPE, slope)
        line = losses.line(slope, restricted=False, apart=loss - slope * decrement)
        before, decrement = decrement, min(max(line.decrement, SMALLEST_LOSS), LARGEST_LOSS)
        if abs(decrement - before) < CONVERGED * before:
            break
    return decrement, line.standard_error, line.log_likelihood


def exponent_of(losses: Losses, log_energy: Array) -> tuple[float, tuple[float, float]]:
    """Return g of the law of loss by maximum likelihood, and its interval by the likelihood.

    A loss in proportion to a power of the energy would have another exponent: the law's loss grows faster than E^-g as
    the motion fades. An end of the interval is NaN where it is not determined.
    """
    centred = log_energy - log_energy.mean()

    def likelihood(g: float) -> float:
        return _law_line(losses, centred, g)[2]

    rough = EXPONENTS[int(np.argmax([likelihood(g) for g in EXPONENTS]))]
    around = np.clip([rough - SPACING, rough + SPACING], EXPONENTS[0], EXPONENTS[-1])
    found = minimize_scalar(lambda g: -likelihood(g), bounds=around, method="bounded", options={"xatol": 1e-5})
    best, least = float(found.x), -float(found.fun) - losses.threshold

    def end(beyond: list[float]) -> float:
        inside = best
        for g in beyond:
            if likelihood(g) < least:
                return float(brentq(lambda between: likelihood(between) - least, inside, g, xtol=1e-5))
            inside = g
        return np.nan

    below, above = (EXPONENTS[side].tolist() for side in (EXPONENTS < best, EXPONENTS > best))
    return best, (end(below[::-1]), end(above))


def displacement_from_peak(curve: TrilinearCurve, amplitude: Array, tau: Array) -> Array:
    r"""Return the displacement at a time before or after the peak of undamped free motion, u/u_ins. [-]

    From rest at its amplitude the wall falls along a hyperbolic cosine on the softening branch, a parabola on the
    plateau, and a cosine on the first branch. A half cycle is this fall and its mirror image in time.

    It solves :math:`x'' + f(x) = 0` from rest at the amplitude. The zero of the displacement lies a quarter of
    `TrilinearCurve.period` from the peak; beyond it the first branch goes on to the other side.

    The arguments broadcast: the amplitude x0 = u0/u_ins in (0, a3) [-], and the time from the peak, of either sign. [-]
    """
    x0, s = amplitude, np.abs(tau)
    k1, b1, ks, a1, a2, a3 = curve.parameters()
    v0 = curve.energy(x0)
    # Where each branch begins on the way down, and with which speed; a branch above the peak begins there, at rest.
    on2, on1 = np.minimum(x0, a2), np.minimum(x0, a1)
    speed2, speed1 = (np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0.0)) for x in (on2, on1))
    reach = np.where(x0 > a2, (a3 - a2) / np.where(x0 > a2, a3 - x0, 1.0), 1.0)
    end3 = np.arccosh(np.maximum(reach, 1.0)) / np.sqrt(ks)
    end2 = end3 + (speed1 - speed2) / b1
    softening = a3 - (a3 - x0) * np.cosh(np.sqrt(ks) * np.minimum(s, end3))
    on_plateau, on_first = s - end3, np.sqrt(k1) * (s - end2)
    plateau = on2 - speed2 * on_plateau - 0.5 * b1 * on_plateau**2
    first = on1 * np.cos(on_first) - speed1 / np.sqrt(k1) * np.sin(on_first)
    return np.where(s < end3, softening, np.where(s < end2, plateau, first))
