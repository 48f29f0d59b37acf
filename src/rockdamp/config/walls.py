"""Whether the walls of a config can rock, and which of them few have seen: what `rockdamp.plausibility` says of them.

This runs whenever snakemake starts, so restitution stands here in plain arithmetic; a test holds it against `Wall`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rockdamp import plausibility
from rockdamp.config import Config
from rockdamp.config.schema import KeyPath, Problem
from rockdamp.errors import InputError
from rockdamp.vocabulary import STUDIES

SHAPE = ("thickness", "slenderness", "hinge_ratio")  # what of a wall decides


class Sizes(NamedTuple):
    """A wall that the config asks for; a parapet has no hinge."""

    path: KeyPath  # of the value that makes it as slender as it is
    thickness: float
    slenderness: float
    hinge_ratio: float | None

    @property
    def restitution(self) -> float:
        """e, as `Wall.restitution` by Eq. (7), or `Parapet.restitution`. [-]"""
        square, r = self.slenderness**2, self.hinge_ratio
        if r is None:
            return 1 - 1.5 / (1 + square)
        return (r * (1 + r) * square - 3) / (r * (1 + r) * square + 3)


def wall_problems(config: Config) -> Iterator[Problem]:
    """Every wall can rock: it is higher than thick, and has a restitution above 0; the overburden stands on it."""
    yield from _told_once([problem for sizes in _sizes(config) for problem in _rocking_problems(sizes)])
    for path, wall in ((("wall",), config["wall"]), (("validation", "wall"), config["validation"]["wall"])):
        limit = wall["thickness"] / 2
        if not abs(wall["eccentricity"]) <= limit:
            text = f"is {wall['eccentricity']}; it must be at most half the thickness, {limit} m, either way"
            yield Problem((*path, "eccentricity"), text)


def _rocking_problems(sizes: Sizes) -> Iterator[Problem]:
    t, h, strip = sizes.thickness, sizes.thickness * sizes.slenderness, sizes.hinge_ratio is not None
    try:
        plausibility.require_rocking(
            t, h, sizes.restitution, 1.0 if strip else 0.0, "Eq. (7)" if strip else "Housner's formula"
        )
    except InputError as error:
        yield Problem(sizes.path, f"makes a wall that cannot rock: {error}")


def wall_doubts(config: Config) -> list[Problem]:
    """List the walls that are larger than masonry walls are: possible, and likelier a slip of units."""
    drawn = config["population"]["parameters"]
    highest = Sizes(
        ("population", "parameters", "thickness", "high"),
        drawn["thickness"]["high"],
        drawn["slenderness"]["high"],
        None,
    )
    doubts = [
        Problem(_largest(sizes), f"makes an unlikely wall: {doubt}")
        for sizes in (*_sizes(config), highest)
        for doubt in plausibility.of_wall(sizes.thickness, sizes.thickness * sizes.slenderness)
    ]
    return _told_once(doubts)


def _told_once(problems: list[Problem]) -> list[Problem]:
    """Leave out what is said of the studies' walls where it is said of the wall that they vary."""
    told = any(problem.path[0] == "wall" for problem in problems)
    return [problem for problem in problems if not (told and problem.path[0] == "studies")]


def _sizes(config: Config) -> Iterator[Sizes]:
    """Every wall of the config, and of those that are drawn or compared by their shape the most squat."""
    wall, rigid = config["wall"], config["loops"]["rigid"]
    yield _of_section(("wall",), wall)
    for study, key in STUDIES.items():
        for index, value in enumerate(config["studies"][study][key] if key in SHAPE else []):
            varied = {**wall, key: value}
            yield Sizes(("studies", study, key, index), *(varied[name] for name in SHAPE))
    slenderness = rigid["height"] / rigid["thickness"]
    yield Sizes(("loops", "rigid", "height"), rigid["thickness"], slenderness, rigid["hinge_ratio"])
    yield _of_section(("validation", "wall"), config["validation"]["wall"])
    for index, entry in enumerate(config["natural"]["walls"]):
        yield _of_section(("natural", "walls", index), entry)
    drawn = config["population"]["parameters"]
    least = (drawn["slenderness"]["low"], drawn["hinge_ratio"]["low"])
    yield Sizes(("population", "parameters", "slenderness", "low"), drawn["thickness"]["low"], *least)
    shapes = config["accuracy"]["rigid"]
    least = (min(shapes["slenderness"]), min(shapes["hinge_ratio"]))
    yield Sizes(("accuracy", "rigid", "slenderness"), rigid["thickness"], *least)


def _of_section(path: KeyPath, wall: Config) -> Sizes:
    return Sizes((*path, "slenderness"), wall["thickness"], wall["slenderness"], wall.get("hinge_ratio"))


def _largest(sizes: Sizes) -> KeyPath:
    """The value that makes a wall large: its thickness, where that is beyond what is built."""
    by_thickness = sizes.path[-1] == "slenderness" and sizes.thickness > plausibility.THICKEST
    return (*sizes.path[:-1], "thickness") if by_thickness else sizes.path
