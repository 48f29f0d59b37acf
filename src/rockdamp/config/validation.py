"""The check of a whole config, before anything is built: schema, every stage's settings, rules between keys."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp import plausibility
from rockdamp.config import Config, earthquakes, settings
from rockdamp.config.merging import COMMAND_LINE, origin
from rockdamp.config.parsing import ConfigError, Settings, section
from rockdamp.config.results_folder import refuse_braces
from rockdamp.config.rules import amplitude_curves, broken, doubts, studies_of
from rockdamp.config.schema import Problem, schema_problems
from rockdamp.errors import InputError
from rockdamp.motions import catalogue
from rockdamp.motions.records import read_record
from rockdamp.pipeline.stages import keys_of
from rockdamp.statistics.distribution import Distribution
from rockdamp.storage import yaml_file
from rockdamp.storage.dotted_keys import path_of, stated
from rockdamp.vocabulary import STUDIES

# The settings of every stage but that of identification, whose distributions are parsed one by one.
SETTINGS = [
    kind
    for module in (settings, earthquakes)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Settings) and kind.__module__ == module.__name__
]


def validate(config: Config, schema: str | Path, files: Sequence[str | Path]) -> None:
    """Check a config, merged from `files`, and warn of what it holds that is possible and unlikely.

    An `InputError` has a line for each thing that is wrong, and where it stands.
    """
    wrong = schema_problems(config, read_schema(schema)) or problems(config)
    if wrong:
        raise InputError("\n".join(_line(origin(problem.path, config, files), problem) for problem in wrong))
    with plausibility.as_meant():
        said = list(doubts(config))
    plausibility.warn([f"{origin(path_of(doubt.key), config, files)}: {doubt}" for doubt in said])


def _line(place: str, problem: Problem) -> str:
    """One line of the error; where the command line states what is nested, also how to state it."""
    misnamed = problem.text.startswith(("is not a key", "is now called"))
    nested = len(problem.path) > 1 and not misnamed or "a mapping" in problem.text
    hint = "; write nested values in a file and pass --configfile" if place == COMMAND_LINE and nested else ""
    return f"{place}: {problem}{hint}"


def read_schema(path: str | Path) -> dict[str, Any]:
    """Read the config's schema, JSON Schema as YAML; it requires every study of free decay."""
    schema: dict[str, Any] = yaml_file.load(Path(path).read_text(encoding="utf-8"))
    schema["properties"]["studies"]["required"] = list(STUDIES)
    return schema


def problems(config: Config) -> list[Problem]:
    """List what is wrong with a config that fits its schema: in its stages' settings, else between its keys."""
    with plausibility.as_meant(), np.errstate(all="ignore"):  # `warn` names the unlikely; what overflows is refused
        wrong = list(_refusals(config)) or list(broken(config))
    return list(dict.fromkeys(Problem(path_of(error.key), error.text) for error in wrong))


def _refusals(config: Config) -> Iterator[ConfigError]:
    """Parse the settings of every stage, and make what they are the first to make of several."""
    makers = [*(kind.of for kind in SETTINGS), _identification, studies_of, amplitude_curves]
    for make in makers:
        try:
            make(config)
        except ConfigError as error:
            yield error


def _identification(config: Config) -> None:
    """Parse the distributions of the section `identification`."""
    for part in ("identification.prior", "identification.simulated"):
        for name, value in stated(config, part).items():
            if isinstance(value, dict):
                section(Distribution, value, f"{part}.{name}")


def require_readable_motions(config: Config) -> None:
    """Read the records of tests and the user's ground motions that a config names, or raise `InputError`."""
    tests = [stated(config, key) for key in keys_of("record")]
    tests += [path for key in keys_of("test_series") for path in stated(config, key)]
    lists = [stated(config, key) for key in keys_of("motions")]
    own = [path for entries in lists for path in catalogue.files_of(entries)]
    refuse_braces([*tests, *own])
    for path in tests:
        read_record(path)
    catalogue.warn_of_left_out([entry for entries in lists for entry in entries])
    for path in dict.fromkeys([*tests, *own]):
        catalogue.from_file(path)
