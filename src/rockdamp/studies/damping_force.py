"""Matched histories and the loops of their damping forces (Fig. 3), and rigid rocking (Fig. 4)."""

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

# Exponent of the secant frequency to which C is proportional. ECD has none: its C depends on the
# energy frequency, which is no function of the secant frequency alone.
FREQUENCY_EXPONENTS = {"CDC": 0.0, "CDR": 1.0, "SDR": 2.0}


def damping_force(config: Config) -> xr.Dataset:
    """Return decays of CR and of the viscous models matched to it, and those of Fig. 4a."""
    parts = [_match_reference(config), _frequency_laws(), _rocking_decays(config)]
    return xr.merge(parts, compat="no_conflicts").assign_coords(
        restitution=config.damping_force.restitution,
        release_amplitude=config.release_amplitude,
        rocking_restitution=config.damping_force.rigid.restitution,
    )


def _match_reference(config: Config) -> xr.Dataset:
    """Return the decay under CR, and that of each viscous model matched to it."""
    curve = config.curve.make()
    e = config.damping_force.restitution
    x0 = config.release_amplitude
    step = config.solver.step
    length = max(config.damping_force.response_length, config.matching.response_length)
    matches = match_decays(
        curve.map(np.atleast_1d),
        np.array([x0]),
        np.array([e]),
        VISCOUS_MODELS,
        config.matching,
        config.solver,
    )
    ratios = {model: float(match.damping_ratio[0]) for model, match in matches.items()}
    dampings = {REFERENCE: Damping(REFERENCE, e)}
    dampings |= {model: Damping(model, xi) for model, xi in ratios.items()}
    decays = damped_decays(
        curve,
        dampings,
        x0,
        step=step,
        steps=step_count(length, step),
        scheme=config.solver.scheme,
    )
    return decays.assign(damping_ratio=("damping_model", [np.nan, *ratios.values()]))


def _frequency_laws() -> xr.Dataset:
    """Return xi(w)/xi of each model against w/w1, from C = 2 m_eff w xi(w): Fig. 3, left."""
    w = np.linspace(0.0, 1.0, 101)
    laws = np.full((len(VISCOUS_MODELS), w.size), np.nan)
    for model, exponent in FREQUENCY_EXPONENTS.items():
        # CDC keeps C of the first branch: at w = 0 its ratio to the vanishing critical damping has
        # no bound.
        at_zero = 0.0 if exponent > 1 else np.nan
        with np.errstate(divide="ignore"):
            law = np.where(w > 0, w ** (exponent - 1), at_zero)
        laws[VISCOUS_MODELS.index(model)] = law
    return xr.Dataset(
        {"damping_ratio_law": (("viscous_model", "frequency_ratio"), laws)},
        coords={"viscous_model": list(VISCOUS_MODELS), "frequency_ratio": w},
    )


def _rocking_decays(config: Config) -> xr.Dataset:
    """Return the decay of the nearly rigid wall of Fig. 4a and those of two rigid bodies."""
    # ASSUME: Fig. 4a names neither its curve nor its hinge height; the config states them (nearly
    # rigid, mid-height).
    rigid = config.damping_force.rigid
    e = rigid.restitution
    x0 = rigid.release_amplitude
    step = config.solver.step
    steps = step_count(config.damping_force.response_length, step)
    tau = step * np.arange(steps + 1)
    # The first branch of a nearly rigid curve is three times as fast as that of the paper's curve:
    # at the step of the other histories its error would be six times theirs.
    refinement = 8
    trilinear = simulate(
        rigid.curve,
        Damping(REFERENCE, e),
        release_amplitude=x0,
        step=step / refinement,
        steps=steps * refinement,
        store_every=refinement,
        scheme=config.solver.scheme,
    )
    histories = {
        "tri-linear": trilinear.displacement,
        "slender": slender_decay(tau, e, x0),
        "large rotation": large_rotation_decay(tau, rigid.wall, e, x0),
    }
    displacement = np.stack(list(histories.values()))
    return xr.Dataset(
        {"rocking_displacement": (("rocking_model", "tau"), displacement)},
        coords={"rocking_model": list(histories), "tau": tau},
    )
