"""Options that several commands share, and the walls, curves and dampers that they describe."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rockdamp.cli.command import HINGE_RATIO, NUMBER, Quantity
from rockdamp.cli.warnings import warn
from rockdamp.constants import (
    MODELS,
    PRESETS,
    REFERENCE,
    RELEASES,
    SMALL_RELEASE_OVERSTATES,
    SOFTENING,
    VISCOUS_MODELS,
)

if TYPE_CHECKING:
    from rockdamp.assessment.table import BadRow, Row
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.mechanics.one_sided import OneSidedWall
    from rockdamp.mechanics.wall import Parapet, Wall

Decorator = Callable[[Any], Any]

SIZES = ("thickness", "height", "width", "density", "overburden_ratio", "eccentricity")
OF_TWO_BODIES = ("hinge_ratio", "overburden_mass")  # which a parapet has not
WALL = (*SIZES, "overburden", *OF_TWO_BODIES, "parapet")
CURVE = ("a1", "b1", "preset", "a3", "softening")


LENGTH, DENSITY = Quantity("m"), Quantity("kg m-3")


RULES = ("measured", "rigid", "impulsive")  # for e; a test keeps them equal to the package's
RESTITUTION = Quantity(words=RULES)
RESTITUTION_MEANT = (
    f"Restitution e of releases from {RELEASES} (one of 0.1 u_ins overstates the intensity of collapse by"
    f" {SMALL_RELEASE_OVERSTATES}, going by measured blocks)"
)


PARAMETERS = {"ECD": "order", "BAND": "width"}  # by model that of a word such as ECD16 or BAND0.4


class Model(click.Choice):
    """Names in capitals, taken in small letters too; click's own way would show and complete small ones.

    Some take a number, as ECD16. The value is the model, and its parameter by name.
    """

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        match = re.fullmatch(r"(ECD|BAND)([\d.]+)", str(value).upper())
        model, parameter = (match[1], {PARAMETERS[match[1]]: float(match[2])}) if match else (value, {})
        return super().convert(str(model).upper(), param, ctx), parameter


def all_of(*options: Decorator) -> Decorator:
    """Return the options as one."""

    def decorate(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


with_default = partial(click.option, show_default=True)  # an option whose help states its default


def wall_options(required: bool = True) -> Decorator:
    """Return the options that describe a wall."""
    return all_of(
        click.option("--thickness", type=LENGTH, required=required, help="Thickness t of the wall."),
        click.option("--height", type=LENGTH, required=required, help="Height h of the wall."),
        with_default("--width", type=LENGTH, default=1.0, help="Horizontal width of the wall."),
        with_default("--density", type=DENSITY, default=1800.0, help="Density of the masonry."),
        with_default(
            "--hinge-ratio",
            type=HINGE_RATIO,
            default=0.7,
            help="Height of the hinge over h, or weakest: where F0 is least between 0.5 and 0.7. A parapet has none.",
        ),
        with_default("--overburden-ratio", type=NUMBER, default=0.0, help="Overburden over weight of the wall."),
        click.option(
            "--overburden",
            type=Quantity("N m-1"),
            help="Overburden on a metre of wall, 12kN/m: not a ratio.",
        ),
        with_default("--eccentricity", type=LENGTH, default=0.0, help="Overburden's distance from mid-thickness."),
        with_default(
            "--overburden-mass",
            type=NUMBER,
            default=0.0,
            help="Part of the overburden, 0 to 1, that moves up and down with the wall as a mass.",
        ),
        click.option("--parapet", is_flag=True, help="A parapet: one block that rocks on its base."),
    )


softening_options = all_of(
    with_default("--a3", type=NUMBER, default=1.0, help="Ultimate displacement ratio u3/u_ins."),
    with_default(
        "--softening", type=click.Choice(SOFTENING), default="steeper", help="Shape of the last branch, for a3 < 1."
    ),
)

curve_options = all_of(
    click.option("--a1", type=NUMBER, help="Yield displacement ratio u1/u_ins."),
    click.option("--b1", type=NUMBER, help="Strength ratio F_y/F0 of the plateau."),
    click.option("--preset", type=click.Choice(list(PRESETS)), help="Curve by name, in place of --a1 and --b1."),
    softening_options,
)

one_sided_option = click.option(
    "--one-sided", is_flag=True, help="The wall rocks to one side, away from a rigid stop behind it."
)

loss_options = all_of(
    click.option("--exponent", type=NUMBER, help="Exponent g of a loss that falls with the amplitude.  [default: 0]"),
    click.option("--at", type=NUMBER, help="With --exponent, amplitude u/u_ins that e belongs to.  [default: 0.3]"),
)

damping_options = all_of(
    click.option(
        "--damping-model",
        type=Model(MODELS),
        help="Damping model; ECD takes an order, as ECD16, and BAND t_c in rad, as BAND0.4.  [default: CR, with"
        " --restitution]",
    ),
    click.option("--damping-ratio", type=NUMBER, help="Damping ratio xi of a viscous model."),
    click.option(
        "--restitution",
        type=RESTITUTION,
        help=f"{RESTITUTION_MEANT}, or a rule for it, for CR, ECD, BAND, and --compare.",
    ),
    loss_options,
    click.option("--compare", is_flag=True, help="Compare CR with every viscous model, at equivalent damping ratios."),
)

json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON and nothing else.")

strict_option = click.option("--strict", is_flag=True, help="End with exit status 3 where rows failed.")


def table_of_walls(path: Path) -> list[Row | BadRow]:
    """Read a table of walls, which must have rows."""
    from rockdamp.assessment.table import read_walls
    from rockdamp.errors import InputError

    rows = read_walls(path)
    if not rows:
        raise InputError(f"{path}: has no rows; a wall must stand in each")
    return rows


def warn_of_restitution(e: float, wall: Wall | Parapet | OneSidedWall) -> None:
    """Warn of an e that is above that of rigid mechanics."""
    if e <= 1 and hasattr(wall, "restitution_rigid"):  # above 1 it is refused, and against a stop there is none
        warn("restitution over that of rigid mechanics", e / wall.restitution_rigid)


def was_given(name: str) -> bool:
    """Return True if an option stands on the command line."""
    return click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE


def refuse_unused(names: Iterable[str], needed: str) -> None:
    """Raise `click.UsageError` for options that were given and have no effect without others."""
    for name in names:
        if was_given(name):
            options = click.get_current_context().command.params
            (option,) = (parameter.opts[0] for parameter in options if parameter.name == name)
            raise click.UsageError(f"{option} must be given with {needed}, or not at all")


def make_wall(options: Mapping[str, Any]) -> Any:
    """Return the wall that `WALL` among the options describe."""
    from rockdamp.mechanics.wall import Parapet, Wall

    sizes = {name: options[name] for name in SIZES}
    if options["parapet"] and was_given("hinge_ratio"):
        raise click.UsageError("--hinge-ratio belongs to a wall; --parapet, one block on its base, must be without it")
    if options["parapet"] and was_given("overburden_mass"):
        raise click.UsageError(
            "--overburden-mass belongs to a wall, whose floor holds it sideways; --parapet must be without it"
        )
    kind: Callable[..., Wall | Parapet] = (
        Parapet if options["parapet"] else partial(Wall, **{name: options[name] for name in OF_TWO_BODIES})
    )
    if options.get("overburden") is not None:
        unloaded = kind(**sizes)
        sizes["overburden_ratio"] = _ratio_of_load(options["overburden"], unloaded)
    wall = kind(**sizes)
    warn("height over thickness", wall.slenderness)
    return one_sided_wall(options, wall)


def one_sided_wall(options: Mapping[str, Any], wall: Wall | Parapet) -> Any:
    """Return the wall against a stop where --one-sided says so."""
    if not options.get("one_sided"):
        return wall
    for name in ("building_period", "diaphragm_period"):
        if options[name] is not None:
            raise click.UsageError(
                f"--{name.replace('_', '-')} must be given without --one-sided: the stop moves as the base does"
            )
    from rockdamp.mechanics.one_sided import OneSidedWall

    return OneSidedWall(wall)


def _ratio_of_load(load: float, unloaded: Wall | Parapet) -> float:
    """Return O/W of --overburden, and print it with the weight that it is over."""
    if was_given("overburden_ratio"):
        raise click.UsageError("--overburden and --overburden-ratio state the same; there must be one of them")
    weight = float(unloaded.weight)
    ratio = load * float(unloaded.width) / weight
    kilonewtons = weight / 1000
    click.echo(
        f"overburden_ratio is {ratio:.4g}: {ratio * kilonewtons:.4g} kN over {kilonewtons:.4g} kN of the wall",
        err=True,
    )
    return ratio


def tell_overburden(wall: Wall | Parapet) -> None:
    """Print what a ratio of overburden to weight amounts to, if there is one."""
    if (ratio := float(wall.overburden_ratio)) > 0:
        click.echo(f"overburden {ratio:.3g} W = {float(wall.overburden / wall.width) / 1000:.3g} kN/m")


def make_optional_wall(options: Mapping[str, Any]) -> Wall | Parapet | None:
    """Return the wall that the options describe, or None where they state neither thickness nor height."""
    stated = [options[name] is not None for name in ("thickness", "height")]
    if all(stated):
        return make_wall(options)
    if any(stated):
        raise click.UsageError("--thickness and --height must be given together, or neither")
    refuse_unused(WALL, "--thickness and --height")
    return None


def make_curve(options: Mapping[str, Any]) -> TrilinearCurve:
    """Return the curve that `CURVE` among the options describe: by a preset, or by a1 and b1."""
    from rockdamp.mechanics.curve import TrilinearCurve

    a1, b1, preset, a3, softening = (options[name] for name in CURVE)
    if preset is not None:
        if a1 is not None or b1 is not None:
            raise click.UsageError("--preset stands for --a1 and --b1; it must be given without them")
        return TrilinearCurve.preset(preset, ultimate_displacement_ratio=a3, softening=softening)
    for name, value in (("--a1", a1), ("--b1", b1)):
        if value is None:
            raise click.UsageError(f"{name} is missing; there must be --a1 and --b1, or --preset")
    return TrilinearCurve(a1, b1, a3, softening)


def loss_of(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the exponent of the loss and the amplitude of e, those that were given."""
    loss = {name: options[name] for name in ("exponent", "at") if options[name] is not None}
    if "at" in loss and "exponent" not in loss:
        raise click.UsageError("--at belongs to --exponent; it must be given with it, or not at all")
    return loss


def make_dampings(
    options: Mapping[str, Any], curve: TrilinearCurve, wall: Wall | Parapet | None = None, **equivalence: float
) -> list[Damping]:
    """Return the one damper that the options describe; with --compare, every model's. A rule for e takes a wall."""
    from rockdamp.equivalence.equivalent import equivalent
    from rockdamp.mechanics.damping import DAMPERS, REFERENCE_AMPLITUDE, Damping

    model, parameter = options["damping_model"] or (None, {})
    ratio, restitution = options["damping_ratio"], options["restitution"]
    if isinstance(restitution, str):
        restitution = _by_rule(restitution, wall)
    elif restitution is not None and wall is not None:
        warn_of_restitution(restitution, wall)
    loss = loss_of(options)
    if loss and (options["compare"] or restitution is None or model not in (None, "CR", "ECD")):
        raise click.UsageError("--exponent belongs to --restitution with CR, ECD; it must be given with them")
    if loss.get("exponent"):
        at = loss.get("at", REFERENCE_AMPLITUDE)
        click.echo(f"e = {restitution:g} at {at:g} u_ins; the loss has g = {loss['exponent']:g}", err=True)
    named = {
        name: loss[key] for key, name in (("exponent", "loss_exponent"), ("at", "reference_amplitude")) if key in loss
    }
    if options["compare"]:
        if model is not None or ratio is not None:
            raise click.UsageError("--compare finds every model's damping ratio; it must be given --restitution alone")
        e = _needed("--restitution", restitution, "--compare")
        rows = equivalent(e, curve, **equivalence)
        return [Damping("CR", e), *(Damping(row["damping_model"], row["damping_ratio"]) for row in rows)]
    if model is None and restitution is not None and ratio is None:
        model = REFERENCE
    if model is None:
        raise click.UsageError(
            f"--damping-model is missing; it must be {REFERENCE} with --restitution, one of {', '.join(VISCOUS_MODELS)}"
            " with --damping-ratio, or --compare with --restitution in place of both"
        )
    if model not in VISCOUS_MODELS:
        if ratio is not None:
            raise click.UsageError("--damping-ratio belongs to viscous models; CR must have --restitution alone")
        return [Damping(model, _needed("--restitution", restitution, f"--damping-model {model}"), **named)]
    named |= parameter
    if restitution is not None:
        exact = [REFERENCE, *(model for model, damper in DAMPERS.items() if damper.is_amplitude_independent)]
        if model not in exact:
            raise click.UsageError(f"--restitution belongs to {', '.join(exact)}; {model} must have --damping-ratio")
        if ratio is not None:
            raise click.UsageError(
                f"--damping-ratio and --restitution state the same of {model}; it must have one of them"
            )
        made = Damping.from_restitution(restitution, model, **named)
    else:
        made = Damping(model, _needed("--damping-ratio", ratio, f"--damping-model {model}"), **named)
        warn("damping_ratio", ratio)
    return [made]


def _by_rule(rule: str, wall: Wall | Parapet | None) -> float:
    """Return e of a wall by a rule, and print it with its reason."""
    from rockdamp.assessment.table import restitution_and_reason

    if wall is None:
        raise click.UsageError(f"--restitution {rule} must be given with --thickness and --height, whose wall it is of")
    e, reason = restitution_and_reason(wall, rule)
    click.echo(f"restitution e = {e:.4g}: {reason}", err=True)
    return e


def _needed(name: str, value: float | None, owner: str) -> float:
    if value is None:
        raise click.UsageError(f"{name} is missing; {owner} must have it")
    return value
