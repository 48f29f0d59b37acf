"""See that the posterior is right about itself: identify records made with parameters drawn from its prior.

`.venv/bin/python tools/check_posterior.py --records 100 --seed 7`. A record takes some seconds. This is what the study
of identification does, for any damping model, seed and number of records. The program tells how often the intervals
held the truth, with the standard error that so many records leave, and ends with status 1 where this is off by more
than three of those.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from rockdamp.config.merging import merged
from rockdamp.identification.simulated import gathered
from rockdamp.progress import track, without_bars
from rockdamp.studies.identification import IdentificationSettings, maker_of
from rockdamp.vocabulary import CANDIDATES, REFERENCE

CONFIG = Path(__file__).resolve().parents[1] / "config/default.yaml"
MOST = 3.0  # standard errors of a share


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
            records.append(maker.judged(number))
    return 0 if report(gathered(maker.names, records)) else 1


if __name__ == "__main__":
    sys.exit(main())
