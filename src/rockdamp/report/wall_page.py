"""The page of one wall that `rockdamp assess --report` writes."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, StrictUndefined
from matplotlib.figure import Figure

from rockdamp import __version__
from rockdamp.assessment.answers import explain_rest, measure_name, reasons, warn_of_zero
from rockdamp.assessment.collapses import LEAST_DAMPER_RESTITUTION
from rockdamp.assessment.sensitivity import sensitivity
from rockdamp.constants import (
    BLOCK_RESTITUTION_DEVIATION,
    RELEASES,
    SMALL_RELEASE_OVERSTATES,
    STANDARD_GRAVITY,
    WALL_RESTITUTION_DEVIATION,
)
from rockdamp.equivalence.programs import REQUIREMENT, describe_damping
from rockdamp.figures.commands import fragility_figure
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Building, Diaphragm
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.storage.files import replace_file
from rockdamp.text import DASH, join_words, number, percent, plain
from rockdamp.units import intensity_unit

# The cases of e, in a sentence.
CASES = {
    "e - s": "e reduced by the scatter of tests",
    "e + s": "e increased by the scatter of tests",
    "impulsive": "e by the rule impulsive (with impulses at the supports)",
}


def write_wall_page(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    motions: Sequence[GroundMotion],
    answer: xr.Dataset,
    path: Path,
    unit: str | None = None,
    building: Building | None = None,
    diaphragm: Diaphragm | None = None,
) -> None:
    """Write inputs, probability of collapse, damper and sensitivity of a wall, self-contained.

    Parameters
    ----------
    wall, curve, motions
        The inputs of the assessment.
    answer : xarray.Dataset
        The result of `assess` for the wall.
    path : Path
        File to write, complete or not at all.
    unit : str, optional
        Unit of the intensities on the page; by default g for a PGA, m/s for a PGV.
    building : Building, optional
        Building whose floors move the wall in `motions`.
    diaphragm : Diaphragm, optional
        Flexible floor that moves the wall in `motions`.
    """
    measure = measure_name(answer)
    unit, size = intensity_unit(measure, unit)
    restitution = max(float(answer["restitution"]), LEAST_DAMPER_RESTITUTION)
    damping = describe_damping(wall, curve, restitution)
    dampers = {row["damping_model"]: row for row in damping["damping"]}
    changes = sensitivity(wall, curve, answer, motions)
    models = answer["damping_model"].values.tolist()
    curves = [answer.sel(damping_model=model) for model in models]
    all_reasons = [reason for model in models for reason in reasons(answer, model)]
    is_wall = isinstance(wall, Wall)
    html = load_template().render(
        kind="wall" if is_wall else "parapet",
        inputs=[
            *list_inputs(wall, curve, float(answer["rocking_onset"])),
            *list_supports(building, diaphragm),
        ],
        supports=name_supports(building, diaphragm),
        answer=answer,
        rest=explain_rest(answer, curve),
        zero_warning=warn_of_zero(answer.isel(intensity=-1)),
        cases=CASES,
        is_wall=is_wall,
        histories=int(answer["records"]) * answer[f"stripe_{measure}"].size,
        scatter=WALL_RESTITUTION_DEVIATION if is_wall else BLOCK_RESTITUTION_DEVIATION,
        cr=answer.sel(damping_model="CR"),
        levels=[write_level(level / size, unit) for level in answer[measure].values],
        fragility=[list_fragility(curve, measure, unit, size) for curve in curves],
        missing=list(dict.fromkeys(all_reasons)),
        dampers=[(dampers[model], need) for model, need in REQUIREMENT.items()],
        w1=damping["initial_frequency"],
        changes=[row | {"median": write_level(row["median"] / size, unit)} for row in changes],
        u_ins=1000 * float(wall.instability_displacement),
        measure=measure.upper(),
        unit=unit,
        size=size,
        records=list_records(motions),
        figure=encode_image(fragility_figure(answer, unit)),
        releases=RELEASES,
        overstates=SMALL_RELEASE_OVERSTATES,
        version=__version__,
    )
    with replace_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8", newline="\n")


def load_template() -> Any:
    """Return the page's template with its filters."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"number": number, "percent": percent, "span": write_span}
    text = files("rockdamp.report").joinpath("wall_page.html.j2").read_text(encoding="utf-8")
    return environment.from_string(text)


def list_inputs(wall: Wall | Parapet, curve: TrilinearCurve, onset: float) -> list[tuple[str, str]]:
    """Return names and values of the inputs, and of the properties that follow from them."""
    inputs: list[tuple[str, Any, str]] = [
        ("thickness t", wall.thickness, "m"),
        ("height h", wall.height, "m"),
        ("width", wall.width, "m"),
        ("density", wall.density, "kg/m³"),
        ("overburden / weight O/W", wall.overburden_ratio, ""),
        ("eccentricity of the overburden", wall.eccentricity, "m"),
    ]
    if isinstance(wall, Wall):
        inputs += [
            ("height of the hinge h₁/h", wall.hinge_ratio, ""),
            ("share of the overburden with mass", wall.overburden_mass, ""),
        ]
    inputs += [
        ("start of the plateau a₁ = u₁/u_ins", curve.yield_displacement_ratio, ""),
        ("strength ratio b₁", curve.strength_ratio, ""),
        ("ultimate displacement ratio a₃", curve.ultimate_displacement_ratio, ""),
    ]
    derived = [
        ("weight W", float(wall.weight) / 1000, "kN"),
        ("strength of rigid blocks F₀", float(wall.rigid_strength) / 1000, "kN"),
        ("instability displacement", 1000 * float(wall.instability_displacement), "mm"),
        ("frequency parameter p", float(wall.frequency_parameter), "rad/s"),
        ("acceleration at the wall at which rocking starts", onset / STANDARD_GRAVITY, "g"),
    ]
    rows = [(name, f"{plain(value)} {unit}") for name, value, unit in inputs]
    return rows + [(name, f"{number(value)} {unit}") for name, value, unit in derived]


def list_supports(building: Building | None, diaphragm: Diaphragm | None) -> list[tuple[str, str]]:
    """Return names and values of the building and of the flexible floor that move a wall."""
    rows = []
    if building is not None:
        rows += [
            ("building period", f"{plain(building.period)} s"),
            ("storeys of the building", plain(building.storeys)),
            ("storey of the wall", plain(building.storey)),
            ("damping ratio of the building", percent(building.damping_ratio)),
        ]
    if diaphragm is not None:
        rows += [
            ("period of the flexible floor", f"{plain(diaphragm.period)} s"),
            ("damping ratio of the flexible floor", percent(diaphragm.damping_ratio)),
        ]
    return rows


def name_supports(building: Building | None, diaphragm: Diaphragm | None) -> str:
    """Return the structures that move a wall, in words; an empty text on the ground."""
    names = []
    if building is not None:
        names.append("the building")
    if diaphragm is not None:
        names.append("the flexible floor")
    return join_words(names)


def list_fragility(curve: xr.Dataset, measure: str, unit: str, size: float) -> dict[str, Any]:
    """Return model, median and its interval, and the parameters of one fragility curve."""
    return {
        "model": curve["damping_model"].item(),
        "median": write_level(curve[f"median_{measure}"] / size, unit),
        "interval": curve[f"median_{measure}_interval"],
        "curve": curve,
    }


def write_level(value: Any, unit: str) -> str:
    """Write an intensity with its unit; a dash if there is none."""
    intensity = float(value)
    return f"{number(intensity)} {unit}" if np.isfinite(intensity) else DASH


def write_span(bounds: xr.DataArray, factor: float = 1.0) -> str:
    """Write the two bounds of an interval, times a factor; a dash if there are none."""
    if not np.isfinite(bounds).all():
        return DASH
    return " to ".join(number(factor * bound) for bound in bounds.values)


def list_records(motions: Sequence[GroundMotion]) -> str:
    """Write the names of the records; of many, the first and the last four."""
    names = [motion.name for motion in motions]
    if len(names) > 8:
        names = [*names[:4], "…", *names[-4:]]
    return ", ".join(names)


def encode_image(figure: Figure) -> str:
    """Return a figure as a PNG within a data URI."""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=150)
    encoded = base64.b64encode(image.getvalue()).decode("ascii")
    return f"data:image/png;base64,{encoded}"
