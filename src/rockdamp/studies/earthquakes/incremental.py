"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same velocity ratios of each wall, lambda PGV/(p u_ins): the velocity that the motion gives
the wall over the one that carries a rigid wall to its instability. One set of them takes every wall from rest to
collapse. `Case` runs the histories and bounds the error of their peaks.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. Those
that come near to collapse or end in two ways are run at h/2 and h/4 too. The finest run is published; the largest
change by any halving of the step bounds its error.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config, NamedWall
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import PARAMETERS, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import IntensityMeasures, intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Histories, Load, Peaks, Reference, peaks, simulate
from rockdamp.studies.matches import match_decays

SOURCES = ("polynomial", "least error", "closed form")  # of the ratio: polynomials, Eq. (17) at that wall, energy
VARIATIONS = ("step", "impact", "lower e", "higher e")

# Near collapse the outcome can flip with a tiny change of the step: the wall comes almost to rest where it hardly
# holds, and may fall back or go on. Two steps may take the same side by chance; then one halving of the step changes
# little and says nothing of the error. Hence there are more halvings near collapse, and the largest change counts.
HALVINGS = 2  # of the coarsest step, for every history
FURTHER = 2  # more of them near to collapse
NEAR = 0.5  # u/u_ins, from which on a wall that survives is near to collapse


@dataclass(frozen=True)
class Case:
    """One wall under one record, whose load has a factor for each scale and the substeps of the coarsest run.

    At the sample `decay` the strong motion has ended.
    """

    curve: TrilinearCurve
    load: Load
    decay: int

    @classmethod
    def from_record(
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
        coarsest = 2**HALVINGS * step / float(curve.initial_frequency)
        substeps = int(count_steps(wall.frequency_parameter * record.step, coarsest))
        decay = int(np.ceil((strong_end - record.elapsed[0]) / record.step))
        return cls(curve, make_load(wall, record, factor, substeps=substeps, tail=tail), decay)

    def __call__(self, damping: Damping, halving: int, scheme: str = "newmark") -> Peaks:
        """Run dampers of shape (e, ...) at every scale: a batch of shape (scales, e, ...)."""
        return peaks(self.curve, damping, load=self._load(damping, halving), scheme=scheme)

    def each_scale(self, damping: Damping) -> Array:
        """Return the load factors, which broadcast with a damper to (scales, e, ...)."""
        return np.reshape(self.load.factor, (-1, *(1 for _ in damping.shape)))

    def _load(self, damping: Damping, halving: int) -> Load:
        return replace(self.load, factor=self.each_scale(damping), substeps=self.load.substeps * 2**halving)

    def runs(self, e: Array, damping_ratio: Array) -> Iterator[Runs]:
        """Run CR, then every damper whose ratios are defined, at the first three steps."""
        # Only the coarsest run of CR is stored, step by step: Eq. (17) compares all dampers with it while they run.
        restitution = Damping("CR", e)
        histories = simulate(self.curve, restitution, load=self._load(restitution, 0))
        reference = self._reference(histories)
        yield self._run(restitution, histories)
        for row, model in enumerate(VISCOUS_MODELS, start=1):
            defined = np.asarray(np.isfinite(damping_ratio[:, row]).all(axis=0))
            damping = Damping(model, damping_ratio[:, row, defined])
            compared = peaks(self.curve, damping, load=self._load(damping, 0), reference=reference)
            yield replace(self._run(damping, compared), defined=defined, misfit=self._decay_misfit(compared))

    def outcome(self, runs: Sequence[Runs]) -> dict[str, Array]:
        """Return peaks, collapses and misfits over the decay; shape (scales, e, models, sources)."""
        restitution = runs[0]
        shape = (*restitution.near.shape, len(MODELS), len(SOURCES))
        names = ("peak", "peak_uncertainty", "decay_misfit")
        outcome = {name: np.full(shape, np.nan) for name in names}
        outcome |= {name: np.full(shape, -1, dtype=np.int8) for name in ("collapsed", "converged")}
        of_restitution = self._judged(restitution)
        for name, values in of_restitution.items():
            outcome[name][:, :, 0] = values[..., None]  # the same whatever the source
        peak = np.where(of_restitution["collapsed"] == 0, of_restitution["peak"], np.nan)
        for row, of_damper in enumerate(runs[1:], start=1):
            for name, values in self._judged(of_damper).items():
                outcome[name][:, :, row, of_damper.defined] = values
            outcome["decay_misfit"][:, :, row, of_damper.defined] = of_damper.misfit / peak[..., None]
        return outcome

    def varied(self, e: Array, change: float) -> dict[str, Array]:
        """Run CR with a coarser step, the printed treatment of impacts, a lower and a higher e; (scales, e, 4)."""
        finest = HALVINGS
        nearby = self(Damping("CR", e[:, None] + change * np.array([-1.0, 1.0])), finest)
        coarse, printed = self(Damping("CR", e), 0), self(Damping("CR", e), finest, "paper")
        peak = [coarse.peak, printed.peak, *np.moveaxis(nearby.peak, -1, 0)]
        collapsed = [coarse.collapsed, printed.collapsed, *np.moveaxis(nearby.collapsed, -1, 0)]
        return {
            "varied_peak": np.stack(peak, axis=-1),
            "varied_collapsed": np.stack(collapsed, axis=-1).astype(np.int8),
        }

    def _run(self, damping: Damping, coarsest: Histories | Peaks) -> Runs:
        """Run a damper at the halvings of the coarsest step, and mark the histories that need more of them."""
        responses = [coarsest, *(self(damping, halving) for halving in range(1, HALVINGS + 1))]
        # NaN and False stand for the further halvings, which `_run_further` fills in where they are needed.
        peak = np.full((HALVINGS + FURTHER + 1, *coarsest.peak.shape), np.nan)
        collapsed = np.zeros(peak.shape, dtype=bool)
        for halving, response in enumerate(responses):
            peak[halving], collapsed[halving] = response.peak, response.collapsed
        converged = self._of_steps(peak[: HALVINGS + 1], collapsed[: HALVINGS + 1])["converged"]
        near = (converged == 0) | (~collapsed[HALVINGS] & (peak[HALVINGS] >= NEAR))
        return Runs(damping, peak, collapsed, near)

    def _judged(self, runs: Runs) -> dict[str, Array]:
        """Return peaks and outcomes at the finest step of each history, and the bound of their error."""
        usual = self._of_steps(runs.peak[: HALVINGS + 1], runs.collapsed[: HALVINGS + 1])
        further = self._of_steps(runs.peak, runs.collapsed)
        return {name: np.where(runs.near, further[name], values) for name, values in usual.items()}

    def _of_steps(self, peak: Array, collapsed: NDArray[np.bool_]) -> dict[str, Array]:
        """Judge runs at halvings 0, 1, ..., the first dimension, by the last and by how it differs from the others."""
        last = len(peak) - 1
        converged = (collapsed == collapsed[-1]).all(axis=0)
        changes = np.abs(np.diff(peak, axis=0)).max(axis=0)
        bound = np.where(converged & ~collapsed[-1], changes + self.roughness(last) * peak[-1], np.nan)
        return {
            "peak": peak[-1],
            "peak_uncertainty": bound,
            "collapsed": collapsed[-1].astype(np.int8),
            "converged": converged.astype(np.int8),
        }

    def roughness(self, halving: int) -> float:
        """Return (w1 h)^2/3 at a halving's step h: the error that no halving may show, as a fraction of the peak.

        Three times the median error of 8000 histories, whose changes, plus this, bounded 99.97 % of their errors.
        """
        step = self.load.sampling / (self.load.substeps * 2**halving)
        return float((step * float(self.curve.initial_frequency)) ** 2 / 3)

    def _reference(self, coarsest: Histories) -> Reference:
        """Make CR's histories the reference of Eq. (17), summed up to the decay and up to the end."""
        displacement = np.nan_to_num(coarsest.displacement.reshape(-1, coarsest.displacement.shape[-1]))
        case = np.arange(displacement.shape[0]).reshape(*coarsest.displacement.shape[:-1], 1)
        substeps = self.load.substeps
        steps = substeps * (self.load.ground.shape[1] - 1)
        checkpoints = [min(max(self.decay * substeps, 1), steps - 1), steps]
        return Reference(displacement, case, checkpoints)

    def _decay_misfit(self, coarsest: Peaks) -> Array:
        """Return the root mean square of the difference in |u| after the strong motion; NaN after a collapse."""
        steps = self.load.substeps * (self.load.ground.shape[1] - 1 - self.decay)
        stands = ~coarsest.collapsed
        error = np.where(stands, coarsest.error, 0.0)
        root = np.sqrt(np.maximum(error[1] - error[0], 0.0) / max(steps, 1))
        return np.where(stands, root, np.nan)


@dataclass(frozen=True)
class Runs:
    """The histories of one damper at every step, the coarsest first.

    `peak` and `collapsed` have the shape (HALVINGS + FURTHER + 1, scales, e, ...); they are NaN and False at the
    further halvings of histories that are not `near` to collapse and do not end in two ways. `defined` marks the
    sources that have a damping ratio of a viscous damper, and `misfit` is `Case._decay_misfit`.
    """

    damping: Damping
    peak: Array
    collapsed: NDArray[np.bool_]
    near: NDArray[np.bool_]
    defined: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    misfit: Array = field(default_factory=lambda: np.empty(0))


def by_damper(cases: Sequence[Case], e: Array, damping_ratio: Array) -> list[dict[str, Array]]:
    """Run walls under one record, with CR and every damper; for each wall arrays of shape (scales, e, models, sources).

    `damping_ratio`, shape (walls, e, models, sources), is NaN where a source has none.
    """
    by_wall = [list(case.runs(e, ratio)) for case, ratio in zip(cases, damping_ratio, strict=True)]
    _run_further([(case, runs) for case, of_wall in zip(cases, by_wall, strict=True) for runs in of_wall])
    return [case.outcome(runs) for case, runs in zip(cases, by_wall, strict=True)]


def _run_further(begun: Sequence[tuple[Case, Runs]]) -> None:
    """Run the histories that come near to collapse at the further halvings, and fill them in."""
    # Of one wall they are few, and a block of the kernel takes as long with one lane as with all. So they share batches
    # across walls: a batch has one damping model, one kind of last branch and one number of steps between two samples.
    together = defaultdict(list)
    for case, runs in begun:
        if runs.near.any():
            together[runs.damping.model, case.curve.softening, case.load.substeps].append((case, runs))
    for members in together.values():
        edges = np.cumsum([runs.near.sum() for _, runs in members])[:-1]
        for halving in range(HALVINGS + 1, HALVINGS + FURTHER + 1):
            response = _near(members, halving)
            ends = (np.split(values, edges) for values in (response.peak, response.collapsed))
            for (_, runs), peak, collapsed in zip(members, *ends, strict=True):
                runs.peak[halving, runs.near], runs.collapsed[halving, runs.near] = peak, collapsed


def _near(members: Sequence[tuple[Case, Runs]], halving: int) -> Peaks:
    """Run the histories near to collapse of the walls of one batch, one after the other in its lanes."""

    def lanes(values: Iterable[Quantity]) -> Array:
        parts = zip(values, (runs.near for _, runs in members), strict=True)
        return np.concatenate([np.broadcast_to(value, near.shape)[near] for value, near in parts])

    first, damping = members[0][0], members[0][1].damping
    parameters = {name: lanes(getattr(runs.damping, name) for _, runs in members) for name in PARAMETERS}
    curve = {name: lanes(getattr(case.curve, name) for case, _ in members) for name in RULES}
    load = replace(
        first.load,
        factor=lanes(case.each_scale(runs.damping) for case, runs in members),
        sampling=lanes(case.load.sampling for case, _ in members),
        substeps=first.load.substeps * 2**halving,
    )
    return peaks(
        TrilinearCurve(**curve, softening=first.curve.softening),
        Damping(damping.model, **parameters),
        load=load,
    )


MEASURES = ("pga", "pgv", "pgd", "arias", "strong_duration")

HISTORY = ("record", "velocity_ratio", "wall", "restitution")
BY_DAMPER = (*HISTORY, "damping_model", "damping_ratio_source")


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    The ratio is NaN for CR and beyond the range of the polynomials.
    """
    quakes = config.earthquakes
    ratio = np.full((len(quakes.walls), len(quakes.restitution), len(MODELS), len(SOURCES)), np.nan)
    ratio[:, :, 1:] = _damping_ratios(config, Polynomials.from_dataset(equivalence))
    made = [(named.wall, named.curve) for named in quakes.walls]
    of_wall: dict[str, Any] = {
        name: ("wall", [float(getattr(wall, name)) for wall, _ in made])
        for name in (
            "thickness",
            "height",
            "slenderness",
            "overburden_ratio",
            "instability_displacement",
            "frequency_parameter",
        )
    }
    of_wall |= {
        name: ("wall", [float(getattr(curve, name)) for _, curve in made])
        for name in ("yield_displacement_ratio", "strength_ratio")
    }
    w1 = np.array([float(wall.frequency_parameter * curve.initial_frequency) for wall, curve in made])
    return xr.Dataset(
        {
            "damping_ratio": (("wall", "restitution", "damping_model", "damping_ratio_source"), ratio),
            "parapet": ("wall", np.array([isinstance(wall, Parapet) for wall, _ in made], dtype=np.int8)),
            "initial_period": ("wall", 2 * np.pi / w1),
            **of_wall,
        },
        coords={
            "wall": [named.name for named in quakes.walls],
            "restitution": quakes.restitution,
            "damping_model": list(MODELS),
            "damping_ratio_source": list(SOURCES),
        },
    )


def _damping_ratios(config: Config, polynomials: Polynomials) -> Array:
    """Return damping ratios, shape (walls, e, viscous models, sources)."""
    quakes = config.earthquakes
    count, e = len(quakes.walls), np.array(quakes.restitution)
    a1, b1, a3 = (np.array([float(getattr(named.curve, name)) for named in quakes.walls]) for name in RULES)
    curves, each_e = TrilinearCurve(a1, b1, a3).map(lambda parameter: np.repeat(parameter, e.size)), np.tile(e, count)
    amplitude = np.full(each_e.size, config.release_amplitude)
    step, scheme, label = config.solver.step, config.solver.scheme, "Damping ratios of the walls"
    matched = match_decays(
        curves, amplitude, each_e, VISCOUS_MODELS, config.matching, step=step, scheme=scheme, description=label
    )
    ratio = np.empty((count, e.size, len(VISCOUS_MODELS), len(SOURCES)))
    for column, model in enumerate(VISCOUS_MODELS):
        by_source = {
            "polynomial": np.stack([polynomials(model, e, own) for own in a1]),
            "least error": matched[model].damping_ratio,
            "closed form": damping_ratio_energy(curves, model, each_e, amplitude),
        }
        for place, source in enumerate(SOURCES):
            ratio[:, :, column, place] = by_source[source].reshape(count, e.size)
    return ratio


# --- the ground motions -----------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's chunk of the records; jobs are numbered from 0."""
    size = config.earthquakes.chunk
    mine = catalogue.record_names(config.records)[int(number) * size : (int(number) + 1) * size]
    e, ratio = walls["restitution"].values, walls["damping_ratio"].values
    parts = [run(config, e, ratio, catalogue.load_record(name)) for name in track(mine, f"Records {int(number) + 1}")]
    return xr.concat(parts, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")


def gather(config: Config, walls: xr.Dataset, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the walls and the jobs' chunks of the records, in the order of the records."""
    joined = xr.concat(chunks, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")
    return joined.merge(walls, join="exact", combine_attrs="drop")


def run(config: Config, restitution: Array, damping_ratio: Array, motion: catalogue.GroundMotion) -> xr.Dataset:
    """Run one record, for every wall, scale, e and damper; ratios have the shape (walls, e, models, sources)."""
    quakes = config.earthquakes
    intensity = intensity_measures(motion.record)
    ratio = quakes.velocity_ratio.values()
    factors = [ratio * float(named.wall.velocity_scale) / intensity.pgv for named in quakes.walls]
    cases = [
        Case.from_record(
            named.wall,
            named.curve,
            motion.record,
            factor,
            strong_end=intensity.strong_end,
            step=quakes.step,
            tail=quakes.tail,
        )
        for named, factor in zip(quakes.walls, factors, strict=True)
    ]
    by_wall = zip(quakes.walls, factors, cases, by_damper(cases, restitution, damping_ratio), strict=True)
    change = quakes.restitution_change
    per_wall = [
        peaks | case.varied(restitution, change) | _load(named, factor, motion.record, intensity)
        for named, factor, case, peaks in by_wall
    ]
    dims = {
        **dict.fromkeys(
            ("peak", "peak_uncertainty", "collapsed", "converged", "decay_misfit"),
            BY_DAMPER[1:],
        ),
        **dict.fromkeys(("varied_peak", "varied_collapsed"), (*HISTORY[1:], "variation")),
        "scale_factor": ("velocity_ratio", "wall"),
        "load_ratio": ("velocity_ratio", "wall"),
    }
    data: dict[str, Any] = {
        name: (of, np.stack([values[name] for values in per_wall], axis=of.index("wall"))) for name, of in dims.items()
    }
    data |= {name: ((), float(getattr(intensity, name))) for name in MEASURES}
    data |= {"sampling_step": ((), motion.record.step)}
    coords = {
        "velocity_ratio": ratio,
        "wall": [named.name for named in quakes.walls],
        "restitution": restitution,
        "damping_model": list(MODELS),
        "damping_ratio_source": list(SOURCES),
        "variation": list(VARIATIONS),
        "record": motion.name,
        "record_set": motion.record_set,
        "station": motion.group,
    }
    return (
        xr.Dataset(data, coords=coords)
        .expand_dims("record")
        .assign_coords({name: ("record", [coords[name]]) for name in ("record_set", "station")})
    )


def _load(named: NamedWall, factor: Array, record: Record, intensity: IntensityMeasures) -> dict[str, Array]:
    """Return the strength of a record for a wall; arrays over the scales, and one for the wall."""
    p = float(named.wall.frequency_parameter)
    yields = float(named.curve.strength_ratio) * p * float(named.wall.velocity_scale)
    return {
        "scale_factor": factor,
        "load_ratio": factor * intensity.pga / yields,
    }
