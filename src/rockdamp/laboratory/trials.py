"""Measured trials of free rocking: ratios of velocity at each impact, and those that a damper predicts for a block."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.constants import REFERENCE
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import turning_points
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate

COLUMNS = ("group", "trial", "duplicate_of_trial", "thickness_m", "height_m", "depth_m", "mass_kg", "impact", "ratio")
KEY = ["group", "trial"]


@dataclass(frozen=True)
class RockingTrials:
    """Trials of free rocking without the duplicates, those with the most impacts first.

    `ratio`, shape (trials, impacts), is the angular velocity after an impact over that before it, NaN after a trial's
    last impact [-]; `geometry` (trials,) the index of each trial's block, `thickness` and `height` (geometries,) the
    blocks' [m]. `impacts`, `trials` and `duplicates` count those of the file.
    """

    ratio: Array
    geometry: NDArray[np.intp]
    thickness: Array
    height: Array
    impacts: int
    trials: int
    duplicates: int


def read_rocking_trials(path: str | os.PathLike[str]) -> RockingTrials:
    """Read trials of free rocking: a CSV with a commented header and the columns of `COLUMNS`, a row an impact.

    The impacts of a trial are numbered from 1 on without a gap; the blocks of a group have one size. A trial that names
    another of its group in ``duplicate_of_trial`` is left out.
    """
    rows = pd.read_csv(path, comment="#")
    if tuple(rows.columns) != COLUMNS:
        raise InputError(f"{path}: columns are {', '.join(rows.columns)}; they must be {', '.join(COLUMNS)}")
    whole = rows.drop(columns="duplicate_of_trial").apply(pd.to_numeric, errors="coerce").notna().all(axis=1)
    if not whole.all():
        raise InputError(f"{path}: row {1 + int(np.argmin(whole))} lacks a number")
    numbered = rows["impact"] == rows.groupby(KEY).cumcount() + 1
    if not numbered.all():
        group, trial = rows.loc[~numbered, KEY].iloc[0]
        raise InputError(f"{path}: impacts of trial {trial} of group {group} must be 1, 2, ... in this order")
    sizes = rows[["group", "thickness_m", "height_m"]].drop_duplicates().set_index("group").sort_index()
    if sizes.index.has_duplicates:
        group = sizes.index[sizes.index.duplicated()][0]
        raise InputError(f"{path}: blocks of group {group} have two sizes; they must have one")
    table = rows[rows["duplicate_of_trial"].isna()].pivot_table(index=KEY, columns="impact", values="ratio")
    table = table.loc[table.notna().sum(axis=1).sort_values(ascending=False, kind="stable").index]
    trials = rows.groupby(KEY).ngroups
    return RockingTrials(
        ratio=table.to_numpy(),
        geometry=sizes.index.get_indexer(table.index.get_level_values("group")),
        thickness=sizes["thickness_m"].to_numpy(),
        height=sizes["height_m"].to_numpy(),
        impacts=len(rows),
        trials=trials,
        duplicates=trials - len(table),
    )


# --- predictions ------------------------------------------------------------------------------------------------------

# ASSUME: the blocks' curve is nearly rigid, bi-linear but below twice u1; the data do not have the release. The loss of
# a rigid block under a viscous damper depends on it, as the force falls with the displacement.
CURVE, RELEASE = TrilinearCurve(0.01, 0.98), 0.5
LARGEST_LOSS = 3.0  # of an impact after which the block all but rests; no prediction goes beyond it
# First losses among which a trial's is looked for: fine near 0, where slender blocks are, and beyond any trial.
LOSSES = 0.35 * np.linspace(0.0, 1.0, 61) ** 1.5 + 1e-4
FIRST_BRANCH_STEPS = 6.0  # of the solver, at least, in which a block crosses u1
STORED = 8  # steps of the solver to one that is stored
MARGIN = 1.25  # beyond the largest first loss: the closed form, which chooses the damping ratios, is of first order


class Prediction(NamedTuple):
    """What a damper predicts for some first losses, shapes (impacts, *losses).

    `ratio` of the velocities at each impact, and `log_energy`, ln(V_k/V_1) before it.
    """

    ratio: Array
    log_energy: Array


def power_law(losses: Array, exponent: float, impacts: int) -> Prediction:
    """Return the prediction of a loss per impact in proportion to the energy left, to the power of an exponent.

    Exponent 0 is one coefficient of restitution.
    """
    log_energy, ratio, energies = np.zeros(losses.shape), [], []
    for _ in range(impacts):
        loss = np.minimum(losses * np.exp(exponent * log_energy), LARGEST_LOSS)
        energies.append(log_energy)
        ratio.append(np.exp(-loss))
        log_energy = log_energy - 2.0 * loss
    return Prediction(np.array(ratio), np.array(energies))


def losses_by_impact(damping: Damping, impacts: int) -> Array:
    """Return the loss delta of each half cycle of decays, (lanes, impacts), `LARGEST_LOSS` after the last turn.

    The energy is that at the turns, V(x): between impacts a rigid block loses nothing, so sqrt(V) at a turn over that
    at the one before is the ratio of velocities at the impact between them.
    """
    fastest = np.sqrt(2.0 * float(CURVE.energy(RELEASE)))
    step = float(CURVE.yield_displacement_ratio) / fastest / FIRST_BRANCH_STEPS
    quarter = float(CURVE.period(RELEASE)) / 4.0  # an undamped quarter is the longest
    steps = STORED * int(np.ceil((2 * impacts + 2) * quarter / step / STORED))
    run = simulate(CURVE, damping, release_amplitude=RELEASE, step=step, steps=steps, store_every=STORED)
    turned, _ = turning_points(run.displacement, run.velocity, STORED * step)
    peaks = np.full((turned.shape[0], impacts + 1), np.nan)
    peaks[:, 0] = RELEASE
    peaks[:, 1 : 1 + turned.shape[1]] = np.abs(turned[:, :impacts])
    energy = np.where(np.isfinite(peaks), CURVE.energy(np.nan_to_num(peaks)), np.nan)
    return np.nan_to_num(-0.5 * np.diff(np.log(energy), axis=1), nan=LARGEST_LOSS).clip(0.0, LARGEST_LOSS)


class DamperLosses:
    """The losses of a damper by the solver's decays, linear between them in the first loss."""

    def __init__(self, model: str, impacts: int) -> None:
        restitution = np.exp(-MARGIN * LOSSES)
        value = restitution if model == REFERENCE else damping_ratio_energy(CURVE, model, restitution, RELEASE)
        loss = losses_by_impact(Damping(model, value), impacts)
        loss = loss[np.argsort(loss[:, 0])]
        # The later losses over the first are smooth down to no loss at all.
        self.first, self.relative = loss[:, 0], loss / loss[:, :1]

    def __call__(self, losses: Array) -> Prediction:
        """Return the prediction for first losses."""
        relative = [np.interp(losses, self.first, column) for column in self.relative.T]
        loss = np.minimum(np.array(relative) * losses, LARGEST_LOSS)
        return Prediction(np.exp(-loss), -2.0 * (np.cumsum(loss, axis=0) - loss))
