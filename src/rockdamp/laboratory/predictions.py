"""The ratios that each damper predicts for a block, by the package's solver on a curve that is nearly rigid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.histories.half_cycles import turns
from rockdamp.laboratory.velocity_ratios import LOSSES, MOST, Prediction
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import REFERENCE

FIRST_BRANCH_STEPS = 6.0  # of the solver, at least, in which a block released as far as 0.9 u_ins crosses u1
STORED = 8  # steps of the solver to one that is stored
BEYOND = 1.25  # of the largest first loss: the closed form, which chooses the damping ratios, is of first order


@dataclass(frozen=True)
class NearlyRigid:
    """A curve like a rigid block's, and the displacement from which the block is released."""

    # ASSUME: the data do not have the release. The loss of a rigid block depends on it, as the force falls with the
    # displacement, so the study varies it.
    yield_displacement_ratio: float
    release_amplitude: float

    @property
    def curve(self) -> TrilinearCurve:
        """A curve that leaves the bi-linear law only below twice u1."""
        return TrilinearCurve(self.yield_displacement_ratio, 1.0 - 2.0 * self.yield_displacement_ratio)


def dampings(block: NearlyRigid, model: str, exponent: float = 0.0) -> Damping:
    """Return a damper with values that lose from nothing to more than the largest of `LOSSES` at the first impact."""
    restitution = np.exp(-BEYOND * LOSSES)
    if model == REFERENCE:
        return Damping.cr(restitution)
    ratio = damping_ratio_energy(block.curve, model, restitution, block.release_amplitude, exponent)
    return Damping.from_values(model, damping_ratio=ratio, exponent=exponent)


def losses_by_impact(block: NearlyRigid, damping: Damping, impacts: int) -> Array:
    """Return the loss delta of each half cycle of decays, shape (lanes, impacts), `MOST` after the last turn.

    The energy is that at the turns, V(x): between impacts a rigid block loses nothing, so sqrt(V) at a turn over that
    at the one before is the ratio of velocities at the impact between them.
    """
    curve, release = block.curve, block.release_amplitude
    fastest = np.sqrt(2.0 * float(curve.energy(release)))
    step = block.yield_displacement_ratio / fastest / FIRST_BRANCH_STEPS
    quarter = float(curve.period(release)) / 4.0  # an undamped quarter is the longest
    steps = STORED * int(np.ceil((2 * impacts + 2) * quarter / step / STORED))
    run = solve(curve, damping, release_amplitude=release, step=step, steps=steps, store_every=STORED)
    turned, _ = turns(run.displacement, run.velocity, STORED * step)
    peaks = np.full((turned.shape[0], impacts + 1), np.nan)
    peaks[:, 0] = release
    peaks[:, 1 : 1 + turned.shape[1]] = np.abs(turned[:, :impacts])
    energy = np.where(np.isfinite(peaks), curve.energy(np.nan_to_num(peaks)), np.nan)
    return np.nan_to_num(-0.5 * np.diff(np.log(energy), axis=1), nan=MOST).clip(0.0, MOST)


def by_solver(block: NearlyRigid, model: str, impacts: int, exponent: float = 0.0) -> Callable[[Array], Prediction]:
    """Return what predicts the ratios for first losses: the solver's decays, linear between them in the first loss."""
    loss = losses_by_impact(block, dampings(block, model, exponent), impacts)
    order = np.argsort(loss[:, 0])
    first, relative = loss[order, 0], loss[order] / loss[order, :1]

    def predict(losses: Array) -> Prediction:
        right = np.clip(np.searchsorted(first, losses), 1, first.size - 1)
        share = np.clip((losses - first[right - 1]) / (first[right] - first[right - 1]), 0.0, 1.0)
        # The later losses over the first are smooth down to no loss at all.
        each = relative[right - 1] + share[..., None] * (relative[right] - relative[right - 1])
        loss = np.moveaxis(np.minimum(each * losses[..., None], MOST), -1, 0)
        return Prediction(np.exp(-loss), -2.0 * (np.cumsum(loss, axis=0) - loss))

    return predict
