"""A verdict on each claim of the paper, as a table."""

import os
import sys

from rockdamp import claims
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

paths, results = snakemake.input, snakemake.config["results"]
datasets = {
    os.path.relpath(path, results).removesuffix(".nc"): dataset.read(path)
    for path in paths.datasets
}
claims.table(claims.read(paths.claims), datasets).to_csv(
    snakemake.output[0], index=False, lineterminator="\n"
)
