"""Configs for tests: the shipped files with changes, as the model that stages are given."""

from repository import ROOT
from snakemake.utils import update_config

from rockdamp.config.files import merged
from rockdamp.laboratory.sections import LaboratoryConfig


def stated(*changes, minimal=False):
    """Return what the default config states, or the minimal one over it, with changes, nested as in a file."""
    names = ["default", "minimal"] if minimal else ["default"]
    raw = merged([ROOT / f"config/{name}.yaml" for name in names], {})
    for change in changes:
        update_config(raw, change)
    return raw


def configured(*changes, minimal=False):
    """Return the same as a model."""
    return LaboratoryConfig.model_validate(stated(*changes, minimal=minimal))


def changed(config, values):
    """Return a config with other values, as made, at dotted keys; they may lie beyond what a file may state."""
    for key, value in values.items():
        name, _, rest = key.partition(".")
        inner = changed(getattr(config, name), {rest: value}) if rest else value
        config = config.model_copy(update={name: inner})
    return config
