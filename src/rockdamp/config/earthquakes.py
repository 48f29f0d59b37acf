"""Checks between the keys of the config's studies of earthquakes, which its schema cannot say."""

from __future__ import annotations

from collections.abc import Iterator

from rockdamp.config import Config
from rockdamp.config.schema import KeyPath, Problem, ascending
from rockdamp.vocabulary import PRESETS

# Of the population's distributions: what every value must lie between, ends excluded where the third says so.
LIMITS = {
    "thickness": (0.0, float("inf"), "greater than 0"),
    "slenderness": (0.0, float("inf"), "greater than 0"),
    "hinge_ratio": (0.0, 1.0, "between 0 and 1, both excluded"),
    "cracked_stiffness_ratio": (0.0, 1.0, "between 0 and 1, both excluded"),
    "plateau_ratio": (0.0, 1.0, "between 0 and 1, both excluded"),
}


def natural_problems(config: Config) -> Iterator[Problem]:
    """Walls have names of their own, curves that exist and one way to state them; e, scales and bands ascend."""
    section, presets = config["natural"], PRESETS
    names = [wall["name"] for wall in section["walls"]]
    for index, wall in enumerate(section["walls"]):
        path: KeyPath = ("natural", "walls", index)
        if wall["name"] in names[:index]:
            yield Problem((*path, "name"), f"is {wall['name']!r}, which an earlier wall has; each must have its own")
        if ("hinge_ratio" in wall) == wall.get("parapet", False):
            text = "must not be stated for a parapet" if wall.get("parapet") else "must be stated for a strip wall"
            yield Problem((*path, "hinge_ratio"), text)
        stated = [key for key in ("cracked_stiffness_ratio", "plateau_ratio") if key in wall]
        if len(stated) != (0 if "preset" in wall else 2):
            yield Problem(path, "must state either a preset, or cracked_stiffness_ratio and plateau_ratio")
            continue
        b1, a1 = presets[wall["preset"]] if "preset" in wall else (wall["plateau_ratio"], wall[stated[0]])
        if not a1 < 1 - b1:
            text = f"is {a1}; a1 must be less than a2, where the plateau ends, {1 - b1:.6g} at b1 = {b1}"
            yield Problem((*path, "cracked_stiffness_ratio"), text)
    for key in ("restitution", "bands"):
        yield from ascending(("natural", key), section[key])
    yield from ascending(("natural", "orders", "order"), section["orders"]["order"])
    yield from ascending(("natural", "orders", "restitution"), section["orders"]["restitution"])
    change = section["restitution_change"]
    for key, e in (("restitution", section["restitution"]), ("orders.restitution", section["orders"]["restitution"])):
        if not (e[0] - change > 0 and e[-1] + change <= 1):
            text = f"is {change}; every e of natural.{key} must stay above 0 and up to 1 with it"
            yield Problem(("natural", "restitution_change"), text)
    start, stop = section["scale"]["start"], section["scale"]["stop"]
    if not start < stop:
        yield Problem(("natural", "scale", "stop"), f"is {stop}; it must be greater than natural.scale.start, {start}")


def population_problems(config: Config) -> Iterator[Problem]:
    """Distributions have all that they need and no value that a wall cannot have; every curve exists."""
    section = config["population"]
    parameters, path = section["parameters"], ("population", "parameters")
    for name, entry in parameters.items():
        yield from _distribution_problems((*path, name), entry)
        low, high, allowed = LIMITS.get(name, (float("-inf"), float("inf"), ""))
        for key in ("low", "high"):
            if not low < entry[key] < high:
                yield Problem((*path, name, key), f"is {entry[key]}; it must be {allowed}")
    if parameters["overburden_ratio"]["low"] < 0:
        yield Problem(
            (*path, "overburden_ratio", "low"), f"is {parameters['overburden_ratio']['low']}; it must be at least 0"
        )
    e = parameters["restitution"]
    if not (e["low"] > 0 and e["high"] <= 1):
        yield Problem((*path, "restitution"), f"is {e['low']} to {e['high']}; e must be greater than 0 and at most 1")
    a1, b1 = parameters["cracked_stiffness_ratio"]["high"], parameters["plateau_ratio"]["high"]
    if not a1 < 1 - b1:
        text = f"is {a1}; it must be less than 1 - b1, {1 - b1:.6g} at population.parameters.plateau_ratio.high = {b1}"
        yield Problem((*path, "cracked_stiffness_ratio", "high"), text)
    for name, others in section["correlations"].items():
        if name in others:
            yield Problem(("population", "correlations", name), f"states {name} itself; it must state other parameters")
    start, stop = section["intensity"]["start"], section["intensity"]["stop"]
    if not start < stop:
        text = f"is {stop}; it must be greater than population.intensity.start, {start}"
        yield Problem(("population", "intensity", "stop"), text)


def _distribution_problems(path: KeyPath, entry: Config) -> Iterator[Problem]:
    if not entry["low"] < entry["high"]:
        yield Problem((*path, "high"), f"is {entry['high']}; it must be greater than low, {entry['low']}")
    if entry["distribution"] == "loguniform" and not entry["low"] > 0:
        yield Problem((*path, "low"), f"is {entry['low']}; it must be greater than 0 for loguniform")
    moments = [key for key in ("mean", "standard_deviation") if key in entry]
    if len(moments) != (2 if entry["distribution"] == "normal" else 0):
        text = f"is {entry['distribution']}; mean and standard_deviation must be stated for normal, and for it alone"
        yield Problem((*path, "distribution"), text)
