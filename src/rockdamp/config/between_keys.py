"""Checks that the config's schema cannot say, between keys, and the parts of it that jobs need.

This runs whenever snakemake starts, so it imports nothing compiled: the few formulas of the curve that it needs stand
here in plain arithmetic, and a test holds them against `TrilinearCurve`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rockdamp import plausibility
from rockdamp.config import Config
from rockdamp.config.earthquakes import natural_problems, population_problems
from rockdamp.config.identification import identification_problems
from rockdamp.config.limits import cost_problems, size_problems
from rockdamp.config.pulses import damper_order_problems, pulse_problems
from rockdamp.config.schema import COMMAND_LINE, KeyPath, Problem, ascending, dotted, origin, schema_problems
from rockdamp.config.walls import wall_doubts, wall_problems
from rockdamp.errors import InputError
from rockdamp.storage import yaml_file
from rockdamp.vocabulary import DEFAULT_WINDOW, PRESETS, STANDARD_GRAVITY, STUDIES

WHOLE = 1e-9  # how far from a whole number of steps a grid's end may lie, as a fraction of the number of steps
FEWEST = 3  # values of e: the polynomials of Fig. 7 have three coefficients


class Case(NamedTuple):
    """A curve that the config asks for, with the step and the releases that it is run with."""

    path: KeyPath  # of the section, or of the one value, that states it
    a1: float
    b1: float
    a3: float
    softening: str
    step: tuple[KeyPath, float]
    releases: Sequence[tuple[KeyPath, float]]
    varied: str = "cracked_stiffness_ratio"  # what the one value is

    @property
    def a2(self) -> float:
        """End of the plateau, as `TrilinearCurve.plateau_end`. [-]"""
        return (1.0 if self.softening == "steeper" else self.a3) - self.b1


def validate(config: Config, schema: str | Path, files: Iterable[str | Path]) -> None:
    """Check a config against its schema, then as `check` does.

    Parameters
    ----------
    config : dict
        As merged from all its files.
    schema : path
        JSON Schema, draft 2020-12, as YAML.
    files : sequence of paths
        Of the config, in the order in which they were merged.

    Raises
    ------
    InputError
        With a line for each thing that is wrong, and where it stands.
    """
    wrong = schema_problems(config, read_schema(schema)) or size_problems(config) or problems(config)
    if wrong:
        files = list(files)
        raise InputError("\n".join(_told(origin(problem.path, config, files), problem) for problem in wrong))


def _told(place: str, problem: Problem) -> str:
    """One line of the error; where the command line states what is nested, also how to state it."""
    nested = len(problem.path) > 1 and "is not a key" not in problem.text or "a mapping" in problem.text
    hint = "; write nested values in a file and pass --configfile" if place == COMMAND_LINE and nested else ""
    return f"{place}: {problem}{hint}"


def warn(config: Config, files: Iterable[str | Path]) -> None:
    """Warn of what a valid config holds that is possible and unlikely, and where it stands.

    Parameters
    ----------
    config, files
        As for `validate`.
    """
    files = list(files)
    plausibility.warn([f"{origin(doubt.path, config, files)}: {doubt}" for doubt in wall_doubts(config)])


def read_schema(path: str | Path) -> dict[str, Any]:
    """Read the config's schema, JSON Schema as YAML; it requires every study of free decay."""
    schema: dict[str, Any] = yaml_file.load(Path(path).read_text(encoding="utf-8"))
    schema["properties"]["studies"]["required"] = list(STUDIES)
    return schema


def check(config: Config) -> None:
    """Raise `InputError`, with a line for each thing, where values of a config that fits the schema do not agree."""
    wrong = problems(config)
    if wrong:
        raise InputError("\n".join(map(str, wrong)))


def problems(config: Config) -> list[Problem]:
    """List where values of a config that fits the schema do not agree."""
    cases = list(_cases(config))
    wrong = [problem for case in cases for problem in _curve_problems(case)]
    if not wrong:  # what follows needs curves that exist
        wrong += _window_problems(config, cases)
    wrong += [*_grid_problems(config), *_study_problems(config)]
    wrong += [*_dispersion_problems(config), *pulse_problems(config), *damper_order_problems(config)]
    wrong += identification_problems(config)
    of_walls = list(natural_problems(config))
    wrong += of_walls or _matched_wall_problems(config)
    of_population = list(population_problems(config))
    wrong += of_population
    if not of_walls and not of_population:  # what follows needs walls that are stated
        wrong += wall_problems(config)
    if "png" not in config["figures"]["formats"]:
        text = f"is {config['figures']['formats']}; png must be among them, as the report shows it"
        wrong.append(Problem(("figures", "formats"), text))
    scan, test = config["matching"]["scan"], config["validation"]
    if not scan["smallest"] < scan["largest"]:
        text = f"is {scan['largest']}; it must be greater than matching.scan.smallest, {scan['smallest']}"
        wrong.append(Problem(("matching", "scan", "largest"), text))
    records: list[tuple[KeyPath, str]] = [(("validation", "record"), test["record"])]
    records += [(("validation", "ladder", index), record) for index, record in enumerate(test["ladder"])]
    for path, record in records:
        if not Path(record).is_file():
            wrong.append(Problem(path, f"is {record!r}; it must be a file, seen from the folder of the run"))
    names = [Path(record).stem for record in test["ladder"]]
    for index, name in enumerate(names):
        if name in names[:index]:
            text = f"is named {name!r}, as one before it; each must have a name of its own"
            wrong.append(Problem(("validation", "ladder", index), text))
    return list(dict.fromkeys(wrong)) or cost_problems(config)


# --- curves --------------------------------------------------------------------------------------------------------


def _cases(config: Config) -> Iterator[Case]:
    """Every curve of the config, with the releases that it starts from."""
    curve, studies, rigid = config["curve"], config["studies"], config["loops"]["rigid"]
    step: tuple[KeyPath, float] = (("solver", "step"), config["solver"]["step"])
    released: tuple[KeyPath, float] = (("release_amplitude",), config["release_amplitude"])
    path: KeyPath = ("studies", "amplitude", "release_amplitude")
    varied = [((*path, index), x0) for index, x0 in enumerate(studies["amplitude"]["release_amplitude"])]
    yield Case(("curve",), *_parameters(curve), step, [released, *varied])

    for study, key in STUDIES.items():
        for index, value in enumerate(studies[study][key] if key in curve else []):
            own, beyond = {**curve, key: value}, studies[study].get("plateau_ratio_beyond")
            if beyond and value >= beyond[key]:
                own["plateau_ratio"] = beyond["plateau_ratio"]
            yield Case(("studies", study, key, index), *_parameters(own), step, [released], key)

    released = (("loops", "rigid", "release_amplitude"), rigid["release_amplitude"])
    a1, b1 = rigid["cracked_stiffness_ratio"], rigid["plateau_ratio"]
    yield Case(("loops", "rigid"), a1, b1, 1.0, "steeper", step, [released])

    step = (("validation", "step"), config["validation"]["step"])
    yield Case(("validation", "curve"), *_parameters(config["validation"]["curve"]), step, [])


def _parameters(curve: Config) -> tuple[float, float, float, str]:
    return curve["cracked_stiffness_ratio"], curve["plateau_ratio"], curve["ultimate_ratio"], curve["softening"]


def _curve_problems(case: Case) -> Iterator[Problem]:
    """The curve has a plateau and a softening branch, the step is stable on it, no release is beyond its end."""
    one_value = isinstance(case.path[-1], int)
    at_a1, at_a3 = (
        case.path if one_value and case.varied == key else (*(("curve",) if one_value else case.path), key)
        for key in ("cracked_stiffness_ratio", "ultimate_ratio")
    )
    of_a1, of_a3 = (
        "" if path[: len(case.path)] == case.path else f", of {dotted(case.path)}" for path in (at_a1, at_a3)
    )
    steeper = case.softening == "steeper"
    room = 1 - case.b1 if steeper else case.a1 + case.b1
    if not case.a3 > room:
        reason = "1 - b1 with steeper softening" if steeper else "a1 + b1 with translated softening"
        yield Problem(at_a3, f"is {case.a3}; a3 must be greater than {reason}, {room:.6g}{of_a3}")
    elif not case.a1 < case.a2:
        text = f"is {case.a1}; a1 must be less than a2, where the plateau ends, {case.a2:.6g} at b1 = {case.b1}{of_a1}"
        yield Problem(at_a1, text)
    limit = 2 / math.sqrt(case.b1 / case.a1)
    path, step = case.step
    if not step < limit:
        text = f"is {step}; it must be less than the stability limit 2 sqrt(a1/b1), {limit:.6g} for {dotted(case.path)}"
        yield Problem(path, text)
    for path, x0 in case.releases:
        if not x0 < case.a3:
            yield Problem(path, f"is {x0}; it must be less than a3, {case.a3}, where the wall collapses")


def first_impact(case: Case, x0: float) -> float:
    """Time to the first impact after a release at rest from `x0`: a quarter of `TrilinearCurve.period`. [-]"""
    a1, a2, a3, b1 = case.a1, case.a2, case.a3, case.b1
    k1, ks = b1 / a1, b1 / (a3 - a2)
    on1, on2 = min(x0, a1), min(max(x0, a1), a2)

    def double_energy(x: float) -> float:
        z1, z2, z3 = min(x, a1), min(max(x, a1), a2), min(max(x, a2), a3)
        return k1 * z1 * z1 + 2 * b1 * (z2 - a1) + ks * (z3 - a2) * (2 * a3 - a2 - z3)

    def speed(x: float) -> float:
        return math.sqrt(max(double_energy(x0) - double_energy(x), 0.0))

    tau = math.atan2(math.sqrt(k1) * on1, speed(on1)) / math.sqrt(k1)
    if x0 > a1:
        tau += (speed(on1) - speed(on2)) / b1
    if x0 > a2:
        tau += math.acosh((a3 - a2) / (a3 - x0)) / math.sqrt(ks)
    return tau


# --- lengths and grids ---------------------------------------------------------------------------------------------


def frequency_parameter(wall: Config) -> float:
    """p, as `Wall.frequency_parameter`. [rad s-1]"""
    lower = wall["hinge_ratio"] * wall["thickness"] * wall["slenderness"]
    upper = wall["thickness"] * wall["slenderness"] - lower
    overburden = wall["overburden_ratio"]
    return math.sqrt(1.5 * STANDARD_GRAVITY * (2 * (1 + overburden) / lower + 2 * overburden / upper))


def _window(config: Config) -> float:
    """The length of the response, in tau."""
    window = config["matching"]["window"]
    return DEFAULT_WINDOW if window == "default" else window


def _window_problems(config: Config, cases: Sequence[Case]) -> Iterator[Problem]:
    """Each response lasts beyond its first impact, before which no damping ratio is defined, and decays are as long."""
    rigid = ("loops", "rigid")
    studies = max(first_impact(case, x0) for case in cases if case.path != rigid for _, x0 in case.releases)
    loops = max(first_impact(case, x0) for case in cases if case.path == rigid for _, x0 in case.releases)
    window, longest = _window(config), config["windows"]["stop"]
    shown = f"'default', {window}" if config["matching"]["window"] == "default" else window
    start, length = config["windows"]["start"], config["loops"]["window"]
    for path, text, value, latest in (
        (("windows", "start"), start, start, studies),
        (("matching", "window"), shown, window, studies),
        (("loops", "window"), length, length, loops),
    ):
        if not value > latest:
            text = f"is {text}; it must be greater than {latest:.6g}, the time of the latest first impact (in tau)"
            yield Problem(path, text)
    if not window <= longest:
        text = f"is {shown}; it must be at most windows.stop, {longest}, to which decays run (in tau)"
        yield Problem(("matching", "window"), text)
        return
    # Held in seconds at the length that the reference wall has, the response of another wall is another length in tau.
    released = first_impact(cases[0], config["release_amplitude"])
    seconds = window / frequency_parameter(config["wall"])
    for study, key in STUDIES.items():
        for index, value in enumerate(config["studies"][study][key] if key in config["wall"] else []):
            length = seconds * frequency_parameter({**config["wall"], key: value})
            if not released < length <= longest:
                text = f"is {value}; at {seconds:.6g} s its response has length {length:.6g} (in tau), which must be"
                text += f" greater than {released:.6g}, its first impact, and at most windows.stop, {longest}"
                yield Problem(("studies", study, key, index), text)


def _grid_problems(config: Config) -> Iterator[Problem]:
    """A grid ends on a step, and there are enough values of e."""
    for name in ("restitution", "windows"):
        start, stop, step = (config[name][key] for key in ("start", "stop", "step"))
        count = (stop - start) / step
        if not start < stop:
            yield Problem((name, "stop"), f"is {stop}; it must be greater than {name}.start, {start}")
        elif abs(count - round(count)) > WHOLE * count:
            text = f"is {step}; a whole number of steps must lead from {name}.start, {start}, to {name}.stop, {stop}"
            yield Problem((name, "step"), text)
        elif name == "restitution" and round(count) + 1 < FEWEST:
            yield Problem((name, "step"), f"is {step}; there must be at least {FEWEST} values from {start} to {stop}")


def _study_problems(config: Config) -> Iterator[Problem]:
    """A study's values ascend, and what other stages look up in them is there."""
    for study, key in STUDIES.items():
        yield from ascending(("studies", study, key), config["studies"][study][key])
    amplitudes = config["studies"]["amplitude"]["release_amplitude"]
    if config["release_amplitude"] not in amplitudes:
        text = f"is {config['release_amplitude']}; it must be among studies.amplitude.release_amplitude, {amplitudes}"
        yield Problem(("release_amplitude",), text)
    yield from _fit_problems(config)


def _fit_problems(config: Config) -> Iterator[Problem]:
    """The polynomials belong to `curve.plateau_ratio` and reach the e and the a1 at which the validation needs them."""
    study, test = config["studies"]["cracked_stiffness"], config["validation"]
    beyond = study["plateau_ratio_beyond"]
    a1 = [
        value
        for value in study["cracked_stiffness_ratio"]
        if value < beyond["cracked_stiffness_ratio"] or beyond["plateau_ratio"] == config["curve"]["plateau_ratio"]
    ]
    e = config["restitution"]
    if not a1:
        limit = beyond["cracked_stiffness_ratio"]
        text = f"has no value below {limit}, from where on another plateau is used; it must have one"
        yield Problem(("studies", "cracked_stiffness", "cracked_stiffness_ratio"), text)
    for index, value in enumerate(test["fit_cracked_stiffness_ratios"]):
        if a1 and not a1[0] <= value <= a1[-1]:
            path = ("validation", "fit_cracked_stiffness_ratios", index)
            yield Problem(path, f"is {value}; it must lie within the a1 of the polynomials, {a1[0]} to {a1[-1]}")
    if not e["start"] <= test["restitution"] <= e["stop"]:
        text = f"is {test['restitution']}; it must lie within the e of the polynomials, {e['start']} to {e['stop']}"
        yield Problem(("validation", "restitution"), text)


# --- beyond the paper ----------------------------------------------------------------------------------------------


def _dispersion_problems(config: Config) -> Iterator[Problem]:
    """The curves of the dispersion exist, the window lasts beyond their first impacts, amplitudes ascend."""
    section = config["dispersion"]
    beyond = config["studies"]["cracked_stiffness"]["plateau_ratio_beyond"]
    step: tuple[KeyPath, float] = (("solver", "step"), config["solver"]["step"])
    shapes: list[tuple[KeyPath, float, float]] = []
    for index, a1 in enumerate(section["cracked_stiffness_ratio"]):
        wide = a1 >= beyond["cracked_stiffness_ratio"]
        b1 = beyond["plateau_ratio"] if wide else config["curve"]["plateau_ratio"]
        shapes.append((("dispersion", "cracked_stiffness_ratio", index), a1, b1))
    path: KeyPath = ("dispersion", "ultimate_ratio")
    shapes += [(path, a1, b1) for b1, a1 in PRESETS.values()]
    cases = [Case(path, a1, b1, 1.0, "steeper", step, []) for path, a1, b1 in shapes]
    wrong = [problem for case in cases for problem in _curve_problems(case)]
    plateaus = [*(case.b1 for case in cases), *section["map"]["plateau_ratio"]]
    if not section["ultimate_ratio"] > 1 - min(plateaus):
        text = f"is {section['ultimate_ratio']}; a3 must be greater than 1 - b1, {1 - min(plateaus):.6g}"
        wrong.append(Problem(path, text))
    yield from wrong
    window = _window(config)
    latest = 0.0 if wrong else max(first_impact(case, max(section["release_share"])) for case in cases)
    if not window > latest:
        text = f"is {max(section['release_share'])}; the first impact from there, at {latest:.6g} in tau, must come"
        yield Problem(("dispersion", "release_share"), f"{text} before the end of matching.window, {window}")
    for key in ("release_share", "restitution"):
        yield from ascending(("dispersion", key), section[key])
    for key in ("cracked_stiffness_ratio", "plateau_ratio"):
        yield from ascending(("dispersion", "map", key), section["map"][key])


def _matched_wall_problems(config: Config) -> Iterator[Problem]:
    """Walls that earthquakes shake are matched too: the step is stable on each, the first impact within the window."""
    x0, window = config["release_amplitude"], _window(config)
    step: tuple[KeyPath, float] = (("solver", "step"), config["solver"]["step"])
    for index, wall in enumerate(config["natural"]["walls"]):
        stated = (wall.get("plateau_ratio"), wall.get("cracked_stiffness_ratio"))
        b1, a1 = PRESETS[wall["preset"]] if "preset" in wall else stated
        case = Case(("natural", "walls", index), a1, b1, 1.0, "steeper", step, [(("release_amplitude",), x0)])
        wrong = list(_curve_problems(case))
        yield from wrong
        if not wrong and not window > (first := first_impact(case, x0)):
            text = f"has its first impact at {first:.6g} (in tau) from {x0}; that must come before the end of"
            yield Problem(case.path, f"{text} matching.window, {window}")
