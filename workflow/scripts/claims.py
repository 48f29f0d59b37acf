"""A verdict on each claim, as a table and as the report reads it, and the evidence for the paper's errata."""

import os
import sys
from pathlib import Path

from rockdamp import claims
from rockdamp.claims import errata
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)

paths, output, results = snakemake.input, snakemake.output, snakemake.config["results"]
datasets = {os.path.relpath(path, results).removesuffix(".nc"): dataset.read(path) for path in paths.datasets}
verdicts = claims.judge(claims.read(paths.claims), datasets, getattr(claims, snakemake.params.judges))
claims.table(verdicts).to_csv(output.table, index=False, lineterminator="\n")
Path(output.structure).write_text(claims.as_json(verdicts), encoding="utf-8")
if "errata" in output.keys():
    errata.table(errata.read(paths.errata), datasets).to_csv(output.errata, index=False, lineterminator="\n")
