"""The checksums of all results, each of which must state the config and the code of this run."""

from boundary import job

with job(snakemake):
    from rockdamp.pipeline.verification import write_checksums

    write_checksums(snakemake.config["results"], snakemake.params.expected)
