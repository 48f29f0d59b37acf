"""Least squares of a curve and a damper to a measured record of a wall.

*Parameters* are a1, b1 and e; of a viscous damper, e is the coefficient that its damping ratio stands for. The search
moves a *point*, which has a1/a2 instead of a1: this keeps a1 below the plateau's end a2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from rockdamp.arrays import Array
from rockdamp.constants import REFERENCE
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import check
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.histories.measured_test import measured_displacement, rest_samples
from rockdamp.mechanics.curve import TrilinearCurve, plateau_end
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, simulate

PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "restitution")
# ASSUME: the range of a masonry wall's a1/a2, b1 and e. Doherty's stages span a1/a2 = 0.21 to 0.40 and b1 = 0.50 to
# 0.72, the paper's walls 0.13 to 0.4 and 0.75 to 0.85.
LOW, HIGH = np.array([0.02, 0.40, 0.50]), np.array([0.90, 0.95, 1.00])
GRID = (
    np.geomspace(0.03, 0.65, 11),
    np.linspace(0.42, 0.94, 53),
    np.linspace(0.56, 1.00, 12),
)  # of the first scan
HALVINGS = 6  # of the distance between the grid's points


def strength_bounds(low: float, high: float, a3: float, softening: str) -> tuple[float, float]:
    """Return the bounds of b1 between which the curve has a plateau and a last branch."""
    inner = (max(low, 1.01 - a3), high) if softening == "steeper" else (low, min(high, a3 - 0.01))
    allowed = f"larger: it leaves no b1 between {low:g} and {high:g} ({softening})"
    check("ultimate_displacement_ratio", a3, lambda _: inner[0] < inner[1], allowed)
    return inner


@dataclass(frozen=True)
class RecordFit:
    """A record of a wall, a damping model, and the known part of the curve: a3 and the variant of its softening.

    Displacements are in metres; `step` is the solver's largest, in tau.
    """

    record: Record
    wall: Wall | Parapet
    damping_model: str = REFERENCE
    ultimate_displacement_ratio: float = 1.0
    softening: str = "steeper"
    step: float = 0.005

    @cached_property
    def measured(self) -> Array:
        """Measured displacement from its level at rest."""
        return measured_displacement(self.record)[0]

    @cached_property
    def trend(self) -> Array:
        """Offset and drift of the sensor, shape (samples, 2), orthonormal."""
        elapsed = self.record.elapsed - self.record.elapsed[0]
        return np.linalg.qr(np.stack([np.ones_like(elapsed), elapsed], axis=1))[0]

    @property
    def resting_deviation(self) -> float:
        """Standard deviation of the displacement sensor's noise at rest, less its offset and drift."""
        # ASSUME: the first two thirds of the rest, as the wall may move while the ground's motion is within noise.
        resting = self.measured[: 2 * rest_samples(self.record) // 3]
        trend = np.linalg.qr(self.trend[: resting.size])[0]
        return float(
            np.linalg.norm(resting - trend @ (trend.T @ resting)) / np.sqrt(resting.size - 2)
        )

    @cached_property
    def substeps(self) -> int:
        """Steps of the solver between two samples."""
        return int(count_steps(self.wall.frequency_parameter * self.record.step, self.step))

    @cached_property
    def load(self) -> Load:
        """The measured motion."""
        return make_load(self.wall, self.record, substeps=self.substeps)

    @cached_property
    def bounds(self) -> Array:
        """Least and largest of a1/a2, b1 and e, shape (2, 3)."""
        bounds = np.stack([LOW, HIGH])
        bounds[:, 1] = strength_bounds(
            LOW[1], HIGH[1], self.ultimate_displacement_ratio, self.softening
        )
        return bounds

    def subtract_trend(self, histories: Array) -> Array:
        """Subtract what offset and drift of the sensor explain from histories, shape (..., samples)."""
        return histories - (histories @ self.trend) @ self.trend.T

    def plateau_end(self, b1: Array) -> Array:
        """Return a2. [-]"""
        return plateau_end(b1, self.ultimate_displacement_ratio, self.softening)

    def parameters(self, points: Array) -> Array:
        """Turn points into parameters, shape (..., 3)."""
        ratio, b1, e = np.moveaxis(points, -1, 0)
        return np.stack([ratio * self.plateau_end(b1), b1, e], axis=-1)

    def curve(self, parameters: Array) -> TrilinearCurve:
        """Return the curves of parameters."""
        return TrilinearCurve(
            parameters[..., 0], parameters[..., 1], self.ultimate_displacement_ratio, self.softening
        )

    def damping(self, parameters: Array) -> Damping:
        """Return the dampers that lose at the reference amplitude what e loses."""
        e = parameters[..., 2]
        if self.damping_model == REFERENCE:
            return Damping(REFERENCE, e)
        amplitude = REFERENCE_AMPLITUDE * self.ultimate_displacement_ratio
        xi = damping_ratio_energy(self.curve(parameters), self.damping_model, e, amplitude)
        return Damping(self.damping_model, xi)

    def response(self, parameters: Array, load: Load | None = None) -> Array:
        """Return the displacements, shape (batch, samples), for parameters (batch, 3), or for one under many loads."""
        damping = self.damping(parameters)
        run = simulate(
            self.curve(parameters), damping, load=load or self.load, store_every=self.substeps
        )
        # A collapsed wall has a number, 3 u_ins, so that it compares with others and loses.
        return float(self.wall.instability_displacement) * np.nan_to_num(run.displacement, nan=3.0)

    def residual(self, points: Array) -> Array:
        """Return computed less measured displacements, less the trends, shape (batch, samples)."""
        return self.subtract_trend(self.response(self.parameters(points)) - self.measured)

    def derivative(self, point: Array) -> Array:
        """Return the derivative of the residual by a point, by central differences; shape (samples, 3)."""
        h = 1e-4 * (HIGH - LOW)
        point = np.clip(
            point, self.bounds[0] + h, self.bounds[1] - h
        )  # 1 is the largest e there is
        sides = np.concatenate([point + np.diag(h), point - np.diag(h)])
        response = self.subtract_trend(self.response(self.parameters(sides)))
        return ((response[:3] - response[3:]) / (2 * h[:, None])).T

    # --- search -------------------------------------------------------------------------------------------------------

    def solution(self) -> OptimizeResult:
        """Return the lowest of the local minima that a coarse scan leads to, at the fit's own step."""
        # The scan's step tells the minima apart and is stable on the whole grid. BAND is within a few per mille of CR,
        # and its steps would have to be short.
        model = REFERENCE if self.damping_model == "BAND" else self.damping_model
        coarse = replace(self, step=max(0.03, self.step), damping_model=model)
        grid = np.array(list(product(*GRID)))
        grid = grid[((grid >= self.bounds[0]) & (grid <= self.bounds[1])).all(axis=1)]
        return self.descend(coarse.descend(coarse.refine(grid)).x)

    def refine(self, points: Array) -> Array:
        """Return the best point: keep the best 64, add their neighbours at half the grid's distance, and so on.

        The misfit has long bent valleys, in which a single descent gets stuck.
        """
        offsets = np.array(list(product((-1, 0, 1), repeat=3)))
        spacing = np.array(
            [np.log(GRID[0][1] / GRID[0][0]), *(axis[1] - axis[0] for axis in GRID[1:])]
        )
        points = self.best(points)
        for _ in range(HALVINGS):
            spacing = spacing / 2
            around = np.stack([points] * len(offsets))
            around[..., 0] *= np.exp(offsets[:, None, 0] * spacing[0])
            around[..., 1:] += offsets[:, None, 1:] * spacing[1:]
            around = np.clip(around.reshape(-1, 3), *self.bounds)
            # Most are another point's neighbours too, within rounding.
            points = self.best(around[np.unique(around.round(11), axis=0, return_index=True)[1]])
        return points[0]

    def best(self, points: Array) -> Array:
        """Return the 64 points with the smallest residuals, the best first."""
        batches = np.array_split(
            points, -(-len(points) // 512)
        )  # whose histories fit into the processor's cache
        squares = [
            (self.residual(batch) ** 2).sum(axis=1)
            for batch in track(batches, "search of a1, b1 and e")
        ]
        return points[np.argsort(np.concatenate(squares), kind="stable")[:64]]

    def descend(self, start: Array) -> OptimizeResult:
        """Return the local least squares that are reached from a point."""
        return least_squares(
            lambda point: self.residual(point[None])[0],
            start,
            self.derivative,
            bounds=tuple(self.bounds),
            x_scale=HIGH - LOW,
            max_nfev=100,
            xtol=1e-9,
            ftol=1e-10,
            gtol=None,
        )
