"""See that the posterior is right about itself: identify records whose truth is known.

`.venv/bin/python tools/check_posterior.py --records 200 --seed 7` makes records with parameters drawn from the prior
(tools/posterior_records.py), by any damping model, and identifies them with the same prior. A record takes some
seconds. What it finds is kept in tools/posterior-check.csv, a row for each parameter of each record, of which
`measured_tables.py` makes the table of the documents; so it goes on where it was stopped. It ends with status 1 where
intervals hold the truth too often or too seldom by more than three standard errors of so many records, the standard
deviation of z lies outside of 0.9 to 1.1, or the ranks are not uniform.

`.venv/bin/python tools/check_posterior.py --tests 200 --seed 7` makes random tests by the event-driven solver
(tools/random_tests.py) and identifies each as `calibrate --posterior` does. What it finds is kept in
tools/random-tests.csv, a row a test, so that it goes on where it was stopped; `--first` starts elsewhere.
It ends with status 1 where a test ended in a traceback or took over two minutes, where the standard deviation of z of
one parameter lies outside of 0.9 to 1.1 or its ranks are not uniform, or where 15 % or more were refused. Intervals of
90 % alone would tell little: a deviation of z of 1.2 still holds 83 %.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from posterior_records import LEVELS
from posterior_records import judged as judged_record
from posterior_records import summary as summary_of_records
from random_tests import NAMES, judged
from scipy.stats import kstest

from rockdamp.laboratory.candidates import Candidate
from rockdamp.progress import track, without_bars
from rockdamp.vocabulary import CANDIDATES, REFERENCE

RECORDS, TESTS = (Path(__file__).with_name(name) for name in ("posterior-check.csv", "random-tests.csv"))
MOST = 3.0  # standard errors of a share
Z, LEAST_P = (0.9, 1.1), 0.01  # of the standard deviation of z, and of the test that ranks are uniform
# Of random tests; these were written before the first was identified.
MOST_REFUSED, LONGEST = 0.15, 120.0  # the last in s of one processor


def report(rows: pd.DataFrame) -> bool:
    """Print how often the intervals held the truth; say whether those of the posterior did as often as they say.

    The deviation of z, of the true value less the mean over the posterior's deviation, is 1 but for chance, and the
    rank of the true value is uniform.
    """
    found, holds = summary_of_records(rows), True
    print(f"{found['identified'].iloc[0]} of {found['records'].iloc[0]} records identified, the others refused")
    for name, of in found.iterrows():
        shares = {level: (of[f"held_{level}"], of[f"held_{level}_by_least_squares"]) for level in LEVELS}
        error = {level: np.sqrt(level * (1 - level) / max(of["identified"], 1)) for level in LEVELS}
        held = ", ".join(
            f"{own:.1%} ± {error[level]:.1%} of {level:.0%} ({other:.1%})" for level, (own, other) in shares.items()
        )
        print(f"{name}: intervals hold {held}; deviation of z {of['deviation_of_z']:.2f}; p of ranks {of['p']:.2g}")
        holds &= all(abs(own - level) <= MOST * error[level] for level, (own, _) in shares.items())
        holds &= bool(Z[0] <= of["deviation_of_z"] <= Z[1] and of["p"] >= LEAST_P)
    print("in brackets: by least squares")
    return holds


def records(first: int, count: int, seed: int, model: str) -> int:
    """Identify the records that are not kept yet; report on all that are."""
    before = pd.read_csv(RECORDS) if RECORDS.exists() else pd.DataFrame({"number": []})
    for number in track(sorted(set(range(first, first + count)) - set(before["number"])), "records"):
        with without_bars():
            rows = pd.DataFrame(judged_record(Candidate.from_name(model), seed, number))
        rows.to_csv(RECORDS, mode="a", header=not RECORDS.exists(), index=False)
    return 0 if report(pd.read_csv(RECORDS)) else 1


def random_tests(first: int, count: int, seed: int) -> int:
    """Identify the tests that are not kept yet; report on all that are."""
    before = set(of_seed(seed)["number"]) if TESTS.exists() else set()
    for number in track([number for number in range(first, first + count) if number not in before], "tests"):
        row = pd.DataFrame([judged(seed, number)])
        row.to_csv(TESTS, mode="a", header=not TESTS.exists(), index=False)
    rows = of_seed(seed)
    found = summary(rows)
    print("\n".join(f"{name}: {value:.3g}" for name, value in found.items()))
    holds = [found["failed"] == 0, found["longest"] <= LONGEST, found["refused_share"] < MOST_REFUSED]
    holds += [Z[0] <= found[f"deviation_of_z_{name}"] <= Z[1] and found[f"p_{name}"] >= LEAST_P for name in NAMES]
    return 0 if all(holds) else 1


def of_seed(seed: int) -> pd.DataFrame:
    """Return the kept random tests of a seed."""
    rows = pd.read_csv(TESTS)
    return rows[rows["seed"] == seed]


def summary(rows: pd.DataFrame) -> dict[str, float]:
    """Return how many tests were answered, refused or failed, the longest time, and z and ranks of the truth."""
    counts = {f"{ended}": float((rows["ended"] == ended).sum()) for ended in ("answered", "refused", "failed")}
    answered = rows[rows["ended"] == "answered"]
    of_truth = {}
    for name in NAMES:
        z = (answered[f"true_{name}"] - answered[f"mean_{name}"]) / answered[f"deviation_{name}"]
        of_truth[f"held_{name}"] = float((abs(2 * answered[f"rank_{name}"] - 1) <= 0.9).mean())
        of_truth[f"deviation_of_z_{name}"] = float(z.std(ddof=0))
        of_truth[f"p_{name}"] = float(kstest(answered[f"rank_{name}"], "uniform").pvalue)
    shares = {"refused_share": counts["refused"] / len(rows), "longest": float(rows["seconds"].max())}
    return {"tests": float(len(rows)), **counts, **shares, **of_truth}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--damping-model", choices=CANDIDATES, default=REFERENCE)
    parser.add_argument("--tests", type=int, help="random tests in place of records")
    parser.add_argument("--first", type=int, default=0, help="number of the first of them")
    given = parser.parse_args()
    if given.tests is not None:
        return random_tests(given.first, given.tests, given.seed)
    return records(given.first, given.records, given.seed, given.damping_model)


if __name__ == "__main__":
    sys.exit(main())
