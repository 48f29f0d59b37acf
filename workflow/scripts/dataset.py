"""A stage's dataset: one function of the package, called with wildcards, config and inputs by their names."""

from pathlib import Path

from boundary import call, job, open_dataset, records_named

with job(snakemake):
    from rockdamp.laboratory.sections import LaboratoryConfig
    from rockdamp.motions.records import read_record
    from rockdamp.storage import dataset

    def each(read, named):
        """Read a file, or several into a list."""
        return read(named) if isinstance(named, str) else [read(path) for path in named]

    params, paths = snakemake.params, dict(snakemake.input.items())
    keys = [key.format(**dict(snakemake.wildcards.items())) for key in params.config_keys]
    config = LaboratoryConfig.model_validate(snakemake.config).part(keys)
    given = {name: each(read_record, paths[name]) for name in params.records}
    for name, records in given.items():
        if isinstance(records, list):
            given[name] = {Path(path).stem: record for path, record in zip(paths[name], records, strict=True)}
    for name in params.datasets:
        given[name] = each(lambda path: open_dataset(snakemake, path), paths[name])
    alone = [paths[name] for name in params.records if isinstance(paths[name], str)]
    with records_named(alone):
        result = call(params.function, *snakemake.wildcards, config, **given)
    dataset.write(result, snakemake.output[0], params.kind, config=params.config, code_version=params.version)
