"""Rules between the keys of a config, which its schema cannot say and no single stage can check.

Each rule takes a config of which every stage's settings can be parsed, and yields what breaks it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from rockdamp import plausibility
from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import (
    EarthquakeWallSettings,
    OrderRecordSettings,
    PopulationWallSettings,
)
from rockdamp.config.parsing import ConfigError
from rockdamp.config.settings import (
    AccuracySettings,
    AmplitudeDependenceSettings,
    DamperOrderSettings,
    DampingForceSettings,
    DecaySettings,
    MatchSettings,
    PulseSettings,
    ResponseLengthSettings,
    ValidationSettings,
)
from rockdamp.config.walls import Study, StudySettings
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import has_displacement
from rockdamp.storage.dotted_keys import stated
from rockdamp.vocabulary import PRESETS, STUDIES

FEWEST = 3  # values of e: the polynomials of Fig. 7 have three coefficients

Problems = Iterator[ConfigError]


def studies_of(config: Config) -> list[Study]:
    """Return the walls of every study."""
    settings = StudySettings.of(config)
    return [settings.study(name) for name in STUDIES]


def amplitude_curves(config: Config) -> TrilinearCurve:
    """Return the curves of the study of amplitude dependence with a3 = 1, and those of the presets."""
    settings = AmplitudeDependenceSettings.of(config)
    a1 = settings.amplitude_dependence.yield_displacement_ratio
    b1 = settings.strength_ratio_beyond.at(a1, settings.strength_ratio)
    presets = np.array(list(PRESETS.values()))
    try:
        return TrilinearCurve(np.append(a1, presets[:, 1]), np.append(b1, presets[:, 0]))
    except InputError as error:
        raise ConfigError(
            "amplitude_dependence.yield_displacement_ratio", f"has a curve that cannot be: {error}"
        ) from None


# --- time ------------------------------------------------------------------------------------------------------------


def steps_are_stable(config: Config) -> Problems:
    """A step in tau must be below the stability limit of every curve that is run with it."""
    solver, test, order = DecaySettings.of(config), ValidationSettings.of(config), DamperOrderSettings.of(config)
    of_solver = {
        "curve": solver.curve,
        **{f"studies.{study.name}": study.curve for study in studies_of(config)},
        "damping_force.rigid": DampingForceSettings.of(config).damping_force.rigid.curve,
        "amplitude_dependence": amplitude_curves(config),
        **{f"earthquakes.walls[{i}]": wall.curve for i, wall in enumerate(EarthquakeWallSettings.of(config).walls)},
    }
    for key, step, curves in (
        ("solver.step", solver.solver.step, of_solver),
        ("validation.step", test.step, {"validation.curve": test.curve}),
        ("pulses.step", PulseSettings.of(config).pulses.step, {"curve": solver.curve}),
        ("damper_order.pulses.step", order.damper_order.pulses.step, {"curve": solver.curve}),
    ):
        limits = {name: 2 / float(np.max(curve.initial_frequency)) for name, curve in curves.items()}
        name = min(limits, key=limits.__getitem__)
        if not step < limits[name]:
            allowed = f"less than the stability limit 2 sqrt(a1/b1), {limits[name]:.6g} for {name}"
            yield ConfigError(key, f"is {step}; it must be {allowed}")


def releases_are_within_the_curve(config: Config) -> Problems:
    """A decay must start where the wall still stands."""
    for study in studies_of(config):
        bad = study.release_amplitude >= study.curve.ultimate_displacement_ratio
        for index in np.flatnonzero(bad)[:1]:
            varied = study.parameter == "release_amplitude"
            key = f"studies.{study.name}.release_amplitude[{index}]" if varied else "release_amplitude"
            a3 = np.broadcast_to(study.curve.ultimate_displacement_ratio, bad.shape)[index]
            text = f"is {study.release_amplitude[index]}; it must be less than a3, {a3:g}, where the wall collapses"
            yield ConfigError(key, text)


def responses_have_an_impact(config: Config) -> Problems:
    """A response must last beyond its first impact, before which no damping ratio is defined."""
    x0, response_length = stated(config, "release_amplitude"), MatchSettings.of(config).matching.response_length
    force, lengths = DampingForceSettings.of(config).damping_force, ResponseLengthSettings.of(config).response_lengths
    latest = max(float(np.max(_first_impact(study.curve, study.release_amplitude))) for study in studies_of(config))
    rigid = float(_first_impact(force.rigid.curve, np.asarray(force.rigid.release_amplitude)))
    for key, length, impact in (
        ("response_lengths.start", lengths[0], latest),
        ("matching.response_length", response_length, latest),
        ("damping_force.response_length", force.response_length, rigid),
    ):
        if not length > impact:
            allowed = f"greater than {impact:.6g}, the time of the latest first impact (in tau)"
            yield ConfigError(key, f"is {length}; it must be {allowed}")
    for index, named in enumerate(EarthquakeWallSettings.of(config).walls):
        impact = float(_first_impact(named.curve, np.asarray(x0)))
        if not response_length > impact:
            text = f"has its first impact at {impact:.6g} (in tau) from {x0}; that must come before the end of"
            yield ConfigError(f"earthquakes.walls[{index}]", f"{text} matching.response_length, {response_length}")
    share = AmplitudeDependenceSettings.of(config).amplitude_dependence.release_share[-1]
    impact = float(np.max(_first_impact(amplitude_curves(config), share)))
    if not response_length > impact:
        text = f"is {share}; the first impact from there, at {impact:.6g} in tau, must come"
        yield ConfigError(
            "amplitude_dependence.release_share",
            f"{text} before the end of matching.response_length, {response_length}",
        )


def _first_impact(curve: TrilinearCurve, x0: Array) -> Array:
    """Time from a release at rest to the first impact, a quarter of the period. [-]"""
    return curve.period(x0) / 4


def decays_are_as_long_as_matches(config: Config) -> Problems:
    """Decays run to response_lengths.stop, and what is matched to them must not be longer.

    Held in seconds at the length that the reference wall has, the response of another wall is another length in tau.
    """
    settings = DecaySettings.of(config)
    response_length, longest = settings.response_length, settings.longest
    if not response_length <= longest:
        yield ConfigError(
            "matching.response_length",
            f"is {response_length}; it must be at most response_lengths.stop, {longest:g} (in tau)",
        )
        return
    seconds = response_length / settings.wall.frequency_parameter
    for study in studies_of(config):
        lengths = np.asarray(seconds * study.frequency_parameter)
        impact = np.broadcast_to(_first_impact(study.curve, study.release_amplitude), lengths.shape)
        for index in np.flatnonzero(study.of_wall & ~((impact < lengths) & (lengths <= longest))):
            text = f"is {study.values[index]:g}; at {seconds:.6g} s its response has length {lengths[index]:.6g}, which"
            text += f" must be greater than {impact[index]:.6g}, its first impact, and at most {longest:g} (in tau)"
            yield ConfigError(f"studies.{study.name}.{study.parameter}[{index}]", text)


# --- values that other stages look up -------------------------------------------------------------------------------


def grids_hold_what_is_looked_up(config: Config) -> Problems:
    """The reference release and the test's values must be among those that were computed."""
    x0, values = stated(config, "release_amplitude"), stated(config, "studies.amplitude.release_amplitude")
    if x0 not in values:
        text = f"is {x0}; it must be among studies.amplitude.release_amplitude, {values}"
        yield ConfigError("release_amplitude", text)
    shown, used = (stated(config, f"measured_rocking.{name}") for name in ("shown_impacts", "impacts_used"))
    if shown not in used:
        yield ConfigError("measured_rocking.shown_impacts", f"is {shown}; it must be among impacts_used, {used}")
    e, test = DecaySettings.of(config).restitution, ValidationSettings.of(config)
    if len(e) < FEWEST:
        text = f"is {stated(config, 'restitution.step')}; there must be at least {FEWEST} values"
        yield ConfigError("restitution.step", text)
    if not e[0] <= test.restitution <= e[-1]:
        text = f"is {test.restitution}; it must lie within the e of the polynomials, {e[0]:g} to {e[-1]:g}"
        yield ConfigError("validation.restitution", text)
    varied = StudySettings.of(config).study("cracked_stiffness")
    a1 = varied.values[varied.curve.strength_ratio == stated(config, "curve.strength_ratio")]
    if not a1.size:
        text = "has no value with the plateau of curve, below strength_ratio_beyond; it must have one"
        yield ConfigError("studies.cracked_stiffness.yield_displacement_ratio", text)
        return
    for index, value in enumerate(test.fit_yield_displacement_ratios):
        if not a1[0] <= value <= a1[-1]:
            text = f"is {value}; it must lie within the a1 of the polynomials, {a1[0]:g} to {a1[-1]:g}"
            yield ConfigError(f"validation.fit_yield_displacement_ratios[{index}]", text)


def changed_restitution_stays_possible(config: Config) -> Problems:
    """Where e is lowered and raised a little, it must stay above 0 and up to 1."""
    walls, orders = EarthquakeWallSettings.of(config), OrderRecordSettings.of(config)
    test, order = DamperOrderSettings.of(config), DamperOrderSettings.of(config).damper_order
    for key, change, e in (
        ("earthquakes", orders.restitution_change, [*walls.restitution, *orders.restitution]),
        ("damper_order", order.restitution_change, [*order.restitution, test.tested_restitution]),
    ):
        if not (min(e) - change > 0 and max(e) + change <= 1):
            text = f"is {change}; every e of {key}, {min(e):g} to {max(e):g}, must stay above 0 and up to 1 with it"
            yield ConfigError(f"{key}.restitution_change", text)
    if not (highest := float(np.max(orders.restitution))) * np.exp(orders.test_spread) <= 1:
        text = f"is {orders.test_spread}; e of earthquakes.orders, up to {highest:g}, must stay up to 1 with it"
        yield ConfigError("earthquakes.orders.test_spread", text)


def amplitude_dependence_has_both_variants(config: Config) -> Problems:
    """The steeper variant of every curve of the amplitude study must exist."""
    section = AmplitudeDependenceSettings.of(config).amplitude_dependence
    b1 = min(float(np.min(amplitude_curves(config).strength_ratio)), float(section.map.strength_ratio[0]))
    if not section.ultimate_displacement_ratio > 1 - b1:
        text = f"is {section.ultimate_displacement_ratio}; a3 must be greater than 1 - b1, {1 - b1:.6g}"
        yield ConfigError("amplitude_dependence.ultimate_displacement_ratio", text)


def population_has_room_for_every_plateau(config: Config) -> Problems:
    """The largest a1 of the population must fit beside its largest b1, and a parameter correlates with others alone."""
    settings = PopulationWallSettings.of(config)
    a1, b1 = (settings.parameters[name].high for name in ("yield_displacement_ratio", "strength_ratio"))
    if not a1 < 1 - b1:
        text = f"is {a1}; it must be less than 1 - b1, {1 - b1:.6g} at population.parameters.strength_ratio.high = {b1}"
        yield ConfigError("population.parameters.yield_displacement_ratio.high", text)
    for name, other in settings.correlations:
        if name == other:
            text = f"states {name} itself; it must state other parameters"
            yield ConfigError(f"population.correlations.{name}", text)


def names_differ(config: Config) -> Problems:
    """Walls under earthquakes and records of the test series are told apart by their names."""
    walls = [wall.name for wall in EarthquakeWallSettings.of(config).walls]
    records = [Path(record).stem for record in stated(config, "validation.test_series")]
    for key, names in (("earthquakes.walls[{}].name", walls), ("validation.test_series[{}]", records)):
        for index, name in enumerate(names):
            if name in names[:index]:
                text = f"is named {name!r}, as one before it; each must have a name of its own"
                yield ConfigError(key.format(index), text)


def records_are_files(config: Config) -> Problems:
    """The records of the test, which hold the measured displacement, and the trials of free rocking must be there."""
    test_series = stated(config, "validation.test_series")
    keys = [
        "validation.record",
        "measured_rocking.trials",
        *(f"validation.test_series[{index}]" for index in range(len(test_series))),
    ]
    for key in keys:
        if not Path(stated(config, key)).is_file():
            yield ConfigError(key, f"is {stated(config, key)!r}; it must be a file, seen from the folder of the run")
        elif key != "measured_rocking.trials" and not has_displacement(stated(config, key)):
            text = f"is {stated(config, key)!r}, a record without displacement_m; it must hold the wall's displacement"
            yield ConfigError(key, text)


# --- walls -----------------------------------------------------------------------------------------------------------


def squat_walls_rock(config: Config) -> Problems:
    """Walls that are drawn or compared by their shape must rock, down to the most squat."""
    low = {name: drawn.low for name, drawn in PopulationWallSettings.of(config).parameters.items()}
    accuracy = AccuracySettings.of(config)
    thickness, rigid = accuracy.damping_force.rigid.thickness, accuracy.accuracy.rigid
    squat = {
        "population.parameters.slenderness.low": (low["thickness"], low["slenderness"], low["hinge_ratio"]),
        "accuracy.rigid.slenderness": (thickness, min(rigid.slenderness), min(rigid.hinge_ratio)),
    }
    for key, (t, slenderness, hinge_ratio) in squat.items():
        try:
            Wall(t, t * slenderness, hinge_ratio=hinge_ratio)
        except InputError as error:
            yield ConfigError(key, f"makes a wall that cannot rock: {error}")


RULES = (
    steps_are_stable,
    grids_hold_what_is_looked_up,
    changed_restitution_stays_possible,
    amplitude_dependence_has_both_variants,
    population_has_room_for_every_plateau,
    names_differ,
    records_are_files,
    squat_walls_rock,
)
RULES_OF_RELEASES = (responses_have_an_impact, decays_are_as_long_as_matches)  # of walls that do not collapse at once


def broken(config: Config) -> Problems:
    """Yield what breaks a rule."""
    for rule in RULES:
        yield from rule(config)
    collapsed = list(releases_are_within_the_curve(config))
    yield from collapsed
    for rule in RULES_OF_RELEASES if not collapsed else ():
        yield from rule(config)


def doubts(config: Config) -> Iterable[ConfigError]:
    """Yield the walls whose size, density or load masonry hardly has: possible, and likelier a slip of units."""
    walls: dict[str, Wall | Parapet] = {
        "wall": StudySettings.of(config).wall,
        "validation.wall": ValidationSettings.of(config).wall,
        "damping_force.rigid": DampingForceSettings.of(config).damping_force.rigid.wall,
        **{f"earthquakes.walls[{i}]": named.wall for i, named in enumerate(EarthquakeWallSettings.of(config).walls)},
    }
    for key, wall in walls.items():
        loads = plausibility.of_overburden(wall.overburden_ratio, np.divide(wall.weight, wall.width))
        for doubt in [*plausibility.of_density(wall.density), *loads]:
            yield ConfigError(key, f"makes an unlikely wall: {doubt}")
    sizes = {key: (float(wall.thickness), float(wall.height)) for key, wall in walls.items()}
    drawn = PopulationWallSettings.of(config).parameters
    thickness = drawn["thickness"].high
    sizes["population.parameters.thickness.high"] = (thickness, thickness * drawn["slenderness"].high)
    for key, (thickness, height) in sizes.items():
        for doubt in plausibility.of_wall(thickness, height):
            yield ConfigError(key, f"makes an unlikely wall: {doubt}")
