"""A figure in every format: the rule's name is the figure's, its inputs are the datasets that it shows."""

from os.path import splitext

from boundary import job

with job(snakemake):
    from rockdamp import figures
    from rockdamp.storage import dataset

    datasets = [dataset.open(path) for path in snakemake.input if path.endswith(".nc")]
    drawn = figures.FIGURES[snakemake.rule](*datasets)
    figures.save(drawn, splitext(snakemake.output[0])[0], **snakemake.params.config["figures"])
