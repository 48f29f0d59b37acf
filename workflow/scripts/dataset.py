"""A stage: a function of the package, called with the values of the config and the inputs that its rule lists."""

import importlib
import sys
from hashlib import sha256
from importlib.metadata import version

from rockdamp.config import parse_config
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)


def load(name):
    module, _, function = name.rpartition(".")
    return getattr(importlib.import_module(f"rockdamp.{module}"), function)


def read(paths):
    if not isinstance(paths, str):
        return [read(path) for path in paths]
    if paths.endswith(".nc"):
        return dataset.read(paths)
    return load("motions.record_file.read_record")(
        paths
    )  # not imported: other stages do not depend on it


params, output = snakemake.params, snakemake.output[0]
values = {key: value for param in params if isinstance(param, dict) for key, value in param.items()}
config = [parse_config(snakemake.config).part(*values)] if values else []
inputs = {name: read(paths) for name, paths in snakemake.input.items()}
result = load(params.function)(*snakemake.wildcards, *config, **inputs)

if output.endswith(".csv"):
    result.to_csv(output, index=False, lineterminator="\n")
elif kind := params.get("dataset"):
    sources = sha256(
        "\n".join(param for param in params if isinstance(param, str)).encode()
    ).hexdigest()[:16]
    dataset.write(
        result, output, kind, config=values, code_version=f"{version('rockdamp')}+{sources}"
    )
else:  # a part, whose variables the stage that joins the parts describes
    result.to_netcdf(output, engine="netcdf4")
