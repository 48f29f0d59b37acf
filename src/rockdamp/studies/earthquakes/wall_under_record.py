"""One wall under one record at every scale: its histories with restitution and with every damper, and their error.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. Those
that come near to collapse or end in two ways are run at h/2 and h/4 too: there the motion forks, and what a halving
changes may be little by chance. The finest is published; the largest change by any halving bounds its error.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity
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
CURVE = ("cracked_stiffness_ratio", "plateau_ratio", "ultimate_ratio")
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
        return solve(self.curve, damping, **self._forced(self.each_scale(damping), halving, scheme))

    def histories(self, damping: Damping) -> Histories:
        """Run dampers at the coarsest step and keep their histories."""
        return solve(self.curve, damping, store_every=1, **self._forced(self.each_scale(damping), 0))

    def compared(self, damping: Damping, reference: Reference) -> Comparison:
        """Run dampers at the coarsest step and compare their histories with the reference."""
        return solve(self.curve, damping, reference=reference, **self._forced(self.each_scale(damping), 0))

    def each_scale(self, damping: Damping) -> Array:
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

    def runs(self, e: Array, damping_ratio: Array) -> Iterator[Runs]:
        """Run CR, then every damper whose ratios are defined, at the first three steps."""
        histories = self.histories(Damping.cr(e))
        reference = self._reference(histories)
        yield self._run(Damping.cr(e), histories)
        for row, model in enumerate(VISCOUS_MODELS, start=1):
            defined = np.asarray(np.isfinite(damping_ratio[:, row]).all(axis=0))
            damping = Damping(model, damping_ratio[:, row, defined])
            compared = self.compared(damping, reference)
            yield replace(self._run(damping, compared), defined=defined, misfit=self._decay_misfit(compared))

    def outcome(self, runs: Sequence[Runs]) -> dict[str, Array]:
        """Peaks, collapses and misfits over the decay of finished runs; shape (scales, e, models, sources)."""
        restitution = runs[0]
        shape = (*restitution.near.shape, len(MODELS), len(SOURCES))
        names = ("peak_ratio", "peak_ratio_uncertainty", "decay_misfit")
        outcome = {name: np.full(shape, np.nan) for name in names}
        outcome |= {name: np.full(shape, -1, dtype=np.int8) for name in ("collapsed", "settled")}
        of_restitution = self._judged(restitution)
        for name, values in of_restitution.items():
            outcome[name][:, :, 0] = values[..., None]  # the same whatever the source
        peak = np.where(of_restitution["collapsed"] == 0, of_restitution["peak_ratio"], np.nan)
        for row, own in enumerate(runs[1:], start=1):
            for name, values in self._judged(own).items():
                outcome[name][:, :, row, own.defined] = values
            outcome["decay_misfit"][:, :, row, own.defined] = own.misfit / peak[..., None]
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

    def _run(self, damping: Damping, coarsest: Response) -> Runs:
        """Run a damper at the halvings of the coarsest step, and say which histories ask for more of them."""
        peak, collapsed = _ends([coarsest, *(self(damping, halving) for halving in range(1, HALVINGS + 1))])
        settled = self._of_steps(peak, collapsed)["settled"]
        return Runs(damping, peak, collapsed, (settled == 0) | (~collapsed[-1] & (peak[-1] >= NEAR)))

    def _judged(self, runs: Runs) -> dict[str, Array]:
        """Peaks and outcomes at the finest step of each history, and what the halvings say of their error."""
        judged, near = self._of_steps(runs.peak, runs.collapsed), runs.near
        if near.any():
            peak = np.concatenate([runs.peak[:, near], runs.finer_peak])
            collapsed = np.concatenate([runs.collapsed[:, near], runs.finer_collapsed])
            for name, values in self._of_steps(peak, collapsed).items():
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

    def _decay_misfit(self, coarsest: Comparison) -> Array:
        """Root mean square of the difference in |u| after the strong motion; NaN after a collapse."""
        steps = self.substeps * (self.ground.size - 1 - self.decay)
        stands = coarsest.outcome != COLLAPSED
        error = np.where(stands, coarsest.error, 0.0)
        root = np.sqrt(np.maximum(error[1] - error[0], 0.0) / max(steps, 1))
        return np.where(stands, root, np.nan)


@dataclass(frozen=True)
class Runs:
    """The histories of one damper at the steps that they were run at, the coarsest first.

    Attributes
    ----------
    damping : Damping, shape (e, ...)
    peak, collapsed : ndarray, shape (HALVINGS + 1, scales, e, ...)
        At the steps that every history is run at.
    near : ndarray of bool, shape (scales, e, ...)
        Which come near to collapse, or end in two ways.
    finer_peak, finer_collapsed : ndarray, shape (FURTHER, histories)
        Of these, at the finer steps.
    defined : ndarray of bool, shape (sources,)
        Of a viscous damper: which sources have a damping ratio.
    misfit : ndarray, shape (scales, e, ...)
        Of a viscous damper: `Case._decay_misfit`.
    """

    damping: Damping
    peak: Array
    collapsed: NDArray[np.bool_]
    near: NDArray[np.bool_]
    finer_peak: Array = field(default_factory=lambda: np.empty((FURTHER, 0)))
    finer_collapsed: NDArray[np.bool_] = field(default_factory=lambda: np.empty((FURTHER, 0), dtype=bool))
    defined: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    misfit: Array = field(default_factory=lambda: np.empty(0))


def by_damper(cases: Sequence[Case], e: Array, damping_ratio: Array) -> list[dict[str, Array]]:
    """Run walls under one record, with CR and every damper.

    Parameters
    ----------
    cases : sequence of Case
        The walls.
    e : ndarray, shape (e,)
        Coefficients of restitution.
    damping_ratio : ndarray, shape (walls, e, models, sources)
        NaN where there is none.

    Returns
    -------
    list of dict
        Of each wall, arrays of shape (scales, e, models, sources).
    """
    begun = [(case, runs) for case, own in zip(cases, damping_ratio, strict=True) for runs in case.runs(e, own)]
    finished = iter(_finish(begun))
    return [case.outcome([next(finished) for _ in MODELS]) for case in cases]


def _finish(begun: Sequence[tuple[Case, Runs]]) -> list[Runs]:
    """Run the histories that come near to collapse at the finer steps: those of all walls that go together at once."""
    together: dict[tuple[object, ...], list[int]] = {}
    for index, (case, runs) in enumerate(begun):
        if runs.near.any():
            together.setdefault((runs.damping.model, case.curve.softening, case.substeps), []).append(index)
    finished = [runs for _, runs in begun]
    for members in together.values():
        own = [begun[index] for index in members]
        peak, collapsed = _ends([_near(own, HALVINGS + further) for further in range(1, FURTHER + 1)])
        edges = np.cumsum([runs.near.sum() for _, runs in own])[:-1]
        for index, of_peak, of_end in zip(
            members, *(np.split(of, edges, axis=1) for of in (peak, collapsed)), strict=True
        ):
            finished[index] = replace(finished[index], finer_peak=of_peak, finer_collapsed=of_end)
    return finished


def _near(own: Sequence[tuple[Case, Runs]], halving: int) -> Response:
    """Run the histories near to collapse of walls that have one model, and as many steps between two samples."""

    def lanes(values: Iterable[Quantity]) -> Array:
        parts = zip(values, (runs.near for _, runs in own), strict=True)
        return np.concatenate([np.broadcast_to(value, near.shape)[near] for value, near in parts])

    first, of = own[0]
    substeps = first.substeps * 2**halving
    curve = {name: lanes(getattr(case.curve, name) for case, _ in own) for name in CURVE}
    damping = {name: lanes(runs.damping.parameters[name] for _, runs in own) for name in of.damping.parameters}
    return solve(
        TrilinearCurve(**curve, softening=first.curve.softening),
        Damping(of.damping.model, **damping),
        step=lanes(case.sampling / substeps for case, _ in own),
        steps=substeps * (first.ground.size - 1),
        load_factor=lanes(case.each_scale(runs.damping) for case, runs in own),
        ground_acceleration=first.ground,
        substeps=substeps,
    )


def _ends(responses: Sequence[Response]) -> tuple[Array, NDArray[np.bool_]]:
    """Peaks and collapses of responses, stacked."""
    return (
        np.stack([response.peak for response in responses]),
        np.stack([response.outcome == COLLAPSED for response in responses]),
    )
