"""One wall under several records at several scales: a row each, without the histories."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.labelled import respond
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record

RESULTS = ("peak_displacement", "peak_ratio", "peak_elapsed", "outcome", "outcome_elapsed")


def scales_of(record: Record, asked: Mapping[str, Sequence[float]]) -> Array:
    """Return the factors on a record's acceleration that are asked for.

    Parameters
    ----------
    record : Record
    asked : dict
        One of ``scale``, plain factors [-], ``pga`` [m s-2] and ``pgv`` [m s-1], to which the record is scaled.
    """
    ((kind, values),) = asked.items()
    if kind == "scale":
        return np.asarray(values, dtype=float)
    bad = [value for value in values if not value > 0]
    if bad:
        raise InputError(f"--to-{kind} is {bad[0]:g}; it must be greater than 0")
    return np.asarray(values, dtype=float) / getattr(intensity_measures(record), kind)


def rows(
    motions: Iterable[GroundMotion],
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    asked: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield what each record does to a wall, at each scale and under each damping model.

    Parameters
    ----------
    motions : iterable of GroundMotion
    wall, curve : Wall or Parapet, TrilinearCurve
    dampings : sequence of Damping
        Of numbers.
    asked : dict
        As for `scales_of`.
    tail : float
        Rest after each record. [s]

    Yields
    ------
    dict
        ``record``, ``scale``, ``pga`` [m s-2] and ``pgv`` [m s-1] of the scaled record, ``damping_model``,
        ``damping_ratio`` (None of restitution) and `RESULTS`, as `respond` has them.
    """
    for motion in motions:
        scale, measures = scales_of(motion.record, asked), intensity_measures(motion.record)
        runs = [respond(wall, curve, each, motion.record, scale=scale, tail=tail, histories=False) for each in dampings]
        for index, factor in enumerate(scale.tolist()):
            for damping, run in zip(dampings, runs, strict=True):
                yield {
                    "record": motion.name,
                    "scale": factor,
                    "pga": abs(factor) * measures.pga,
                    "pgv": abs(factor) * measures.pgv,
                    "damping_model": damping.model,
                    "damping_ratio": None if damping.is_impact else float(damping.damping_ratio),
                    **{name: run[name].values[index].item() for name in RESULTS},
                }
