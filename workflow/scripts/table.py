"""A table of a dataset, as CSV: one function of the package."""

from boundary import call, job

with job(snakemake) as given:
    from rockdamp.storage.atomic import replacing

    table = call(snakemake.params.function, given.open(snakemake.input.datasets[0]))
    with replacing(snakemake.output[0]) as unfinished:
        table.to_csv(unfinished, index=False, lineterminator="\n")
