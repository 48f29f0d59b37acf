"""A stage: a function of the package, called with its rule's wildcards, config and inputs."""

import importlib
import sys
from hashlib import sha256
from importlib.metadata import version

from rockdamp.config import Config
from rockdamp.config.keys import restrict
from rockdamp.storage import dataset

sys.stderr = sys.stdout = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)


def load(path):
    """Import a function of the package by its dotted path."""
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(f"rockdamp.{module}"), name)


def read(paths):
    """Read datasets; return the path of any other file."""
    if not isinstance(paths, str):
        return [read(path) for path in paths]
    return dataset.read(paths) if paths.endswith(".nc") else paths


stage, *dependencies = snakemake.params
output = snakemake.output[0]
values = {}
for dependency in dependencies:
    if isinstance(dependency, dict):
        values |= dependency

arguments = list(snakemake.wildcards)
if values:
    arguments.append(restrict(Config.model_validate(snakemake.config), values))
inputs = {name: read(paths) for name, paths in snakemake.input.items()}
if "record" in inputs:
    # Loaded by name, so that the stages without a record do not depend on its reader.
    inputs["record"] = load("motions.record_file.read_record")(inputs["record"])

result = load(stage["function"])(*arguments, **inputs)

if output.endswith(".csv"):
    result.to_csv(output, index=False, lineterminator="\n")
else:
    sources = "\n".join(text for text in dependencies if isinstance(text, str))
    code_version = f"{version('rockdamp')}+{sha256(sources.encode()).hexdigest()[:16]}"
    dataset.write(result, output, stage["dataset"], config=values, code_version=code_version)
