"""See that intervals of e at 0.3 u_ins and of the exponent of free-rocking tests are right: draw impacts, fit them.

`.venv/bin/python tools/check_losses.py --tests 200 --seed 42` draws walls, releases, the scatter from impact to impact
and the error of each peak, lets the wall lose by one e and by the law of loss with g = 0.26 (docs/theory.md, section 9;
its damper loses the same in every half cycle, so that it makes the same peaks), and fits the losses. It writes
tools/losses-check.csv: of each maker and parameter the share of 90 % intervals that hold the truth with its standard
error, the standard deviation of the standardised errors z, and the probability of their ranks by Kolmogorov and
Smirnov's test of uniformity. It is of the losses alone; `check_free_rocking.py` fits whole signals. It ends with status
1 where a share is more than two standard errors off 90 %, where that deviation lies outside 0.9 to 1.1, or the
probability is below 0.01.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import kstest, norm
from scipy.stats import t as student

import rockdamp as rd
from rockdamp.laboratory.excursions import Losses, exponent_of, restitution_at
from rockdamp.progress import track

FILE = Path(__file__).with_name("losses-check.csv")
MAKERS = {"one e": 0.0, "law of loss, g = 0.26": 0.26}
AT, FEWEST = 0.3, 6  # u/u_ins that e belongs to; impacts
LEVEL, DEVIATIONS, LEAST_PROBABILITY = 0.90, (0.9, 1.1), 0.01


def impacts(random: Any, g: float) -> tuple[Losses, Any, Any, float]:
    """Return the measured losses of a specimen's releases, ln V before each, ln V(AT), and the true e at AT."""
    curve = rd.TrilinearCurve(random.uniform(0.02, 0.10), random.uniform(0.65, 0.88))
    e, scatter, sensor = random.uniform(0.80, 0.93), random.uniform(0.005, 0.03), random.uniform(1e-4, 4e-4)
    level = float(curve.energy(AT))
    lost = level**g * -np.expm1(2 * g * np.log(e))
    decrements, before, blocks = [], [], []
    for _ in range(random.randint(1, 4)):
        energies = [float(curve.energy(random.uniform(0.4, 0.8)))]
        while float(curve.amplitude(energies[-1])) > float(curve.yield_displacement_ratio) and len(energies) < 40:
            left = energies[-1] * e**2 if g == 0 else max(energies[-1] ** g - lost, 0.0) ** (1 / g)
            if left <= 0.0:
                break
            energies.append(left * np.exp(2 * scatter * random.standard_normal()))
        peaks = curve.amplitude(np.array(energies))
        error = curve.force(peaks) * sensor / (2 * np.array(energies))  # of ln sqrt(V)
        measured = 0.5 * np.log(energies) + error * random.standard_normal(peaks.size)
        steps = np.eye(peaks.size)[:-1] - np.eye(peaks.size)[1:]
        decrements.append(steps @ measured)
        blocks.append(steps @ np.diag(error**2) @ steps.T)
        before.append(2 * measured[:-1])
    size = sum(map(len, decrements))
    covariance, start = np.zeros((size, size)), 0
    for block in blocks:
        covariance[start : start + len(block), start : start + len(block)] = block
        start += len(block)
    return Losses(np.concatenate(decrements), covariance), np.concatenate(before), np.log(level), e


def judged_restitution(found: float, ends: Any, true: float, freedom: int) -> tuple[bool, float]:
    """Return whether the interval of e holds the truth, and the rank of the truth, 0 to 1."""
    deviation = np.log(found / ends[0]) / student.ppf(0.5 + LEVEL / 2, freedom)
    return bool(ends[0] <= true <= ends[1]), float(student.cdf(np.log(found / true) / deviation, freedom))


def judged_exponent(found: float, ends: Any, true: float, freedom: int) -> tuple[bool, float] | None:
    """Return the same of g by the end on the truth's side; None where that end is not determined."""
    half = (ends[1] - found if true > found else found - ends[0]) / student.ppf(0.5 + LEVEL / 2, freedom)
    if not np.isfinite(half):
        return None
    return bool(ends[0] <= true <= ends[1]), float(student.cdf((found - true) / half, freedom))


def judged(random: Any, g: float) -> dict[str, tuple[bool, float]]:
    """Fit a specimen; return of e and g whether the interval holds the truth, and the rank of the truth."""
    losses, log_energy, at, e = impacts(random, g)
    while losses.decrement.size < FEWEST:
        losses, log_energy, at, e = impacts(random, g)
    freedom = losses.decrement.size - 2
    ranks = {"e": judged_restitution(*restitution_at(losses, log_energy, float(at)), e, freedom)}
    of_g = judged_exponent(*exponent_of(losses, log_energy), g, freedom)
    return ranks | ({"g": of_g} if of_g else {})


def row(maker: str, parameter: str, tests: int, ranks: list[tuple[bool, float]]) -> dict[str, Any]:
    """Return the row of a parameter, by whether its intervals hold the truth and by the ranks of the truth."""
    held, rank = np.array([one[0] for one in ranks]), np.array([one[1] for one in ranks])
    return {
        "made_by": maker,
        "parameter": parameter,
        "tests": tests,
        "determined": len(ranks),
        "share": round(float(held.mean()), 4),
        "standard_error": round(float(np.sqrt(LEVEL * (1 - LEVEL) / len(ranks))), 4),
        "deviation_of_z": round(float(np.std(norm.ppf(np.clip(rank, 1e-6, 1 - 1e-6)))), 4),
        "rank_probability": round(float(kstest(rank, "uniform").pvalue), 4),
    }


def rows_by(maker: str, count: int, seed: int) -> list[dict[str, Any]]:
    """Return a row for each parameter."""
    g = MAKERS[maker]
    fits = [judged(np.random.RandomState([seed, list(MAKERS).index(maker), n]), g) for n in track(range(count), maker)]
    return [row(maker, name, count, [fit[name] for fit in fits if name in fit]) for name in ("e", "g")]


def good(row: dict[str, Any]) -> bool:
    """Say whether a row lies within the limits."""
    return (
        abs(float(row["share"]) - LEVEL) <= 2 * float(row["standard_error"])
        and DEVIATIONS[0] <= float(row["deviation_of_z"]) <= DEVIATIONS[1]
        and float(row["rank_probability"]) >= LEAST_PROBABILITY
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=200)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--output", type=Path, default=FILE)
    given = parser.parse_args()
    rows = [row for maker in MAKERS for row in rows_by(maker, given.tests, given.seed)]
    with given.output.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    for row in rows:
        print(*row.values(), sep="  ")
    return 0 if all(map(good, rows)) else 1


if __name__ == "__main__":
    sys.exit(main())
