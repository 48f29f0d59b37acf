"""A stage's dataset: one function of the package, called with wildcards, config and inputs by their names."""

from boundary import call, job, open_dataset, records_named

with job(snakemake):
    from rockdamp.config import parse_config
    from rockdamp.motions.records import read_record
    from rockdamp.storage import dataset

    params, paths = snakemake.params, dict(snakemake.input.items())
    keys = [key.format(**dict(snakemake.wildcards.items())) for key in params.config_keys]
    config = parse_config(snakemake.config).part(*keys)
    given = {name: read_record(paths[name]) for name in params.records}
    for name in params.datasets:
        named = paths[name]
        several = not isinstance(named, str)
        given[name] = [open_dataset(snakemake, path) for path in named] if several else open_dataset(snakemake, named)
    with records_named([paths[name] for name in params.records]):
        result = call(params.function, *snakemake.wildcards, config, **given)
    dataset.write(result, snakemake.output[0], params.kind, config=params.config, code_version=params.version)
