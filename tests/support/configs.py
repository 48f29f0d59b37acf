"""Configs for tests: the shipped files with changes, as the model that stages are given."""

import yaml
from repository import ROOT
from snakemake.utils import update_config

from rockdamp.config import Config


def merge_files(*changes, minimal=False):
    """Return the values of the default config, or of the minimal one, with nested changes."""
    names = ["default", "minimal"] if minimal else ["default"]
    values = {}
    for name in names:
        text = (ROOT / f"config/{name}.yaml").read_text(encoding="utf-8")
        update_config(values, yaml.safe_load(text))
    for change in changes:
        update_config(values, change)
    return values


def configured(*changes, minimal=False):
    """Return the same as a model."""
    return Config.model_validate(merge_files(*changes, minimal=minimal))


def changed(config, values):
    """Return a config with other values at dotted keys, even outside the bounds of a file."""
    for key, value in values.items():
        name, _, rest = key.partition(".")
        if rest:
            value = changed(getattr(config, name), {rest: value})
        config = config.model_copy(update={name: value})
    return config
