"""Matched histories and the loops of their damping forces (Fig. 3), and the check against rigid rocking (Fig. 4)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.constants import REFERENCE, VISCOUS_MODELS
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.two_bodies import large_rotation_decay, slender_decay
from rockdamp.solvers.newmark import simulate
from rockdamp.studies.decays import damped_decays, step_count
from rockdamp.studies.matches import match_decays


def damping_force(config: Config) -> xr.Dataset:
    """Return the decays of CR and of every viscous model matched to it, and the three rocking decays of Fig. 4a."""
    return xr.merge(
        [_matched(config), _frequency_laws(), _rocking(config)], compat="no_conflicts"
    ).assign_coords(
        restitution=config.damping_force.restitution,
        release_amplitude=config.release_amplitude,
        rocking_restitution=config.damping_force.rigid.restitution,
    )


def _matched(config: Config) -> xr.Dataset:
    """Return the decay under CR, and that of each viscous model matched to it."""
    curve, e, x0 = config.curve.make(), config.damping_force.restitution, config.release_amplitude
    step = config.solver.step
    length = max(config.damping_force.response_length, config.matching.response_length)
    steps = step_count(length, step)
    release = curve.map(np.atleast_1d), np.array([x0]), np.array([e])
    matched = match_decays(*release, VISCOUS_MODELS, config.matching, config.solver)
    ratio = {model: float(of.damping_ratio[0]) for model, of in matched.items()}
    dampings = {
        REFERENCE: Damping(REFERENCE, e),
        **{model: Damping(model, xi) for model, xi in ratio.items()},
    }
    decays = damped_decays(curve, dampings, x0, step=step, steps=steps, scheme=config.solver.scheme)
    return decays.assign(damping_ratio=("damping_model", [np.nan, *ratio.values()]))


def _frequency_laws() -> xr.Dataset:
    """xi(w)/xi of each model against the secant frequency w/w1, from C = 2 m_eff w xi(w): Fig. 3, left.

    ECD depends on the energy frequency, which is no function of the secant frequency alone: it has no such law.
    """
    w = np.linspace(0.0, 1.0, 101)
    laws = {model: np.full(w.size, np.nan) for model in VISCOUS_MODELS}
    for model, exponent in (
        ("CDC", 0.0),
        ("CDR", 1.0),
        ("SDR", 2.0),
    ):  # of C, in the secant frequency
        # CDC keeps C of the first branch; at w = 0 its ratio to a vanishing critical damping has no bound.
        with np.errstate(divide="ignore"):
            laws[model] = np.where(w > 0, w ** (exponent - 1), 0.0 if exponent > 1 else np.nan)
    return xr.Dataset(
        {
            "damping_ratio_law": (
                ("viscous_model", "frequency_ratio"),
                np.stack(list(laws.values())),
            )
        },
        coords={"viscous_model": list(laws), "frequency_ratio": w},
    )


def _rocking(config: Config) -> xr.Dataset:
    """Return the decay of the nearly rigid wall of Fig. 4a and those of two rigid bodies."""
    # ASSUME: Fig. 4a names neither its curve nor its hinge height; the config states them (nearly rigid, mid-height).
    rigid, step = config.damping_force.rigid, config.solver.step
    wall, e, x0 = rigid.wall, rigid.restitution, rigid.release_amplitude
    steps = step_count(config.damping_force.response_length, step)
    tau = step * np.arange(steps + 1)
    # At the step of the other histories the first branch of a nearly rigid curve, which is three times as fast as that
    # of the paper's curve, would be off by six times as much as they are.
    finer = 8
    response = simulate(
        rigid.curve,
        Damping(REFERENCE, e),
        release_amplitude=x0,
        step=step / finer,
        steps=steps * finer,
        store_every=finer,
        scheme=config.solver.scheme,
    )
    histories = {
        "tri-linear": response.displacement,
        "slender": slender_decay(tau, e, x0),
        "large rotation": large_rotation_decay(tau, wall, e, x0),
    }
    return xr.Dataset(
        {"rocking_displacement": (("rocking_model", "tau"), np.stack([*histories.values()]))},
        coords={"rocking_model": list(histories), "tau": tau},
    )
