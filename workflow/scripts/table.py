"""A table of a dataset, as CSV: one function of the package."""

from boundary import call, job, open_datasets

with job(snakemake):
    from rockdamp.storage.atomic import replacing

    table = call(snakemake.params.function, *open_datasets(snakemake))
    with replacing(snakemake.output[0]) as unfinished:
        table.to_csv(unfinished, index=False, lineterminator="\n")
