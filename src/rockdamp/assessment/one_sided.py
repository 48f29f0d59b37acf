"""Walls that rock to one side, with or without ties: collapses under records both ways, and the tie that is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arguments import instance, number
from rockdamp.arrays import Array
from rockdamp.assessment.collapses import SHOWN, STRIPES, TAIL
from rockdamp.errors import InputError, require
from rockdamp.histories.one_sided import peaks_and_collapses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import CONTACT_STEP, CONTACT_STIFFNESS, OneSidedWall, Tie, stop_damping_ratio
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record
from rockdamp.solvers.newmark import available_threads
from rockdamp.vocabulary import REFERENCE

STOP = "STOP"  # the damper at the stop, among the damping models
MODELS = (REFERENCE, STOP)
TURNED = " turned"  # ends the name of a record that acts the other way
CLOSE = 0.02  # of a strength that is searched for, relatively
STRONGEST = 100.0  # strength over F0 up to which a tie is searched for


def both_ways(motions: Sequence[GroundMotion]) -> list[GroundMotion]:
    """Return each motion as it is and turned round, of the same group; those that are so already as they are."""
    if any(motion.name.endswith(TURNED) for motion in motions):
        return list(motions)
    others = [
        replace(
            motion,
            name=motion.name + TURNED,
            record=turned(motion.record),
        )
        for motion in motions
    ]
    return [each for pair in zip(motions, others, strict=True) for each in pair]


def turned(record: Record) -> Record:
    """Return a record that acts the other way."""
    return Record(record.elapsed, -record.ground_acceleration, header=record.header, digest=record.digest)


def collapses(
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: ArrayLike,
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    step: float = 0.0,
    tail: float = TAIL,
    track: Callable[[Sequence[GroundMotion]], Iterable[GroundMotion]] = SHOWN,
) -> xr.Dataset:
    """Run one wall with restitution, event by event, and with the damper at its stop.

    Arguments and result are as of `collapses.collapses`, of one wall; `step` has no effect, as the stop needs its own.
    ``stripe_coarser`` is at twice the step of the damper at the stop: restitution needs none.
    """
    e = float(np.ravel(restitution)[0])
    curve = curve.map(lambda parameter: parameter.reshape(-1)[0])
    levels = np.array([getattr(intensity_measures(motion.intensity_record), measure.lower()) for motion in motions])
    supports = [intensity_measures(motion.record) for motion in motions]
    stripe = float(wall.velocity_scale) * STRIPES * float(np.median(levels / [level.pgv for level in supports]))
    wanted, asked = np.concatenate([intensity, stripe]), intensity.size
    threads = available_threads()
    peaks, collapsed, coarser = [], [], []
    for motion, level in zip(track(motions), levels, strict=True):
        run = partial(peaks_and_collapses, motion.record, wall, curve, e, wanted / level, tail=tail, threads=threads)
        exact, damped = run(), run(contact_stiffness=CONTACT_STIFFNESS)
        longer = run(contact_stiffness=CONTACT_STIFFNESS, step=2 * CONTACT_STEP)
        outcome = np.stack([exact[1], damped[1]], axis=-1)
        peaks.append(np.where(outcome, np.nan, np.stack([exact[0], damped[0]], axis=-1))[:asked])
        collapsed.append(outcome)
        coarser.append(np.stack([exact[1], longer[1]], axis=-1))
    at, stripes = ("record", "wall", "intensity", "damping_model"), ("record", "wall", "stripe", "damping_model")
    fell, before = (np.stack(values)[:, None] for values in (collapsed, coarser))
    factor = intensity / levels[:, None]
    return xr.Dataset(
        {
            "peak": (at, np.stack(peaks)[:, None]),
            "collapsed": (at, fell[:, :, :asked]),
            "stripe_collapsed": (stripes, fell[:, :, asked:]),
            "stripe_coarser": (stripes, before[:, :, asked:]),
            "stripe_intensity": (("wall", "stripe"), stripe[None]),
            "asked": ("intensity", intensity),
            "scale_factor": (("record", "intensity"), factor),
            "strongest": ("intensity", np.max(factor * [[level.pga] for level in supports], axis=0)),
            "damping_ratio": (("damping_model", "wall"), [[np.nan], [stop_damping_ratio(e)]]),
            "order": (("damping_model", "wall"), [[np.nan], [np.nan]]),
        },
        coords={"damping_model": list(MODELS)},
    )


@dataclass(frozen=True)
class NeededTie:
    """The strength of a tie that keeps the probability of collapse at or below a target, and the steps to it.

    `strength` is that of all ties of the wall together [N]; `probability` what it leaves, `without` that of the wall
    without ties. `tried` are the strengths [N] and probabilities that were tried, in their order.
    """

    strength: float
    probability: float
    without: float
    tried: tuple[tuple[float, float], ...]


def needed_tie(
    wall: OneSidedWall,
    curve: TrilinearCurve,
    records: Sequence[GroundMotion],
    *,
    target: float,
    restitution: float,
    pgv: float | None = None,
    pga: float | None = None,
    tail: float = TAIL,
) -> NeededTie:
    """Return how strong the tie of a wall must be for a target of the probability of collapse, under restitution.

    The tie of `wall` says all of it but the strength, which is searched for by halves, to 2 %. Its yield stretch stays:
    a stronger tie is a thicker one, and stiffer in proportion. Each record acts both ways.

    Parameters
    ----------
    wall, curve : OneSidedWall, TrilinearCurve
    records : sequence of GroundMotion
    target : float
        Probability of collapse. [-]
    restitution : float
        e. [-]
    pgv, pga : float
        One of them: the intensity. [m s-1], [m s-2]

    Raises
    ------
    InputError
        If the wall has no tie, the target is none, or no tie of a hundred times F0 is enough.
    """
    instance("wall", wall, OneSidedWall)
    if wall.tie is None:
        raise InputError("the wall has no tie; it must have one, whose strength is then searched for")
    target = number("target", target)
    require(0 < target < 1, "target", target, "between 0 and 1, both excluded")
    if (pgv is None) == (pga is None):
        raise InputError("there must be either pgv or pga, the intensity")
    tie, level, measure = wall.tie, pgv or pga, "pga" if pgv is None else "pgv"
    motions = both_ways(records)
    factors = [float(level) / getattr(intensity_measures(motion.record), measure) for motion in motions]  # type: ignore[arg-type]

    def probability(strength: float) -> float:
        tied = replace(wall, tie=_stronger(tie, strength) if strength else None)
        outcomes = [
            bool(peaks_and_collapses(motion.record, tied, curve, restitution, factor, tail=tail)[1])
            for motion, factor in zip(motions, factors, strict=True)
        ]
        return float(np.mean(outcomes))

    without = probability(0.0)
    if without <= target:
        return NeededTie(0.0, without, without, ())
    tried: list[tuple[float, float]] = []

    def enough(strength: float) -> bool:
        tried.append((strength, probability(strength)))
        return tried[-1][1] <= target

    low, high, most = 0.0, float(tie.strength), STRONGEST * float(wall.mechanism.rigid_strength)
    while not enough(high):
        low, high = high, 2 * high
        if high > most:
            raise InputError(f"target is {target:g}; no tie up to {most / 1000:.3g} kN leaves so low a probability")
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    left = min(share for strength, share in tried if strength == high)
    return NeededTie(high, left, without, tuple(tried))


def _stronger(tie: Tie, strength: float) -> Tie:
    """Return a tie of another strength whose yield stretch is the same."""
    return replace(tie, strength=strength, stiffness=float(tie.stiffness) * strength / float(tie.strength))
