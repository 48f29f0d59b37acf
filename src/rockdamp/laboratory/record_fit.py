"""Least squares of a curve and a damper to a measured record of a wall.

*Parameters* are a1, b1 and e; of a viscous damper e is what its damping ratio stands for. A *point* is where the search
has them: a1 over the plateau's end a2 in place of a1, which keeps a1 below a2.
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
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.histories.measured_test import measured_displacement, rest_samples
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, simulate

PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "restitution")
# ASSUME: where a masonry wall is looked for. Doherty's stages span a1/a2 = 0.21 to 0.40 and b1 = 0.50 to 0.72, the
# paper's walls 0.13 to 0.4 and 0.75 to 0.85.
LOW, HIGH = np.array([0.02, 0.40, 0.50]), np.array([0.90, 0.95, 1.00])
WIDTH = HIGH - LOW
GRID = np.geomspace(0.03, 0.65, 11), np.linspace(0.42, 0.94, 53), np.linspace(0.56, 1.00, 12)
SCAN_STEP = 0.03  # in tau, at most: tells the minima apart, and is below the stability limit of all of the grid
# The misfit has long bent valleys, in which a descent gets stuck: the best points of the scan are refined together.
KEPT, HALVINGS, ROUNDS = 64, 6, 3
NEIGHBOURS = np.array([offset for offset in product((-1, 0, 1), repeat=3) if any(offset)])
BATCH = 512  # histories held at once, in the processor's cache
DIFFERENCE = 1e-4  # of a parameter's range: step of the central differences
COLLAPSED = 3.0  # u/u_ins that stands for a collapsed wall, far beyond any that stands


@dataclass(frozen=True)
class RecordFit:
    """A record of a wall, a damper, and what is taken as known of the curve: a3 and the variant of its softening.

    Displacements are in metres.
    """

    record: Record
    wall: Wall | Parapet
    damping_model: str = REFERENCE
    ultimate_displacement_ratio: float = 1.0
    softening: str = "steeper"
    step: float = 0.005  # of the solver, in tau, at most

    @cached_property
    def measured(self) -> Array:
        """Measured displacement from its level at rest."""
        return measured_displacement(self.record)[0]

    @cached_property
    def trend(self) -> Array:
        """Offset and drift of the sensor, shape (samples, 2), orthonormal."""
        elapsed = self.record.elapsed - self.record.elapsed[0]
        return np.linalg.qr(np.stack([np.ones_like(elapsed), elapsed], axis=1))[0]

    def subtract_trend(self, histories: Array) -> Array:
        """Subtract what offset and drift of the sensor explain from histories, shape (..., samples)."""
        return histories - (histories @ self.trend) @ self.trend.T

    def end_of_plateau(self, b1: Array) -> Array:
        """Return a2. [-]"""
        return (1.0 if self.softening == "steeper" else self.ultimate_displacement_ratio) - b1

    def parameters(self, points: Array) -> Array:
        """Turn points into parameters, shape (..., 3)."""
        ratio, b1, e = np.moveaxis(points, -1, 0)
        return np.stack([ratio * self.end_of_plateau(b1), b1, e], axis=-1)

    def damping(self, curve: TrilinearCurve, e: Array) -> Damping:
        """Return the damper that loses at the reference amplitude what e loses."""
        if self.damping_model == REFERENCE:
            return Damping(REFERENCE, e)
        amplitude = REFERENCE_AMPLITUDE * self.ultimate_displacement_ratio
        return Damping(self.damping_model, damping_ratio_energy(curve, self.damping_model, e, amplitude))

    def curve(self, parameters: Array) -> TrilinearCurve:
        """Return the curves of parameters."""
        return TrilinearCurve(parameters[..., 0], parameters[..., 1], self.ultimate_displacement_ratio, self.softening)

    @cached_property
    def substeps(self) -> int:
        """Steps of the solver between two samples."""
        return int(count_steps(self.wall.frequency_parameter * self.record.step, self.step))

    @cached_property
    def load(self) -> Load:
        """The measured motion."""
        return make_load(self.wall, self.record, substeps=self.substeps)

    def response(self, parameters: Array, load: Load | None = None) -> Array:
        """Return the displacements, shape (batch, samples), for parameters (batch, 3), or for one under many loads."""
        curve = self.curve(parameters)
        damping = self.damping(curve, parameters[..., 2])
        run = simulate(curve, damping, load=load or self.load, store_every=self.substeps)
        # Collapsed walls must stay comparable numbers, and lose.
        return float(self.wall.instability_displacement) * np.nan_to_num(run.displacement, nan=COLLAPSED)

    def derivative(self, point: Array) -> Array:
        """Return the derivative of the response by a point, less the trends; shape (samples, 3)."""
        h = DIFFERENCE * WIDTH
        point = np.clip(point, LOW + h, HIGH - h)  # 1 is the largest e there is
        sides = np.concatenate([point + np.diag(h), point - np.diag(h)])
        response = self.subtract_trend(self.response(self.parameters(sides)))
        return ((response[:3] - response[3:]) / (2 * h[:, None])).T

    def residual(self, points: Array) -> Array:
        """Return computed less measured displacements, less the trends, shape (batch, samples)."""
        return self.subtract_trend(self.response(self.parameters(points)) - self.measured)

    # --- search -------------------------------------------------------------------------------------------------------

    def solution(self) -> OptimizeResult:
        """Return the least squares: the lowest minimum that a coarse scan leads to, at the fit's own step."""
        # BAND is within a few per mille of CR, and its steps would have to be short.
        model = REFERENCE if self.damping_model == "BAND" else self.damping_model
        coarse = replace(self, step=max(SCAN_STEP, self.step), damping_model=model)
        grid = np.array(list(product(*GRID)))
        points = grid[np.argsort(coarse.misfit(grid, "scan of a1, b1 and e"), kind="stable")[:KEPT]]
        best = coarse.descend(coarse.refine(points))
        for _ in range(ROUNDS):
            again = coarse.descend(coarse.refine(best.x[None]))
            if again.cost > 0.99 * best.cost:
                break
            best = again
        return self.descend(best.x)

    def misfit(self, points: Array, description: str = "refinement") -> Array:
        """Return the sum of squares of each point's residual, shape (batch,). [m2]"""
        batches = np.array_split(points, -(-len(points) // BATCH))
        return np.concatenate([(self.residual(batch) ** 2).sum(axis=1) for batch in track(batches, description)])

    def refine(self, points: Array) -> Array:
        """Look around each point, keep the best of all, halve the distance, and so on; return the best."""
        spacing = np.array([np.log(GRID[0][1] / GRID[0][0]), *(axis[1] - axis[0] for axis in GRID[1:])])
        misfit = self.misfit(points)
        for _ in range(HALVINGS):
            spacing = spacing / 2
            around = np.stack([points] * len(NEIGHBOURS))
            around[..., 0] *= np.exp(NEIGHBOURS[:, None, 0] * spacing[0])
            around[..., 1:] += NEIGHBOURS[:, None, 1:] * spacing[1:]
            around = np.clip(around.reshape(-1, 3), LOW, HIGH)
            # Three of four are another point's neighbours too, but for rounding.
            _, first, which = np.unique(around.round(11), axis=0, return_index=True, return_inverse=True)
            points, misfit = np.concatenate([points, around]), np.append(misfit, self.misfit(around[first])[which])
            best = np.argsort(misfit, kind="stable")[:KEPT]
            points, misfit = points[best], misfit[best]
        return points[0]

    def descend(self, start: Array) -> OptimizeResult:
        """Return the local least squares that are reached from a point."""
        return least_squares(
            lambda point: self.residual(point[None])[0],
            start,
            self.derivative,
            bounds=(LOW, HIGH),
            x_scale=WIDTH,
            max_nfev=100,
            xtol=1e-9,
            ftol=1e-10,
            gtol=None,
        )

    @property
    def resting_deviation(self) -> float:
        """Standard deviation of the displacement sensor's noise at rest, less its zero and drift."""
        # ASSUME: of the rest the first two thirds, as the wall may move while the ground's motion is within noise.
        resting = self.measured[: 2 * rest_samples(self.record) // 3]
        trend = np.linalg.qr(self.trend[: resting.size])[0]
        return float(np.linalg.norm(resting - trend @ (trend.T @ resting)) / np.sqrt(resting.size - 2))
