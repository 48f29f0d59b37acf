"""See that published uncertainties are bounds: solve damping ratios and histories again exactly, drawn by any seed.

`.venv/bin/python tools/check_bounds.py --seed 7`, after `make`. It takes about a minute. At least 99 % of the damping
ratios and of the histories that are converged have to lie within what is stated of them; the exit status says whether
they do.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.config.files import merged
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.storage import dataset
from rockdamp.studies.accuracy import stage
from rockdamp.studies.earthquakes import event_driven_check
from rockdamp.vocabulary import STUDIES, VISCOUS_MODELS

ROOT = Path(__file__).resolve().parents[1]
HELD = 0.99  # at least, of each


def ratios(results: Path, config: Config, count: int, seed: int) -> float:
    """Return the share of `count` damping ratios whose exact minimum lies within their uncertainty."""
    studies = {name: config.study(name) for name in STUDIES}
    matches = {name: dataset.open(results / f"match/{name}.nc") for name in STUDIES}
    each = -(-count // len(VISCOUS_MODELS))
    found = stage.minima(studies, matches, count=each, bracket=config.accuracy.bracket, seed=seed)
    part = abs(found["sample_published_ratio"] - found["sample_exact_ratio"]) / (
        found["sample_bound"] * found["sample_published_ratio"]
    )
    print(f"{part.size} damping ratios, half of them those of the largest Err; difference over uncertainty:")
    for model in found["viscous_model"].values:
        own = part.sel(viscous_model=model).values
        print(
            f"  {model}: {np.sum(own <= 1)} of {own.size} within,"
            f" {np.median(own):.2f} in the middle, {own.max():.2f} at most"
        )
    return float((part <= 1).mean())


def histories(results: Path, config: Config, count: int, seed: int) -> float:
    """Return the share of the converged ones of `count` histories that end as stated and peak within their bound."""
    check = config.earthquakes.check.model_copy(update={"histories": count, "seed": seed})
    asked = config.model_copy(update={"earthquakes": config.earthquakes.model_copy(update={"check": check})})
    found = event_driven_check.check_earthquakes(asked, dataset.open(results / "earthquakes.nc"))
    print(f"{found.sizes['history']} histories, event by event:")
    rates = ("otherwise_share", "beyond_bound_share", "median_difference", "largest_difference")
    table = found[["study_count", "checked_count", *rates]].to_dataframe()
    print(table.to_string(float_format=lambda share: f"{float(f'{100 * share:.2g}'):g} %", na_rep="-"))
    return float(held(found.isel(history=(found["converged"] == 1).values)).mean())


def held(checked: xr.Dataset) -> xr.DataArray:
    """Which histories end as the study says and, where they stand, peak within their bound."""
    off = abs(checked["peak"] - checked["exact_peak"])
    within = (checked["collapsed"] == 1) | (off <= checked["peak_uncertainty"])
    return (checked["collapsed"] == checked["exact_collapsed"]) & within


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--ratios", type=int, default=200)
    parser.add_argument("--histories", type=int, default=4000, help="a fifth of them far from collapse")
    parser.add_argument("--results", type=Path, default=ROOT / "results")
    parser.add_argument("--config", type=Path, default=ROOT / "config/default.yaml", help="that of the results")
    asked = parser.parse_args()
    config = LaboratoryConfig.model_validate(merged([asked.config], {}))
    shares = (
        ratios(asked.results, config, asked.ratios, asked.seed),
        histories(asked.results, config, asked.histories, asked.seed),
    )
    print(f"held: {100 * shares[0]:.4g} % of the damping ratios, {100 * shares[1]:.4g} % of the converged histories")
    return 0 if min(shares) >= HELD else 1


if __name__ == "__main__":
    sys.exit(main())
