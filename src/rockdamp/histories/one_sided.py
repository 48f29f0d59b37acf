"""One-sided walls under records: peaks and collapses, event by event.

Nobody knows which way the next earthquake pushes, so a record shakes such a wall both ways: as it
is and reversed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.constants import REFERENCE
from rockdamp.histories.loads import check_tail
from rockdamp.histories.respond import scale_factors
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers.exact import ExactHistory, exact_history


def add_reversed(motions: Iterable[GroundMotion]) -> list[GroundMotion]:
    """Return each motion as it is and reversed, in the same group.

    Parameters
    ----------
    motions : iterable of GroundMotion
        Ground motions. The reversed motion has the same name, followed by ``reversed``.
    """
    directions = []
    for motion in motions:
        reversed_record = replace(
            motion.record, ground_acceleration=-motion.record.ground_acceleration, displacement=None
        )
        directions.append(motion)
        directions.append(replace(motion, name=f"{motion.name} reversed", record=reversed_record))
    return directions


def run_one_sided(
    record: Record,
    specimen: Specimen,
    factor: ArrayLike,
    *,
    tail: float,
    threads: int = 1,
) -> list[ExactHistory]:
    """Run a one-sided wall from rest under a record that is scaled by each factor.

    Parameters
    ----------
    record : Record
        Motion of the base and the stop.
    specimen : Specimen
        One one-sided wall with restitution; its parameters are numbers, not arrays.
    factor : sequence of float
        Factors on the acceleration. [-]
    tail : float
        Rest after the record, at most 1000. [s]
    threads : int
        Histories that run at once.
    """
    ground = append_rest(record.ground_acceleration, record.step, check_tail(tail))
    sampling = float(specimen.wall.frequency_parameter) * record.step
    end = sampling * (ground.size - 1)

    def solve(load_factor: float) -> ExactHistory:
        return exact_history(
            specimen.curve,
            specimen.damping,
            [end],
            load=load_factor * ground,
            sampling=sampling,
            one_sided=True,
        )

    load_factors = float(specimen.wall.load_factor) * np.asarray(factor)
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(solve, load_factors.tolist()))


def respond_one_sided(
    motions: Iterable[GroundMotion],
    specimen: Specimen,
    target: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield the peak and the outcome of a wall under each record, both ways.

    Parameters
    ----------
    motions : iterable of GroundMotion
        Motions of the base and the stop.
    specimen : Specimen
        One one-sided wall with restitution; its parameters are numbers, not arrays.
    target : mapping
        Scales, or intensities to which the records are scaled, as in `respond.scale_factors`.
    tail : float
        Rest after each record, at most 1000. [s]

    Yields
    ------
    dict
        Rows as `respond.tabulate` yields them.
    """
    u_ins = float(specimen.wall.instability_displacement)
    p = float(specimen.wall.frequency_parameter)
    for motion in add_reversed(motions):
        measures = intensity_measures(motion.intensity_record)
        factors = scale_factors(motion.intensity_record, target)
        start = float(motion.record.elapsed[0])
        histories = run_one_sided(motion.record, specimen, factors, tail=tail)
        for factor, history in zip(factors.tolist(), histories, strict=True):
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
                "outcome": "collapsed" if history.collapsed else "survived",
                "outcome_elapsed": start + history.end_tau / p,
            }
