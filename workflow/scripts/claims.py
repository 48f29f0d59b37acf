"""A verdict on each claim of the paper, as a table."""

import os
import sys

from rockdamp import claims
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

datasets = {}
for path in snakemake.input.datasets:
    name = os.path.relpath(path, snakemake.config["results"]).removesuffix(".nc")
    datasets[name] = dataset.read(path)
table = claims.table(claims.read(snakemake.input.claims), datasets)
table.to_csv(snakemake.output[0], index=False, lineterminator="\n")
