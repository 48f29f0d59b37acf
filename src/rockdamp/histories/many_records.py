"""One wall under several records at several scales: a row each, without the histories."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.labelled import respond, warn_of_motion
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record
from rockdamp.plausibility import as_meant

RESULTS = ("peak_displacement", "peak", "peak_elapsed", "outcome", "outcome_elapsed")


def scales_of(record: Record, asked: Mapping[str, Sequence[float]]) -> Array:
    """Return the factors on a record's acceleration.

    `asked` has one key: ``scale``, plain factors [-], or ``pga`` [m s-2] or ``pgv`` [m s-1], to which the record is
    scaled.
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
    """Yield the peaks and the outcome of a wall under each record, at each scale and under each damping model.

    ``pga`` [m s-2] and ``pgv`` [m s-1] are those of the scaled record; in a building, of the ground. ``damping_ratio``
    is None for restitution; the `RESULTS` are those of `respond`. `asked` is as for `scales_of`; `tail` is the rest
    after each record. [s]
    """
    for motion in motions:
        scale, measures = scales_of(motion.intensity_record, asked), intensity_measures(motion.intensity_record)
        warn_of_motion(motion.record.ground_acceleration, scale)
        with as_meant():  # one record of several may be too weak to rock the wall
            runs = [
                respond(wall, curve, each, motion.record, scale=scale, tail=tail, histories=False) for each in dampings
            ]
        for index, factor in enumerate(scale.tolist()):
            for damping, run in zip(dampings, runs, strict=True):
                yield {
                    "record": motion.name,
                    "scale": factor,
                    "pga": abs(factor) * measures.pga,
                    "pgv": abs(factor) * measures.pgv,
                    "damping_model": damping.model,
                    "damping_ratio": float(xi) if (xi := damping.parameters.get("damping_ratio")) is not None else None,
                    **{name: run[name].values[index].item() for name in RESULTS},
                }
