"""See that intervals from free-rocking tests hold the truth as often as they say: fit tests that an integrator made.

`.venv/bin/python tools/check_free_rocking.py --tests 200 --dampers 40 --seed 8` draws specimens, releases and sensors
at random, simulates them (`free_rocking_tests.py`, which shares no code with the package) and fits their whole signals.
Specimens lose by one e, by the law of loss with g = 0.26 and by its damper of order 16, whose e and g are known; of the
other dampers it counts which the losses exclude. It takes some seconds a test, goes on after the makers that
tools/free-rocking-check.csv has, of which `measured_tables.py` makes the tables of the documents, and ends with status
1 where the errors of e at 0.3 u_ins or of g are not those that their intervals say, by the limits of `check_losses.py`.
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
from check_losses import good, judged_exponent, judged_restitution, row
from free_rocking_tests import AT, Specimen, channel, decay
from scipy.stats import norm

import rockdamp as rd
from rockdamp.errors import InputWarning
from rockdamp.progress import track

FILE = Path(__file__).with_name("free-rocking-check.csv")
STEP, LONGEST = 0.002, 15.0  # 500 Hz; [s]
G = 0.26
MAKERS: dict[str, dict[str, float]] = {
    "one e": {},
    f"law of loss, g = {G:g}": {"g": G},
    "its damper, order 16": {"g": G, "order": 16.0},
    "CDC": {"xi": 0.04, "n": 0.0},
    "CDR": {"xi": 0.04, "n": 1.0},
    "SDR": {"xi": 0.06, "n": 2.0},
    "ECD": {"order": 0.0},
}
KNOWN = list(MAKERS)[:3]  # whose e at 0.3 u_ins and g are known
JUDGED = ("e at 0.3 u_ins", "g")
CURVE = {"yield_displacement_ratio": "a1", "strength_ratio": "b1"}


def specimen(random: Any, made_by: str = KNOWN[0]) -> Specimen:
    """Draw a wall with its curve and its loss."""
    thickness = random.uniform(0.1, 0.4)
    loss = MAKERS[made_by]
    return Specimen(
        thickness=thickness,
        height=thickness * random.uniform(8, 25),
        hinge_ratio=random.uniform(0.5, 0.7),
        overburden_ratio=random.uniform(0, 6),
        a1=random.uniform(0.02, 0.10),
        b1=random.uniform(0.65, 0.88),
        e=random.uniform(0.80, 0.93),
        scatter=random.uniform(0, 0.03),
        **{**loss, "xi": loss.get("xi", 0.0) * random.uniform(0.6, 1.4)},
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        loaded = {"hinge_ratio": wall.hinge_ratio, "overburden_ratio": wall.overburden_ratio}
        known = rd.Wall(wall.thickness, wall.height, **loaded)
        return rd.calibrate_free_rocking(tests, known)


def judged(wall: Specimen, fit: xr.Dataset) -> dict[str, tuple[bool, float]]:
    """Return of a1, b1, e and g whether the interval holds the truth, and the rank of the truth, 0 to 1."""
    freedom = int(fit["impact_rocking"].sum()) - 2
    found = {}
    for name, short in CURVE.items():
        one, true = fit.sel(parameter=name), {"a1": wall.a1, "b1": wall.b1}[short]
        low, high = one["interval"].values
        rank = float(norm.cdf((float(one["estimate"]) - true) / float(one["standard_error"])))
        found[short] = (bool(low <= true <= high), rank)
    e = fit.sel(amplitude=AT)
    ends = e["restitution_at_amplitude_interval"].values
    found[JUDGED[0]] = judged_restitution(float(e["restitution_at_amplitude"]), ends, wall.e, freedom)
    of_g = judged_exponent(float(fit["loss_exponent"]), fit["loss_exponent_interval"].values, wall.g, freedom)
    return found | ({JUDGED[1]: of_g} if of_g else {})


def excluded(fit: xr.Dataset) -> dict[str, bool]:
    """Say of each damper whether its losses are excluded."""
    least = float(fit["log_likelihood_threshold"])
    return {str(one["damping_model"].item()): bool(one < least) for one in fit["relative_log_likelihood"]}


def rows_by(made_by: str, count: int, seed: int) -> list[dict[str, Any]]:
    """Fit so many specimens that lose energy in one way; return a row of each parameter and of each damper."""
    fits, refused = [], 0
    for number in track(range(count), made_by):
        random = np.random.RandomState([seed, list(MAKERS).index(made_by), number])
        wall = specimen(random, made_by)
        tests, _ = tests_of(wall, random)
        try:
            fits.append((wall, fitted(wall, tests)))
        except rd.InputError as error:
            refused += 1
            print(f"{made_by} {number} refused: {error}", file=sys.stderr)
    rows = []
    if made_by in KNOWN:
        each = [judged(wall, fit) for wall, fit in fits]
        rows = [row(made_by, name, count, [one[name] for one in each if name in one]) for name in each[0]]
    every = [excluded(fit) for _, fit in fits]
    rows += [
        {"made_by": made_by, "parameter": f"{name} excluded", "tests": count, "determined": len(every), "share": share}
        for name in every[0]
        for share in [sum(one[name] for one in every) / len(every)]
    ]
    return [one | {"refused": refused} for one in rows]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=200)
    parser.add_argument("--dampers", type=int, default=40, help="tests made by each damper whose e and g are not known")
    parser.add_argument("--seed", type=int, default=8)
    parser.add_argument("--output", type=Path, default=FILE)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    if given.output.exists():
        with given.output.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    for name in MAKERS:
        count = given.tests if name in KNOWN else given.dampers
        if not count or any(one["made_by"] == name for one in rows):
            continue
        rows += rows_by(name, count, given.seed)
        with given.output.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]), restval="", lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    for one in rows:
        print(*one.values(), sep="  ")
    return 0 if all(good(one) for one in rows if one["parameter"] in JUDGED and one["made_by"] in KNOWN) else 1


if __name__ == "__main__":
    sys.exit(main())
