"""A stage's dataset: one function of the package, called with the wildcards, the config and the inputs."""

from pathlib import Path

from boundary import about, call, job

with job(snakemake) as given:
    from rockdamp.motions.records import read_record
    from rockdamp.storage import dataset

    inputs = [read_record(path) for path in snakemake.input.record]
    if snakemake.params.ladder:
        inputs.append({Path(path).stem: read_record(path) for path in snakemake.input.ladder})
    inputs += [given.open(path, lazily=snakemake.params.lazy) for path in snakemake.input.datasets]
    config = snakemake.params.config
    with about(snakemake.input.record, snakemake.input.datasets):
        result = call(snakemake.params.function, *snakemake.wildcards, config, *inputs)
    dataset.write(
        result, snakemake.output[0], snakemake.params.kind, config=config, code_version=snakemake.params.version
    )
