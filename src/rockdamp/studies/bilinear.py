"""Displacement demand with the bi-linear curve (section 3) and with the tri-linear one, in pairs.

The same wall with the same e is put under the same earthquake records. The nearly rigid curve of Fig. 4a stands for the
bi-linear law.
"""

from __future__ import annotations

import xarray as xr

from rockdamp.config import Config, RigidWall
from rockdamp.histories.loads import run_records
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track


def bilinear(config: Config) -> xr.Dataset:
    """Run the reference wall with both curves under restitution, under every record at every intensity."""
    e, settings = config.damping_force.restitution, config.bilinear
    rigid: RigidWall = config.damping_force.rigid
    curves = {"tri-linear": config.curve.make(), "bi-linear": rigid.curve}
    ended = run_records(
        map(catalogue.load_record, track(catalogue.record_names(settings.records), "Bi-linear and tri-linear curve")),
        {name: (config.wall.make(), curve) for name, curve in curves.items()},
        Damping("CR", [float(e)]),
        settings.velocity_ratio.values(),
        step=settings.step,
        tail=settings.tail,
        dim="restitution",
    )
    return (
        ended.isel(restitution=0)
        .drop_vars(["record_set", "station"])
        .rename(wall="force_curve")
        .transpose("force_curve", ...)
        .assign(
            {
                name: ("force_curve", [float(getattr(curve, name)) for curve in curves.values()])
                for name in ("yield_displacement_ratio", "strength_ratio")
            }
        )
        .assign(restitution=e)
    )
