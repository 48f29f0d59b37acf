"""Options that several commands share, and the walls, curves and dampers that they describe."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rockdamp import units
from rockdamp.cli.command import HINGE_RATIO, NUMBER, RELEASE, SHARE, Read, quantity, ratio, word_or_number
from rockdamp.vocabulary import (
    MODELS,
    PRESETS,
    REFERENCE,
    RELEASES,
    SMALL_RELEASE_OVERSTATES,
    SOFTENING,
    VISCOUS_MODELS,
    parameter_of_word,
)

if TYPE_CHECKING:
    from rockdamp.assessment.table import BadRow, Row
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.mechanics.wall import Parapet, Wall

Decorator = Callable[[Any], Any]

SIZES = ("thickness", "height", "width", "density", "overburden_ratio", "eccentricity")
OF_TWO_BODIES = ("hinge_ratio", "overburden_mass")  # which a parapet has not
WALL = (*SIZES, "overburden", *OF_TWO_BODIES, "parapet")
CURVE = ("a1", "b1", "preset", "a3", "softening")


def _size(text: str, unit: str) -> float:
    """Read a length or density of a wall: also in feet and inches, or as a weight by volume."""
    return units.density(text) if unit == "kg m-3" else units.length(text)


LENGTH, DENSITY = (quantity(unit, _size) for unit in ("m", "kg m-3"))
LOAD = Read(units.overburden, "[N|N m-1|N m-2]", "one, as 12kN/m of wall, 12kN on its whole width, or 60kPa on its top")


def _ratio(text: str) -> float:
    """Read O/W; point to --overburden where it is a load."""
    try:
        return units.number(text)
    except ValueError as error:
        try:
            units.overburden(text)
        except ValueError:
            raise error from None
        raise ValueError(f"{text!r} is a load, which --overburden takes") from None


RATIO = Read(_ratio, "FLOAT", "a number, as 0.5")


RULES = ("measured", "analytical", "impulsive")  # for e; a test keeps them equal to the package's
RESTITUTION = Read(word_or_number(*RULES), f"NUMBER|{'|'.join(RULES)}", f"one, or one of {', '.join(RULES)}")
RESTITUTION_MEANT = (
    f"Restitution e of releases from {RELEASES} (one of 0.1 u_ins overstates the intensity of collapse by"
    f" {SMALL_RELEASE_OVERSTATES}, going by measured blocks)"
)


class Model(click.Choice):
    """Names in capitals, taken in small letters too; click's own way would show and complete small ones.

    Some take a number, as ECD16. The value is the model, and its parameter by name.
    """

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        model, parameter = parameter_of_word(str(value).upper())
        return super().convert(model, param, ctx), parameter


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
        with_default("--overburden-ratio", type=RATIO, default=0.0, help="Overburden over weight of the wall."),
        click.option("--overburden", type=LOAD, help="Overburden as a load, 12kN/m, in place of --overburden-ratio."),
        with_default("--eccentricity", type=LENGTH, default=0.0, help="Overburden's distance from mid-thickness."),
        with_default(
            "--overburden-mass",
            type=Read(units.number, "FLOAT", "a part of the overburden, from 0 to 1"),
            default=0.0,
            help="Part of the overburden, 0 to 1, that moves up and down with the wall as a mass.",
        ),
        click.option("--parapet", is_flag=True, help="A parapet: one block that rocks on its base."),
    )


softening_options = all_of(
    with_default("--a3", type=ratio("u3/u_ins", "0.9"), default=1.0, help="Ultimate displacement ratio u3/u_ins."),
    with_default(
        "--softening", type=click.Choice(SOFTENING), default="steeper", help="Shape of the last branch, for a3 < 1."
    ),
)

curve_options = all_of(
    click.option("--a1", type=ratio("u1/u_ins (wall prints u_ins)", "0.04"), help="Yield displacement ratio u1/u_ins."),
    click.option("--b1", type=ratio("F_y/F0 (wall prints F0)", "0.85"), help="Strength ratio F_y/F0 of the plateau."),
    click.option("--preset", type=click.Choice(list(PRESETS)), help="Curve by name, in place of --a1 and --b1."),
    softening_options,
)

one_sided_option = click.option(
    "--one-sided", is_flag=True, help="The wall rocks to one side, away from a rigid stop behind it."
)

loss_options = all_of(
    click.option("--exponent", type=NUMBER, help="Exponent g of a loss that falls with the amplitude.  [default: 0]"),
    click.option("--at", type=RELEASE, help="With --exponent, amplitude u/u_ins that e belongs to.  [default: 0.3]"),
)

damping_options = all_of(
    click.option(
        "--damping-model",
        type=Model(MODELS),
        help="Damping model; ECD takes an order, as ECD16, and BAND t_c in rad, as BAND0.4.  [default: CR, with"
        " --restitution]",
    ),
    click.option("--damping-ratio", type=SHARE, help="Damping ratio xi of a viscous model."),
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


def table_of_walls(path: Path, storeys: int | None = None) -> list[Row | BadRow]:
    """Read a table of walls, which must have rows, of a building of some storeys, and print its warnings."""
    from rockdamp.assessment.table import BadRow, read_walls
    from rockdamp.errors import InputError

    rows = read_walls(path, storeys)
    if not rows:
        raise InputError(f"{path}: has no rows; a wall must stand in each")
    same: dict[str, list[str]] = {}  # warnings that differ in their numbers alone
    for row in rows:
        if isinstance(row, BadRow):
            continue
        for doubt in row.doubts:
            same.setdefault(re.sub(r"[-+.\d]+", "", doubt), []).append(doubt)
    for doubts in same.values():
        more = "" if len(doubts) == 1 else f"; and {len(doubts) - 1} more rows alike"
        click.echo(f"warning: {path}, {doubts[0]}{more}", err=True)
    return rows


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
    from rockdamp.plausibility import as_meant, warn
    from rockdamp.stated import of_stated

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
        with as_meant():
            unloaded = kind(**sizes)
        sizes["overburden_ratio"] = _ratio_of_load(options["overburden"], unloaded)
    with as_meant():  # what is unlikely is said of the wall with its load, in its building
        wall = one_sided_wall(options, kind(**sizes))
    warn(of_stated(wall, options.get("storeys")))
    return wall


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


def _ratio_of_load(load: tuple[float, int], unloaded: Wall | Parapet) -> float:
    """Return O/W of --overburden, and print it with the weight that it is over."""
    if was_given("overburden_ratio"):
        raise click.UsageError("--overburden and --overburden-ratio state the same; there must be one of them")
    weight = float(unloaded.weight)
    ratio = units.overburden_ratio(*load, weight, float(unloaded.width), float(unloaded.thickness))
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
    from rockdamp.equivalence.equivalent import equivalent, longest_step
    from rockdamp.mechanics.damping import DAMPERS, REFERENCE_AMPLITUDE, Damping
    from rockdamp.plausibility import of_sizes, warn
    from rockdamp.questions import of_band

    model, parameter = options["damping_model"] or (None, {})
    ratio, restitution = options["damping_ratio"], options["restitution"]
    if isinstance(restitution, str):
        restitution = _by_rule(restitution, wall)
    elif restitution is not None and wall is not None:
        warn(of_sizes(restitution, float(wall.restitution_rigid)))
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
    if model == "BAND":
        c, step = float(made.width / curve.initial_frequency), float(longest_step(curve))
        warn(of_band(float(made.width), 2 * c / step))
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
