"""Rules between keys of the config, and the errors that name the key."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError

from rockdamp.config.model import Config
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Diaphragm

# Allowed values by the type of pydantic's error.
ALLOWED = {
    "greater_than": "greater than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "multiple_of": "a multiple of {multiple_of:g}",
    **dict.fromkeys(("float_type", "float_parsing", "finite_number"), "a number"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "a whole number"),
    "list_type": "a list",
    "literal_error": "{expected}",
    **dict.fromkeys(("model_type", "model_attributes_type"), "a section of keys"),
    "string_type": "a text",
    "too_long": "a list of at most {max_length} values",
    "too_short": "a list of at least {min_length} values",
}
# Folders of the project, in which results would mix with sources.
SOURCE_FOLDERS = (
    ".git",
    ".venv",
    "benchmarks",
    "config",
    "data",
    "docs",
    "examples",
    "profiles",
    "src",
    "tests",
    "tools",
    "workflow",
)


def parse_config(values: Mapping[str, Any], project: Path) -> Config:
    """Return the config that Snakemake has read and merged.

    Parameters
    ----------
    values : mapping
        The nested values of every key.
    project : Path
        Folder of the project, which has the files of the default config.

    Raises
    ------
    InputError
        One line for each wrong key, with its value and the allowed values.
    """
    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        raise InputError("\n".join(map(_describe, error.errors()))) from None
    check_results(config, project)
    check_files(config, project)
    check_studies(config)
    check_steps(config)
    check_lists(config)
    check_lengths(config)
    check_floors(config)
    return config


def _describe(problem: Any) -> str:
    """Return the line of one of pydantic's errors."""
    *sections, name = problem["loc"]
    key = ".".join(map(str, problem["loc"]))
    if problem["type"] == "extra_forbidden":
        place = ".".join(map(str, sections)) or "the config"
        return f"{key}: unknown key; the keys of {place} are {', '.join(_section_keys(sections))}"
    if problem["type"] == "missing":
        return f"{key}: missing; it must have a value"
    if problem["type"] in ALLOWED:
        allowed = ALLOWED[problem["type"]].format(**problem.get("ctx", {}))
        return f"{key} is {problem['input']!r:.60}; it must be {allowed}"
    line = f"{key}: {problem['msg'].removeprefix('Value error, ')}"
    if not isinstance(problem["input"], Mapping):
        line += f", is {problem['input']!r:.60}"
    return line


def _section_keys(path: Iterable[str | int]) -> list[str]:
    """Return the keys of a section, or of a member of a list of sections."""
    section: Any = Config
    for name in path:
        if isinstance(name, str):
            annotation = section.model_fields[name].annotation
            (section,) = get_args(annotation) or (annotation,)
    return list(section.model_fields)


def _require(holds: bool, key: str, value: Any, allowed: str) -> None:
    if not holds:
        raise InputError(f"{key} is {value!r}; it must be {allowed}")


def check_results(config: Config, project: Path) -> None:
    """Check that the folder of results is apart from the project's sources."""
    name = config.results
    _require(not name.startswith("~"), "results", name, "written in full, as ~ is not expanded")
    folder = Path(os.path.abspath(name))
    contains_project = project.is_relative_to(folder)
    is_in_sources = any(folder.is_relative_to(project / source) for source in SOURCE_FOLDERS)
    allowed = "a folder of its own, such as results/mine, and not one of the project's sources"
    _require(not (contains_project or is_in_sources), "results", name, allowed)


def find_file(name: str, project: Path) -> str:
    """Return the path of a file, in the working directory or else in the project's folder."""
    if not Path(name).exists() and (project / name).exists():
        return str(project / name)
    return name


def check_files(config: Config, project: Path) -> None:
    """Check that the named files exist, in the working directory or in the project's folder."""
    files = {
        "validation.record": config.validation.record,
        "measured_rocking.trials": config.measured_rocking.trials,
    }
    for key, name in files.items():
        exists = Path(find_file(name, project)).is_file()
        _require(exists, key, name, f"a file that exists, seen from {os.getcwd()}")


def check_studies(config: Config) -> None:
    """Check that the walls and curves of the studies are possible."""
    slenderness = np.array(config.studies.slenderness)
    overburden_ratio = np.array(config.studies.overburden)
    makers = {
        "slenderness": lambda: config.wall.make(slenderness=slenderness),
        "overburden": lambda: config.wall.make(overburden_ratio=overburden_ratio),
        "cracked_stiffness": config.cracked_curves,
    }
    for name, make in makers.items():
        try:
            make()
        except InputError as error:
            raise InputError(f"studies.{name}: {error}") from None


def check_steps(config: Config) -> None:
    """Check that steps in tau are below the stability limit of each curve run with them."""
    curves = {
        "curve": config.curve.make(),
        "damping_force.rigid": config.damping_force.rigid.curve,
        "studies.cracked_stiffness": config.cracked_curves(),
    }
    for wall in config.earthquakes.walls:
        curves[f"earthquakes.walls.{wall.name}"] = wall.curve
    _require_stable("solver.step", config.solver.step, curves)
    tested_curve = {"validation.curve": config.validation.curve.make()}
    _require_stable("validation.step", config.validation.step, tested_curve)


def _require_stable(key: str, step: float, curves: Mapping[str, TrilinearCurve]) -> None:
    # The explicit Newmark method needs w1 h < 2; the paper's scheme allows longer steps.
    limits = {}
    for name, curve in curves.items():
        limits[name] = 2 / float(np.max(curve.initial_frequency))
    name = min(limits, key=limits.__getitem__)
    allowed = f"less than the stability limit of {name}, {limits[name]:.6g}"
    _require(step < limits[name], key, step, allowed)


def check_lists(config: Config) -> None:
    """Check that the values which figures and later stages look up are computed."""
    shown_impacts = config.measured_rocking.shown_impacts
    used_impacts = config.measured_rocking.impacts_used
    amplitudes = config.studies.amplitude
    _require_among("order.order", config.order.order, {16: "16"})
    _require_among("order.band_width", config.order.band_width, {0.2: "0.2", 0.4: "0.4"})
    shown = {shown_impacts: f"shown_impacts, {shown_impacts}"}
    _require_among("measured_rocking.impacts_used", used_impacts, shown)
    release = {config.release_amplitude: f"release_amplitude, {config.release_amplitude:g}"}
    _require_among("studies.amplitude", amplitudes, release)
    a3 = config.curve.ultimate_displacement_ratio
    _require(amplitudes[-1] < a3, "studies.amplitude", amplitudes, f"less than a3, {a3:g}")
    names = [wall.name for wall in config.earthquakes.walls]
    are_unique = len(set(names)) == len(names)
    _require(are_unique, "earthquakes.walls", names, "walls of different names")
    e = config.restitution.values()
    is_fittable = e.size >= 3 and e[-1] <= 1  # by polynomials of three coefficients
    _require(is_fittable, "restitution", e.tolist(), "at least three values up to 1")
    for key, section in (("earthquakes", config.earthquakes), ("order", config.order)):
        change = section.restitution_change
        room = min(section.restitution[0], 1 - section.restitution[-1])
        allowed = f"less than {room:g}, so that {key}.restitution stays between 0 and 1"
        _require(change < room, f"{key}.restitution_change", change, allowed)
    _check_fits(config)


def _require_among(key: str, values: list[Any], needed: Mapping[Any, str]) -> None:
    """Check that a list contains values, which have their names in the message."""
    if not set(needed) <= set(values):
        raise InputError(f"{key} is {values!r}; it must contain {' and '.join(needed.values())}")


def _check_fits(config: Config) -> None:
    """Check that the polynomials of the reference plateau reach the a1 of the validation."""
    softer = config.softer_plateau.yield_displacement_ratio
    a1 = [value for value in config.studies.cracked_stiffness if value < softer]
    fits = config.validation.fit_yield_displacement_ratios
    expected = config.validation.curve.yield_displacement_ratio
    allowed = f"within the range of studies.cracked_stiffness with this strength_ratio, {a1}"
    contains_fits = len(a1) > 0 and a1[0] <= fits[0] and fits[-1] <= a1[-1]
    _require(contains_fits, "validation.fit_yield_displacement_ratios", fits, allowed)
    contains_expected = a1[0] <= expected <= a1[-1]
    _require(contains_expected, "validation.curve.yield_displacement_ratio", expected, allowed)


def check_floors(config: Config) -> None:
    """Check that the flexible floors of the supports are possible."""
    for period in config.supports.diaphragm_period:
        try:
            Diaphragm(period, config.supports.diaphragm_damping)
        except InputError as error:
            raise InputError(f"supports.diaphragm_period: {error}") from None


def check_lengths(config: Config) -> None:
    """Check the length of the matched response, and that no decay has too many steps to store."""
    length = config.matching.response_length
    longest = config.response_lengths.stop
    first_impact = float(config.curve.make().period(config.release_amplitude)) / 4
    allowed = (
        f"greater than {first_impact:.6g}, the first impact,"
        f" and at most response_lengths.stop, {longest:g}"
    )
    _require(first_impact < length <= longest, "matching.response_length", length, allowed)
    shortest = longest / 1e6
    allowed = f"at least {shortest:g}, so that the longest response has at most a million steps"
    _require(config.solver.step >= shortest, "solver.step", config.solver.step, allowed)
