"""A figure in every format: one function of the package, called with the datasets that it shows."""

from os.path import splitext

from boundary import call, job

with job(snakemake) as given:
    from rockdamp.figures.output import save

    datasets = [given.open(path) for path in snakemake.input.datasets]
    drawn = call(snakemake.params.function, *datasets)
    save(drawn, splitext(snakemake.output[0])[0], **snakemake.params.config["figures"])
