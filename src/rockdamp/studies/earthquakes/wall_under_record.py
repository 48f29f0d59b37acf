"""One wall under one record at every scale: its histories with restitution and with every damper, and their error.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. Those
that come near to collapse or end in two ways are run at h/2 and h/4 too: there the motion forks, and what a halving
changes may be little by chance. The finest is published; the largest change by any halving bounds its error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Comparison, Histories, Options, Reference, Response
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

SOURCES = ("fit", "error", "closed form")  # of the damping ratio: polynomials, Eq. (17) at that wall, energy
VARIATIONS = ("step", "impact", "lower e", "higher e")

HALVINGS = 2  # of the coarsest step, for every history
FURTHER = 2  # more of them near to collapse
NEAR = 0.5  # u/u_ins, from which on a wall that stands is near to collapse


@dataclass(frozen=True)
class Case:
    """One wall under one record, at every scale.

    Attributes
    ----------
    curve : TrilinearCurve
    load_factor : ndarray, shape (scales,)
        What times the record's acceleration is the dimensionless load. [s2 m-1]
    ground : ndarray
        The record, and rest after it. [m s-2]
    sampling : float
        Of the record, in tau. [-]
    substeps : int
        Of the coarsest run, between two samples.
    decay : int
        The sample at which the strong motion has ended.
    """

    curve: TrilinearCurve
    load_factor: Array
    ground: Array
    sampling: float
    substeps: int
    decay: int

    @classmethod
    def of(
        cls,
        wall: Wall | Parapet,
        curve: TrilinearCurve,
        record: Record,
        factor: Array,
        *,
        strong_end: float,
        step: float,
        tail: float,
    ) -> Case:
        """Scale the record by each of `factor`; its strong motion ends at `strong_end`, the `step` is the finest's."""
        sampling = float(wall.frequency_parameter) * record.step
        coarsest = 2**HALVINGS * step / float(curve.initial_frequency)
        return cls(
            curve,
            float(wall.load_factor) * factor,
            followed_by_rest(record.ground_acceleration, record.step, tail),
            sampling,
            int(np.ceil(sampling / coarsest)),
            int(np.ceil((strong_end - record.elapsed[0]) / record.step)),
        )

    def __call__(self, damping: Damping, halving: int, scheme: str = "newmark") -> Response:
        """Run dampers of shape (e, ...) at every scale: a batch of shape (scales, e, ...)."""
        return solve(self.curve, damping, **self._forced(self._each_scale(damping), halving, scheme))

    def histories(self, damping: Damping) -> Histories:
        """Run dampers at the coarsest step and keep their histories."""
        return solve(self.curve, damping, store_every=1, **self._forced(self._each_scale(damping), 0))

    def compared(self, damping: Damping, reference: Reference) -> Comparison:
        """Run dampers at the coarsest step and compare their histories with the reference."""
        return solve(self.curve, damping, reference=reference, **self._forced(self._each_scale(damping), 0))

    def some(self, damping: Damping, at: tuple[NDArray[np.int64], ...], halving: int) -> Response:
        """Run the histories at some places of a batch of shape (scales, e, ...): a batch of shape (places,)."""
        shape = (self.load_factor.size, *damping.shape)
        lanes = damping.map(lambda parameter: np.broadcast_to(parameter, shape)[at])
        return solve(self.curve, lanes, **self._forced(self.load_factor[at[0]], halving))

    def _each_scale(self, damping: Damping) -> Array:
        """The load factors, which broadcast with a damper to (scales, e, ...)."""
        return self.load_factor.reshape(-1, *(1 for _ in damping.shape))

    def _forced(self, load_factor: Array, halving: int, scheme: str = "newmark") -> Options:
        substeps = self.substeps * 2**halving
        return {
            "step": self.sampling / substeps,
            "steps": substeps * (self.ground.size - 1),
            "load_factor": load_factor,
            "ground_acceleration": self.ground,
            "substeps": substeps,
            "scheme": scheme,
        }

    def by_damper(self, e: Array, damping_ratio: Array) -> dict[str, Array]:
        """Peaks, collapses and misfits over the decay; shape (scales, e, models, sources)."""
        shape = (self.load_factor.size, e.size, len(MODELS), len(SOURCES))
        names = ("peak_ratio", "peak_ratio_uncertainty", "decay_misfit")
        outcome = {name: np.full(shape, np.nan) for name in names}
        outcome |= {name: np.zeros(shape, dtype=np.int8) for name in ("collapsed", "settled")}
        histories = self.histories(Damping.cr(e))
        reference = self._reference(histories)
        for name, values in self._judge(Damping.cr(e), histories).items():
            outcome[name][:, :, 0] = values[..., None]  # the same whatever the source
        stands, peak = outcome["collapsed"][:, :, 0, 0] == 0, outcome["peak_ratio"][:, :, 0, 0]
        for row, model in enumerate(VISCOUS_MODELS, start=1):
            defined = np.isfinite(damping_ratio[:, row]).all(axis=0)
            damping = Damping(model, damping_ratio[:, row, defined])
            compared = self.compared(damping, reference)
            for name, values in self._judge(damping, compared).items():
                outcome[name][:, :, row, defined] = values
            outcome["decay_misfit"][:, :, row, defined] = self._decay_misfit(compared, peak, stands)
            outcome["collapsed"][:, :, row, ~defined] = -1
            outcome["settled"][:, :, row, ~defined] = -1
        return outcome

    def varied(self, e: Array, change: float) -> dict[str, Array]:
        """CR with a coarser step, the printed treatment of impacts, and e a little lower and higher; (scales, e, 4)."""
        finest = HALVINGS
        nearby = self(Damping.cr(e[:, None] + change * np.array([-1.0, 1.0])), finest)
        coarse, printed = self(Damping.cr(e), 0), self(Damping.cr(e), finest, "paper")
        peak = [coarse.peak, printed.peak, *np.moveaxis(nearby.peak, -1, 0)]
        outcome = [coarse.outcome, printed.outcome, *np.moveaxis(nearby.outcome, -1, 0)]
        return {
            "varied_peak": np.stack(peak, axis=-1),
            "varied_collapsed": (np.stack(outcome, axis=-1) == COLLAPSED).astype(np.int8),
        }

    def _judge(self, damping: Damping, coarsest: Response) -> dict[str, Array]:
        """Peaks and outcomes at the finest step of each history, and what the halvings say of their error."""
        responses = [coarsest, *(self(damping, halving) for halving in range(1, HALVINGS + 1))]
        peak, collapsed = _ends(responses)
        judged = self._of_steps(peak, collapsed)
        near = (judged["settled"] == 0) | (~collapsed[-1] & (peak[-1] >= NEAR))
        if near.any():
            at = np.nonzero(near)
            finer = _ends([self.some(damping, at, HALVINGS + further) for further in range(1, FURTHER + 1)])
            peaks, ends = np.concatenate([peak[:, near], finer[0]]), np.concatenate([collapsed[:, near], finer[1]])
            for name, values in self._of_steps(peaks, ends).items():
                judged[name][near] = values
        return judged

    def _of_steps(self, peak: Array, collapsed: NDArray[np.bool_]) -> dict[str, Array]:
        """What runs at halvings 0, 1, ... say; each array has a first dimension of them."""
        last = len(peak) - 1
        settled = (collapsed == collapsed[-1]).all(axis=0)
        changes = np.abs(np.diff(peak, axis=0)).max(axis=0)
        bound = np.where(settled & ~collapsed[-1], changes + self.roughness(last) * peak[-1], np.nan)
        return {
            "peak_ratio": peak[-1],
            "peak_ratio_uncertainty": bound,
            "collapsed": collapsed[-1].astype(np.int8),
            "settled": settled.astype(np.int8),
        }

    def roughness(self, halving: int) -> float:
        """(w1 h)^2/3 at a halving's step h: what a halving may hide by chance, as a fraction of the peak.

        Three times the median error of 8000 histories, whose changes, plus this, bounded 99.97 % of their errors.
        """
        step = self.sampling / (self.substeps * 2**halving)
        return (step * float(self.curve.initial_frequency)) ** 2 / 3

    def _reference(self, coarsest: Histories) -> Reference:
        """What Eq. (17) compares with: CR's histories at the coarsest step, summed up to the decay and to the end."""
        displacement = np.nan_to_num(coarsest.displacement.reshape(-1, coarsest.displacement.shape[-1]))
        case = np.arange(displacement.shape[0]).reshape(*coarsest.displacement.shape[:-1], 1)
        steps = self.substeps * (self.ground.size - 1)
        checkpoints = [min(max(self.decay * self.substeps, 1), steps - 1), steps]
        return Reference(displacement, case, checkpoints)

    def _decay_misfit(self, coarsest: Comparison, reference_peak: Array, stands: ArrayLike) -> Array:
        """Root mean square of the difference in |u| after the strong motion, over CR's peak; NaN after a collapse."""
        steps = self.substeps * (self.ground.size - 1 - self.decay)
        both = np.asarray(stands)[..., None] & (coarsest.outcome != COLLAPSED)
        error = np.where(both, coarsest.error, 0.0)
        root = np.sqrt(np.maximum(error[1] - error[0], 0.0) / max(steps, 1))
        return np.where(both, root / reference_peak[..., None], np.nan)


def _ends(responses: Sequence[Response]) -> tuple[Array, NDArray[np.bool_]]:
    """Peaks and collapses of responses, stacked."""
    return (
        np.stack([response.peak for response in responses]),
        np.stack([response.outcome == COLLAPSED for response in responses]),
    )
