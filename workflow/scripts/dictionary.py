"""The data dictionary, from the datasets of a build."""

from boundary import job

with job(snakemake):
    from rockdamp.pipeline import verification

    verification.write_dictionary(snakemake.config["results"])
