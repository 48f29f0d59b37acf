"""Walls and curves from their description: values by name, of an option or of a table's column."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.specimen import AnyWall
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall

# SI unit of each value that describes a wall, by its name; None for texts.
DESCRIPTION_UNITS: dict[str, str | None] = {
    **dict.fromkeys(("id", "parapet", "one_sided", "preset", "softening")),
    **dict.fromkeys(("thickness", "height", "width", "eccentricity"), "m"),
    **dict.fromkeys(("hinge_ratio", "overburden_ratio", "overburden_mass"), ""),
    **dict.fromkeys(("a1", "b1", "a3", "restitution"), ""),
    "density": "kg m-3",
    "overburden": "N m-1",
    "diaphragm_period": "s",
}
# Parameters of `Wall`; a parapet has all but the last two.
WALL_PARAMETERS = (
    "thickness",
    "height",
    "width",
    "density",
    "overburden_ratio",
    "eccentricity",
    "hinge_ratio",
    "overburden_mass",
)
# Names in a description of the ratios of `TrilinearCurve`.
CURVE_NAMES = {
    "yield_displacement_ratio": "a1",
    "strength_ratio": "b1",
    "ultimate_displacement_ratio": "a3",
}


def make_wall(values: Mapping[str, Any]) -> AnyWall:
    """Return the wall that values describe.

    Parameters
    ----------
    values : mapping
        Values by the names of `DESCRIPTION_UNITS`; one that is None or missing has the default of
        `Wall`. ``overburden`` is a load on a metre of wall [N m-1]; ``parapet`` and ``one_sided``
        are true or false.

    Raises
    ------
    InputError
        If a value lies outside its range, two state the same, or a parapet has what only a wall
        with a hinge has.
    """
    parameters = {name: values[name] for name in WALL_PARAMETERS if values.get(name) is not None}
    kind: type[Wall | Parapet] = Wall
    if values.get("parapet"):
        kind = Parapet
        for name in ("hinge_ratio", "overburden_mass"):
            if name in parameters:
                raise InputError(f"{name} is {parameters[name]}; a parapet must have no {name}")
    if values.get("overburden") is not None:
        if "overburden_ratio" in parameters:
            raise InputError(
                "overburden and overburden_ratio are alternatives; give only one of them"
            )
        unloaded = kind(**parameters)
        overburden = values["overburden"] * float(unloaded.width / unloaded.weight)
        parameters["overburden_ratio"] = overburden
    wall = kind(**parameters)
    return OneSidedWall(wall) if values.get("one_sided") else wall


def make_curve(values: Mapping[str, Any]) -> TrilinearCurve:
    """Return the force-displacement curve that values describe.

    Parameters
    ----------
    values : mapping
        ``preset``, or ``a1`` and ``b1``; ``a3`` and ``softening`` have defaults.

    Raises
    ------
    InputError
        If a value lies outside its range, or there is not one of preset and a1 with b1.
    """
    a1 = values.get("a1")
    b1 = values.get("b1")
    preset = values.get("preset")
    has_one_of_pair = (a1 is None) is not (b1 is None)
    if has_one_of_pair or (preset is None) is (a1 is None):
        raise InputError("give either preset (new, moderate or severe), or both a1 and b1")
    options: dict[str, Any] = {}
    if values.get("a3") is not None:
        options["ultimate_displacement_ratio"] = values["a3"]
    if values.get("softening") is not None:
        options["softening"] = values["softening"]
    try:
        if preset is None:
            return TrilinearCurve(a1, b1, **options)
        return TrilinearCurve.preset(preset, **options)
    except InputError as error:
        message = str(error)
        for ratio, name in CURVE_NAMES.items():
            message = message.replace(ratio, name)
        raise InputError(message) from error
