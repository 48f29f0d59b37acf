"""The displacement demand with the bi-linear curve: section 3, in pairs with the tri-linear curve.

The same wall with the same e is put under the same pulses and earthquake records. The nearly rigid curve of Fig. 4a
stands for the bi-linear law.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.config.study import RigidWall
from rockdamp.histories.loads import under_pulses, under_records
from rockdamp.mechanics.curve import TEXTS, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track

CURVES = ("tri-linear", "bi-linear")


def demand(config: Config) -> xr.Dataset:
    """Run the reference wall with both curves under restitution, under every pulse and every record.

    The loads are over the tri-linear plateau for both.
    """
    rigid: RigidWall = config.damping_force.rigid
    pair = (config.curve, rigid.curve)
    a1, b1, a3 = (np.array([float(getattr(curve, name)) for curve in pair]) for name in TEXTS)
    curves = TrilinearCurve(a1, b1, a3, config.curve.softening)
    e, asked = config.damping_force.restitution, config.bilinear
    dampings, plateau = {"CR": Damping.cr(np.full(len(pair), e))}, float(config.curve.strength_ratio)
    by_pulse = under_pulses(
        curves,
        dampings,
        config.pulses.frequency,
        config.pulses.load,
        step=config.pulses.step,
        tail=config.pulses.tail,
        plateau=plateau,
        dims=["force_curve"],
    )
    entries = track(catalogue.listing(asked.records), "Bi-linear and tri-linear curve")
    walls = {name: (config.wall, curve) for name, curve in zip(CURVES, pair, strict=True)}
    by_record = under_records(
        map(catalogue.read, entries),
        walls,
        {"CR": Damping.cr(e)},
        asked.velocity_ratio,
        step=asked.step,
        tail=asked.tail,
    ).rename(wall="force_curve")
    both = [
        ended.sel(damping_model="CR", drop=True)
        .transpose("force_curve", ...)
        .rename(peak=f"peak_under_{load}", collapsed=f"{load}_collapsed")
        for load, ended in (("pulse", by_pulse), ("record", by_record.drop_vars(["record_set", "station"])))
    ]
    return xr.merge([both[0].assign_coords(force_curve=list(CURVES)), both[1]], join="exact").assign(
        yield_displacement_ratio=("force_curve", a1), strength_ratio=("force_curve", b1), restitution=e
    )
