"""See that the posterior is right about itself: identify records made with parameters drawn from its prior.

`.venv/bin/python tools/check_posterior.py --records 100 --seed 7`. A record takes some seconds. This is what the study
of identification does, for any damping model, seed and number of records. The program tells how often the intervals
held the truth, with the standard error that so many records leave, and ends with status 1 where this is off by more
than three of those.

`.venv/bin/python tools/check_posterior.py --tests 200 --seed 7` makes random tests by the event-driven solver
(tools/random_tests.py) and identifies each as `calibrate --posterior` does. What it finds is kept in
results/random-tests-SEED.csv, a row a test, so that it goes on where it was stopped; `--first` starts elsewhere.
It ends with status 1 where a test ended in a traceback or took over two minutes, where the intervals of 90 % of one
parameter hold the truth outside of 84 to 96 %, or where 15 % or more were refused.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from random_tests import NAMES, judged

from rockdamp.config.files import merged
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.laboratory.simulated import gathered
from rockdamp.laboratory.stages import maker_of
from rockdamp.progress import track, without_bars
from rockdamp.vocabulary import CANDIDATES, REFERENCE

ROOT = Path(__file__).resolve().parents[1]
CONFIG, RESULTS = ROOT / "config/default.yaml", ROOT / "results"
MOST = 3.0  # standard errors of a share
# Of random tests; these were written before the first was identified.
HELD, MOST_REFUSED, LONGEST = (0.84, 0.96), 0.15, 120.0  # the last in s of one processor


def report(found: xr.Dataset) -> bool:
    """Print how often the intervals held the truth; say whether those of the posterior did as often as they say."""
    print(f"{int(found['identified_records'])} of {found.sizes['draw']} records identified, the others refused")
    holds = bool(found["identified_records"] > 0)
    for route, name in (("posterior", "coverage"), ("least squares", "coverage_by_least_squares")):
        print(f"by {route}:")
        for parameter in found["parameter"].values:
            for level, error in zip(found["level"].values, found["coverage_error"].values, strict=True):
                share = float(found[name].sel(parameter=parameter, level=level))
                if np.isfinite(share):
                    print(f"  {level:.0%} interval of {parameter}: {share:.1%} ± {error:.1%}")
                    holds &= route != "posterior" or bool(abs(share - level) <= MOST * error)
    return holds


def random_tests(first: int, count: int, seed: int) -> int:
    """Identify the tests that are not kept yet; report on all that are."""
    kept = RESULTS / f"random-tests-{seed}.csv"
    kept.parent.mkdir(exist_ok=True)
    before = set(pd.read_csv(kept)["number"]) if kept.exists() else set()
    for number in track([number for number in range(first, first + count) if number not in before], "tests"):
        row = pd.DataFrame([judged(seed, number)])
        row.to_csv(kept, mode="a", header=not kept.exists(), index=False)
    rows = pd.read_csv(kept)
    found = summary(rows)
    print("\n".join(f"{name}: {value:.3g}" for name, value in found.items()))
    held = [value for name, value in found.items() if name.startswith("held")]
    holds = [found["failed"] == 0, found["longest"] <= LONGEST, found["refused_share"] < MOST_REFUSED]
    return 0 if all([*holds, *(low <= value <= high for value in held for low, high in [HELD])]) else 1


def summary(rows: pd.DataFrame) -> dict[str, float]:
    """Return how many tests were answered, refused or failed, the longest time, and how often intervals held."""
    counts = {f"{ended}": float((rows["ended"] == ended).sum()) for ended in ("answered", "refused", "failed")}
    answered = rows[rows["ended"] == "answered"]
    held = {f"held_{name}": float(answered[f"held_{name}"].mean()) for name in NAMES}
    shares = {"refused_share": counts["refused"] / len(rows), "longest": float(rows["seconds"].max())}
    return {"tests": float(len(rows)), **counts, **shares, **held}


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
    simulated = {"simulated": {"seed": given.seed, "damping_model": given.damping_model}}
    maker = maker_of(LaboratoryConfig.model_validate(merged([CONFIG], {"identification": simulated})))
    records = []
    for number in track(range(given.records), "records"):
        with without_bars():
            records.append(maker.judged(number))
    return 0 if report(gathered(maker.names, records)) else 1


if __name__ == "__main__":
    sys.exit(main())
