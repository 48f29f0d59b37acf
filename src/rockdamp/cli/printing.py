"""Answers of commands: sentences, tables, JSON and files."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp.cli.inputs import Inputs
from rockdamp.constants import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

# Inputs that name files or describe the text of files; a dataset has the digests of the files in
# their place.
NOT_STORED = (
    "output",
    "plot",
    "report",
    "walls",
    "files",
    "as_json",
    "step",
    "unit",
    "column",
)


# Columns of CSV files, whose names end with their units as those of records do.
CSV_COLUMNS = {
    "pga": "pga_m_s2",
    "pgv": "pgv_m_s",
    "peak_displacement": "peak_displacement_m",
    "peak_elapsed": "peak_elapsed_s",
    "outcome_elapsed": "outcome_elapsed_s",
    "rocking_onset": "rocking_onset_m_s2",
}

# --- sentences ---------------------------------------------------------------------------------


def describe_sizes(wall: Any) -> str:
    """Return the sizes, the density, the hinge and the load of the wall."""
    body = getattr(wall, "mechanism", wall)  # of a wall against a stop
    parts = [
        f"{type(body).__name__} {float(body.thickness):g} x {float(body.height):g} m",
        f"{float(body.density):g} kg/m3",
    ]
    if body is not wall:
        parts.append("rocks to one side")
    if hasattr(body, "hinge_ratio"):
        parts.append(f"hinge at {float(body.hinge_ratio):.3g} h")
    if body.overburden_ratio > 0:
        load = float(body.overburden / body.width) / 1000
        parts.append(f"O/W = {float(body.overburden_ratio):.3g} ({load:.3g} kN/m)")
    return ", ".join(parts)


def describe_wall(
    wall: Any,
    curve: rd.TrilinearCurve | None,
    e: float | None = None,
    reason: str = "",
    *,
    on_floors: bool = False,
) -> str:
    """Return the sizes of the wall, its curve, where rocking starts, and e with its reason."""
    text = describe_sizes(wall)
    strength = 1.0
    if curve is not None:
        strength = float(curve.strength_ratio)
        text += f", a1 = {float(curve.yield_displacement_ratio):g}, b1 = {strength:g}"
    onset = float(wall.rocking_onset(strength)) / STANDARD_GRAVITY
    text += f"; rocking starts at {onset:.3g} g"
    if on_floors:
        text += " at the wall (the floors amplify the motion of the ground)"
    if e is not None:
        text += f"; e = {e:.3g} ({reason})"
    return text


def describe_records(motions: Iterable[rd.GroundMotion]) -> str:
    """Return number and size of records: ``1 record (5366 samples, step 0.005 s, PGA 0.28 g)``."""
    from rockdamp.text import count_noun

    records = [motion.intensity_record for motion in motions]
    pgas = [rd.intensity_measures(record).pga / STANDARD_GRAVITY for record in records]
    samples = _range([record.elapsed.size for record in records], 9)
    step = _range([record.step for record in records], 3)
    pga = _range(pgas, 2)
    return f"{count_noun(len(records), 'record')} ({samples} samples, step {step} s, PGA {pga} g)"


def _range(values: Sequence[float], digits: int) -> str:
    ends = [f"{end:.{digits}g}" for end in (min(values), max(values))]
    return " to ".join(dict.fromkeys(ends))


def percent(share: float) -> str:
    """Return a share in per cent."""
    if share >= 0.995:  # of which two digits would be 1e+02
        return "100 %"
    return f"{100 * share:.2g} %"


def span(bounds: Iterable[float], digits: int = 3, unit: str = "") -> str:
    """Return an interval; a dash if neither end is known."""
    ends = ["not known" if isnan(bound) else f"{float(bound):.{digits}g}" for bound in bounds]
    if set(ends) == {"not known"}:
        return "-"
    return " to ".join(ends) + unit


# --- tables ------------------------------------------------------------------------------------


def cell(value: Any) -> str:
    """Return the text of a value in a table; a dash if it is not known."""
    if value is None or value != value:  # NaN
        return "-"
    if isinstance(value, str | int):
        return str(value)
    if 1000 <= abs(value) < 1e6:  # of which three digits would be 1.2e+03
        return f"{value:.0f}"
    return f"{value + 0:.3g}"  # + 0 makes 0 of -0


def print_table(rows: Sequence[Inputs], caption: str = "") -> None:
    """Print rows under the names of their columns, without empty columns, below a caption."""
    if caption:
        click.echo(caption)
    texts = [{name: cell(row[name]) for name in rows[0]} for row in rows]
    names = [name for name in rows[0] if any(text[name] not in ("", "-") for text in texts)]
    widths = [max(len(line) for line in (name, *(text[name] for text in texts))) for name in names]
    heads = {name: name for name in names}
    for text in (heads, *texts):
        columns = (text[name].rjust(width) for name, width in zip(names, widths, strict=True))
        click.echo("  ".join(columns).rstrip())


def print_dampers(damping: Inputs, rows: Iterable[Inputs]) -> None:
    """Print dampers in the order of preference, each with the feature that it needs."""
    from rockdamp.equivalence.programs import REQUIREMENT

    e = damping["damping_restitution"]
    w1 = damping["initial_frequency"]
    period = damping["initial_period"]
    table = {
        row["damping_model"]: {
            "damper": row["damping_model"],
            "xi": None if row["damping_model"] == "BAND" else row["damping_ratio"],
            "frequency of xi": row["refers_to"],
            "the program needs": REQUIREMENT.get(row["damping_model"], "(not recommended)"),
            "missed collapses": percent(row["missed_collapse_rate"]),
        }
        for row in rows
    }
    print_table(
        [table[model] for model in dict.fromkeys([*REQUIREMENT, *table])],
        "If you use another program, take the first damper that it supports "
        f"(e = {e:.3g}, w1 = {w1:.3g} rad/s, T1 = {period:.3g} s; missed collapses are those of "
        "the study of eight walls, not of this wall):",
    )


# --- JSON and files ----------------------------------------------------------------------------


def print_json(value: Any) -> None:
    """Print a value as JSON."""
    click.echo(json.dumps(_for_json(value), indent=2, allow_nan=False))


def _for_json(value: Any) -> Any:
    """Replace arrays by lists, and NaN by None."""
    if isinstance(value, Mapping):
        return {name: _for_json(member) for name, member in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list):
        return [_for_json(member) for member in value]
    return None if value != value else value  # NaN


def write_csv(rows: Iterable[Inputs], path: Path) -> None:
    """Write rows as CSV; the name of a column that has a dimension ends with its unit."""
    import pandas as pd

    from rockdamp.storage.files import replace_file

    table = pd.DataFrame(list(rows), dtype=object)  # counts stay whole beside an empty cell
    with replace_file(path) as temporary:
        table.rename(columns=CSV_COLUMNS).to_csv(temporary, index=False)
    announce(path)


def write_dataset(dataset: xr.Dataset, kind: str, inputs: Inputs, **contents: Any) -> None:
    """Write the dataset of --output, if it is one, with the inputs; `contents` replace files."""
    from rockdamp.storage.dataset import write

    output = inputs["output"]
    if output is None or output.suffix != ".nc":
        return
    stored = {name: value for name, value in inputs.items() if name not in NOT_STORED}
    write(dataset, output, kind, config=stored | contents, code_version=rd.__version__)
    announce(output)


def save_plot(figure: Any, path: Path) -> None:
    """Save the figure of --plot."""
    from rockdamp.figures.style import save

    save(figure, [path], 200)
    announce(path)


def announce(path: Path) -> None:
    """Say on standard error that a file is written."""
    click.echo(f"{path} written", err=True)


def digests(motions: Iterable[rd.GroundMotion]) -> str:
    """Return the names of records with the digests of their files."""
    return " ".join(f"{motion.name} {motion.record.digest}".strip() for motion in motions)
