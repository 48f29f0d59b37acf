"""Least squares of a1, b1 and e of CR to a measured record, from a scan of all there may be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import minimum_filter
from scipy.optimize import OptimizeResult, least_squares

from rockdamp.arrays import Array, Quantity
from rockdamp.constants import SOFTENING
from rockdamp.errors import InputError, check, check_choice
from rockdamp.histories.loads import count_steps
from rockdamp.histories.measured_test import measured_displacement, motion_noise, rest_samples
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, simulate

PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "restitution")
# ASSUME: where a masonry wall is looked for. a1 is searched as a1/a2, which keeps it below the plateau's end a2;
# Doherty's stages span a1/a2 = 0.21 to 0.40 and b1 = 0.50 to 0.72, the paper's walls 0.13 to 0.4 and 0.75 to 0.85.
SEARCHED = {
    "yield_displacement_ratio": "yield_displacement_ratio over the plateau's end (a1/a2)",
    "strength_ratio": "strength_ratio (b1)",
    "restitution": "restitution (e)",
}
LOW, HIGH = np.array([0.02, 0.40, 0.50]), np.array([0.90, 0.95, 1.00])
WIDTH = HIGH - LOW
GRID = {
    "yield_displacement_ratio": np.geomspace(0.03, 0.65, 11),
    "strength_ratio": np.linspace(0.42, 0.94, 53),
    "restitution": np.linspace(0.56, 1.00, 12),
}
SCAN_STEP = 0.03  # in tau, at most: enough to tell the minima apart, and below the stability limit of all of the scan
# The misfit has long bent valleys, in which a descent gets stuck: the best points of the scan are refined together.
KEPT, REFINEMENTS, ROUNDS = 64, 6, 4
NEARBY = np.array([offset for offset in product((-1, 0, 1), repeat=3) if any(offset)])
EXPLAINED = 1.5  # the residuals' deviation over the resting sensor's up to which no better minimum is looked for
DESCENT = {"max_nfev": 100, "xtol": 1e-9, "ftol": 1e-10, "gtol": None}
BATCH = 512  # histories held at once, in the processor's cache
DIFFERENCE = 1e-4  # of a parameter's range: step of the central differences
DRAWS, DRAWS_SEED = 256, 0  # of the motion's noise
TOGETHER = 16  # of them: of more, each would take longer for the others' motions
DRAWN = 0.3  # of its size: small enough for the response to be linear, and large against the solver's roughness
LARGEST_CONDITION = 1e4  # of the scaled derivatives: beyond it the record does not tell the parameters apart
LOST = 3.0  # u/u_ins that stands for a collapsed wall, far beyond any that stands


@dataclass(frozen=True)
class RecordFit:
    """CR fitted to a record. A *point* has the coordinates of the search, a1/a2, b1, e; *parameters* are a1, b1, e."""

    record: Record
    wall: Wall | Parapet
    ultimate_displacement_ratio: float
    softening: str
    step: float
    motion: Array  # the ground acceleration at the solver's steps [m s-2]

    @classmethod
    def from_record(
        cls,
        record: Record,
        wall: Wall | Parapet,
        *,
        ultimate_displacement_ratio: float,
        softening: str,
        step: float,
    ) -> RecordFit:
        """Prepare the fit to a record, with steps of the solver of at most `step` in tau."""
        check("step", step, lambda step: step > 0, "greater than 0")
        valid, allowed = RULES["ultimate_displacement_ratio"]
        a3 = float(check("ultimate_displacement_ratio", ultimate_displacement_ratio, valid, allowed))
        check_choice("softening", softening, SOFTENING)
        measured_displacement(record), rest_samples(record)  # refuses a record without a response or a rest
        return cls(record, wall, a3, softening, step, np.empty(0)).with_step(step)

    def with_step(self, step: float) -> RecordFit:
        """Return the same fit with another step of the solver."""
        other = replace(self, step=step)
        return replace(other, motion=other.at_steps(self.record.ground_acceleration))

    def at_steps(self, motions: Array) -> Array:
        """Return motions, shape (..., samples), at the solver's steps, by a spline: lines would cut a pulse's peak."""
        index = np.arange(motions.shape[-1])
        substeps = int(count_steps(self.wall.frequency_parameter * self.record.step, self.step))
        at = np.arange(index[-1] * substeps + 1) / substeps
        return np.ascontiguousarray(CubicSpline(index, motions, axis=-1)(at))

    @cached_property
    def measured(self) -> Array:
        """Measured displacement from its level at rest. [m]"""
        return measured_displacement(self.record)[0]

    @property
    def sensor_zero(self) -> float:
        """Level at rest of the measured displacement. [m]"""
        return measured_displacement(self.record)[1]

    @cached_property
    def resting(self) -> Array:
        """The sensor's noise: the displacement in two thirds of the rest, less its zero and drift. [m]"""
        # ASSUME: a drift would pass for noise, and so would the wall's motion while the ground's is within noise.
        measured = self.measured[: 2 * rest_samples(self.record) // 3]
        basis = np.linalg.qr(self.trend[: measured.size])[0]
        return np.asarray(measured - basis @ (basis.T @ measured))

    @property
    def rest_deviation(self) -> float:
        """Standard deviation of the sensor's noise at rest. [m]"""
        return float(np.linalg.norm(self.resting) / np.sqrt(self.resting.size - 2))

    @cached_property
    def trend(self) -> Array:
        """Offset and drift of the sensor, shape (samples, 2)."""
        elapsed = self.record.elapsed - self.record.elapsed[0]
        return np.stack([np.ones_like(elapsed), elapsed], axis=1)

    @cached_property
    def basis(self) -> Array:
        """The trend, orthonormal."""
        return np.linalg.qr(self.trend)[0]

    @cached_property
    def u_ins(self) -> float:
        """Instability displacement of the wall. [m]"""
        return float(self.wall.instability_displacement)

    def physical(self, points: Array) -> Array:
        """Turn points into parameters, or a batch of them, shape (..., 3)."""
        end = (1.0 if self.softening == "steeper" else self.ultimate_displacement_ratio) - points[..., 1]
        return np.stack([points[..., 0] * end, points[..., 1], points[..., 2]], axis=-1)

    def computed(self, parameters: Array) -> Array:
        """Return the displacement for parameters of shape (batch, 3), shape (batch, samples). [m]"""
        return self._displacement(*self._wall(parameters), self.wall.load_factor, self.motion)

    def _displacement(self, curve: TrilinearCurve, damping: Damping, load_factor: Quantity, motion: Array) -> Array:
        load = Load(motion, load_factor, self.wall.frequency_parameter * self.record.step / self._substeps)
        response = simulate(curve, damping, load=load, store_every=self._substeps).displacement
        # Collapsed walls must stay comparable numbers, and lose.
        response[np.isnan(response)] = LOST
        return self.u_ins * response

    def _wall(self, parameters: Array) -> tuple[TrilinearCurve, Damping]:
        """Curve and damping of parameters of shape (batch, 3)."""
        a1, b1, e = parameters.T
        return TrilinearCurve(a1, b1, self.ultimate_displacement_ratio, self.softening), Damping("CR", e)

    @property
    def _substeps(self) -> int:
        """Steps of the solver between two samples."""
        return (self.motion.size - 1) // (self.record.elapsed.size - 1)

    def without_trend(self, histories: Array) -> Array:
        """Subtract what an offset and a drift explain from histories, shape (..., samples)."""
        return histories - (histories @ self.basis) @ self.basis.T

    def misfit(self, points: Array, description: str = "") -> Array:
        """Sum of squares of each point's residual, shape (batch,); a description shows the progress. [m2]"""
        batches = np.array_split(points, -(-len(points) // BATCH))
        some = track(batches, description) if description else batches
        residuals = (self.without_trend(self.measured - self.computed(self.physical(batch))) for batch in some)
        return np.concatenate([np.einsum("ij,ij->i", residual, residual) for residual in residuals])

    def derivative(self, parameters: Array, *, at_point: bool = False) -> Array:
        """Derivative of the computed history by the parameters, or at a point by the point; shape (samples, 3)."""
        h = DIFFERENCE * WIDTH
        sides = np.concatenate([parameters + np.diag(h), parameters - np.diag(h)])
        computed = self.without_trend(self.computed(self.physical(sides) if at_point else sides))
        return ((computed[:3] - computed[3:]) / (2 * h[:, None])).T

    def shifts_by_motion(self, parameters: Array, computed: Array) -> Array:
        """Draw what the accelerometer's noise adds to the computed history, to first order; shape (DRAWS, samples). [m]

        It acts through the response, as an error of the motion: it shifts the whole decay, and the residuals of a fit
        hardly show it. Taken as white; its size is that of the differences between samples before and after the
        motion. It is drawn, as near collapse the tangent would make it too small.
        """
        acceleration = self.record.ground_acceleration
        size = DRAWN * motion_noise(self.record)
        draws = size * np.random.RandomState(DRAWS_SEED).standard_normal((DRAWS, acceleration.size))
        motions = self.at_steps(acceleration + draws)

        curve, damping = self._wall(parameters[None])
        parts = [motions[at : at + TOGETHER] for at in range(0, DRAWS, TOGETHER)]
        # Each lane has a motion alone: the others times 0.
        responses = [
            self._displacement(curve, damping, self.wall.load_factor * np.eye(len(part)), part)
            for part in track(parts, "noise of the motion")
        ]
        return (np.concatenate(responses) - computed) / DRAWN

    def solution(self) -> Solution:
        """Search the least squares, and say what surrounds it."""
        point, local_minima = self.search()
        estimate = self.physical(point)
        computed = self.computed(estimate[None])[0]
        return Solution(self, point, estimate, computed, self.physical(local_minima))

    def search(self) -> tuple[Array, Array]:
        """Return the point of least misfit, and the local minima that the scan found, the lowest first."""
        axes = list(GRID.values())
        grid = np.array(list(product(*axes)))
        coarse = self.with_step(max(SCAN_STEP, self.step))
        misfit = coarse.misfit(grid, "scan of a1, b1 and e").reshape([len(axis) for axis in axes])
        minima = np.flatnonzero(misfit == minimum_filter(misfit, size=3, mode="nearest"))
        lowest = np.argsort(misfit, axis=None, kind="stable")
        points, found = grid[lowest[:KEPT]], grid[lowest[np.isin(lowest, minima)]]
        best = coarse.descend(coarse._refine(points))
        for _ in range(ROUNDS - 1):
            if np.sqrt(2 * best.cost / self.measured.size) < EXPLAINED * self.rest_deviation:
                break
            again = coarse.descend(coarse._refine(best.x[None]))
            if again.cost > 0.99 * best.cost:
                break
            best = again
        return self.descend(best.x).x, found

    def _refine(self, points: Array) -> Array:
        """Look around each point, keep the best of all, halve the distance, and so on; return the best."""
        a1, *others = GRID.values()
        spacing = np.array([np.log(a1[1] / a1[0]), *(axis[1] - axis[0] for axis in others)])
        misfit = self.misfit(points)
        for _ in track(range(REFINEMENTS), "refinement of the scan"):
            spacing = spacing / 2
            around = np.stack([points] * len(NEARBY))
            around[..., 0] *= np.exp(NEARBY[:, None, 0] * spacing[0])
            around[..., 1:] += NEARBY[:, None, 1:] * spacing[1:]
            around = np.clip(around.reshape(-1, 3), LOW, HIGH)
            # Three of four are another point's neighbours too, but for rounding.
            _, first, which = np.unique(around.round(11), axis=0, return_index=True, return_inverse=True)
            points, misfit = np.concatenate([points, around]), np.append(misfit, self.misfit(around[first])[which])
            best = np.argsort(misfit, kind="stable")[:KEPT]
            points, misfit = points[best], misfit[best]
        return points[0]

    def descend(self, start: Array) -> OptimizeResult:
        """Return the local least squares that are reached from a point."""

        def residual(point: Array) -> Array:
            return self.without_trend(self.computed(self.physical(point)[None])[0] - self.measured)

        def derivative(point: Array) -> Array:
            # Central differences must not step over a bound: 1 is the largest e there is.
            inside = DIFFERENCE * WIDTH
            return self.derivative(np.clip(point, LOW + inside, HIGH - inside), at_point=True)

        return least_squares(residual, start, derivative, bounds=(LOW, HIGH), x_scale=WIDTH, **DESCENT)


@dataclass(frozen=True)
class Solution:
    """The least squares of a fit: its point and parameters, its history, and the local minima of the scan before."""

    fit: RecordFit
    point: Array
    estimate: Array
    computed: Array  # [m]
    local_minima: Array  # (minima, 3): their parameters, those of the lowest first

    @cached_property
    def residual(self) -> Array:
        """Measured less computed displacement, without the sensor's offset and drift. [m]"""
        return self.fit.without_trend(self.fit.measured - self.computed)

    @cached_property
    def derivative(self) -> Array:
        """Derivative of the history by the parameters, without offset and drift; shape (samples, 3)."""
        return self.fit.derivative(self.estimate)

    def with_size(self, name: str, change: float) -> Array:
        """Return the estimate of a wall of which a size is larger by so much, descended to from this one."""
        wall = replace(self.fit.wall, **{name: getattr(self.fit.wall, name) + change})
        other = replace(self.fit, wall=wall)
        return other.physical(other.descend(self.point).x)

    @cached_property
    def shifts(self) -> Array:
        """Draws of what the noise of the measured motion adds to the history, shape (DRAWS, samples). [m]"""
        return self.fit.shifts_by_motion(self.estimate, self.computed)

    @cached_property
    def covariance_by_motion(self) -> Array:
        """Covariance that the accelerometer's noise alone gives the estimates."""
        estimates = np.linalg.lstsq(self.derivative, self.fit.without_trend(self.shifts).T, rcond=None)[0]
        return estimates @ estimates.T / len(self.shifts)

    @cached_property
    def covariance_by_sensor(self) -> tuple[Array, int]:
        """Covariance by the residuals, and the samples over which they are taken as correlated."""
        return covariance_by_sensor(self.derivative, self.residual)


def covariance_by_sensor(derivative: Array, residual: Array) -> tuple[Array, int]:
    """Covariance of the estimates under serially correlated residuals, and the bandwidth in samples that it took.

    Derivative and residual are without offset and drift, so those two are accounted for (Frisch and Waugh).
    """
    scale = np.linalg.norm(derivative, axis=0)
    if not scale.all() or np.linalg.cond(derivative / scale) > LARGEST_CONDITION:
        raise InputError("the record does not determine a1, b1 and e; it must hold rocking beyond the first branch")
    scores = (derivative / scale) * residual[:, None]
    samples = residual.size
    lag_one = np.sum(scores[1:] * scores[:-1], axis=0) / np.sum(scores**2, axis=0)
    rho = min(float(lag_one.max()), 0.99)
    alpha = 4 * rho**2 / (1 - rho**2) ** 2
    bandwidth = min(int(np.ceil(1.1447 * (alpha * samples) ** (1 / 3))), samples - 1)
    meat = scores.T @ scores
    for lag in range(1, bandwidth + 1):
        product_ = scores[lag:].T @ scores[:-lag]
        meat += (1 - lag / (bandwidth + 1)) * (product_ + product_.T)
    meat *= samples / (samples - derivative.shape[1] - 2)
    bread = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    return bread @ meat @ bread / np.outer(scale, scale), bandwidth
