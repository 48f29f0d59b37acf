"""Least squares of a curve and a damper to a measured record of a wall.

*Parameters* are a1, b1 and e; for a viscous damper, e is the restitution coefficient that loses as
much as its damping ratio. The search moves a *point*, which has a1/a2 instead of a1: this keeps a1
below the plateau's end a2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from rockdamp.arrays import Array
from rockdamp.constants import REFERENCE
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import check
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.histories.record_rest import measured_displacement, rest_samples
from rockdamp.mechanics.curve import TrilinearCurve, plateau_end
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, simulate

PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "restitution")
# ASSUME: the range of a masonry wall's a1/a2, b1 and e. Doherty's stages span a1/a2 = 0.21 to 0.40
# and b1 = 0.50 to 0.72, the paper's walls 0.13 to 0.4 and 0.75 to 0.85.
LOWEST_POINT = np.array([0.02, 0.40, 0.50])
HIGHEST_POINT = np.array([0.90, 0.95, 1.00])
# Values of a1/a2, b1 and e in the first scan, and how often the distance between them is halved.
SCAN_VALUES = (
    np.geomspace(0.03, 0.65, 11),
    np.linspace(0.42, 0.94, 53),
    np.linspace(0.56, 1.00, 12),
)
SCAN_HALVINGS = 6


def strength_bounds(low: float, high: float, a3: float, softening: str) -> tuple[float, float]:
    """Return the bounds of b1 between which the curve has a plateau and a last branch."""
    least_branch = 0.01  # length of a branch, u/u_ins
    if softening == "steeper":
        bounds = max(low, 1 + least_branch - a3), high
    else:
        bounds = low, min(high, a3 - least_branch)
    check(
        "ultimate_displacement_ratio",
        a3,
        lambda _: bounds[0] < bounds[1],
        f"larger: it leaves no b1 between {low:g} and {high:g} ({softening})",
    )
    return bounds


@dataclass(frozen=True)
class RecordFit:
    """Fit of e, or of the damper that loses as much, and of the curve's a1 and b1 to a record.

    Parameters
    ----------
    record : Record
        Measured motion and displacement.
    wall : Wall or Parapet
        Sizes and weights of the wall.
    damping_model : str
        Damping model to be fitted.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of the softening branch, which are known.
    step : float
        Largest step of the solver, in tau. [-]
    """

    record: Record
    wall: Wall | Parapet
    damping_model: str = REFERENCE
    ultimate_displacement_ratio: float = 1.0
    softening: str = "steeper"
    step: float = 0.005

    @cached_property
    def measured(self) -> Array:
        """Measured displacement from its level at rest. [m]"""
        displacement, _ = measured_displacement(self.record)
        return displacement

    @cached_property
    def trend(self) -> Array:
        """Offset and drift of the sensor, shape (samples, 2), orthonormal."""
        elapsed = self.record.elapsed - self.record.elapsed[0]
        basis, _ = np.linalg.qr(np.stack([np.ones_like(elapsed), elapsed], axis=1))
        return basis

    @property
    def resting_deviation(self) -> float:
        """Standard deviation of the displacement at rest, without offset and drift. [m]"""
        # ASSUME: the first two thirds of the rest, as the wall may move while the ground's motion
        # is within the noise.
        resting = self.measured[: 2 * rest_samples(self.record) // 3]
        trend, _ = np.linalg.qr(self.trend[: resting.size])
        noise = resting - trend @ (trend.T @ resting)
        return float(np.linalg.norm(noise) / np.sqrt(resting.size - 2))

    @cached_property
    def substeps(self) -> int:
        """Steps of the solver between two samples."""
        return int(count_steps(self.wall.frequency_parameter * self.record.step, self.step))

    @cached_property
    def load(self) -> Load:
        """Load of the measured motion."""
        return make_load(self.wall, self.record, substeps=self.substeps)

    @cached_property
    def bounds(self) -> Array:
        """Lowest and highest a1/a2, b1 and e, shape (2, 3)."""
        bounds = np.stack([LOWEST_POINT, HIGHEST_POINT])
        low, high = bounds[:, 1]
        bounds[:, 1] = strength_bounds(low, high, self.ultimate_displacement_ratio, self.softening)
        return bounds

    # --- response ---------------------------------------------------------------------------------

    def subtract_trend(self, histories: Array) -> Array:
        """Subtract the best offset and drift of the sensor from histories, shape (..., samples)."""
        return histories - (histories @ self.trend) @ self.trend.T

    def plateau_end(self, b1: Array) -> Array:
        """Return a2 for values of b1. [-]"""
        return plateau_end(b1, self.ultimate_displacement_ratio, self.softening)

    def parameters(self, points: Array) -> Array:
        """Return the parameters of points, shape (..., 3)."""
        ratio, b1, e = np.moveaxis(points, -1, 0)
        return np.stack([ratio * self.plateau_end(b1), b1, e], axis=-1)

    def curve(self, parameters: Array) -> TrilinearCurve:
        """Return the curves of parameters, shape (..., 3)."""
        a1 = parameters[..., 0]
        b1 = parameters[..., 1]
        return TrilinearCurve(a1, b1, self.ultimate_displacement_ratio, self.softening)

    def damping(self, parameters: Array) -> Damping:
        """Return the dampers whose loss at the reference amplitude equals that of e."""
        e = parameters[..., 2]
        if self.damping_model == REFERENCE:
            return Damping(REFERENCE, e)
        amplitude = REFERENCE_AMPLITUDE * self.ultimate_displacement_ratio
        xi = damping_ratio_energy(self.curve(parameters), self.damping_model, e, amplitude)
        return Damping(self.damping_model, xi)

    def response(self, parameters: Array, load: Load | None = None) -> Array:
        """Return displacements, shape (batch, samples), of a batch of parameters or loads. [m]"""
        histories = simulate(
            self.curve(parameters),
            self.damping(parameters),
            load=load or self.load,
            store_every=self.substeps,
        )
        # After a collapse the history is at 3 u_ins, so that its residual is finite and large.
        displacement = np.nan_to_num(histories.displacement, nan=3.0)
        return float(self.wall.instability_displacement) * displacement

    def residual(self, points: Array) -> Array:
        """Return computed less measured displacements, without trends, (batch, samples). [m]"""
        return self.subtract_trend(self.response(self.parameters(points)) - self.measured)

    def derivative(self, point: Array) -> Array:
        """Return central differences of the residual by the point, shape (samples, 3)."""
        h = 1e-4 * (HIGHEST_POINT - LOWEST_POINT)
        # The point may lie at e = 1, beyond which no damper exists.
        inner_point = np.clip(point, self.bounds[0] + h, self.bounds[1] - h)
        sides = np.concatenate([inner_point + np.diag(h), inner_point - np.diag(h)])
        response = self.subtract_trend(self.response(self.parameters(sides)))
        return ((response[:3] - response[3:]) / (2 * h[:, None])).T

    # --- search -----------------------------------------------------------------------------------

    def solution(self) -> Solution:
        """Return the lowest of the local minima that a coarse scan leads to, at the fit's step."""
        # The scan's step tells the minima apart and is stable on the whole grid. BAND is within a
        # few per mille of CR, and its steps would have to be short.
        model = REFERENCE if self.damping_model == "BAND" else self.damping_model
        coarse = replace(self, step=max(0.03, self.step), damping_model=model)
        grid = np.array(list(product(*SCAN_VALUES)))
        is_inside = ((grid >= self.bounds[0]) & (grid <= self.bounds[1])).all(axis=1)
        start = coarse.refine(grid[is_inside])
        return self.descend(coarse.descend(start).point)

    def refine(self, points: Array) -> Array:
        """Return the best point near a grid, whose spacing is halved around the best points.

        The misfit has long bent valleys, in which a single descent gets stuck.
        """
        offsets = np.array(list(product((-1, 0, 1), repeat=3)))
        ratios, *other_axes = SCAN_VALUES
        spacing = np.array(
            [np.log(ratios[1] / ratios[0]), *(values[1] - values[0] for values in other_axes)]
        )
        points = self.best(points)
        for _ in range(SCAN_HALVINGS):
            spacing = spacing / 2
            neighbours = np.stack([points] * len(offsets))
            neighbours[..., 0] *= np.exp(offsets[:, None, 0] * spacing[0])
            neighbours[..., 1:] += offsets[:, None, 1:] * spacing[1:]
            neighbours = np.clip(neighbours.reshape(-1, 3), *self.bounds)
            # Most neighbours belong to several points, within rounding.
            _, first = np.unique(neighbours.round(11), axis=0, return_index=True)
            points = self.best(neighbours[first])
        return points[0]

    def best(self, points: Array) -> Array:
        """Return the 64 points with the smallest residuals, the best first."""
        # ASSUME: 64 points cover every valley of the misfit; fewer may lose the one of the minimum.
        count = 64
        # The histories of 512 points fit into the processor's cache.
        batches = np.array_split(points, -(-len(points) // 512))
        squares = []
        for batch in track(batches, "search of a1, b1 and e"):
            squares.append((self.residual(batch) ** 2).sum(axis=1))
        order = np.argsort(np.concatenate(squares), kind="stable")
        return points[order[:count]]

    def descend(self, start: Array) -> Solution:
        """Return the local least squares that a descent from a point reaches."""
        result = least_squares(
            lambda point: self.residual(point[None])[0],
            start,
            self.derivative,
            bounds=tuple(self.bounds),
            x_scale=HIGHEST_POINT - LOWEST_POINT,
            max_nfev=100,
            xtol=1e-9,
            ftol=1e-10,
            gtol=None,
        )
        return Solution(self, result.x, result.fun)


class Solution(NamedTuple):
    """Minimum of a fit: its point, shape (3,), and the residual there, shape (samples,). [m]"""

    fit: RecordFit
    point: Array
    residual: Array

    @property
    def parameters(self) -> Array:
        """Best a1, b1 and e."""
        return self.fit.parameters(self.point)
