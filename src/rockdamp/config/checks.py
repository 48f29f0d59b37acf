"""The check of a whole config, before anything is built: its model, and the rules between keys.

Each rule takes a config that fits its model, and yields what breaks it; sections that null leaves out have no rules.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from rockdamp import plausibility
from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.files import Problem, problems, refuse_braces
from rockdamp.config.study import Study
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.records import has_displacement, read_record
from rockdamp.stated import of_stated
from rockdamp.storage.yaml_file import path_of
from rockdamp.vocabulary import STUDIES

FEWEST = 3  # values of e: the polynomials of Fig. 7 have three coefficients

Rule = Callable[[Any], Iterator[tuple[str, str]]]  # from a config to keys, and what is wrong with each
Problems = Iterator[tuple[str, str]]
C = TypeVar("C", bound=Config)


def validate(kind: type[C], given: Mapping[str, Any], files: Sequence[str | Path], more: Sequence[Rule] = ()) -> C:
    """Return a config, merged from `files`, as its model `kind`; warn of what is possible and unlikely in it.

    An `InputError` has a line for each thing that is wrong, and where it stands. `more` are rules beside those of here.
    """
    said: list[str] = []
    try:
        config = kind.model_validate(given)
    except ValidationError as error:
        wrong = problems(error, kind.model_json_schema())
    else:
        with plausibility.as_meant(), np.errstate(all="ignore"):  # what overflows is refused
            wrong = [Problem(path_of(key), text) for key, text in dict.fromkeys(broken(config, more))]
            said = [Problem(path_of(key), text).line(given, files) for key, text in doubts(config)]
    if wrong:  # what is unlikely stands first, as it may be why
        raise InputError("\n".join([*said, *(problem.line(given, files) for problem in wrong)]))
    plausibility.warn(said)
    return config


def studies_of(config: Config) -> list[Study]:
    """Return the walls of every study."""
    return [config.study(name) for name in STUDIES]


def walls_and_curves_exist(config: Config) -> Problems:
    """Walls and curves that are made of several sections must be possible."""
    for name, parameter in STUDIES.items():
        try:
            config.study(name)
        except InputError as error:
            if error.name == parameter:
                yield f"studies.{name}.{parameter}", error.text
            else:
                yield f"studies.{name}", f"cannot be used: {error}"


# --- time ------------------------------------------------------------------------------------------------------------


def steps_are_stable(config: Config) -> Problems:
    """A step in tau must be below the stability limit of every curve that is run with it."""
    of_solver = {
        "curve": config.curve,
        **{f"studies.{study.name}": study.curve for study in studies_of(config)},
        "damping_force.rigid": config.damping_force.rigid.curve,
    }
    if config.earthquakes:
        walls = enumerate(config.earthquakes.walls)
        of_solver |= {f"earthquakes.walls[{index}]": wall.curve for index, wall in walls}
    cases = [
        ("solver.step", config.solver.step, of_solver),
        ("validation.step", config.validation.step, {"validation.curve": config.validation.curve}),
    ]
    for key, step, curves in cases:
        limits = {name: 2 / float(np.max(curve.initial_frequency)) for name, curve in curves.items()}
        name = min(limits, key=limits.__getitem__)
        if not step < limits[name]:
            allowed = f"less than the stability limit 2 sqrt(a1/b1), {limits[name]:.6g} for {name}"
            yield key, f"is {step}; it must be {allowed}"


def releases_are_within_the_curve(config: Config) -> Problems:
    """A decay must start where the wall still survives."""
    for study in studies_of(config):
        bad = study.release_amplitude >= study.curve.ultimate_displacement_ratio
        for index in np.flatnonzero(bad)[:1]:
            varied = study.parameter == "release_amplitude"
            key = f"studies.{study.name}.release_amplitude[{index}]" if varied else "release_amplitude"
            a3 = np.broadcast_to(study.curve.ultimate_displacement_ratio, bad.shape)[index]
            yield key, f"is {study.release_amplitude[index]}; it must be less than a3, {a3:g}, where the wall collapses"


def responses_have_an_impact(config: Config) -> Problems:
    """A response must last beyond its first impact, before which no damping ratio is defined."""
    x0, response_length, force = config.release_amplitude, config.matching.response_length, config.damping_force
    latest = max(float(np.max(_first_impact(study.curve, study.release_amplitude))) for study in studies_of(config))
    rigid = float(_first_impact(force.rigid.curve, np.asarray(force.rigid.release_amplitude)))
    for key, length, impact in (
        ("response_lengths.start", config.response_lengths.start, latest),
        ("matching.response_length", response_length, latest),
        ("damping_force.response_length", force.response_length, rigid),
    ):
        if not length > impact:
            allowed = f"greater than {impact:.6g}, the time of the latest first impact (in tau)"
            yield key, f"is {length}; it must be {allowed}"
    for index, named in enumerate(config.earthquakes.walls if config.earthquakes else ()):
        impact = float(_first_impact(named.curve, np.asarray(x0)))
        if not response_length > impact:
            text = f"has its first impact at {impact:.6g} (in tau) from {x0}; that must come before the end of"
            yield f"earthquakes.walls[{index}]", f"{text} matching.response_length, {response_length}"
    if config.amplitude:
        share = config.amplitude.release_share[-1]
        impact = float(_first_impact(config.curve, share * config.curve.ultimate_displacement_ratio))
        if not response_length > impact:
            text = f"is {share}; the first impact from there, at {impact:.6g} in tau, must come"
            end = f"before the end of matching.response_length, {response_length}"
            yield "amplitude.release_share", f"{text} {end}"


def _first_impact(curve: TrilinearCurve, x0: Array) -> Array:
    """Time from a release at rest to the first impact, a quarter of the period. [-]"""
    return curve.period(x0) / 4


def decays_are_as_long_as_matches(config: Config) -> Problems:
    """Decays run to response_lengths.stop, and what is matched to them must not be longer.

    Held in seconds at the length that the reference wall has, the response of another wall is another length in tau.
    """
    response_length, longest = config.matching.response_length, config.response_lengths.stop
    if not response_length <= longest:
        text = f"is {response_length}; it must be at most response_lengths.stop, {longest:g} (in tau)"
        yield "matching.response_length", text
        return
    seconds = response_length / config.wall.frequency_parameter
    for study in studies_of(config):
        lengths = np.asarray(seconds * study.frequency_parameter)
        impact = np.broadcast_to(_first_impact(study.curve, study.release_amplitude), lengths.shape)
        for index in np.flatnonzero(study.of_wall & ~((impact < lengths) & (lengths <= longest))):
            text = f"is {study.values[index]:g}; at {seconds:.6g} s its response has length {lengths[index]:.6g}, which"
            text += f" must be greater than {impact[index]:.6g}, its first impact, and at most {longest:g} (in tau)"
            yield f"studies.{study.name}.{study.parameter}[{index}]", text


# --- values that other stages look up -------------------------------------------------------------------------------


def grids_hold_what_is_looked_up(config: Config) -> Problems:
    """What a figure or a later stage looks up must be among the values that were computed."""
    if config.order and not {0.2, 0.4} <= set(config.order.band_width.tolist()):
        yield "order.band_width", f"is {config.order.band_width.tolist()}; it must have 0.2 and 0.4"
    if config.order and 16 not in config.order.order:
        yield "order.order", f"is {config.order.order.tolist()}; it must have 16"
    x0, values = config.release_amplitude, config.studies.amplitude.release_amplitude.tolist()
    if x0 not in values:
        yield "release_amplitude", f"is {x0}; it must be among studies.amplitude.release_amplitude, {values}"
    e, test = config.restitution, config.validation
    if len(e) < FEWEST:
        yield "restitution.step", f"makes {len(e)} values; there must be at least {FEWEST} values"
    varied = config.study("cracked_stiffness")
    a1 = varied.values[varied.curve.strength_ratio == config.curve.strength_ratio]
    if not a1.size:
        text = "has no value with the plateau of curve, below strength_ratio_beyond; it must have one"
        yield "studies.cracked_stiffness.yield_displacement_ratio", text
        return
    for index, value in enumerate(test.fit_yield_displacement_ratios):
        if not a1[0] <= value <= a1[-1]:
            text = f"is {value}; it must lie within the a1 of the polynomials, {a1[0]:g} to {a1[-1]:g}"
            yield f"validation.fit_yield_displacement_ratios[{index}]", text


def changed_restitution_stays_possible(config: Config) -> Problems:
    """Where e is lowered and raised a little, it must stay above 0 and up to 1."""
    cases = [
        (key, section.restitution_change, section.restitution)
        for key, section in (("earthquakes", config.earthquakes), ("order", config.order))
        if section
    ]
    for key, change, e in cases:
        if not (min(e) - change > 0 and max(e) + change <= 1):
            text = f"is {change}; every e of {key}, {min(e):g} to {max(e):g}, must stay above 0 and up to 1 with it"
            yield f"{key}.restitution_change", text


def record_is_a_file(config: Config) -> Problems:
    """The record of the test must be there and hold the measured displacement."""
    key, path = "validation.record", config.validation.record
    if not Path(path).is_file():
        yield key, f"is {path!r}; it must be a file, seen from the folder of the run"
    elif not has_displacement(path):
        yield key, f"is {path!r}, a record without displacement_m; it must hold the wall's displacement"


RULES: tuple[Rule, ...] = (
    steps_are_stable,
    grids_hold_what_is_looked_up,
    changed_restitution_stays_possible,
    record_is_a_file,
)
RULES_OF_RELEASES: tuple[Rule, ...] = (responses_have_an_impact, decays_are_as_long_as_matches)  # of walls that survive


def broken(config: Config, more: Sequence[Rule]) -> Problems:
    """Yield what breaks a rule; what is wrong with walls and curves goes before rules that ask them."""
    impossible = list(walls_and_curves_exist(config))
    yield from impossible
    if impossible:
        return
    for rule in (*RULES, *more):
        yield from rule(config)
    collapsed = list(releases_are_within_the_curve(config))
    yield from collapsed
    for rule in RULES_OF_RELEASES if not collapsed else ():
        yield from rule(config)


def doubts(config: Config) -> Iterable[tuple[str, str]]:
    """Yield the walls whose size, density or load masonry hardly has: possible, and likelier a slip of units."""
    walls: dict[str, Wall | Parapet] = {
        "wall": config.wall,
        "validation.wall": config.validation.wall,
        "damping_force.rigid": config.damping_force.rigid.wall,
    }
    if config.earthquakes:
        walls |= {f"earthquakes.walls[{i}]": named.wall for i, named in enumerate(config.earthquakes.walls)}
    for key, wall in walls.items():
        for doubt in of_stated(replace(wall, eccentricity=0.0)):  # it may have its load in the study of those
            yield key, f"makes an unlikely wall: {doubt}"
    curves = {"curve": config.curve, "validation.curve": config.validation.curve}
    if config.earthquakes:
        curves |= {f"earthquakes.walls[{i}]": named.curve for i, named in enumerate(config.earthquakes.walls)}
    for key, curve in curves.items():
        for doubt in plausibility.of_curve(curve.yield_displacement_ratio, curve.strength_ratio):
            yield key, f"makes an unlikely curve: {doubt}"
    for name in ("", "damping_force", "earthquakes", "amplitude", "order"):
        section = getattr(config, name) if name else config
        for doubt in plausibility.of_restitution(section.restitution) if section else ():
            yield f"{name}.restitution".strip("."), f"is unlikely: {doubt}"


# --- ground motions and folders --------------------------------------------------------------------------------------


def require_readable_motions(tests: Iterable[str], lists: Sequence[Sequence[str]]) -> None:
    """Read the records of tests and the user's ground motions that a config names, or raise `InputError`."""
    of_tests, own = list(tests), [path for entries in lists for path in catalogue.files_of(entries)]
    refuse_braces([*of_tests, *own])
    for test in of_tests:
        read_record(test)
    catalogue.warn_of_left_out([entry for entries in lists for entry in entries])
    for path in dict.fromkeys([*map(str, of_tests), *map(str, own)]):
        catalogue.from_file(path)
