"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same velocity ratios of each wall, lambda PGV/(p u_ins): the velocity that the motion gives
the wall over the one that carries a rigid wall to its instability. One set of them takes every wall from rest to
collapse.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. Those
that come near to collapse or end in two ways are run at h/2 and h/4 too. The finest run is published; the largest
change by any halving of the step bounds its error.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import PARAMETERS, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, Peaks, peaks
from rockdamp.studies.matches import match_decays

SOURCES = ("polynomial", "least error", "closed form")  # of the ratio: polynomials, Eq. (17) at that wall, energy
VARIATIONS = ("step", "impact", "lower e", "higher e")
HISTORY = ("record", "velocity_ratio", "wall", "restitution")
BY_DAMPER = (*HISTORY, "damping_model", "damping_ratio_source")
SIZES = ("thickness", "height", "slenderness", "overburden_ratio", "instability_displacement", "frequency_parameter")

# Near collapse the outcome can flip with a tiny change of the step: the wall comes almost to rest where it hardly
# holds, and may fall back or go on. Two steps may take the same side by chance; then one halving of the step changes
# little and says nothing of the error. Hence there are more halvings near collapse, and the largest change counts.
HALVINGS = 2  # of the coarsest step, for every history
FURTHER = 2  # more of them near to collapse
NEAR = 0.5  # u/u_ins, from which on a wall that survives is near to collapse


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    The ratio is NaN for CR and beyond the range of the polynomials.
    """
    quakes = config.earthquakes
    ratio = np.full((len(quakes.walls), len(quakes.restitution), len(MODELS), len(SOURCES)), np.nan)
    ratio[:, :, 1:] = _damping_ratios(config, Polynomials.from_dataset(equivalence))
    w1 = [float(named.wall.frequency_parameter * named.curve.initial_frequency) for named in quakes.walls]
    columns: dict[str, Any] = {
        **{name: [float(getattr(named.wall, name)) for named in quakes.walls] for name in SIZES},
        **{
            name: [float(getattr(named.curve, name)) for named in quakes.walls]
            for name in ("yield_displacement_ratio", "strength_ratio")
        },
        "initial_period": 2 * np.pi / np.array(w1),
        "parapet": np.array([named.parapet for named in quakes.walls], dtype=np.int8),
    }
    return xr.Dataset(
        {
            "damping_ratio": (("wall", "restitution", "damping_model", "damping_ratio_source"), ratio),
            **{name: ("wall", values) for name, values in columns.items()},
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
    quakes, solver = config.earthquakes, config.solver
    e, curves = np.array(quakes.restitution), [named.curve for named in quakes.walls]
    a1, b1, a3 = (np.array([float(getattr(curve, name)) for curve in curves]) for name in RULES)
    lanes = TrilinearCurve(a1, b1, a3).map(lambda parameter: np.repeat(parameter, e.size))
    each_e, amplitude = np.tile(e, a1.size), np.full(e.size * a1.size, config.release_amplitude)
    matched = match_decays(
        lanes,
        amplitude,
        each_e,
        VISCOUS_MODELS,
        config.matching,
        step=solver.step,
        scheme=solver.scheme,
        description="Damping ratios of the walls",
    )
    ratios = [
        [
            np.stack([polynomials(model, e, own) for own in a1]),
            matched[model].damping_ratio.reshape(a1.size, e.size),
            damping_ratio_energy(lanes, model, each_e, amplitude).reshape(a1.size, e.size),
        ]
        for model in VISCOUS_MODELS
    ]
    return np.moveaxis(np.array(ratios), (0, 1), (-2, -1))


# --- the ground motions -----------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's chunk of the records; jobs are numbered from 0."""
    size = config.earthquakes.chunk
    names = catalogue.record_names(config.records)[int(number) * size : (int(number) + 1) * size]
    e, ratio = walls["restitution"].values, walls["damping_ratio"].values
    parts = [run(config, e, ratio, catalogue.load_record(name)) for name in track(names, f"Records {int(number) + 1}")]
    return _join(parts)


def gather(config: Config, walls: xr.Dataset, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the walls and the jobs' chunks of the records, in the order of the records."""
    return _join(chunks).merge(walls, join="exact", combine_attrs="drop")


def _join(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    return xr.concat(parts, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")


def run(config: Config, restitution: Array, damping_ratio: Array, motion: catalogue.GroundMotion) -> xr.Dataset:
    """Run one record, for every wall, scale, e and damper; ratios have the shape (walls, e, models, sources)."""
    quakes, intensity = config.earthquakes, intensity_measures(motion.record)
    ratio = quakes.velocity_ratio.values()
    factors = [ratio * float(named.wall.velocity_scale) / intensity.pgv for named in quakes.walls]
    shaken = [
        WallUnderRecord.from_record(
            named.wall,
            named.curve,
            motion.record,
            factor,
            step=quakes.step,
            tail=quakes.tail,
        )
        for named, factor in zip(quakes.walls, factors, strict=True)
    ]
    variations = [wall.run_variations(restitution, quakes.restitution_change) for wall in shaken]
    data: dict[str, Any] = {
        name: (dims, np.stack([one[name] for one in results], axis=1))
        for results, dims in (
            (run_dampers(shaken, restitution, damping_ratio), BY_DAMPER[1:]),
            (variations, (*HISTORY[1:], "variation")),
        )
        for name in results[0]
    }
    data["scale_factor"] = ("velocity_ratio", "wall"), np.stack(factors, axis=1)
    coords = {
        "velocity_ratio": ratio,
        "wall": [named.name for named in quakes.walls],
        "restitution": restitution,
        "damping_model": list(MODELS),
        "damping_ratio_source": list(SOURCES),
        "variation": list(VARIATIONS),
    }
    measures = {"pga": intensity.pga, "pgv": intensity.pgv}
    names = {"record": motion.name, "station": motion.group}
    return (
        xr.Dataset(data, coords=coords)
        .expand_dims("record")
        .assign({name: ("record", [value]) for name, value in measures.items()})
        .assign_coords({name: ("record", [value]) for name, value in names.items()})
    )


# --- histories and the error of their peaks ---------------------------------------------------------------------------


@dataclass(frozen=True)
class WallUnderRecord:
    """One wall under one record, whose load has a factor for each scale and the substeps of the coarsest run."""

    curve: TrilinearCurve
    load: Load

    @classmethod
    def from_record(
        cls, wall: Wall | Parapet, curve: TrilinearCurve, record: Record, factor: Array, *, step: float, tail: float
    ) -> WallUnderRecord:
        """Scale the record by each of `factor`; the `step` is the finest run's, times the first branch's frequency."""
        coarsest = 2**HALVINGS * step / float(curve.initial_frequency)
        substeps = int(count_steps(wall.frequency_parameter * record.step, coarsest))
        return cls(curve, make_load(wall, record, factor, substeps=substeps, tail=tail))

    def halve(self, damping: Damping, halving: int) -> Load:
        """Return the load of every scale on dampers of shape (e, ...), at a halving of the coarsest step."""
        factor = np.reshape(self.load.factor, (-1, *(1 for _ in damping.shape)))
        return replace(self.load, factor=factor, substeps=self.load.substeps * 2**halving)

    def __call__(self, damping: Damping, halving: int, scheme: str = "newmark") -> Peaks:
        """Run dampers of shape (e, ...) at every scale: a batch of shape (scales, e, ...)."""
        return peaks(self.curve, damping, load=self.halve(damping, halving), scheme=scheme)

    def begin(self, e: Array, damping_ratio: Array) -> list[Runs]:
        """Run CR, then every damper whose ratios are defined, at the first three steps."""
        begun = [self._run_halvings(Damping("CR", e), np.ones(len(SOURCES), dtype=bool))]
        for row, model in enumerate(VISCOUS_MODELS, start=1):
            defined = np.asarray(np.isfinite(damping_ratio[:, row]).all(axis=0))
            begun.append(self._run_halvings(Damping(model, damping_ratio[:, row, defined]), defined))
        return begun

    def collect(self, begun: Sequence[Runs]) -> dict[str, Array]:
        """Return peaks and collapses; shape (scales, e, models, sources)."""
        shape = (*begun[0].near.shape, len(MODELS), len(SOURCES))
        outcome: dict[str, Array] = {name: np.full(shape, np.nan) for name in ("peak", "peak_uncertainty")}
        outcome |= {name: np.full(shape, -1, dtype=np.int8) for name in ("collapsed", "converged")}
        for row, runs in enumerate(begun):
            for name, values in self._judge(runs).items():
                # Those of CR are the same whatever the source.
                outcome[name][:, :, row, runs.defined] = values[..., None] if row == 0 else values
        return outcome

    def run_variations(self, e: Array, change: float) -> dict[str, Array]:
        """Run CR with a coarser step, the printed treatment of impacts, a lower and a higher e; (scales, e, 4)."""
        cr = Damping("CR", e)
        others = [self(Damping("CR", e + sign * change), HALVINGS) for sign in (-1.0, 1.0)]
        found = [self(cr, 0), self(cr, HALVINGS, "paper"), *others]
        return {
            "varied_peak": np.stack([one.peak for one in found], axis=-1),
            "varied_collapsed": np.stack([one.collapsed for one in found], axis=-1).astype(np.int8),
        }

    def _run_halvings(self, damping: Damping, defined: NDArray[np.bool_]) -> Runs:
        """Run a damper at the halvings of the coarsest step, and mark the histories that need more of them."""
        ended = [self(damping, halving) for halving in range(HALVINGS + 1)]
        # NaN and False stand for the further halvings, which `_run_further` fills in where they are needed.
        peak = np.full((HALVINGS + FURTHER + 1, *ended[0].peak.shape), np.nan)
        collapsed = np.zeros(peak.shape, dtype=bool)
        for halving, one in enumerate(ended):
            peak[halving], collapsed[halving] = one.peak, one.collapsed
        converged = (collapsed[: HALVINGS + 1] == collapsed[HALVINGS]).all(axis=0)
        near = ~converged | (~collapsed[HALVINGS] & (peak[HALVINGS] >= NEAR))
        return Runs(damping, peak, collapsed, near, defined)

    def _judge(self, runs: Runs) -> dict[str, Array]:
        """Return peaks and outcomes at the finest step of each history, and the bound of their error."""
        usual = self.judge_steps(runs.peak[: HALVINGS + 1], runs.collapsed[: HALVINGS + 1])
        further = self.judge_steps(runs.peak, runs.collapsed)
        return {name: np.where(runs.near, further[name], values) for name, values in usual.items()}

    def judge_steps(self, peak: Array, collapsed: NDArray[np.bool_]) -> dict[str, Array]:
        """Judge runs at halvings 0, 1, ..., the first dimension, by the last and by how it differs from the others.

        The bound of the error adds (w1 h)^2/3 of the peak to its largest change, an error that no halving may show: it
        is three times the median error of 8000 histories, whose changes, plus this, bounded 99.97 % of their errors.
        """
        w1h = self.load.sampling / (self.load.substeps * 2 ** (len(peak) - 1)) * float(self.curve.initial_frequency)
        converged = (collapsed == collapsed[-1]).all(axis=0)
        changes = np.abs(np.diff(peak, axis=0)).max(axis=0)
        bound = np.where(converged & ~collapsed[-1], changes + w1h**2 / 3 * peak[-1], np.nan)
        return {
            "peak": peak[-1],
            "peak_uncertainty": bound,
            "collapsed": collapsed[-1].astype(np.int8),
            "converged": converged.astype(np.int8),
        }


@dataclass(frozen=True)
class Runs:
    """The histories of one damper at every step, the coarsest first.

    `peak` and `collapsed` have the shape (HALVINGS + FURTHER + 1, scales, e, ...); they are NaN and False at the
    further halvings of histories that are not `near` to collapse and do not end in two ways. `defined` marks the
    sources that have a damping ratio.
    """

    damping: Damping
    peak: Array
    collapsed: NDArray[np.bool_]
    near: NDArray[np.bool_]
    defined: NDArray[np.bool_]


def run_dampers(shaken: Sequence[WallUnderRecord], e: Array, damping_ratio: Array) -> list[dict[str, Array]]:
    """Run walls under one record, with CR and every damper; for each wall arrays of shape (scales, e, models, sources).

    `damping_ratio`, shape (walls, e, models, sources), is NaN where a source has none.
    """
    begun = [wall.begin(e, ratio) for wall, ratio in zip(shaken, damping_ratio, strict=True)]
    _run_further([(wall, runs) for wall, own in zip(shaken, begun, strict=True) for runs in own if runs.near.any()])
    return [wall.collect(own) for wall, own in zip(shaken, begun, strict=True)]


def _run_further(begun: Sequence[tuple[WallUnderRecord, Runs]]) -> None:
    """Run the histories that come near to collapse at the further halvings, and fill them in."""
    # Of one wall they are few, and a block of the kernel takes as long with one lane as with all. So they share batches
    # across walls: a batch has one damping model, one kind of last branch and one number of steps between two samples.
    together = defaultdict(list)
    for wall, runs in begun:
        together[runs.damping.model, wall.curve.softening, wall.load.substeps].append((wall, runs))
    for members in together.values():
        edges = np.cumsum([runs.near.sum() for _, runs in members])[:-1]
        for halving in range(HALVINGS + 1, HALVINGS + FURTHER + 1):
            response = _run_near(members, halving)
            ends = (np.split(values, edges) for values in (response.peak, response.collapsed))
            for (_, runs), peak, collapsed in zip(members, *ends, strict=True):
                runs.peak[halving, runs.near], runs.collapsed[halving, runs.near] = peak, collapsed


def _run_near(members: Sequence[tuple[WallUnderRecord, Runs]], halving: int) -> Peaks:
    """Run the histories near to collapse of the walls of one batch, one after the other in its lanes."""

    def lanes(values: Iterable[Quantity]) -> Array:
        parts = zip(values, (runs.near for _, runs in members), strict=True)
        return np.concatenate([np.broadcast_to(value, near.shape)[near] for value, near in parts])

    (first, runs), *_ = members
    parameters = {name: lanes(getattr(runs.damping, name) for _, runs in members) for name in PARAMETERS}
    curve = {name: lanes(getattr(wall.curve, name) for wall, _ in members) for name in RULES}
    load = replace(
        first.halve(runs.damping, halving),
        factor=lanes(wall.halve(runs.damping, 0).factor[0] for wall, runs in members),
        sampling=lanes(wall.load.sampling for wall, _ in members),
    )
    curves = TrilinearCurve(**curve, softening=first.curve.softening)
    return peaks(curves, Damping(runs.damping.model, **parameters), load=load)
