"""Options that several commands have, and what they make: a wall, a curve, dampers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rockdamp.cli.types import Number, Quantity
from rockdamp.vocabulary import MODELS, PRESETS, REFERENCE, SOFTENING, VISCOUS_MODELS

if TYPE_CHECKING:
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.mechanics.wall import Parapet, Wall

Decorator = Callable[[Any], Any]


class Model(click.Choice):
    """Names in capitals, taken in small letters too; click's own way to do so would show and complete small ones."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return super().convert(str(value).upper(), param, ctx)


def _all(*options: Decorator) -> Decorator:
    def decorate(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def wall_options(required: bool = True) -> Decorator:
    """Return the options that describe a wall."""
    return _all(
        click.option("--thickness", type=Quantity("m"), required=required, help="Thickness t."),
        click.option("--height", type=Quantity("m"), required=required, help="Height h."),
        click.option("--width", type=Quantity("m"), default=1.0, show_default=True, help="Length of the strip."),
        click.option(
            "--density", type=Quantity("kg m-3"), default=1800.0, show_default=True, help="Density of the masonry."
        ),
        click.option(
            "--hinge-ratio",
            type=Number(),
            default=0.7,
            show_default=True,
            help="Hinge's height over h; a parapet has none.",
        ),
        click.option(
            "--overburden-ratio", type=Number(), default=0.0, show_default=True, help="Overburden over weight, O/W."
        ),
        click.option(
            "--eccentricity",
            type=Quantity("m"),
            default=0.0,
            show_default=True,
            help="Overburden's distance from mid-t.",
        ),
        click.option("--parapet", is_flag=True, help="One block that rocks on its base."),
    )


softening_options = _all(
    click.option("--a3", type=Number(), default=1.0, show_default=True, help="Ultimate ratio u3/u_ins."),
    click.option(
        "--softening",
        type=click.Choice(SOFTENING),
        default="steeper",
        show_default=True,
        help="Kind of last branch, for a3 < 1.",
    ),
)

curve_options = _all(
    click.option("--a1", type=Number(), help="Cracked stiffness ratio u1/u_ins."),
    click.option("--b1", type=Number(), help="Plateau ratio F_y/F0."),
    click.option("--preset", type=click.Choice(list(PRESETS)), help="A named curve in place of --a1 and --b1."),
    softening_options,
)

damping_options = _all(
    click.option("--damping-model", type=Model(MODELS), help="One model alone.  [default: CR, with --restitution]"),
    click.option("--damping-ratio", type=Number(), help="xi of a viscous model."),
    click.option(
        "--restitution",
        type=Number(),
        help="Coefficient of restitution e of CR, of ECD of any order, and for --compare.",
    ),
    click.option("--order", type=Number(), help="Order m of ECD: the larger, the nearer to CR.  [default: 0]"),
    click.option("--compare", is_flag=True, help="CR and every viscous model at its equivalent damping ratio."),
)

record_option = click.option(
    "--record",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE",
    help="Record: CSV of this project, or PEER AT2.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for programs, and nothing else.")


def was_given(name: str) -> bool:
    """Whether an option stands on the command line."""
    return click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE


def refuse_unused(names: Iterable[str], needed: str) -> None:
    """Raise `click.UsageError` for options that were given and have no effect without others."""
    for name in names:
        if was_given(name):
            options = click.get_current_context().command.params
            (option,) = (parameter.opts[0] for parameter in options if parameter.name == name)
            raise click.UsageError(f"{option} must be given with {needed}, or not at all")


def make_wall(parapet: bool, hinge_ratio: float, **options: float) -> Wall | Parapet:
    """Return the wall that the options describe."""
    from rockdamp.mechanics.wall import Parapet, Wall

    if parapet and was_given("hinge_ratio"):
        raise click.UsageError("--hinge-ratio belongs to a wall; --parapet, one block on its base, must be without it")
    return Parapet(**options) if parapet else Wall(hinge_ratio=hinge_ratio, **options)


def make_curve(a1: float | None, b1: float | None, preset: str | None, a3: float, softening: str) -> TrilinearCurve:
    """Return the curve that the options describe.

    Raises
    ------
    click.UsageError
        If there are both a preset and a1 or b1, or neither.
    """
    from rockdamp.mechanics.curve import TrilinearCurve

    if preset is not None:
        if a1 is not None or b1 is not None:
            raise click.UsageError("--preset stands for --a1 and --b1; it must be given without them")
        return TrilinearCurve.preset(preset, ultimate_ratio=a3, softening=softening)
    for name, value in (("--a1", a1), ("--b1", b1)):
        if value is None:
            raise click.UsageError(f"{name} is missing; there must be --a1 and --b1, or --preset")
    return TrilinearCurve(a1, b1, a3, softening)


def make_dampings(
    damping_model: str | None,
    damping_ratio: float | None,
    restitution: float | None,
    compare: bool,
    order: float | None,
    curve: TrilinearCurve,
    **equivalence: float,
) -> list[Damping]:
    """Return the one damper that the options describe, or for a comparison all of them.

    Raises
    ------
    click.UsageError
        If the options do not go together.
    """
    from rockdamp.equivalence.one_curve import equivalent_dampings
    from rockdamp.mechanics.damping import Damping

    if order is not None and damping_model != "ECD":
        raise click.UsageError("--order belongs to --damping-model ECD; it must be given with it, or not at all")
    if compare:
        if damping_model is not None or damping_ratio is not None:
            raise click.UsageError("--compare finds every model's damping ratio; it must be given --restitution alone")
        return equivalent_dampings(_given("--restitution", restitution, "--compare"), curve, **equivalence)
    if damping_model is None and restitution is not None and damping_ratio is None:
        damping_model = REFERENCE
    if damping_model is None:
        raise click.UsageError(
            f"--damping-model is missing; it must be {REFERENCE} with --restitution, one of {', '.join(VISCOUS_MODELS)}"
            " with --damping-ratio, or --compare with --restitution in place of both"
        )
    if damping_model not in VISCOUS_MODELS:
        if damping_ratio is not None:
            raise click.UsageError("--damping-ratio belongs to viscous models; CR must have --restitution alone")
        return [Damping(damping_model, _given("--restitution", restitution, f"--damping-model {damping_model}"))]
    named = {} if order is None else {"order": order}
    if restitution is not None:
        exact = Damping.exact_models()
        if damping_model not in exact:
            raise click.UsageError(
                f"--restitution belongs to {', '.join(exact)}; {damping_model} must have --damping-ratio"
            )
        if damping_ratio is not None:
            raise click.UsageError(
                f"--damping-ratio and --restitution state the same of {damping_model}; it must have one of them"
            )
        return [Damping.of_restitution(restitution, damping_model, **named)]
    ratio = _given("--damping-ratio", damping_ratio, f"--damping-model {damping_model}")
    return [Damping(damping_model, ratio, **named)]


def _given(name: str, value: float | None, owner: str) -> float:
    if value is None:
        raise click.UsageError(f"{name} is missing; {owner} must have it")
    return value
