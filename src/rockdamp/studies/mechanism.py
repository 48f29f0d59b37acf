"""Curves and loops of single walls.

Curves of Fig. 2: the rigid bi-linear law and the tri-linear ones built on it; restitution and slenderness. Matched
histories and the loops of their damping forces (Fig. 3), and the check against rigid rocking (Fig. 4).
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config, Matching, RigidWall
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.two_bodies import large_rotation_decay, slender_decay
from rockdamp.mechanics.wall import EXCITATION_FACTOR, Wall
from rockdamp.solvers.newmark import solve
from rockdamp.studies.decays import step_count
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import MODELS, PRESETS, VISCOUS_MODELS

POINTS = 1001
# ASSUME: the paper draws a3 < 1 without stating its value; this one leaves room for the translated variant.
DRAWN_ULTIMATE_RATIO = 0.93
# Section 2 gives 0.5 to 0.7 for the height of the hinge. ASSUME: the range of slenderness, that of the studies.
HINGE_RATIOS = np.array([0.5, 0.6, 0.7])
SLENDERNESSES = np.arange(10.0, 31.0)


def mechanism(config: Config) -> xr.Dataset:
    """Tabulate f/F0 against u/u_ins for the curves that Fig. 2 and the presets draw, and the wall of Fig. 1.

    Also e against slenderness and height of the hinge (section 4.1), by Eq. (7) and with every support's impulse.
    """
    wall, tested, curve = config.wall.make(), config.validation.wall.make(), config.curve.make()
    curves = {
        "tri-linear": curve,
        **drawn_variants(curve),
        **{name: TrilinearCurve.preset(name) for name in PRESETS},
    }
    corners = np.concatenate([np.ravel(each.parameters()[3:]) for each in curves.values()])
    x = np.unique(np.concatenate([np.linspace(0, 1, POINTS), corners]))
    force = np.stack([1 - x, *(each.force(x) for each in curves.values())])
    parameters = np.array([[np.nan] * 3, *([*map(float, each.parameters()[3:])] for each in curves.values())])
    plateau = np.array([np.nan, *(float(each.strength_ratio) for each in curves.values())])
    walls = Wall(1.0, SLENDERNESSES, hinge_ratio=HINGE_RATIOS[:, None])
    mass = effective_mass_ratio(HINGE_RATIOS[:, None], SLENDERNESSES)
    return xr.Dataset(
        {
            "force": (("curve_name", "displacement"), force),
            "yield_displacement_ratio": ("curve_name", parameters[:, 0]),
            "plateau_end_ratio": ("curve_name", parameters[:, 1]),
            "ultimate_displacement_ratio": ("curve_name", parameters[:, 2]),
            "strength_ratio": ("curve_name", plateau),
            "thickness": float(wall.thickness),
            "height": float(wall.height),
            "hinge_ratio": float(wall.hinge_ratio),
            "instability_displacement": float(wall.instability_displacement),
            "restitution_rigid": (("hinge_height_ratio", "slenderness"), walls.restitution_rigid),
            "restitution_impulsive": (("hinge_height_ratio", "slenderness"), walls.restitution_impulsive),
            "effective_mass_ratio": (("hinge_height_ratio", "slenderness"), mass),
            "excitation_factor": (("hinge_height_ratio", "slenderness"), 1 / mass),
            "tested_restitution_rigid": float(tested.restitution_rigid),
            "tested_restitution_impulsive": float(tested.restitution_impulsive),
        },
        coords={
            "curve_name": ["bi-linear", *curves],
            "displacement": x,
            "hinge_height_ratio": HINGE_RATIOS,
            "slenderness": SLENDERNESSES,
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


def drawn_variants(curve: TrilinearCurve) -> dict[str, TrilinearCurve]:
    """Return both variants of the last branch with the a3 that Fig. 2 draws."""
    a1, b1 = float(curve.yield_displacement_ratio), float(curve.strength_ratio)
    # Translated softening needs a3 > a1 + b1: a lower plateau where the curve's leaves no room.
    lower = min(b1, DRAWN_ULTIMATE_RATIO - 1.5 * a1)
    return {
        "steeper": TrilinearCurve(a1, b1, DRAWN_ULTIMATE_RATIO, "steeper"),
        "translated": TrilinearCurve(a1, lower, DRAWN_ULTIMATE_RATIO, "translated"),
    }


FREQUENCIES = np.linspace(0.0, 1.0, 101)
# ASSUME: Fig. 4a names neither its curve nor its hinge height; the config states them (nearly rigid, mid-height).
ROCKING_MODELS = ("tri-linear", "slender", "large rotation")
# At the step of the other histories, the first branch of a nearly rigid curve would be off by six times as much as they
# are: it is three times as fast as that of the paper's curve.
RIGID_REFINEMENT = 8  # steps of its history in place of each of the solver's


def damping_force(config: Config) -> xr.Dataset:
    """Return the decays of CR and of every viscous model matched to it, and the three rocking decays of Fig. 4a."""
    e, x0, length = (
        config.damping_force.restitution,
        config.release_amplitude,
        config.damping_force.response_length,
    )
    step, scheme, rigid = config.solver.step, config.solver.scheme, config.damping_force.rigid
    parts = [
        matched_histories(config.curve.make(), e, x0, config.matching, length=length, step=step, scheme=scheme),
        _frequency_laws(),
        _rocking(rigid, length=length, step=step, scheme=scheme),
    ]
    return xr.merge(parts, compat="no_conflicts").assign_coords(
        restitution=e, release_amplitude=x0, rocking_restitution=rigid.restitution
    )


def matched_histories(
    curve: TrilinearCurve, e: float, x0: float, matching: Matching, *, length: float, step: float, scheme: str
) -> xr.Dataset:
    """Return the decay from x0 under e, and that of each viscous model matched to it, over `length` in tau or more."""
    steps = max(step_count(length, step), step_count(matching.response_length, step))
    matched = match_decays(
        curve.map(np.atleast_1d), np.array([x0]), np.array([e]), VISCOUS_MODELS, matching, step=step, scheme=scheme
    )
    ratio = {model: float(of.damping_ratio[0]) for model, of in matched.items()}
    dampings = [Damping.cr(e), *(Damping(model, xi) for model, xi in ratio.items())]
    histories = [
        solve(curve, damping, release_amplitude=x0, step=step, steps=steps, store_every=1, scheme=scheme)
        for damping in dampings
    ]
    force = [
        damping.coefficient(curve, history.displacement, history.velocity) * history.velocity
        for damping, history in zip(dampings, histories, strict=True)
    ]
    dims = ("damping_model", "tau")
    return xr.Dataset(
        {
            "displacement": (dims, np.stack([history.displacement for history in histories])),
            "velocity": (dims, np.stack([history.velocity for history in histories])),
            "damping_force": (dims, np.stack(force)),
            "damping_ratio": ("damping_model", [np.nan, *ratio.values()]),
        },
        coords={"damping_model": list(MODELS), "tau": step * np.arange(steps + 1)},
    )


def _frequency_laws() -> xr.Dataset:
    """xi(w)/xi of each model against the secant frequency w/w1, from C = 2 m_eff w xi(w): Fig. 3, left.

    ECD depends on the energy frequency, which is no function of the secant frequency alone: it has no such law.
    """
    laws = {model: np.full(FREQUENCIES.size, np.nan) for model in VISCOUS_MODELS}
    exponents = {model: Damping(model, 1.0).secant_exponent for model in VISCOUS_MODELS}
    for model, exponent in exponents.items():
        if exponent is None:
            continue
        # CDC keeps C of the first branch; at w = 0 its ratio to a vanishing critical damping has no bound.
        with np.errstate(divide="ignore"):
            laws[model] = np.where(FREQUENCIES > 0, FREQUENCIES ** (exponent - 1), 0.0 if exponent > 1 else np.nan)
    return xr.Dataset(
        {"damping_ratio_law": (("viscous_model", "frequency_ratio"), np.stack(list(laws.values())))},
        coords={"viscous_model": list(laws), "frequency_ratio": FREQUENCIES},
    )


def _rocking(rigid: RigidWall, *, length: float, step: float, scheme: str) -> xr.Dataset:
    """Return the decay of the nearly rigid wall of Fig. 4a and those of two rigid bodies, over `length` in tau."""
    wall, e, x0 = rigid.wall, rigid.restitution, rigid.release_amplitude
    steps = step_count(length, step)
    tau = step * np.arange(steps + 1)
    response = solve(
        rigid.curve,
        Damping.cr(e),
        release_amplitude=x0,
        step=step / RIGID_REFINEMENT,
        steps=steps * RIGID_REFINEMENT,
        store_every=RIGID_REFINEMENT,
        scheme=scheme,
    )
    histories = [
        response.displacement,
        slender_decay(tau, e, x0),
        large_rotation_decay(tau, wall, e, x0),
    ]
    return xr.Dataset(
        {"rocking_displacement": (("rocking_model", "tau"), np.stack(histories))},
        coords={
            "rocking_model": list(ROCKING_MODELS),
            "tau": tau,
            "rocking_frequency_parameter": float(wall.frequency_parameter),
        },
    )
