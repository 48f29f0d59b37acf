"""See that honest records of tests are answered, and that records with a slip are refused or warned of.

`.venv/bin/python tools/check_slips.py --tests 60 --seed 7` makes so many random tests (tools/random_tests.py) that are
what they say, by walls that are CR and by others, and as many with a slip each. `calibrate` fits them all. What it
says is kept in tools/slips-check.csv, a row a record, so that the program goes on where it was stopped;
`measured_tables.py` makes the table of the documents of it.

These limits were written before the first record was fitted: of the honest records of each maker at least 85 % are
answered, and with a warning of the misfit where it is more than noise; every record with a slip is refused, or answered
with that warning. The program ends with status 1 where one does not hold.
"""

import argparse
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from random_tests import MAKERS, OVERSAMPLING, RandomTest, drawn
from scipy.integrate import cumulative_simpson

from rockdamp.errors import InputError
from rockdamp.laboratory.calibration import calibrate
from rockdamp.motions.records import Record
from rockdamp.progress import track, without_bars
from rockdamp.vocabulary import STANDARD_GRAVITY

FILE = Path(__file__).with_name("slips-check.csv")
ANSWERED = 0.85  # of the honest records, at least
NOISE = (5e-4, 1e-2)  # standard deviation of the sensor's, over the largest displacement
BRANCH = 1.0  # times u1, which the wall at least reaches
CUT = (0.6, 0.9)  # of the largest value, where a channel is clipped
NONE = "none"


def _table(test: RandomTest, record: Record, _: np.random.RandomState) -> Record:
    velocity = cumulative_simpson(test.fine.ground_acceleration, dx=test.fine.step, initial=0)
    moved = cumulative_simpson(velocity, dx=test.fine.step, initial=0)[::OVERSAMPLING]
    return replace(record, displacement=record.displacement + moved)


def _clipped(name: str) -> Callable[[RandomTest, Record, np.random.RandomState], Record]:
    def clip(_: RandomTest, record: Record, random: np.random.RandomState) -> Record:
        values = getattr(record, name)
        top = random.uniform(*CUT) * float(np.abs(values).max())
        return replace(record, **{name: np.clip(values, -top, top)})

    return clip


SLIPS: dict[str, Callable[[RandomTest, Record, np.random.RandomState], Record]] = {
    NONE: lambda _test, record, _random: record,
    "displacement in mm": lambda _test, record, _random: replace(record, displacement=1000 * record.displacement),
    "sign of the acceleration": lambda _test, record, _random: replace(
        record, ground_acceleration=-record.ground_acceleration
    ),
    "table's displacement in the wall's": _table,
    "acceleration in g": lambda _test, record, _random: replace(
        record, ground_acceleration=record.ground_acceleration / STANDARD_GRAVITY
    ),
    "channels exchanged": lambda _test, record, _random: replace(
        record, displacement=record.ground_acceleration, ground_acceleration=record.displacement
    ),
    "displacement clipped": _clipped("displacement"),
    "acceleration clipped": _clipped("ground_acceleration"),
}


def judged(seed: int, number: int, slip: str, maker: str) -> dict[str, float | str]:
    """Fit a record, and tell how that ended."""
    test = drawn(seed, number, maker, BRANCH, NOISE)
    record = SLIPS[slip](test, test.record, np.random.RandomState([seed, number, 1]))
    ended, words = "answered", ""
    start, misfit = time.process_time(), np.nan
    with without_bars(), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            misfit = float(calibrate(record, test.wall)["residual_over_peak"])
        except InputError as error:
            ended, words = "refused", str(error)
        except Exception as error:
            ended, words = "failed", f"{type(error).__name__}: {error}"
    doubts = [str(one.message) for one in caught if "the best fit leaves" in str(one.message)]
    if ended == "answered" and doubts:
        ended, words = "warned", doubts[0]
    return {
        "number": number,
        "slip": slip,
        "maker": maker,
        "peak": round(test.peak, 3),
        "over_u1": round(test.peak / test.truth[0], 2),
        "residual_over_peak": misfit,
        "ended": ended,
        "reason": words,
        "seconds": round(time.process_time() - start, 1),
    }


def planned(tests: int) -> list[tuple[str, str]]:
    """Return the slip and the maker of each record: the honest ones first."""
    slips = [name for name in SLIPS if name != NONE]
    honest = [(NONE, MAKERS[index % len(MAKERS)]) for index in range(tests)]
    others = [(slips[index % len(slips)], MAKERS[index // len(slips) % len(MAKERS)]) for index in range(tests)]
    return [*honest, *others]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=60)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--output", type=Path, default=FILE)
    given = parser.parse_args()
    before = set(pd.read_csv(given.output)["number"]) if given.output.exists() else set()
    plan = planned(given.tests)
    for number in track([number for number in range(len(plan)) if number not in before], "records"):
        row = pd.DataFrame([judged(given.seed, number, *plan[number])])
        row.to_csv(given.output, mode="a", header=not given.output.exists(), index=False)
    rows = pd.read_csv(given.output)
    honest = rows[rows["slip"] == NONE]
    answered = honest["ended"].isin(["answered", "warned"]).groupby(honest["maker"]).mean()
    print(answered.to_string())
    slips = rows[rows["slip"] != NONE]
    missed = slips[~slips["ended"].isin(["refused", "warned"])]
    print(f"{len(missed)} of {len(slips)} slips answered without a warning, {(rows['ended'] == 'failed').sum()} failed")
    return int((answered < ANSWERED).any() or len(missed) > 0 or (rows["ended"] == "failed").any())


if __name__ == "__main__":
    sys.exit(main())
