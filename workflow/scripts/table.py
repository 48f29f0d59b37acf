"""A table of a dataset, as CSV: one function of the package."""

import os

from boundary import call, job

with job(snakemake):
    from rockdamp import dataset

    table = call(snakemake.params.function, dataset.open(snakemake.input[0]))
    unfinished = f"{snakemake.output[0]}.part"
    table.to_csv(unfinished, index=False, lineterminator="\n")
    os.replace(unfinished, snakemake.output[0])
