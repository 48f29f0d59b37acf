"""Walls that rock to one side under records: peaks and collapses.

Nobody knows which way the next earthquake pushes, so a record shakes such a wall as it is, and turned round.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.histories.labelled import scales_of
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.solvers import one_sided
from rockdamp.solvers.response import Response
from rockdamp.vocabulary import OUTCOMES, REFERENCE


def both_ways(motions: Iterable[GroundMotion]) -> list[GroundMotion]:
    """Return each motion as it is and turned round, of the same group."""
    return [
        each
        for motion in motions
        for each in (motion, replace(motion, name=f"{motion.name} turned", record=turned(motion.record)))
    ]


def turned(record: Record) -> Record:
    """Return a record that acts the other way."""
    return Record(record.elapsed, -record.ground_acceleration, header=record.header, digest=record.digest)


def ends(
    record: Record,
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: float,
    factor: ArrayLike,
    *,
    tail: float,
    threads: int = 1,
) -> Response:
    """Run a wall from rest under a record that is scaled by each factor, with a rest of `tail` after it. [-], [s]"""
    return one_sided.ends(
        curve,
        restitution,
        load_factor=float(wall.load_factor) * np.asarray(factor),
        ground_acceleration=followed_by_rest(record.ground_acceleration, record.step, tail),
        sampling=float(wall.frequency_parameter) * record.step,
        threads=threads,
    )


def rows(
    motions: Iterable[GroundMotion],
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: float,
    asked: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield the peaks and the outcome of a wall under each record, both ways, as `labelled.rows` does."""
    u_ins, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    for motion in both_ways(motions):
        scale, measures = scales_of(motion.intensity_record, asked), intensity_measures(motion.intensity_record)
        start = float(motion.record.elapsed[0])
        ended = ends(motion.record, wall, curve, restitution, scale, tail=tail)
        for index, factor in enumerate(scale.tolist()):
            yield {
                "record": motion.name,
                "scale": factor,
                "pga": abs(factor) * measures.pga,
                "pgv": abs(factor) * measures.pgv,
                "damping_model": REFERENCE,
                "damping_ratio": None,
                "peak_displacement": u_ins * float(ended.peak[index]),
                "peak": float(ended.peak[index]),
                "peak_elapsed": start + float(ended.peak_tau[index]) / p,
                "outcome": OUTCOMES[int(ended.outcome[index])],
                "outcome_elapsed": start + float(ended.outcome_tau[index]) / p,
            }
