"""The displacement demand with the bi-linear curve: section 3, in pairs with the tri-linear curve.

The same wall with the same e is put under the same pulses and earthquake records. The nearly rigid curve of Fig. 4a
stands for the bi-linear law.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.histories.at_intensities import peaks_and_collapses
from rockdamp.histories.forcing import Forcing
from rockdamp.mechanics.curve import TEXTS, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED
from rockdamp.studies.pulses import CELLS, PULSES, pulse

CURVES = ("tri-linear", "bi-linear")


def demand(config: Config) -> xr.Dataset:
    """Run the reference wall with both curves under restitution, under every pulse and every record.

    The loads are over the tri-linear plateau for both.
    """
    pair = (config.curve, config.damping_force.rigid.curve)
    a1, b1, a3 = (np.array([float(getattr(curve, name)) for curve in pair]) for name in TEXTS)
    curves = TrilinearCurve(a1, b1, a3, config.curve.softening)
    e = Damping.cr(np.full(len(pair), config.damping_force.restitution))
    pulses = np.stack([_under_pulses(config, curves, e, name) for name in PULSES], axis=2)
    motions, records = _under_records(config, curves, e)
    by_pulse, by_record = ("force_curve", *CELLS), ("force_curve", "record", "velocity_ratio")
    return xr.Dataset(
        {
            "peak_under_pulse": (by_pulse, pulses[0]),
            "pulse_collapsed": (by_pulse, pulses[1].astype(np.int8)),
            "peak_under_record": (by_record, records[0]),
            "record_collapsed": (by_record, records[1].astype(np.int8)),
            "yield_displacement_ratio": ("force_curve", a1),
            "strength_ratio": ("force_curve", b1),
            "restitution": config.damping_force.restitution,
        },
        coords={
            "force_curve": list(CURVES),
            "pulse": list(PULSES),
            "pulse_frequency": config.pulses.frequency,
            "load_ratio": config.pulses.load,
            "record": motions,
            "velocity_ratio": config.bilinear.velocity_ratio,
        },
    )


def _under_pulses(config: Config, curves: TrilinearCurve, e: Damping, name: str) -> Array:
    """Peaks and collapses under one pulse, shape (2, curves, frequencies, loads)."""
    ended = np.empty((2, *curves.shape, config.pulses.frequency.size, config.pulses.load.size))
    each, step = curves.map(lambda parameter: parameter[:, None]), config.pulses.step
    for column, frequency in enumerate(config.pulses.frequency):
        load = followed_by_rest(pulse(name, float(frequency), step), step, config.pulses.tail)
        forcing = Forcing(load, step, float(config.curve.strength_ratio) * config.pulses.load)
        response = solve(each, e.map(lambda parameter: parameter[:, None]), peaks_only=True, **forcing.newmark())
        ended[:, :, column] = response.peak, response.outcome == COLLAPSED
    return ended


def _under_records(config: Config, curves: TrilinearCurve, e: Damping) -> tuple[list[str], Array]:
    """Names of the records; peaks and collapses, shape (2, curves, records, scales)."""
    names, ended = [], []
    for entry in track(catalogue.listing(config.bilinear.records), "Bi-linear and tri-linear curve"):
        motion = catalogue.read(entry)
        factor = config.bilinear.velocity_ratio * config.wall.velocity_scale / intensity_measures(motion.record).pgv
        both = peaks_and_collapses(
            motion.record, config.wall, curves, [e], factor, step=config.bilinear.step, tail=config.bilinear.tail
        )
        names.append(motion.name)
        ended.append(np.stack(both)[..., 0])
    return names, np.stack(ended, axis=2)
