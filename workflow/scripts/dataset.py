"""A stage's dataset: one function of the package, called with the wildcards, the config and the inputs."""

from boundary import about, call, job

with job(snakemake):
    from rockdamp.motions.records import read_record
    from rockdamp.storage import dataset

    unread = {*snakemake.input.code, *snakemake.input.watched}
    paths = [path for path in snakemake.input if path not in unread]
    opened = dataset.connect if snakemake.params.lazy else dataset.open
    inputs = [opened(path) if path.endswith(".nc") else read_record(path) for path in paths]
    config = snakemake.params.config
    with about(paths):
        result = call(snakemake.params.function, *snakemake.wildcards, config, *inputs)
    dataset.write(
        result, snakemake.output[0], snakemake.params.kind, config=config, code_version=snakemake.params.version
    )
