"""A figure in every format: one function of the package, called with the datasets that it shows."""

from os.path import splitext

from boundary import call, job, open_datasets

with job(snakemake):
    from rockdamp.figures.output import save

    config = snakemake.params.config
    figure = call(snakemake.params.function, *open_datasets(snakemake))
    formats, resolution = config["figures.formats"], config["figures.resolution"]
    save(figure, splitext(snakemake.output[0])[0], formats=formats, resolution=resolution)
