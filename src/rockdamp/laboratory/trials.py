"""Measured trials of free rocking, and ratios of velocity that a damper predicts for a block."""

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

TRIAL_KEY = ["group", "trial"]
TRIAL_COLUMNS = [
    *TRIAL_KEY,
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
        Angular velocity after an impact divided by that before; NaN after a trial's last one. [-]
    geometry : ndarray of int, shape (trials,)
        Index of each trial's block.
    housner : ndarray, shape (geometries,)
        Loss -ln e of each block by Housner's formula. [-]
    """

    ratio: Array
    geometry: NDArray[np.intp]
    housner: Array


def read_rocking_trials(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read trials of free rocking.

    Parameters
    ----------
    path : path-like
        CSV with a commented header and the columns `TRIAL_COLUMNS`, one row per impact. The impacts
        of a trial are numbered from 1 without a gap; the blocks of a group have one size. A
        duplicate names the trial of its group that it repeats.

    Raises
    ------
    InputError
        If the table is not of this form.
    """
    rows = pd.read_csv(path, comment="#")
    if [*rows.columns] != TRIAL_COLUMNS:
        raise InputError(
            f"{path}: columns are {', '.join(rows.columns)};"
            f" they must be {', '.join(TRIAL_COLUMNS)}"
        )
    required = rows.drop(columns="duplicate_of_trial")
    is_complete = required.apply(pd.to_numeric, errors="coerce").notna().all(axis=1)
    if not is_complete.all():
        raise InputError(f"{path}: row {1 + int(np.argmin(is_complete))} lacks a number")
    is_in_order = rows["impact"] == rows.groupby(TRIAL_KEY).cumcount() + 1
    if not is_in_order.all():
        group, trial = rows.loc[~is_in_order, TRIAL_KEY].iloc[0]
        raise InputError(
            f"{path}: impacts of trial {trial} of group {group} must be 1, 2, ... in this order"
        )
    size_counts = rows.groupby("group")[["thickness_m", "height_m"]].nunique().max(axis=1)
    if size_counts.max() > 1:
        raise InputError(
            f"{path}: blocks of group {size_counts.idxmax()} have {size_counts.max()} sizes;"
            " they must have one"
        )
    return rows


def make_trials(rows: pd.DataFrame, impacts: int) -> Trials:
    """Return the ratios of the first impacts of each trial, without the duplicates."""
    blocks = rows.groupby("group")[["thickness_m", "height_m"]].first()
    originals = rows[rows["duplicate_of_trial"].isna()]
    table = originals.pivot_table(index=TRIAL_KEY, columns="impact", values="ratio")
    order = table.count(axis=1).sort_values(ascending=False, kind="stable").index
    table = table.loc[order]
    thickness, height = blocks.to_numpy().T
    return Trials(
        ratio=table.to_numpy()[:, :impacts],
        geometry=blocks.index.get_indexer(table.index.get_level_values("group")),
        housner=-np.log(Parapet(thickness, height).restitution_rigid),
    )


# --- predictions ----------------------------------------------------------------------------------

# ASSUME: the blocks' curve is nearly rigid, bi-linear below twice u1; the data do not state the
# release. The loss of a rigid block under a viscous damper depends on the release, as the force
# falls with the displacement.
BLOCK_CURVE = TrilinearCurve(0.01, 0.98)
BLOCK_RELEASE = 0.5
# Largest loss of a prediction, e = 0.05: after such an impact the block all but rests.
RESTING_LOSS = 3.0
# First losses among which a trial's is searched: fine near 0, where slender blocks are, up to more
# than any trial's.
FIRST_LOSSES = 0.35 * np.linspace(0.0, 1.0, 61) ** 1.5 + 1e-4


class Prediction(NamedTuple):
    """Prediction of a damper for given losses of the first impact, an array of any shape.

    Parameters
    ----------
    ratio : ndarray, shape (impacts, *losses)
        Ratio of the velocities at each impact. [-]
    log_energy : ndarray, shape (impacts, *losses)
        ln(V_k/V_1), with V_k the energy before impact k. [-]
    """

    ratio: Array
    log_energy: Array


# A function of first losses and of the exponent of a power law, which dampers ignore.
Predict: TypeAlias = Callable[[Array, float], Prediction]


def power_law(losses: Array, exponent: float, impacts: int) -> Prediction:
    """Return the prediction of a loss proportional to a power of the remaining energy.

    Parameters
    ----------
    losses : ndarray
        Losses -ln e of the first impact. [-]
    exponent : float
        Exponent of the energy; 0 is one restitution coefficient for all impacts. [-]
    impacts : int
        Number of impacts.
    """
    log_energy = np.zeros(losses.shape)
    ratios = []
    log_energies = []
    for _ in range(impacts):
        loss = np.minimum(losses * np.exp(exponent * log_energy), RESTING_LOSS)
        log_energies.append(log_energy)
        ratios.append(np.exp(-loss))
        log_energy = log_energy - 2.0 * loss
    return Prediction(np.array(ratios), np.array(log_energies))


def predict_damper(model: str, impacts: int) -> Predict:
    """Return the function that predicts a damper's ratios, by interpolation of solved decays."""
    # A quarter more than the largest loss, as the closed form that chooses the damping ratios is of
    # first order.
    restitution = np.exp(-1.25 * FIRST_LOSSES)
    if model == REFERENCE:
        damping = Damping(model, restitution)
    else:
        xi = damping_ratio_energy(BLOCK_CURVE, model, restitution, BLOCK_RELEASE)
        damping = Damping(model, xi)
    losses_of_decays = losses_by_impact(damping, impacts)
    losses_of_decays = losses_of_decays[np.argsort(losses_of_decays[:, 0])]
    first = losses_of_decays[:, 0]
    # The later losses over the first are smooth down to no loss at all.
    relative = losses_of_decays / losses_of_decays[:, :1]

    def predict(losses: Array, _: float = 0.0) -> Prediction:
        factors = np.array([np.interp(losses, first, column) for column in relative.T])
        loss = np.minimum(factors * losses, RESTING_LOSS)
        # ln(V_k/V_1) is minus twice the sum of the losses before impact k.
        return Prediction(np.exp(-loss), -2.0 * (np.cumsum(loss, axis=0) - loss))

    return predict


def losses_by_impact(damping: Damping, impacts: int) -> Array:
    """Return the loss -ln(ratio) of each half cycle of decays, shape (lanes, impacts).

    Between impacts a rigid block loses nothing, so that sqrt(V) at a turn over sqrt(V) at the one
    before is the ratio of velocities at the impact between them. After the last turn the loss is
    `RESTING_LOSS`.
    """
    substeps = 8  # steps of the solver per stored step
    # ASSUME: six steps resolve the crossing of the first branch at the largest speed.
    speed = np.sqrt(2.0 * float(BLOCK_CURVE.energy(BLOCK_RELEASE)))
    step = float(BLOCK_CURVE.yield_displacement_ratio) / speed / 6.0
    quarter = float(BLOCK_CURVE.period(BLOCK_RELEASE)) / 4.0  # an undamped quarter is the longest
    steps = substeps * int(np.ceil((2 * impacts + 2) * quarter / step / substeps))
    histories = simulate(
        BLOCK_CURVE,
        damping,
        release_amplitude=BLOCK_RELEASE,
        step=step,
        steps=steps,
        store_every=substeps,
    )
    turns, _ = turning_points(histories.displacement, histories.velocity, substeps * step)
    peaks = np.full((turns.shape[0], impacts + 1), np.nan)
    peaks[:, 0] = BLOCK_RELEASE
    peaks[:, 1 : 1 + turns.shape[1]] = np.abs(turns[:, :impacts])
    energy = np.where(np.isfinite(peaks), BLOCK_CURVE.energy(np.nan_to_num(peaks)), np.nan)
    losses = -0.5 * np.diff(np.log(energy), axis=1)
    return np.nan_to_num(losses, nan=RESTING_LOSS).clip(0.0, RESTING_LOSS)
