"""Make the table of damping ratios that the package ships, src/rockdamp/equivalence/ratios.npz, and check it.

`.venv/bin/python tools/tabulate_ratios.py make` takes four minutes on one core. It matches CDC, CDR and SDR at every
node of the table, then in the middle of every cell and at points drawn in it. A cell is refused where one of its
points, or of a cell that shares a face with it, is off by more than `OFF`, and where Err has two minima at one of its
corners.

`.venv/bin/python tools/tabulate_ratios.py check --seed 7` takes two minutes. It draws walls from the table's range,
matches them as `rockdamp.equivalent` does, with finer steps and more trials than the table, and compares. From the
worst of them it searches for worse ones nearby. The exit status says whether all are within `STATED`; what it found is
written to src/rockdamp/equivalence/ratios-check.csv, for the documents.
"""

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rockdamp.arrays import Array
from rockdamp.equivalence import matching, one_curve, tabulated
from rockdamp.equivalence.closed_form import exact_ratio
from rockdamp.equivalence.minima import SCAN, Cases
from rockdamp.equivalence.scan import Scan
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.progress import track
from rockdamp.storage.atomic import replacing
from rockdamp.vocabulary import DEFAULT_WINDOW, PAPER_MODELS

PLACE = Path(tabulated.__file__).parent
AT_ONCE = 256  # walls
STEP, REFINEMENT, TRIALS = 0.005, 2, 60  # of the table's matches
OFF = 0.003  # of xi, at a point of a cell that is refused
DRAWN, SEED = 2, 16  # points in a cell beside its middle
STATED = tabulated.LARGEST_ERROR
COLUMNS = ("damping_model", "walls", "refused", "median", "permille", "largest", "searched", "largest_searched")
WORST, ROUNDS, TRIED = 20, 8, 8  # of the search: starts, rounds, walls tried around each
NEAR, SHRINKING = 0.02, 0.7  # how far around, over the range, and how that shrinks from round to round


def matched(
    unit: Array, step: float, refinement: int, scan: Scan, description: str, models: Sequence[str] = PAPER_MODELS
) -> tuple[Array, Array]:
    """Return ln(xi/xi_E) and the number of minima of Err, shape (models, walls), at points of the unit box."""
    ratio, minima = np.empty((2, len(models), unit.shape[1]))
    steps = round(DEFAULT_WINDOW / step)
    for start in track(range(0, unit.shape[1], AT_ONCE), description):
        here = slice(start, start + AT_ONCE)
        e, a1, b1, a3, x0 = tabulated.walls_at(unit[:, here])
        cases = Cases.released(TrilinearCurve(a1, b1, a3), x0, e, step=step, steps=steps)
        found = matching.solve(cases, models, steps, scan=scan, refinement=refinement)
        for row, model in enumerate(models):
            ratio[row, here] = np.log(found[model].damping_ratio / exact_ratio(e))
            minima[row, here] = found[model].local_minima
    return ratio, minima


def points(counts: tuple[int, ...], shift: float) -> Array:
    """Return the points of a grid in the unit box, moved by a part of a cell, shape (5, points)."""
    parts = [(np.arange(count) + shift) / (nodes - 1) for count, nodes in zip(counts, tabulated.NODES, strict=True)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*parts, indexing="ij")])


def make() -> int:
    coarse = (STEP, REFINEMENT, Scan(SCAN.smallest, SCAN.largest, TRIALS))
    cells = tuple(n - 1 for n in tabulated.NODES)
    at_nodes, minima = matched(points(tabulated.NODES, 0.0), *coarse, "nodes")
    log_ratio = at_nodes.reshape(-1, *tabulated.NODES)
    several = minima.reshape(log_ratio.shape) > 1
    refused = np.zeros((len(PAPER_MODELS), *cells), dtype=bool)
    table = tabulated.Table(np.round(log_ratio / tabulated.UNIT) * tabulated.UNIT, refused)
    # The middle of each cell, then points drawn in it.
    drawn = np.random.default_rng(SEED).uniform(size=(DRAWN, 5, refused[0].size))
    within = [points(cells, 0.5), *(points(cells, 0.0) + part / np.array(cells)[:, None] for part in drawn)]
    off = np.zeros_like(refused)
    for number, unit in enumerate(within):
        exact, _ = matched(unit, *coarse, f"cells, {number + 1} of {len(within)}")
        for row, model in enumerate(PAPER_MODELS):
            off[row] |= np.abs(np.expm1(table.read(model, unit) - exact[row])).reshape(cells) > OFF
    for row, model in enumerate(PAPER_MODELS):
        refused[row] = off[row] | beside(off[row]) | at_a_corner(several[row])
        print(f"{model}: {refused[row].mean():.2%} of the cells are refused, {off[row].mean():.2%} by their own points")
    made_by = {"step": STEP, "refinement": REFINEMENT, "trials": TRIALS, "off": OFF, "drawn": DRAWN}
    content = tabulated.packed(table, tabulated.protocol(**made_by))
    with replacing(PLACE / tabulated.FILE) as path:
        path.write_bytes(content)
    print(f"{PLACE / tabulated.FILE}: {len(content)} bytes")
    return 0


def beside(cells: Array) -> Array:
    """Tell which cells share a face with one of those given."""
    found = np.zeros_like(cells)
    for axis in range(cells.ndim):
        own, others = np.moveaxis(found, axis, 0), np.moveaxis(cells, axis, 0)
        own[1:] |= others[:-1]
        own[:-1] |= others[1:]
    return found


def at_a_corner(nodes: Array) -> Array:
    """Tell which cells have one of the nodes given at a corner."""
    for axis in range(nodes.ndim):
        along = np.moveaxis(nodes, axis, 0)
        nodes = np.moveaxis(along[1:] | along[:-1], 0, axis)
    return nodes


def check(walls: int, seed: int) -> int:
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(size=(5, walls))
    off = differences(drawn, PAPER_MODELS, "walls")
    rows, within = [], True
    for model, own in zip(PAPER_MODELS, off, strict=True):
        answered = own[np.isfinite(own)]
        worst = np.argsort(-np.nan_to_num(own))[:WORST]
        tried, largest = search(model, drawn[:, worst], own[worst], rng)
        values = (np.median(answered), np.quantile(answered, 0.999), answered.max(), largest)
        median, permille, of_drawn, of_all = (f"{value:.6f}" for value in values)
        refused = f"{1 - answered.size / walls:.4f}"
        rows.append((model, walls, refused, median, permille, of_drawn, tried, of_all))
        within &= largest <= STATED
        print(dict(zip(COLUMNS, rows[-1], strict=True)))
    with replacing(PLACE / "ratios-check.csv") as path, path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    return int(not within)


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
    exact, _ = matched(unit, one_curve.STEP, matching.REFINEMENT, SCAN, description, models)
    table = tabulated.shipped()
    read = np.stack([table.read(model, unit) for model in models])
    refused = np.stack([table.refuses(model, unit) for model in models])
    return np.where(refused, np.nan, np.abs(np.expm1(read - exact)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=("make", "check"))
    parser.add_argument("--walls", type=int, default=4000, help="drawn by check")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    sys.exit(make() if given.task == "make" else check(given.walls, given.seed))
