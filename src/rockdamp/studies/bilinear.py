"""Displacement demand with the bi-linear curve (section 3) and with the tri-linear one, in pairs.

The same wall with the same e is put under the same earthquake records. The nearly rigid curve of
Fig. 4a represents the bi-linear law.
"""

from __future__ import annotations

import xarray as xr

from rockdamp.config import Config, RigidWall
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_records
from rockdamp.progress import track
from rockdamp.studies.runner import Case, run, use


def bilinear(config: Config) -> xr.Dataset:
    """Run the reference wall with both curves, with restitution, under every scaled record."""
    e = config.damping_force.restitution
    settings = config.bilinear
    rigid: RigidWall = config.damping_force.rigid
    curves = {"tri-linear": config.curve.make(), "bi-linear": rigid.curve}
    walls = {name: (config.wall.make(), curve) for name, curve in curves.items()}
    motions = track(load_records(settings.records), "Bi-linear and tri-linear curve")
    case = Case("restitution", use(Damping("CR", e)), settings.step)
    peaks = run([case], motions, walls, settings.velocity_ratio.values(), tail=settings.tail)
    curve_variables = {
        name: ("force_curve", [float(getattr(curve, name)) for curve in curves.values()])
        for name in ("yield_displacement_ratio", "strength_ratio")
    }
    return (
        peaks.isel(case=0)
        .drop_vars(["case", "reference", "station"])
        .rename(wall="force_curve")
        .transpose("force_curve", ...)
        .assign(curve_variables)
        .assign(restitution=e)
    )
