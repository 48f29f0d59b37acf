"""The data dictionary, from the datasets of a build."""

from boundary import job

with job(snakemake):
    from rockdamp.pipeline import dictionary

    dictionary.write(snakemake.config["results"])
