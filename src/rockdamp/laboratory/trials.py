"""Measured trials of free rocking: ratios of velocity at each impact, and those that a damper predicts for a block."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.constants import REFERENCE
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import turning_points
from rockdamp.laboratory.velocity_ratios import LOSSES, MOST, Prediction
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate
from rockdamp.storage.files import read_text

COLUMNS = (
    "group",
    "trial",
    "duplicate_of_trial",
    "thickness_m",
    "height_m",
    "depth_m",
    "mass_kg",
    "impact",
    "ratio",
)
WHOLE = ("group", "trial", "duplicate_of_trial", "impact")  # numbers
DUPLICATE = "duplicate_of_trial"  # empty where the trial is none
HEADER = ("specimen", "source", "licence", "meaning", "synthetic")  # keys that must stand there
KEY = ["group", "trial"]


@dataclass(frozen=True)
class RockingTrials:
    """Trials of free rocking without the duplicates, those with the most impacts first.

    `ratio`, shape (trials, impacts), is the angular velocity after an impact over that before it, NaN after a trial's
    last impact [-]; `geometry` (trials,) the index of each trial's block, `thickness` and `height` (geometries,) the
    blocks' [m]. `impacts`, `trials` and `duplicates` count those of the file; `source` says who measured them.
    """

    ratio: Array
    geometry: NDArray[np.intp]
    thickness: Array
    height: Array
    impacts: int
    trials: int
    duplicates: int
    source: str

    @property
    def slenderness(self) -> Array:
        """Height over thickness of each geometry, shape (geometries,). [-]"""
        return self.height / self.thickness


def read_rocking_trials(path: str | os.PathLike[str]) -> RockingTrials:
    """Read trials of free rocking: a CSV with a commented header and the columns of `COLUMNS`, a row an impact.

    The impacts of a trial are numbered from 1 on without a gap; its block has one size. A trial that names another of
    its group in ``duplicate_of_trial`` must equal it, and is left out. It raises `InputError` where a key of the
    header, a column, an impact or a number is missing, or two rows disagree.
    """
    shown = os.fspath(path)
    text = read_text(path)
    try:
        return _trials(_rows(text), _header(text))
    except InputError as error:
        raise InputError(f"{shown}: {error}") from None


def _header(text: str) -> dict[str, str]:
    lines = [line[1:].partition(":") for line in text.splitlines() if line.startswith("#")]
    header = {key.strip().lower(): value.strip() for key, _, value in lines}
    for key in HEADER:
        if not header.get(key):
            raise InputError(f"the header lacks {key!r}; it must have {', '.join(HEADER)}")
    if header["synthetic"] != "no":
        raise InputError(f"synthetic is {header['synthetic']!r}; it must be no, as the trials are measured")
    return header


def _rows(text: str) -> pd.DataFrame:
    try:
        read = pd.read_csv(io.StringIO(text), comment="#", dtype=str, keep_default_na=False)
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"cannot be read as a CSV ({str(error).strip()})") from None
    if list(read.columns) != list(COLUMNS):
        raise InputError(f"the columns are {', '.join(map(str, read.columns))}; they must be {', '.join(COLUMNS)}")
    if not len(read):
        raise InputError("there are no impacts; there must be at least one")
    rows = read.apply(pd.to_numeric, errors="coerce")
    for name in COLUMNS:
        values = rows[name].to_numpy(dtype=float)
        good = np.isfinite(values) & ((name not in WHOLE) | (values == np.round(values)))
        good |= (read[name] == "").to_numpy() & (name == DUPLICATE)
        if not good.all():
            row, kind = int(np.argmin(good)), "a whole number" if name in WHOLE else "a number"
            raise InputError(f"{name} in row {row + 1} is {read[name].iloc[row]!r}; it must be {kind}")
    return rows


def _trials(rows: pd.DataFrame, header: dict[str, str]) -> RockingTrials:
    for (group, trial), one in rows.groupby(KEY):
        label = f"trial {trial} of group {group}"
        if (one["impact"].to_numpy() != np.arange(1, len(one) + 1)).any():
            raise InputError(f"the impacts of {label} are not 1, 2, ... in this order; none may be missing")
        if len(one[[DUPLICATE, "thickness_m", "height_m", "depth_m", "mass_kg"]].drop_duplicates()) > 1:
            raise InputError(f"the rows of {label} state two blocks or two duplicates; they must state one")
    sizes = rows[["group", "thickness_m", "height_m"]].drop_duplicates()
    if sizes["group"].duplicated().any():
        group = int(sizes.loc[sizes["group"].duplicated(), "group"].iloc[0])
        raise InputError(f"group {group} has blocks of two sizes; it must have one")
    if not ((sizes["thickness_m"] > 0) & (sizes["height_m"] > 0)).all():
        raise InputError("a thickness or a height is not greater than 0 [m]")
    table = rows.pivot_table(index=KEY, columns="impact", values="ratio")
    ratios = {key: row.to_numpy() for key, row in table.iterrows()}
    others = rows.groupby(KEY)[DUPLICATE].first().dropna()
    for (group, trial), other in others.items():  # type: ignore[misc]
        if not np.array_equal(ratios[group, trial], ratios.get((group, int(other)), np.empty(0)), equal_nan=True):
            raise InputError(f"trial {trial} of group {group} is no duplicate of trial {other:g}; they must be equal")
    whole, sizes = table.drop(index=others.index), sizes.set_index("group").sort_index()
    whole = whole.loc[whole.notna().sum(axis=1).sort_values(ascending=False, kind="stable").index]
    return RockingTrials(
        ratio=whole.to_numpy(),
        geometry=sizes.index.get_indexer(whole.index.get_level_values("group")),
        thickness=sizes["thickness_m"].to_numpy(),
        height=sizes["height_m"].to_numpy(),
        impacts=len(rows),
        trials=len(table),
        duplicates=len(others),
        source=header["source"],
    )


# --- predictions ------------------------------------------------------------------------------------------------------

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


def dampings(block: NearlyRigid, model: str) -> Damping:
    """Return a damper with values that lose from nothing to more than the largest of `LOSSES` at the first impact."""
    restitution = np.exp(-BEYOND * LOSSES)
    if model == REFERENCE:
        return Damping("CR", restitution)
    return Damping(model, damping_ratio_energy(block.curve, model, restitution, block.release_amplitude))


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
    run = simulate(curve, damping, release_amplitude=release, step=step, steps=steps, store_every=STORED)
    turned, _ = turning_points(run.displacement, run.velocity, STORED * step)
    peaks = np.full((turned.shape[0], impacts + 1), np.nan)
    peaks[:, 0] = release
    peaks[:, 1 : 1 + turned.shape[1]] = np.abs(turned[:, :impacts])
    energy = np.where(np.isfinite(peaks), curve.energy(np.nan_to_num(peaks)), np.nan)
    return np.nan_to_num(-0.5 * np.diff(np.log(energy), axis=1), nan=MOST).clip(0.0, MOST)


def by_solver(block: NearlyRigid, model: str, impacts: int) -> Callable[[Array], Prediction]:
    """Return what predicts the ratios for first losses: the solver's decays, linear between them in the first loss."""
    loss = losses_by_impact(block, dampings(block, model), impacts)
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
