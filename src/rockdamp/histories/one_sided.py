"""Walls that rock to one side under records: peaks and collapses, event by event.

Nobody knows which way the next earthquake pushes, so a record shakes such a wall as it is and turned round.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.constants import REFERENCE
from rockdamp.histories.respond import scale_factors
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import Specimen
from rockdamp.mechanics.wall import OneSidedWall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers.exact import ExactHistory, exact_history


def add_reversed(motions: Iterable[GroundMotion]) -> list[GroundMotion]:
    """Return each motion as it is and turned round, of the same group."""
    both = []
    for motion in motions:
        record = replace(
            motion.record, ground_acceleration=-motion.record.ground_acceleration, displacement=None
        )
        both += [motion, replace(motion, name=f"{motion.name} turned", record=record)]
    return both


def run_one_sided(
    record: Record,
    specimen: Specimen,
    factor: ArrayLike,
    *,
    tail: float,
    threads: int = 1,
) -> list[ExactHistory]:
    """Run a one-sided wall of numbers under a record that is scaled by each factor, from rest. [-], [s]"""
    ground = append_rest(record.ground_acceleration, record.step, tail)
    sampling = float(specimen.wall.frequency_parameter) * record.step

    def solve(load_factor: float) -> ExactHistory:
        end = sampling * (ground.size - 1)
        return exact_history(
            specimen.curve,
            specimen.damping,
            [end],
            load=load_factor * ground,
            sampling=sampling,
            one_sided=True,
        )

    with ThreadPoolExecutor(threads) as pool:
        return list(
            pool.map(solve, (float(specimen.wall.load_factor) * np.asarray(factor)).tolist())
        )


def respond_one_sided(
    motions: Iterable[GroundMotion],
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: float,
    asked: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield the peak and the outcome of a wall under each record, both ways, as `respond.tabulate` does."""
    specimen = Specimen(wall, curve, Damping(REFERENCE, restitution))
    u_ins, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    for motion in add_reversed(motions):
        scale, measures = (
            scale_factors(motion.intensity_record, asked),
            intensity_measures(motion.intensity_record),
        )
        start = float(motion.record.elapsed[0])
        histories = run_one_sided(motion.record, specimen, scale, tail=tail)
        for factor, history in zip(scale.tolist(), histories, strict=True):
            yield {
                "record": motion.name,
                "scale": factor,
                "pga": abs(factor) * measures.pga,
                "pgv": abs(factor) * measures.pgv,
                "damping_model": REFERENCE,
                "damping_ratio": None,
                "peak_displacement": u_ins * history.peak,
                "peak": history.peak,
                "peak_elapsed": start + history.peak_tau / p,
                "outcome": "collapsed" if history.collapsed else "completed",
                "outcome_elapsed": start + history.end_tau / p,
            }
