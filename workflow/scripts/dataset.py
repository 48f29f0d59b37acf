"""A stage's dataset: one function of the package, called with the wildcards, the config and the inputs."""

from pathlib import Path

from boundary import call, files_named, job, open_datasets

with job(snakemake):
    from rockdamp.laboratory.sections import LaboratoryConfig
    from rockdamp.motions.records import read_record
    from rockdamp.storage import dataset

    params, paths = snakemake.params, snakemake.input
    keys = [key.format(**dict(snakemake.wildcards.items())) for key in params.config_keys]
    config = LaboratoryConfig.model_validate(snakemake.config).part(keys)
    inputs = [read_record(path) for path in paths.record]
    if params.test_series:
        inputs.append({Path(path).stem: read_record(path) for path in paths.test_series})
    inputs += open_datasets(snakemake, lazily=params.lazy)
    with files_named(paths.record, paths.datasets):
        result = call(params.function, *snakemake.wildcards, config, *inputs)
    dataset.write(result, snakemake.output[0], params.kind, config=params.config, code_version=params.version)
