"""See that intervals from free-rocking tests hold the truth as often as they say: fit tests that an integrator made.

`.venv/bin/python tools/check_free_rocking.py --tests 200 --dampers 40 --seed 8` draws specimens, releases and sensors
at random, simulates them (`free_rocking_tests.py`, which shares no code with the package) and fits them. It takes some
seconds a test, writes tools/free-rocking-check.csv, of which `measured_tables.py` makes the table of the documents, and
ends with status 1 where an interval of 90 % holds the truth in less than 84 or more than 96 of 100 tests.
"""

from __future__ import annotations

import argparse
import csv
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from free_rocking_tests import Specimen, channel, decay

import rockdamp as rd
from rockdamp.errors import InputWarning
from rockdamp.progress import track

FILE = Path(__file__).with_name("free-rocking-check.csv")
ALLOWED = (0.84, 0.96)  # of intervals of 90 %
STEP, LONGEST = 0.002, 15.0  # 500 Hz; [s]
LOSSES = {"CR": (None, 0.0), "CDC": (0.04, 0.0), "CDR": (0.04, 1.0), "SDR": (0.06, 2.0)}  # damping ratio and exponent
PARAMETERS = {"yield_displacement_ratio": "a1", "strength_ratio": "b1", "restitution": "e"}


def specimen(random: Any, made_by: str = "CR") -> Specimen:
    """Draw a wall with its curve and its loss."""
    thickness = random.uniform(0.1, 0.4)
    xi, exponent = LOSSES[made_by]
    return Specimen(
        thickness=thickness,
        height=thickness * random.uniform(8, 25),
        hinge_ratio=random.uniform(0.5, 0.7),
        overburden_ratio=random.uniform(0, 6),
        a1=random.uniform(0.02, 0.10),
        b1=random.uniform(0.65, 0.88),
        e=random.uniform(0.80, 0.93),
        scatter=random.uniform(0, 0.03),
        xi=0.0 if xi is None else xi * random.uniform(0.6, 1.4),
        n=exponent,
    )


def tests_of(wall: Specimen, random: Any, most: int = 3) -> tuple[list[rd.FreeRocking], list[list[float]]]:
    """Return one to `most` tests of a specimen, and e of each impact of each test.

    Some begin after the release, some end before the specimen is at rest.
    """
    tests, impacts = [], []
    for _ in range(random.randint(1, most + 1)):
        moved, kept = decay(wall, random.uniform(0.25, 0.8) * wall.u_ins, STEP, LONGEST, 1e-3 * wall.u_ins, random)
        whole = random.uniform() < 0.75
        if not whole:
            moved = moved[: int(random.uniform(0.6, 0.9) * moved.size)]
        begins_late = random.uniform() < 1 / 3
        elapsed, shown = channel(
            moved,
            STEP,
            held=0.0 if begins_late else random.uniform(0.2, 0.6),
            late=random.uniform(0, 0.15) * moved.size * STEP if begins_late else 0.0,
            rest=1.0 if whole else 0.0,
            noise=random.uniform(5e-4, 2e-3) * wall.u_ins,
            drift=1e-3 * wall.u_ins * random.standard_normal(),
            random=random,
        )
        tests.append(rd.FreeRocking(elapsed, shown))
        impacts.append(kept)
    return tests, impacts


def fitted(wall: Specimen, tests: list[rd.FreeRocking]) -> xr.Dataset:
    """Fit tests of a specimen, the geometry of which is known."""
    known = rd.Wall(wall.thickness, wall.height, hinge_ratio=wall.hinge_ratio, overburden_ratio=wall.overburden_ratio)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        return rd.calibrate_free_rocking(tests, known)


def held(wall: Specimen, fit: xr.Dataset) -> dict[str, bool]:
    """Say of a1, b1, e and the exponent whether the interval holds the truth."""
    true = {"yield_displacement_ratio": wall.a1, "strength_ratio": wall.b1, "restitution": wall.e}
    low, high = fit["interval"].values
    within = {
        PARAMETERS[name]: bool(low[index] <= true[name] <= high[index])
        for index, name in enumerate(map(str, fit["parameter"].values))
    }
    # No loss at impacts goes with the amplitude; an end that is not determined excludes nothing.
    below, above = (float(end) for end in fit["amplitude_exponent_interval"])
    return {**within, "gamma": not (below > 0 or above < 0)}


def excluded(fit: xr.Dataset) -> dict[str, bool]:
    """Say of each damper whether its losses are excluded."""
    least = float(fit["log_likelihood_threshold"])
    return {str(one["damping_model"].item()): bool(one < least) for one in fit["relative_log_likelihood"]}


def rows_by(made_by: str, count: int, seed: int) -> list[dict[str, Any]]:
    """Fit so many specimens that lose energy in one way; return the shares of each, as rows."""
    judged, refused, misses = [], 0, []
    for number in track(range(count), made_by):
        random = np.random.RandomState([seed, list(LOSSES).index(made_by), number])
        wall = specimen(random, made_by)
        tests, _ = tests_of(wall, random)
        try:
            fit = fitted(wall, tests)
        except rd.InputError as error:
            refused += 1
            print(f"{made_by} {number} refused: {error}", file=sys.stderr)
            continue
        right = held(wall, fit)
        judged.append({**(right if made_by == "CR" else {}), **{f"{m} excluded": e for m, e in excluded(fit).items()}})
        if made_by == "CR":
            misses += [f"{number} {name}" for name, inside in right.items() if not inside]
    print(f"{made_by}: {len(judged)} fitted, {refused} refused; truth outside: {', '.join(misses)}", file=sys.stderr)
    return [
        {"made_by": made_by, "tests": len(judged), "refused": refused, "quantity": name, "share": share}
        for name in judged[0]
        for share in [sum(one[name] for one in judged) / len(judged)]
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=200)
    parser.add_argument("--dampers", type=int, default=40, help="tests made by each viscous damper")
    parser.add_argument("--seed", type=int, default=8)
    parser.add_argument("--output", type=Path, default=FILE)
    given = parser.parse_args()
    counts = {name: given.tests if name == "CR" else given.dampers for name in LOSSES}
    rows: list[dict[str, Any]] = []
    for name, count in counts.items():
        new = rows_by(name, count, given.seed) if count else []
        rows += new
        with given.output.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
        for row in new:
            print(f"{row['made_by']:4s} {row['quantity']:15s} {row['share']:.3f}", flush=True)
    shares = [row["share"] for row in rows if row["made_by"] == "CR" and "excluded" not in row["quantity"]]
    return 0 if all(ALLOWED[0] <= share <= ALLOWED[1] for share in shares) else 1


if __name__ == "__main__":
    sys.exit(main())
