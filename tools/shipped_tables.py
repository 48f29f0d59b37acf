"""Write the tables that the package ships, from the results of a full build.

Run it as `.venv/bin/python tools/shipped_tables.py`. The tables are the polynomials of
`results/coefficients.csv`, and the shares of collapses that each damper misses.
"""

import shutil
from pathlib import Path

import pandas as pd

from rockdamp.constants import RECOMMENDED_SOURCE, VISCOUS_MODELS
from rockdamp.storage import dataset

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"
SHIPPED = ROOT / "src/rockdamp/equivalence"


def missed_collapses() -> pd.DataFrame:
    """Return the shares by e and damper, with damping ratios of least error."""
    comparison = dataset.read(RESULTS / "comparison.nc")
    rates = comparison["missed_collapse_rate"].sel(damping_ratio_source=RECOMMENDED_SOURCE)
    rates = rates.sel(damping_model=list(VISCOUS_MODELS)).transpose("restitution", "damping_model")
    return rates.rename("missed_collapse_rate").to_series().round(6).reset_index()


if __name__ == "__main__":
    missed_collapses().to_csv(SHIPPED / "missed_collapses.csv", index=False, lineterminator="\n")
    shutil.copyfile(RESULTS / "coefficients.csv", SHIPPED / "coefficients.csv")
