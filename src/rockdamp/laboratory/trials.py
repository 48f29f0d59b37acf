"""Measured trials of free rocking: ratios of velocity at each impact, and those that a damper predicts for a block."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

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
from rockdamp.mechanics.wall import Parapet
from rockdamp.solvers.newmark import simulate

KEY = ["group", "trial"]
COLUMNS = [
    *KEY,
    "duplicate_of_trial",
    "thickness_m",
    "height_m",
    "depth_m",
    "mass_kg",
    "impact",
    "ratio",
]


@dataclass(frozen=True, eq=False)
class Trials:
    """Trials of free rocking, those with the most impacts first.

    Parameters
    ----------
    ratio : ndarray, shape (trials, impacts)
        Angular velocity after an impact over that before it, NaN after a trial's last impact. [-]
    geometry : ndarray of int, shape (trials,)
        Index of each trial's block.
    housner : ndarray, shape (geometries,)
        Loss -ln e of each block by Housner's formula. [-]
    """

    ratio: Array
    geometry: NDArray[np.intp]
    housner: Array


def read_rocking_trials(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read trials of free rocking: a CSV with a commented header and the columns of `COLUMNS`, one row per impact.

    The impacts of a trial are numbered from 1 on without a gap; the blocks of a group have one size. A duplicate names
    the trial of its group that it repeats. Raises `InputError` for another table.
    """
    rows = pd.read_csv(path, comment="#")
    if [*rows.columns] != COLUMNS:
        raise InputError(
            f"{path}: columns are {', '.join(rows.columns)}; they must be {', '.join(COLUMNS)}"
        )
    complete = (
        rows.drop(columns="duplicate_of_trial")
        .apply(pd.to_numeric, errors="coerce")
        .notna()
        .all(axis=1)
    )
    if not complete.all():
        raise InputError(f"{path}: row {1 + int(np.argmin(complete))} lacks a number")
    numbered = rows["impact"] == rows.groupby(KEY).cumcount() + 1
    if not numbered.all():
        group, trial = rows.loc[~numbered, KEY].iloc[0]
        raise InputError(
            f"{path}: impacts of trial {trial} of group {group} must be 1, 2, ... in this order"
        )
    sizes = rows.groupby("group")[["thickness_m", "height_m"]].nunique().max(axis=1)
    if sizes.max() > 1:
        raise InputError(
            f"{path}: blocks of group {sizes.idxmax()} have {sizes.max()} sizes; they must have one"
        )
    return rows


def make_trials(rows: pd.DataFrame, impacts: int) -> Trials:
    """Return the ratios of the first impacts of each trial, without the duplicates."""
    blocks = rows.groupby("group")[["thickness_m", "height_m"]].first()
    table = rows[rows["duplicate_of_trial"].isna()].pivot_table(
        index=KEY, columns="impact", values="ratio"
    )
    table = table.loc[table.count(axis=1).sort_values(ascending=False, kind="stable").index]
    return Trials(
        ratio=table.to_numpy()[:, :impacts],
        geometry=blocks.index.get_indexer(table.index.get_level_values("group")),
        housner=-np.log(Parapet(*blocks.to_numpy().T).restitution_rigid),
    )


# --- predictions ------------------------------------------------------------------------------------------------------

# ASSUME: the blocks' curve is nearly rigid, bi-linear below twice u1; the data do not have the release. The loss of a
# rigid block under a viscous damper depends on the release, as the force falls with the displacement.
CURVE, RELEASE = TrilinearCurve(0.01, 0.98), 0.5
LARGEST_LOSS = 3.0  # of an impact after which the block all but rests; no prediction is larger
# First losses among which a trial's is searched: fine near 0, where slender blocks are, up to more than any trial's.
LOSSES = 0.35 * np.linspace(0.0, 1.0, 61) ** 1.5 + 1e-4


class Prediction(NamedTuple):
    """What a damper predicts for some first losses, shapes (impacts, *losses).

    `ratio` of the velocities at each impact, and `log_energy`, ln(V_k/V_1) before it.
    """

    ratio: Array
    log_energy: Array


Predict: TypeAlias = Callable[
    [Array, float], Prediction
]  # from first losses and the exponent, which a power law has


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


def predict_damper(model: str, impacts: int) -> Predict:
    """Return the prediction of a damper by decays of the solver, linear between them in the first loss."""
    # A quarter more than the largest loss: the closed form, which chooses the damping ratios, is of first order.
    restitution = np.exp(-1.25 * LOSSES)
    value = (
        restitution
        if model == REFERENCE
        else damping_ratio_energy(CURVE, model, restitution, RELEASE)
    )
    computed = losses_by_impact(Damping(model, value), impacts)
    computed = computed[np.argsort(computed[:, 0])]
    # The later losses over the first are smooth down to no loss at all.
    first, relative = computed[:, 0], computed / computed[:, :1]

    def predict(losses: Array, _: float = 0.0) -> Prediction:
        loss = np.array([np.interp(losses, first, column) for column in relative.T]) * losses
        loss = np.minimum(loss, LARGEST_LOSS)
        return Prediction(np.exp(-loss), -2.0 * (np.cumsum(loss, axis=0) - loss))

    return predict


def losses_by_impact(damping: Damping, impacts: int) -> Array:
    """Return the loss -ln(ratio) of each half cycle of decays, (lanes, impacts), `LARGEST_LOSS` after the last turn.

    The energy is V(x) at the turns: between impacts a rigid block loses nothing, so sqrt(V) at a turn over sqrt(V) at
    the one before is the ratio of velocities at the impact between them.
    """
    stored = (
        8  # steps of the solver per stored step; a block takes at least 6 of the solver to cross u1
    )
    step = float(CURVE.yield_displacement_ratio) / np.sqrt(2.0 * float(CURVE.energy(RELEASE))) / 6.0
    quarter = float(CURVE.period(RELEASE)) / 4.0  # an undamped quarter is the longest
    steps = stored * int(np.ceil((2 * impacts + 2) * quarter / step / stored))
    run = simulate(
        CURVE, damping, release_amplitude=RELEASE, step=step, steps=steps, store_every=stored
    )
    turned, _ = turning_points(run.displacement, run.velocity, stored * step)
    peaks = np.full((turned.shape[0], impacts + 1), np.nan)
    peaks[:, 0] = RELEASE
    peaks[:, 1 : 1 + turned.shape[1]] = np.abs(turned[:, :impacts])
    energy = np.where(np.isfinite(peaks), CURVE.energy(np.nan_to_num(peaks)), np.nan)
    return np.nan_to_num(-0.5 * np.diff(np.log(energy), axis=1), nan=LARGEST_LOSS).clip(
        0.0, LARGEST_LOSS
    )
