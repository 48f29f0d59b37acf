"""Make the table of damping ratios that the package ships, src/rockdamp/equivalence/ratios.npz, and check it.

`.venv/bin/python tools/tabulate_ratios.py make` takes a quarter of an hour on one core. It matches each model at every
node of its table, then in the middle of every cell and at points drawn in it. A cell is doubtful where one of these, or
of a cell that shares a face with it, is off by more than `DOUBTFUL`: there `CLOSER` further points are drawn. It is
bad where one of its points is off by more than `OFF`, or one of a cell that shares a face with it by more than
`STATED`, and where Err has two minima at one of its corners or points. Bad cells are refused, and all that share a face
with one.

`.venv/bin/python tools/tabulate_ratios.py check --seed 7 8 9` takes three minutes. It draws walls from the table's
range, matches them as `rockdamp.equivalent` does, with finer steps and more trials than the table, and compares. From
the worst of each seed it searches for worse ones nearby. The exit status says whether all are within `STATED`; what it
found is written to src/rockdamp/equivalence/ratios-check.csv, for the documents.
"""

import argparse
import csv
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence import equivalent, matching, tabulated
from rockdamp.equivalence.closed_form import exact_ratio
from rockdamp.equivalence.minima import SCAN, Cases
from rockdamp.equivalence.scan import Scan
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.progress import track
from rockdamp.storage.atomic import replacing
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, PAPER_MODELS

PLACE = Path(tabulated.__file__).parent
AT_ONCE = 256  # walls
STEP, REFINEMENT, TRIALS = 0.005, 2, 60  # of the table's matches
COARSE = STEP, REFINEMENT, Scan(SCAN.smallest, SCAN.largest, TRIALS)
DRAWN, CLOSER, SEED = 2, 16, 16  # points in each cell beside its middle; further ones in a doubtful cell
DOUBTFUL, OFF = 0.003, 0.004  # of xi, at a point of a cell that is looked at closer, and that is refused
STATED = tabulated.LARGEST_ERROR
COLUMNS = ("damping_model", "walls", "refused", "median", "permille", "largest", "searched", "largest_searched")
WORST, ROUNDS, TRIED = 20, 8, 8  # of the search: starts, rounds, walls tried around each
NEAR, SHRINKING = 0.02, 0.7  # how far around, over the range, and how that shrinks from round to round


def matched(
    unit: Array, step: float, refinement: int, scan: Scan, description: str, models: Sequence[str] = PAPER_MODELS
) -> tuple[Array, Array]:
    """Return ln(xi/xi_E) and the number of minima of Err, shape (models, walls), at points of the unit box."""
    ratio, minima = np.empty((2, len(models), unit.shape[1]))
    steps = round(DEFAULT_RESPONSE_LENGTH / step)
    for start in track(range(0, unit.shape[1], AT_ONCE), description):
        here = slice(start, start + AT_ONCE)
        e, a1, b1, a3, x0 = walls_at(unit[:, here])
        cases = Cases.released(TrilinearCurve(a1, b1, a3), x0, e, step=step, steps=steps)
        found = matching.solve(cases, models, steps, scan=scan, refinement=refinement)
        for row, model in enumerate(models):
            ratio[row, here] = np.log(found[model].damping_ratio / exact_ratio(e))
            minima[row, here] = found[model].local_minima
    return ratio, minima


def walls_at(unit: Array) -> tuple[Array, ...]:
    """Return e, a1, b1, a3 and u0/u_ins at points of the unit box, shape (5, ...), for curves of steeper softening.

    Each variable goes from 0 to 1 over its range; a1 in its logarithm.
    """
    e, b1, a3 = (
        low + (high - low) * part
        for part, (low, high) in zip(
            unit[[0, 2, 3]], (tabulated.RESTITUTION, tabulated.STRENGTH_RATIO, tabulated.ULTIMATE_RATIO), strict=True
        )
    )
    a1 = tabulated.LEAST_A1 * (tabulated.largest_a1(b1) / tabulated.LEAST_A1) ** unit[1]
    least = tabulated.LEAST_RELEASE + tabulated.BEYOND_A1 * a1
    return e, a1, b1, a3, least + (tabulated.LARGEST_RELEASE * a3 - least) * unit[4]


def protocol(**made_by: float) -> str:
    """Return in words what a table is of; the file says the same of itself."""
    ranges = (
        tabulated.RESTITUTION,
        (tabulated.LEAST_A1, tabulated.ROOM),
        tabulated.STRENGTH_RATIO,
        tabulated.ULTIMATE_RATIO,
    )
    release = (tabulated.LEAST_RELEASE, tabulated.BEYOND_A1, tabulated.LARGEST_RELEASE)
    shared = {"response_length": DEFAULT_RESPONSE_LENGTH, "nodes": tabulated.NODES, "unit": tabulated.UNIT}
    return json.dumps({**shared, "ranges": ranges, "release": release, **made_by}, sort_keys=True)


def write(tables: dict[str, tabulated.Table], stated: str, path: Path) -> None:
    """Write the tables of all models, with what they are of, to a file of NumPy's."""
    arrays: dict[str, Any] = {"protocol": np.array(stated)}
    for model, table in tables.items():
        arrays[f"{model}_log_ratio"] = np.round(table.log_ratio / tabulated.UNIT).astype(np.int16)
        arrays[f"{model}_refused"] = table.refused
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def make() -> int:
    tables = {model: filled(model) for model in PAPER_MODELS}
    made_by = {"step": STEP, "refinement": REFINEMENT, "trials": TRIALS, "drawn": DRAWN, "closer": CLOSER}
    with replacing(tabulated.FILE) as path:
        write(tables, protocol(**made_by, doubtful=DOUBTFUL, off=OFF), path)
    print(f"{tabulated.FILE}: {tabulated.FILE.stat().st_size} bytes")
    return 0


def filled(model: str) -> tabulated.Table:
    """Return a model's table: match at its nodes, then within its cells."""
    nodes = tabulated.NODES[model]
    cells = tuple(n - 1 for n in nodes)

    def found(unit: Array, what: str) -> tuple[Array, Array]:
        ratio, minima = matched(unit, *COARSE, f"{model}, {what}", (model,))
        return ratio[0], minima[0] > 1

    at_nodes, several = found(lattice(nodes) / np.array(cells)[:, None], "nodes")
    log_ratio = np.round(at_nodes.reshape(nodes) / tabulated.UNIT) * tabulated.UNIT
    table = tabulated.Table(log_ratio, np.zeros(cells, dtype=bool))
    two = at_a_corner(several.reshape(nodes)).ravel()
    off = np.zeros(two.size)

    def look(cell: NDArray[np.int64], parts: Array, what: str) -> None:
        for number, part in enumerate(parts, 1):
            unit = (lattice(cells)[:, cell] + part) / np.array(cells)[:, None]
            exact, several = found(unit, f"{what}, {number} of {len(parts)}")
            off[cell] = np.maximum(off[cell], np.abs(np.expm1(table.read(unit) - exact)))
            two[cell] |= several

    rng = np.random.default_rng(SEED)
    middle = np.full((1, 5, off.size), 0.5)
    look(np.arange(off.size), np.concatenate([middle, rng.uniform(size=(DRAWN, 5, off.size))]), "cells")
    doubtful = np.flatnonzero(and_beside(off.reshape(cells) > DOUBTFUL))
    look(doubtful, rng.uniform(size=(CLOSER, 5, doubtful.size)), "doubtful cells")
    bad = two.reshape(cells) | (off.reshape(cells) > OFF) | and_beside(off.reshape(cells) > STATED)
    refused = and_beside(bad)
    print(
        f"{model}: {refused.mean():.2%} of the cells are refused, {two.mean():.2%} have two minima,"
        f" {(off > OFF).mean():.2%} are off; {doubtful.size / off.size:.2%} were doubtful"
    )
    return tabulated.Table(log_ratio, refused)


def lattice(counts: tuple[int, ...]) -> Array:
    """Return every combination of whole numbers below the counts, the last the fastest, shape (5, combinations)."""
    return np.indices(counts, dtype=float).reshape(len(counts), -1)


def and_beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which cells are among those given or share a face with one of them."""
    found = cells.copy()
    for axis in range(cells.ndim):
        own, others = np.moveaxis(found, axis, 0), np.moveaxis(cells, axis, 0)
        own[1:] |= others[:-1]
        own[:-1] |= others[1:]
    return found


def at_a_corner(nodes: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which cells have one of the nodes given at a corner."""
    for axis in range(nodes.ndim):
        along = np.moveaxis(nodes, axis, 0)
        nodes = np.moveaxis(along[1:] | along[:-1], 0, axis)
    return nodes


def check(walls: int, seeds: Sequence[int]) -> int:
    own: dict[str, list[Array]] = {model: [] for model in PAPER_MODELS}
    searched = dict.fromkeys(PAPER_MODELS, (0, 0.0))
    for seed in seeds:
        rng = np.random.default_rng(seed)
        drawn = rng.uniform(size=(5, walls))
        for model, off in zip(PAPER_MODELS, differences(drawn, PAPER_MODELS, f"walls of seed {seed}"), strict=True):
            own[model].append(off)
            worst = np.argsort(-np.nan_to_num(off))[:WORST]
            tried, largest = search(model, drawn[:, worst], off[worst], rng)
            searched[model] = searched[model][0] + tried, max(searched[model][1], largest)
            print(f"seed {seed}, {model}: largest {np.nanmax(off):.4%}, searched {largest:.4%}", flush=True)
    rows = []
    for model in PAPER_MODELS:
        off = np.concatenate(own[model])
        answered = off[np.isfinite(off)]
        tried, largest = searched[model]
        values = (np.median(answered), np.quantile(answered, 0.999), answered.max(), largest)
        median, permille, of_drawn, of_all = (f"{value:.6f}" for value in values)
        rows.append((model, off.size, f"{1 - answered.size / off.size:.4f}", median, permille, of_drawn, tried, of_all))
        print(dict(zip(COLUMNS, rows[-1], strict=True)))
    with replacing(PLACE / "ratios-check.csv") as path, path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    return int(max(largest for _, largest in searched.values()) > STATED)


def search(model: str, starts: Array, off: Array, rng: np.random.Generator) -> tuple[int, float]:
    """Look near some walls for worse ones: how many the table answered for, and the largest difference of all."""
    worst, off, answered = starts.copy(), off.copy(), 0
    for step in NEAR * SHRINKING ** np.arange(ROUNDS):
        near = np.clip(worst[:, :, None] + rng.uniform(-step, step, size=(*worst.shape, TRIED)), 0, 1)
        found = differences(near.reshape(5, -1), (model,), f"search, {model}").reshape(-1, TRIED)
        answered += int(np.isfinite(found).sum())
        best = np.nan_to_num(found).argmax(axis=1)
        value = np.nan_to_num(found)[np.arange(best.size), best]
        better = value > off
        worst[:, better] = near[:, np.arange(best.size), best][:, better]
        off[better] = value[better]
    return answered, float(off.max())


def differences(unit: Array, models: Sequence[str], description: str) -> Array:
    """Return |xi of the table/xi - 1|, shape (models, walls), NaN where the table does not answer."""
    exact, _ = matched(unit, equivalent.STEP, matching.REFINEMENT, SCAN, description, models)
    read = np.stack([tabulated.shipped(model).read(unit) for model in models])
    refused = np.stack([tabulated.shipped(model).refuses(unit) for model in models])
    return np.where(refused, np.nan, np.abs(np.expm1(read - exact)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=("make", "check"))
    parser.add_argument("--walls", type=int, default=4000, help="drawn by check, for each seed")
    parser.add_argument("--seed", type=int, nargs="+", default=[7])
    given = parser.parse_args()
    sys.exit(make() if given.task == "make" else check(given.walls, given.seed))
