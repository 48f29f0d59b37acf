"""See that the walkers' posterior is right about itself: identify records made with parameters drawn from its prior.

`.venv/bin/python tools/check_posterior.py --records 100 --seed 7`. A record takes some seconds. The study of
identification judges weighted draws in this way; this program judges those of the walkers that `rockdamp calibrate
--posterior` returns. It tells how often the intervals held the truth, with the standard error that so many records
leave, and ends with status 1 where this is off by more than three of those.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from rockdamp.config.merging import merged
from rockdamp.errors import InputError
from rockdamp.identification.evidence import weighted_draws
from rockdamp.identification.posterior import Sampler, draw
from rockdamp.identification.problem import Problem
from rockdamp.identification.simulated import Draws, gathered
from rockdamp.progress import track, without_bars
from rockdamp.studies.identification import IdentificationSettings, maker_of
from rockdamp.vocabulary import CANDIDATES, REFERENCE

CONFIG = Path(__file__).resolve().parents[1] / "config/default.yaml"
SAMPLER = Sampler(ensembles=4, walkers=64, burn_in=80, steps=60, rounds=6, effective=200)
MOST = 3.0  # standard errors of a share


def walked(problem: Problem, random: np.random.RandomState) -> Draws:
    """Draw from a posterior by walkers."""
    draws = draw(problem, weighted_draws(problem, random), replace(SAMPLER, seed=random.randint(2**31 - 100)))
    if not draws.good:
        raise InputError("the walkers do not agree")
    return draws.flat, np.full(len(draws.flat), 1 / len(draws.flat))


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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--damping-model", choices=CANDIDATES, default=REFERENCE)
    given = parser.parse_args()
    settings = IdentificationSettings.of(merged([CONFIG], {}))
    simulated = replace(settings.simulated, seed=given.seed, damping_model=given.damping_model)
    maker = maker_of(replace(settings, simulated=simulated))
    records = []
    for number in track(range(given.records), "records"):
        with without_bars():
            records.append(maker.judged(number, walked))
    return 0 if report(gathered(maker.names, records)) else 1


if __name__ == "__main__":
    sys.exit(main())
