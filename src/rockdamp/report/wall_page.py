"""The page of one wall that `rockdamp assess --report` writes: inputs, probability of collapse, sensitivity."""

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
from rockdamp.assessment.answers import measure_name, reasons
from rockdamp.assessment.checks import sensitivity
from rockdamp.assessment.collapses import LEAST_OF_DAMPER
from rockdamp.constants import RELEASES, SMALL_RELEASE_OVERSTATES, STANDARD_GRAVITY
from rockdamp.equivalence.programs import REQUIREMENT, describe_damping
from rockdamp.figures.commands import fragility_figure
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.storage.files import replace_file
from rockdamp.text import DASH, number, percent, plain


def write_wall_page(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    motions: Sequence[GroundMotion],
    answer: xr.Dataset,
    path: Path,
) -> None:
    """Write the page, self-contained. `answer` is the result of `assess` for the wall."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"number": number, "percent": percent, "span": _span}
    measure, e = measure_name(answer), float(answer["restitution"])
    damping = describe_damping(wall, curve, max(e, LEAST_OF_DAMPER))
    dampers = {row["damping_model"]: row for row in damping["damping"]}
    models = list(map(str, answer["damping_model"].values))
    text = files("rockdamp.report").joinpath("wall_page.html.j2").read_text(encoding="utf-8")
    html = environment.from_string(text).render(
        kind="parapet" if isinstance(wall, Parapet) else "wall",
        inputs=_inputs(wall, curve, float(answer["rocking_onset"])),
        answer=answer,
        cr=answer.sel(damping_model="CR"),
        levels=[_level(measure, level) for level in answer[measure].values],
        fragility=[
            {
                "model": model,
                "median": _level(measure, answer[f"median_{measure}"].sel(damping_model=model)),
                "interval": answer[f"median_{measure}_interval"].sel(damping_model=model),
                "one": answer.sel(damping_model=model),
            }
            for model in models
        ],
        missing=list(
            dict.fromkeys(reason for model in models for reason in reasons(answer, model))
        ),
        dampers=[(dampers[model], need) for model, need in REQUIREMENT.items()],
        w1=damping["initial_frequency"],
        moved=[
            row | {"median": _level(measure, row["median"])}
            for row in sensitivity(wall, curve, answer, motions)
        ],
        u_ins=1000 * float(wall.instability_displacement),
        measure=measure.upper(),
        unit="g" if measure == "pga" else "m/s",
        size=STANDARD_GRAVITY if measure == "pga" else 1.0,
        records=_records(motions),
        figure=_image(fragility_figure(answer)),
        releases=RELEASES,
        overstates=SMALL_RELEASE_OVERSTATES,
        version=__version__,
    )
    with replace_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8", newline="\n")


def _inputs(wall: Wall | Parapet, curve: TrilinearCurve, onset: float) -> list[tuple[str, str]]:
    """Return names and values of the inputs, and of the properties that follow from them."""
    rows: list[tuple[str, Any, str]] = [
        ("thickness t", wall.thickness, "m"),
        ("height h", wall.height, "m"),
        ("width", wall.width, "m"),
        ("density", wall.density, "kg/m³"),
        ("overburden over weight O/W", wall.overburden_ratio, ""),
        ("eccentricity of the overburden", wall.eccentricity, "m"),
    ]
    if isinstance(wall, Wall):
        rows += [
            ("height of the hinge h₁/h", wall.hinge_ratio, ""),
            ("overburden that is a mass", wall.overburden_mass, ""),
        ]
    rows += [
        ("yield displacement ratio a₁", curve.yield_displacement_ratio, ""),
        ("strength ratio b₁", curve.strength_ratio, ""),
        ("ultimate displacement ratio a₃", curve.ultimate_displacement_ratio, ""),
    ]
    derived = [
        ("weight W", float(wall.weight) / 1000, "kN"),
        ("strength of the rigid wall F₀", float(wall.rigid_strength) / 1000, "kN"),
        ("instability displacement", 1000 * float(wall.instability_displacement), "mm"),
        ("frequency parameter p", float(wall.frequency_parameter), "rad/s"),
        ("rocking starts at", onset / STANDARD_GRAVITY, "g"),
    ]
    return [(name, f"{plain(value)} {unit}") for name, value, unit in rows] + [
        (name, f"{number(value)} {unit}") for name, value, unit in derived
    ]


def _level(measure: str, value: Any) -> str:
    """Return an intensity with its unit: a PGA in g; a dash where there is none."""
    value = float(value)
    if not np.isfinite(value):
        return DASH
    return f"{number(value / STANDARD_GRAVITY)} g" if measure == "pga" else f"{number(value)} m/s"


def _span(bounds: xr.DataArray, factor: float = 1.0) -> str:
    return (
        " to ".join(number(factor * bound) for bound in bounds.values)
        if np.isfinite(bounds).all()
        else DASH
    )


def _records(motions: Sequence[GroundMotion]) -> str:
    names = [motion.name for motion in motions]
    return ", ".join(names if len(names) <= 8 else [*names[:4], "…", *names[-4:]])


def _image(figure: Figure) -> str:
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=150)
    return f"data:image/png;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}"
