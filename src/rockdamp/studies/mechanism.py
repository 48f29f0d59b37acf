"""Force-displacement curves of Fig. 2, the wall of Fig. 1, and restitution by slenderness; no history is solved."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config
from rockdamp.constants import PRESETS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import EXCITATION_FACTOR, Wall


def mechanism(config: Config) -> xr.Dataset:
    """Tabulate f/F0 against u/u_ins for the curves that Fig. 2 and the presets draw, and the wall of Fig. 1.

    Also e against slenderness and height of the hinge (section 4.1), by Eq. (7) and with every support's impulse.
    """
    # Section 2 gives 0.5 to 0.7 for the height of the hinge. ASSUME: the range of slenderness, that of the studies.
    hinge_ratio, slenderness = np.array([0.5, 0.6, 0.7]), np.arange(10.0, 31.0)
    wall, tested, curve = config.wall.make(), config.validation.wall.make(), config.curve.make()
    curves = {
        "tri-linear": curve,
        **make_variants(curve),
        **{name: TrilinearCurve.preset(name) for name in PRESETS},
    }
    corners = np.concatenate([np.ravel(drawn.parameters()[3:]) for drawn in curves.values()])
    # Corners such as 1 - 0.85 are rounded, so that no displacement stands there twice.
    x = np.unique(np.concatenate([np.linspace(0, 1, 1001), corners]).round(12))
    force = np.stack([1 - x, *(drawn.force(x) for drawn in curves.values())])

    def tabulate(parameter: str) -> tuple[str, list[float]]:
        return "curve_name", [
            np.nan,
            *(float(getattr(drawn, parameter)) for drawn in curves.values()),
        ]

    walls = Wall(1.0, slenderness, hinge_ratio=hinge_ratio[:, None])
    mass, dims = (
        effective_mass_ratio(hinge_ratio[:, None], slenderness),
        ("hinge_height_ratio", "slenderness"),
    )
    return xr.Dataset(
        {
            "force": (("curve_name", "displacement"), force),
            "yield_displacement_ratio": tabulate("yield_displacement_ratio"),
            "plateau_end_ratio": tabulate("plateau_end"),
            "ultimate_displacement_ratio": tabulate("ultimate_displacement_ratio"),
            "strength_ratio": tabulate("strength_ratio"),
            "thickness": float(wall.thickness),
            "height": float(wall.height),
            "hinge_ratio": float(wall.hinge_ratio),
            "instability_displacement": float(wall.instability_displacement),
            "restitution_rigid": (dims, walls.restitution_rigid),
            "restitution_impulsive": (dims, walls.restitution_impulsive),
            "effective_mass_ratio": (dims, mass),
            "excitation_factor": (dims, 1 / mass),
            "tested_restitution_rigid": float(tested.restitution_rigid),
        },
        coords={
            "curve_name": ["bi-linear", *curves],
            "displacement": x,
            "hinge_height_ratio": hinge_ratio,
            "slenderness": slenderness,
        },
    )


def effective_mass_ratio(hinge_ratio: Quantity, slenderness: Quantity) -> Array:
    r"""Effective mass at u = 0 over the wall's mass, of bodies with a thickness; lambda is its inverse. [-]

    .. math:: \frac{m_\mathrm{eff}}{m} = \frac{2}{3} \left[1 + \frac{t^2}{h^2} \frac{3 - 2r}{r^2 (1 - r)}\right]

    The first term is Eq. (2), of slender bodies, which do not rise as they turn; r = h1/h.
    """
    r, h_t = np.asarray(hinge_ratio, dtype=float), np.asarray(slenderness, dtype=float)
    ratio: Array = (1 + (3 - 2 * r) / (r**2 * (1 - r) * h_t**2)) / EXCITATION_FACTOR
    return ratio


def make_variants(curve: TrilinearCurve) -> dict[str, TrilinearCurve]:
    """Return both variants of the last branch with the a3 that Fig. 2 draws."""
    # ASSUME: the paper draws a3 < 1 without stating its value; this one leaves room for the translated variant.
    a1, b1, a3 = float(curve.yield_displacement_ratio), float(curve.strength_ratio), 0.93
    # Translated softening needs a3 > a1 + b1: a lower plateau where the curve's leaves no room.
    lower = min(b1, a3 - 1.5 * a1)
    return {
        "steeper": TrilinearCurve(a1, b1, a3, "steeper"),
        "translated": TrilinearCurve(a1, lower, a3, "translated"),
    }
