"""Energy audit: what impacts and dampers take equals what leaves the wall, to the order of the scheme; in joules.

Dimensionless as in the kernels, a wall has the energy v^2/2 + V(x). An impact takes (1 - e^2) v^2/2, Eq. (13); a damper
takes the integral of C v^2 by tau, Eq. (14); the load does the work of its product with v.

**Joules.** Times K0 u_ins^2 these are 1/2 m_eff u'^2 + integral F du: energies of the generalised coordinate, *twice*
the mechanical ones. The lower body turns about its base at u'/h1 and the upper one about its top at u'/h2; slender
bodies have m_i h_i^2/3 about their ends, so

    T = 1/2 (m1 h1^2/3) (u'/h1)^2 + 1/2 (m2 h2^2/3) (u'/h2)^2 = 1/2 (m/3) u'^2 = 1/2 (1/2 m_eff u'^2),

as m_eff = 2 m/3. Likewise the weights' work is the integral of F/2: Eq. (1) counts forces double, as its load shows,
lambda m_eff = m, where a load m a_g spread over the face does work over the mean displacement u/2. A parapet with u at
its top has 1/2 (m h^2/3) (u'/h)^2: the same half. Eq. (13), with moments of inertia and velocities of the centres, is
mechanical as it is printed; Eq. (14), of C u' du, is generalised, and takes the factor 1/2 to be compared with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from operator import itemgetter

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.config.study import Study
from rockdamp.histories.half_cycles import passes_zero, turning_points
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.base import IMPACT
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.studies.accuracy.convergence import EXCITATIONS, Ensemble, fitted_order
from rockdamp.vocabulary import MODELS

MECHANICAL_SHARE = 0.5  # mechanical over generalised energy
HALF_CYCLES = 6  # of which the loss is given in joules


@dataclass(frozen=True)
class Balance:
    """The energy of histories and where it went, over K0 u_ins^2; every array has the histories' shape, time last. [-]

    `energy` is v^2/2 + V(x). `lost` went to impacts and dampers since the start, and `work` was done by the load.
    """

    energy: Array
    lost: Array
    work: Array

    @property
    def residual(self) -> Array:
        """Energy that left and was not lost: zero but for the scheme's error. [-]"""
        return self.energy[..., :1] + self.work - self.lost - self.energy

    @property
    def largest_residual(self) -> Array:
        """Largest |residual| of each history over the most energy that it was given until then. [-]"""
        most = (self.energy[..., :1] + self.work).max(axis=-1)
        return np.abs(self.residual).max(axis=-1) / most


def balance(
    curve: TrilinearCurve,
    damping: Damping,
    displacement: ArrayLike,
    velocity: ArrayLike,
    step: float,
    load: ArrayLike = 0.0,
) -> Balance:
    """Add up the energy of stored histories from displacement and velocity at each step, shape (..., n).

    The damper's integral is the trapezoidal sum. The load's is its mean over a step times the change of x, as x has no
    jump at an impact. Each is second order in the step, as is the velocity at an impact: see `_impact_loss`.
    """
    x, v = np.asarray(displacement, dtype=float), np.asarray(velocity, dtype=float)
    p = np.broadcast_to(np.asarray(load, dtype=float), x.shape)
    each = curve.map(lambda parameter: parameter[..., None])
    if damping.step_kind == IMPACT:
        lost = _impact_loss(each, damping.restitution[..., None], x, v, p, step)
    else:
        own = damping.map(lambda parameter: parameter[..., None])
        rate = own.coefficient(each, x, v) * v**2
        lost = step * (rate[..., 1:] + rate[..., :-1]) / 2
    work = (p[..., 1:] + p[..., :-1]) / 2 * np.diff(x, axis=-1)
    return Balance(v**2 / 2 + each.energy(x), _since_start(lost), _since_start(work))


def _since_start(parts: Array) -> Array:
    total = np.zeros((*parts.shape[:-1], parts.shape[-1] + 1))
    np.cumsum(parts, axis=-1, out=total[..., 1:])
    return total


def _impact_loss(curve: TrilinearCurve, restitution: Array, x: Array, v: Array, load: Array, step: float) -> Array:
    """(1 - e^2) v^2/2 in each step in which x reaches or passes zero, v being the velocity there; zero elsewhere. [-]

    The time to the impact is that of the parabola from the step's start, and v follows from the mean of the
    acceleration there and at the impact, where the restoring force is zero and the load's is all.
    """
    before, speed = x[..., :-1], v[..., :-1]
    hit = passes_zero(x)
    acceleration = load[..., :-1] - curve.force(before)
    away = np.where(before > 0, speed, -speed)
    root = np.sqrt(np.maximum(speed**2 - 2 * acceleration * before, 0.0))
    span = np.where(hit, root - away, 1.0)
    time = np.clip(np.where(hit, 2 * np.abs(before), 0.0) / np.where(span > 0, span, 1.0), 0.0, step)
    there = load[..., :-1] + (load[..., 1:] - load[..., :-1]) * time / step
    arriving = speed + time * (acceleration + there) / 2
    return np.where(hit, (1 - restitution**2) * arriving**2 / 2, 0.0)


def joules(wall: Wall | Parapet, energy: ArrayLike) -> Array:
    """Mechanical energy of a dimensionless one, MECHANICAL_SHARE K0 u_ins^2 times it. [J]"""
    scale = wall.rigid_stiffness * np.square(wall.instability_displacement)
    return MECHANICAL_SHARE * scale * np.asarray(energy, dtype=float)


def lost_per_half_cycle(curve: TrilinearCurve, damping: Damping, x: Array, v: Array, step: float, count: int) -> Array:
    """Return the loss of one free history from each peak to the next, `count` values; NaN where it has fewer. [-]

    Eq. (13) for CR, whose half cycles hold one impact each, and Eq. (14) for dampers.
    """
    turns = turning_points(v)
    lost = np.diff(balance(curve, damping, x, v, step).lost[turns])[:count]
    return np.concatenate([lost, np.full(count - lost.size, np.nan)])


# --- the stage's parts ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Audited:
    """A wall, and its histories under restitution and under each damper matched to it, as in `damping_force.nc`."""

    wall: Wall
    curve: TrilinearCurve
    restitution: float
    histories: xr.Dataset

    def damping(self, model: str) -> Damping:
        """Return what damps the history of one model."""
        ratio = float(self.histories["damping_ratio"].sel(damping_model=model))
        return Damping.from_values(model, restitution=self.restitution, damping_ratio=ratio)


def residuals(ensemble: Ensemble, step: float) -> xr.Dataset:
    """Audit the ensemble at steps down to half of `step`: median and largest residual, and the median's order."""
    steps = ensemble.steps[ensemble.steps > 0.4 * step]
    largest = np.empty((len(EXCITATIONS), len(MODELS), steps.size, ensemble.factor.size))
    for x, m, k in np.ndindex(largest.shape[:-1]):
        load = ensemble.load_at(float(steps[k])) if EXCITATIONS[x] == "forced" else 0.0
        histories = ensemble.histories(MODELS[m], EXCITATIONS[x], float(steps[k]), 1)
        sums = balance(ensemble.curve, ensemble.damping(MODELS[m]), *histories, float(steps[k]), load)
        largest[x, m, k] = sums.largest_residual.ravel()
    median = np.median(largest, axis=-1)
    dims = ("excitation", "damping_model")
    return xr.Dataset(
        {
            "energy_residual": ((*dims, "audit_step"), median),
            "largest_energy_residual": ((*dims, "audit_step"), largest.max(axis=-1)),
            "energy_order": (dims, fitted_order(steps, median)),
        },
        coords={"excitation": list(EXCITATIONS), "damping_model": list(MODELS), "audit_step": steps},
    )


def stored(loops: Audited, decays: Mapping[str, xr.Dataset], studies: Mapping[str, Study], step: float) -> xr.Dataset:
    """Audit all histories in `damping_force.nc` and all decays of the studies as stored: largest residuals."""
    of_loops = []
    for model in MODELS:
        history = loops.histories.sel(damping_model=model)
        x, v = history["displacement"].values, history["velocity"].values
        of_loops.append(float(balance(loops.curve, loops.damping(model), x, v, step).largest_residual))
    of_decays = []
    for name, decay in decays.items():
        study, damping = studies[name], Damping.cr(decay["restitution"].values)
        worst = 0.0
        for i in range(study.values.size):  # one wall at a time, for the memory's sake
            own = study.curve.map(itemgetter(slice(i, i + 1)))
            sums = balance(own, damping, decay["displacement"].values[i], decay["velocity"].values[i], step)
            worst = max(worst, float(sums.largest_residual.max()))
        of_decays.append(worst)
    return xr.Dataset(
        {"damping_force_energy_residual": ("damping_model", of_loops), "decay_energy_residual": ("study", of_decays)},
        coords={"damping_model": list(MODELS), "study": list(decays)},
    )


def losses(audited: Mapping[str, Audited], release_amplitude: float, step: float) -> xr.Dataset:
    """Energy in joules that each half cycle of the histories loses; they start from `release_amplitude`."""
    walls = list(audited.values())
    lost = np.empty((len(walls), len(MODELS), HALF_CYCLES))
    for (w, own), (m, model) in product(enumerate(walls), enumerate(MODELS)):
        history = own.histories.sel(damping_model=model)
        x, v, damping = history["displacement"].values, history["velocity"].values, own.damping(model)
        lost[w, m] = joules(own.wall, lost_per_half_cycle(own.curve, damping, x, v, step, HALF_CYCLES))
    release = [float(joules(own.wall, own.curve.energy(release_amplitude))) for own in walls]
    ratio = [own.histories["damping_ratio"].sel(damping_model=list(MODELS)).values for own in walls]
    return xr.Dataset(
        {
            "energy_lost": (("audited_wall", "damping_model", "half_cycle"), lost),
            "release_energy": ("audited_wall", release),
            "audited_damping_ratio": (("audited_wall", "damping_model"), np.stack(ratio)),
            "audited_restitution": ("audited_wall", [own.restitution for own in walls]),
        },
        coords={
            "audited_wall": list(audited),
            "damping_model": list(MODELS),
            "half_cycle": np.arange(1, HALF_CYCLES + 1),
        },
    )
