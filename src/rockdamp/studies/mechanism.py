"""Force-displacement curves of Fig. 2, the wall of Fig. 1, and restitution by slenderness."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config
from rockdamp.constants import PRESETS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import EXCITATION_FACTOR, Wall

# Variables of the dataset, and the attributes of a curve that they hold.
CURVE_VARIABLES = {
    "yield_displacement_ratio": "yield_displacement_ratio",
    "plateau_end_ratio": "plateau_end",
    "ultimate_displacement_ratio": "ultimate_displacement_ratio",
    "strength_ratio": "strength_ratio",
}


def mechanism(config: Config) -> xr.Dataset:
    """Tabulate f/F0 against u/u_ins for the curves of Fig. 2, and the wall of Fig. 1.

    The dataset also has e against slenderness and height of the hinge (section 4.1), by Eq. (7) and
    with the impulses of all supports.
    """
    wall = config.wall.make()
    tested = config.validation.wall.make()
    paper_curve = config.curve.make()
    curves = {
        "tri-linear": paper_curve,
        **make_variants(paper_curve),
        **{name: TrilinearCurve.preset(name) for name in PRESETS},
    }
    # The last three parameters are the corners a1, a2 and a3.
    corners = np.concatenate([np.ravel(curve.parameters()[3:]) for curve in curves.values()])
    # Corners such as 1 - 0.85 are rounded, so that no displacement stands there twice.
    x = np.unique(np.concatenate([np.linspace(0, 1, 1001), corners]).round(12))
    # The first row is the bi-linear law, f/F0 = 1 - u/u_ins.
    force = np.stack([1 - x, *(curve.force(x) for curve in curves.values())])
    curve_variables = {}
    for name, attribute in CURVE_VARIABLES.items():
        values = [float(getattr(curve, attribute)) for curve in curves.values()]
        curve_variables[name] = ("curve_name", [np.nan, *values])
    return xr.Dataset(
        {
            "force": (("curve_name", "displacement"), force),
            **curve_variables,
            **_restitution_by_slenderness(),
            "thickness": float(wall.thickness),
            "height": float(wall.height),
            "hinge_ratio": float(wall.hinge_ratio),
            "instability_displacement": float(wall.instability_displacement),
            "tested_restitution_rigid": float(tested.restitution_rigid),
        },
        coords={"curve_name": ["bi-linear", *curves], "displacement": x},
    )


def _restitution_by_slenderness() -> xr.Dataset:
    """Return e and the effective mass by height of the hinge and slenderness."""
    # Section 2 gives 0.5 to 0.7 for the height of the hinge.
    hinge_ratio = np.array([0.5, 0.6, 0.7])
    # ASSUME: the range of slenderness is that of the studies.
    slenderness = np.arange(10.0, 31.0)
    walls = Wall(1.0, slenderness, hinge_ratio=hinge_ratio[:, None])
    mass_ratio = effective_mass_ratio(hinge_ratio[:, None], slenderness)
    dims = ("hinge_height_ratio", "slenderness")
    return xr.Dataset(
        {
            "restitution_rigid": (dims, walls.restitution_rigid),
            "restitution_impulsive": (dims, walls.restitution_impulsive),
            "effective_mass_ratio": (dims, mass_ratio),
            "excitation_factor": (dims, 1 / mass_ratio),
        },
        coords={"hinge_height_ratio": hinge_ratio, "slenderness": slenderness},
    )


def effective_mass_ratio(hinge_ratio: Quantity, slenderness: Quantity) -> Array:
    r"""Return effective mass / mass of the wall at u = 0, for bodies of finite thickness. [-]

    .. math:: \frac{m_\mathrm{eff}}{m}
              = \frac{2}{3} \left[1 + \frac{t^2}{h^2} \frac{3 - 2r}{r^2 (1 - r)}\right]

    The first term is Eq. (2), for slender bodies, which do not rise as they turn; r = h1/h. The
    inverse of the ratio is lambda.
    """
    r = np.asarray(hinge_ratio, dtype=float)
    h_t = np.asarray(slenderness, dtype=float)
    ratio: Array = (1 + (3 - 2 * r) / (r**2 * (1 - r) * h_t**2)) / EXCITATION_FACTOR
    return ratio


def make_variants(curve: TrilinearCurve) -> dict[str, TrilinearCurve]:
    """Return both variants of the softening branch, with the a3 of Fig. 2."""
    a1 = float(curve.yield_displacement_ratio)
    b1 = float(curve.strength_ratio)
    # ASSUME: the paper draws a3 < 1 without its value; this one leaves room for translated
    # softening.
    a3 = 0.93
    # Translated softening needs a3 > a1 + b1. If the curve's own b1 leaves no room, a lower one
    # makes the plateau half as long as a1.
    lower_b1 = min(b1, a3 - 1.5 * a1)
    return {
        "steeper": TrilinearCurve(a1, b1, a3, "steeper"),
        "translated": TrilinearCurve(a1, lower_b1, a3, "translated"),
    }
