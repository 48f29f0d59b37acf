"""Configs with numbers far off are used, or refused with an `InputError`."""

import copy
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from repository import ROOT
from snakemake.utils import update_config

from rockdamp.config import validation as checks
from rockdamp.config.schema import schema_problems
from rockdamp.config.settings import DecaySettings
from rockdamp.config.walls import StudySettings, make_named_wall
from rockdamp.errors import InputError
from rockdamp.plausibility import as_meant
from rockdamp.storage import yaml_file
from rockdamp.studies import force_curves
from rockdamp.vocabulary import STUDIES

SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
FILES = [ROOT / f"config/{name}.yaml" for name in ("default", "minimal")]
few = settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])


def loaded():
    whole = {}
    for path in FILES:
        update_config(whole, yaml_file.load(path.read_text(encoding="utf-8")))
    return whole


def paths(value, path=()):
    """Every place in the config: of sections, of lists, of their items."""
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths(item, (*path, key))


WHOLE = loaded()
RULES = checks.read_schema(SCHEMA)
PATHS = sorted(paths(WHOLE), key=str)
# Of the sections that the cheap stages below read, so that more than the schema is asked.
READ = [
    path for path in PATHS if path[0] in ("wall", "curve", "studies", "earthquakes", "restitution", "release_amplitude")
]
ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**30), 10**30),
    st.floats(),
    st.sampled_from([0, -1, 1e-320, 1e308, 10**400, math.nan, -math.inf, "", "1e-3", "x", [], {}, [[]], {"a": 1}]),
    st.lists(st.floats(), max_size=3),
    st.text(max_size=5),
    st.dictionaries(st.text(max_size=3), st.floats(), max_size=2),
)
FACTOR = st.sampled_from([-1, 0, 0.5, 0.9, 1.1, 2, 10, 1e-6, 1e6, 1e200])


def mutated(config, path, change):
    """Replace what stands at `path` by `change(it)`."""
    *sections, last = path
    for key in sections:
        config = config[key]
    config[last] = change(config[last])


def stretched(factor):
    return lambda value: value * factor if isinstance(value, int | float) and not isinstance(value, bool) else value


@pytest.fixture
def here(monkeypatch):
    monkeypatch.chdir(ROOT)  # the record's path is seen from the folder of the run


def judge(config):
    """Check a config; what is accepted, the cheap stages must take, or refuse as the checks do."""
    found = schema_problems(config, RULES) or checks.problems(config)
    if found:
        assert all(map(str, found))
        return
    try:
        with as_meant():
            made = [StudySettings.of(config).study(name).frequency_parameter for name in STUDIES]
            made += [force_curves.mechanism(config)["force"].values, DecaySettings.of(config).restitution]
            made += [named.wall.frequency_parameter for named in map(make_named_wall, config["earthquakes"]["walls"])]
    except InputError as error:
        assert str(error)
    else:
        assert all(np.isfinite(values).all() for values in made)


@few
@given(st.lists(st.tuples(st.sampled_from(READ), FACTOR), min_size=1, max_size=4))
def test_a_config_with_numbers_far_off_is_used_or_refused(here, changes):
    config = copy.deepcopy(WHOLE)
    for path, factor in changes:
        mutated(config, path, stretched(factor))
    judge(config)


@settings(few, max_examples=10)
@given(st.sampled_from(PATHS), ODD)
def test_whatever_is_wrong_with_a_config_is_told_with_its_place(here, path, value):
    config = copy.deepcopy(WHOLE)
    mutated(config, path, lambda _: value)
    try:
        checks.validate(config, SCHEMA, FILES)
    except InputError as error:
        assert all(line.startswith(("the command line: ", f"{ROOT}/config/")) for line in str(error).splitlines())
