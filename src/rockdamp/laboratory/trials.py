"""Measured trials of free rocking: the ratio of angular velocities at each impact of each trial."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.storage import input_file

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
    text = input_file.text(input_file.content(path, "a CSV of rocking trials"), path)
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
