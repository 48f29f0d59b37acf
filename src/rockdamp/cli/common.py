"""What the commands share: from options to a wall, its dampers and motions; tables, files and errors of one line."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from math import inf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, SupportsFloat

import click

import rockdamp as rd
from rockdamp.constants import STANDARD_GRAVITY, VISCOUS_MODELS

if TYPE_CHECKING:
    import xarray as xr

Inputs = Mapping[str, Any]  # of a command, by the name of the option


def warn(name: str, value: SupportsFloat, least: float, most: float, remark: str) -> None:
    """Print a line where a value is possible and unusual; `remark` says what lies beyond the usual ones."""
    if not least <= float(value) <= most:
        limit = f"less than {least:g}" if float(value) < least else f"more than {most:g}"
        click.echo(f"warning: {name} is {float(value):.3g}, {limit}: {remark}", err=True)


def warn_of_rest(peak: SupportsFloat, curve: rd.TrilinearCurve) -> None:
    warn(
        "peak over a1",
        float(peak) / float(curve.yield_displacement_ratio),
        1.0,
        inf,
        "the wall does not rock",
    )


# --- what the options describe ----------------------------------------------------------------------------------------


def build_wall(inputs: Inputs) -> Any:
    """Return the wall: a Wall, a Parapet, or one of them against a stop."""
    from rockdamp.assessment.description import make_wall

    wall: Any = make_wall(inputs)
    slenderness = getattr(wall, "mechanism", wall).slenderness
    warn("height over thickness", slenderness, 0.0, 40.0, "tests of walls went to 28")
    return wall


def build_curve(inputs: Inputs) -> rd.TrilinearCurve:
    from rockdamp.assessment.description import make_curve

    return make_curve(inputs)


def choose_restitution(wall: Any, restitution: float | str) -> tuple[float, str]:
    """Return e and its reason; warn of a number above that of rigid mechanics."""
    from rockdamp.assessment.restitution import find_restitution

    e, reason = find_restitution(wall, restitution)
    if not isinstance(restitution, str) and hasattr(
        wall, "restitution_rigid"
    ):  # against a stop there is none
        remark = "tests of walls and blocks gave 0.85 to 1.03"
        warn(
            "restitution over that of rigid mechanics", e / wall.restitution_rigid, 0.0, 1.1, remark
        )
    return e, reason


def build_dampings(
    inputs: Inputs, curve: rd.TrilinearCurve, e: float | None, **release: float
) -> list[rd.Damping]:
    """Return the damper that the options describe; with --compare that of every model."""
    (model, parameter), xi = inputs["damping_model"] or ("CR", {}), inputs["damping_ratio"]
    if inputs["compare"]:
        if e is None or xi is not None or inputs["damping_model"]:
            raise click.UsageError("--compare must be given with --restitution alone")
        rows = rd.equivalent(e, curve, **release)
        return [
            rd.Damping("CR", e),
            *(rd.Damping(row["damping_model"], row["damping_ratio"]) for row in rows),
        ]
    if (e is None) is (xi is None) or (model == "CR" and xi is not None):
        viscous = f"--damping-ratio with --damping-model {'|'.join(VISCOUS_MODELS)}"
        raise click.UsageError(f"there must be either --restitution, or {viscous}")
    if xi is not None:
        warn("damping_ratio", xi, 0.0, 0.5, "the damper is near critical")
    return [
        rd.Damping(model, xi, **parameter)
        if e is None
        else rd.Damping.from_restitution(e, model, **parameter)
    ]


def read_motions(inputs: Inputs) -> list[rd.GroundMotion]:
    """Return the ground motions of --records; refuse an output that would overwrite one of them."""
    from rockdamp.motions.catalogue import record_files

    output, sources = (
        inputs["output"],
        [*record_files(inputs["records"]), *filter(None, [inputs.get("walls")])],
    )
    if (
        output is not None
        and output.exists()
        and any(output.samefile(source) for source in sources)
    ):
        raise click.UsageError(
            f"--output is {str(output)!r}, which the command reads; it must be another file"
        )
    statements = {name: inputs[name] for name in ("step", "unit", "column")}
    motions = rd.load_records(inputs["records"], **statements)
    for motion in motions:
        measures, name = rd.intensity_measures(motion.record), motion.name
        warn(
            f"{name}: PGA in g",
            measures.pga / STANDARD_GRAVITY,
            0.001,
            5.0,
            "records of earthquakes lie within",
        )
        left = abs(measures.end_velocity) / measures.pgv
        warn(
            f"{name}: velocity at the end over PGV",
            left,
            0.0,
            0.1,
            "the ground still moves when the record ends",
        )
    return motions


def build_supports(inputs: Inputs) -> dict[str, Any]:
    """Return the building and the flexible floor that the options describe, as `floor_motions` takes them."""
    building = [inputs[name] for name in ("building_period", "storeys", "storey")]
    if None in building and any(value is not None for value in building):
        raise click.UsageError("--building-period, --storeys and --storey must be given together")
    period = inputs["diaphragm_period"]
    supports: dict[str, Any] = {} if None in building else {"building": rd.Building(*building)}
    supports |= {} if period is None else {"diaphragm": rd.Diaphragm(period)}
    return supports


def read_support_motions(inputs: Inputs) -> Sequence[rd.GroundMotion]:
    """Return the motions of a wall's supports: those of --records, or what a building and a floor make of them."""
    supports = build_supports(inputs)
    if supports and inputs["one_sided"]:
        raise click.UsageError("--one-sided must be without a building or a flexible floor")
    motions = read_motions(inputs)
    return rd.floor_motions(motions, parapet=inputs["parapet"], **supports) if supports else motions


# --- output -----------------------------------------------------------------------------------------------------------


def describe_wall(
    wall: Any, curve: rd.TrilinearCurve | None, e: float | None = None, reason: str = ""
) -> str:
    """Return what was taken: the wall's sizes, its curve, where rocking starts, and e with its reason."""
    body = getattr(wall, "mechanism", wall)  # of a wall against a stop
    kind = f"{'' if body is wall else 'one-sided '}{type(body).__name__.lower()}"
    text = f"{kind} {float(body.thickness):g} x {float(body.height):g} m, {float(body.density):g} kg/m3"
    if hasattr(body, "hinge_ratio"):
        text += f", hinge at {float(body.hinge_ratio):.3g} h"
    if body.overburden_ratio > 0:
        load = float(body.overburden / body.width) / 1000
        text += f", O/W {float(body.overburden_ratio):.3g} ({load:.3g} kN/m)"
    b1 = 1.0 if curve is None else float(curve.strength_ratio)
    text += "" if curve is None else f", a1 {float(curve.yield_displacement_ratio):g}, b1 {b1:g}"
    text += f"; rocking starts at {float(wall.rocking_onset(b1)) / STANDARD_GRAVITY:.3g} g"
    return text if e is None else f"{text}; e = {e:.4g}, {reason}"


def describe_records(motions: Iterable[rd.GroundMotion]) -> str:
    """Return what was read of records: ``record: 5366 samples, 0.005 s, PGA 0.28 g``."""
    records = [motion.intensity_record for motion in motions]
    samples, step = (
        _range(values, 9)
        for values in ([r.elapsed.size for r in records], [r.step for r in records])
    )
    pga = _range([rd.intensity_measures(record).pga / STANDARD_GRAVITY for record in records], 2)
    name = "record" if len(records) == 1 else f"{len(records)} records"
    return f"{name}: {samples} samples, {step} s, PGA {pga} g"


def _range(values: Sequence[float], digits: int) -> str:
    return " to ".join(dict.fromkeys(f"{end:.{digits}g}" for end in (min(values), max(values))))


def percent(share: float) -> str:
    """Return a share in per cent."""
    return f"{100 * share:.2g} %" if share < 0.995 else "100 %"


def span(bounds: Iterable[float], digits: int, unit: str = "") -> str:
    """Return an interval; a dash where neither end is known."""
    ends = ["not known" if isnan(bound) else f"{float(bound):.{digits}g}" for bound in bounds]
    return "-" if set(ends) == {"not known"} else " to ".join(ends) + unit


def cell(value: Any) -> str:
    """Return the text of a value in a table; a dash where it is not known."""
    if value is None or value != value:
        return "-"
    return value if isinstance(value, str) else f"{value + 0:.5g}"  # no "-0"


def print_table(rows: Sequence[Inputs]) -> None:
    """Print rows under the names of their columns, but for those that are empty."""
    names = [name for name in rows[0] if any(cell(row[name]) not in ("", "-") for row in rows)]
    lines = [names, *([cell(row[name]) for name in names] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        click.echo(
            "  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)).rstrip()
        )


def print_dampers(damping: Inputs, rows: Iterable[Inputs]) -> None:
    """Print some dampers in the order in which to take them, by what a program must take."""
    from rockdamp.equivalence.programs import REQUIREMENT

    e, w1, period = (
        damping[name] for name in ("damping_restitution", "initial_frequency", "initial_period")
    )
    click.echo(
        f"in a program the first that it takes, for e = {e:.4g}; w1 = {w1:.4g} rad/s, T1 = {period:.4g} s"
    )
    table = {
        row["damping_model"]: {
            "damper": row["damping_model"],
            "xi": row["damping_ratio"],
            "refers to": row["refers_to"],
            "if it takes": REQUIREMENT.get(row["damping_model"], "-"),
            "collapses missed": percent(row["missed_collapse_rate"]),
        }
        for row in rows
    }
    print_table([table[model] for model in dict.fromkeys([*REQUIREMENT, *table])])


def print_json(value: Any) -> None:
    click.echo(json.dumps(_for_json(value), indent=2, allow_nan=False))


def _for_json(value: Any) -> Any:
    """Replace arrays by lists, and NaN, which is not known, by None."""
    if isinstance(value, Mapping):
        return {name: _for_json(each) for name, each in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list):
        return [_for_json(each) for each in value]
    return None if value != value else value


def write_csv(rows: Iterable[Inputs], path: Path) -> None:
    """Write rows as CSV."""
    import pandas as pd

    from rockdamp.storage.files import replace_file

    with replace_file(path) as temporary:
        pd.DataFrame(list(rows)).to_csv(temporary, index=False)
    click.echo(f"{path} written", err=True)


def write_outputs(
    dataset: xr.Dataset, kind: str, inputs: Inputs, figure: str = "", **read: Any
) -> None:
    """Write the dataset of --output, and the picture of --plot by the `figure` of that name.

    The inputs stand for the config; `read` is the content of files, in place of their names.
    """
    output, plot = inputs["output"], inputs.get("plot")
    if output is not None and output.suffix == ".nc":
        from rockdamp.storage.dataset import write

        files = ("output", "plot", "report", "walls", "files", "as_json", "step", "unit", "column")
        config = {name: value for name, value in inputs.items() if name not in files} | read
        write(dataset, output, kind, config=config, code_version=rd.__version__)
        click.echo(f"{output} written", err=True)
    if plot is not None:
        from rockdamp.figures import commands
        from rockdamp.figures.style import save

        save(getattr(commands, figure)(dataset), [plot], 200)
        click.echo(f"{plot} written", err=True)


def digests(motions: Iterable[rd.GroundMotion]) -> str:
    """Return the names of records with the digests of their files."""
    return " ".join(f"{motion.name} {motion.record.digest}".strip() for motion in motions)


# --- commands ---------------------------------------------------------------------------------------------------------


class Main(click.Group):
    """Commands whose every mistake is one line on standard error, with status 2."""

    def main(self, *arguments: Any, **how: Any) -> NoReturn:
        try:
            status = super().main(*arguments, **{**how, "standalone_mode": False})
        except click.ClickException as error:
            message = error.format_message()
        except click.Abort:
            sys.exit(1)
        except (OSError, rd.InputError) as error:
            message = str(error)
        else:
            sys.exit(status)
        click.echo(f"Error: {' '.join(message.split())}", err=True)
        sys.exit(2)


def examples(*lines: str) -> str:
    """Return examples as the end of a help text."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
