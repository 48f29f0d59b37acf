"""The verdicts on the paper's claims and the evidence for its errata, as CSV: both tables, or none."""

import os
from pathlib import Path

from boundary import job

with job(snakemake):
    from rockdamp import claims, dataset
    from rockdamp.claims import errata

    results = Path(snakemake.output.claims).parent
    paths = [path for path in snakemake.input if path.endswith(".nc")]
    names = [Path(path).relative_to(results).with_suffix("").as_posix() for path in paths]
    datasets = {name: dataset.open(path) for name, path in zip(names, paths)}
    tables = {
        snakemake.output.claims: claims.judge(claims.read(snakemake.input.claims), datasets),
        snakemake.output.errata: errata.table(errata.read(snakemake.input.errata), datasets),
    }
    for path, table in tables.items():
        table.to_csv(f"{path}.part", index=False, lineterminator="\n")
    for path in tables:
        os.replace(f"{path}.part", path)
