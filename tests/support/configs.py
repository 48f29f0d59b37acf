"""Configs for tests: the shipped files with changes, as the model that stages are given."""

import yaml
from repository import ROOT
from snakemake.utils import update_config

from rockdamp.config import Config


def stated(*changes, minimal=False):
    """Return what the default config states, or the minimal one over it, with changes, nested as in a file."""
    names = ["default", "minimal"] if minimal else ["default"]
    raw = {}
    for change in (
        *(yaml.safe_load((ROOT / f"config/{name}.yaml").read_text()) for name in names),
        *changes,
    ):
        update_config(raw, change)
    return raw


def configured(*changes, minimal=False):
    """Return the same as a model."""
    return Config.model_validate(stated(*changes, minimal=minimal))


def changed(config, values):
    """Return a config with other values, as made, at dotted keys; they may lie beyond what a file may state."""
    for key, value in values.items():
        name, _, rest = key.partition(".")
        inner = changed(getattr(config, name), {rest: value}) if rest else value
        config = config.model_copy(update={name: inner})
    return config
