"""The page of one wall: its assumptions and its answers, printed on two sheets of A4."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from rockdamp import __version__
from rockdamp.arrays import Array
from rockdamp.assessment.collapses import STRIPES, TAIL, UNITS
from rockdamp.assessment.one_wall import REPLICATES, beside_each_other
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.errors import InputError
from rockdamp.figures.assessment import fragility_figure
from rockdamp.figures.single import response_figure
from rockdamp.figures.wall_sketch import wall_figure
from rockdamp.histories.side_by_side import responses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import kinds
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.plausibility import as_meant
from rockdamp.report.one_wall.checks import Placement, section
from rockdamp.storage.atomic import replacing
from rockdamp.text import DASH, number, percent, plain
from rockdamp.vocabulary import RECOMMENDED, REFERENCE, STANDARD_GRAVITY, VISCOUS_MODELS

# Files of this package that the page is made of; named here, so that an edit of one is an edit of the page.
TEMPLATE = "wall.html.j2"
STYLE = "wall.css"
U_INS = Markup("u<sub>ins</sub>")
RESOLUTION = 200  # dots per inch
PRINTED = {"m s-1": "m s⁻¹", "m s-2": "m s⁻²"}
MOST_ROWS = 4  # intensities in the table
MOST_NAMES = 8  # records named


@dataclass(frozen=True)
class Subject:
    """A wall, its records, and the dataset that `rockdamp.assess` returned for them."""

    name: str
    wall: Wall | Parapet
    curve: TrilinearCurve
    motions: Sequence[GroundMotion]
    answer: xr.Dataset
    placement: Placement = Placement()


def build(subject: Subject) -> str:
    """Return the page as HTML, which needs nothing but itself."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    answer = subject.answer
    worst = worst_standing(subject)
    return environment.from_string(_text(TEMPLATE)).render(
        style=Markup(_text(STYLE)),
        name=subject.name,
        parapet=isinstance(subject.wall, Parapet),
        inputs=_inputs(subject),
        derived=_derived(subject),
        reason=answer.attrs["restitution_reason"],
        e=number(float(answer["restitution"])),
        dampers=_dampers(subject),
        shares=_shares(answer),
        left_out=max(answer.sizes["intensity"] - MOST_ROWS, 0),
        fragility=_fragility(answer),
        headline=_headline(answer),
        checked=section(subject.placement),
        measure=answer.attrs["intensity_measure"],
        unit=PRINTED[UNITS[answer.attrs["intensity_measure"]]],
        records=_records(subject.motions),
        worst=worst,
        images={
            "wall": _image(wall_figure(subject.wall, subject.curve)),
            "fragility": _image(fragility_figure(answer)),
            "response": _image(response_figure(worst["histories"])) if worst else "",
        },
        recommended=RECOMMENDED,
        stripes=STRIPES.size,
        replicates=REPLICATES,
        tail=f"{TAIL:g}",
        method=answer.attrs["collapse_probability_interval"],
        version=__version__,
    )


def write(subject: Subject, path: str | os.PathLike[str]) -> None:
    """Write the page, complete or not at all."""
    html = build(subject)
    with replacing(path) as temporary:
        Path(temporary).write_text(html, encoding="utf-8", newline="\n")


def worst_standing(subject: Subject) -> dict[str, Any]:
    """Return the history of the largest peak that the wall survives, at the highest intensity that it may survive.

    It is run again at the finer step of `respond`; where it then falls, the next largest peak is taken. The
    dictionary is empty where the wall survives no record.
    """
    answer, motions = subject.answer, {motion.name: motion for motion in subject.motions}
    dampings = beside_each_other(float(answer["restitution"]))
    peaks = answer["peak_ratio"].sel(damping_model=REFERENCE)
    for index in reversed(range(answer.sizes["intensity"])):
        at = peaks.isel(intensity=index).dropna("record")
        for name in at["record"].values[np.argsort(-at.values, kind="stable")]:
            scale = float(answer["scale_factor"].sel(record=name).isel(intensity=index))
            with as_meant():  # the intensity was warned of when it was asked for
                histories = responses(
                    motions[str(name)].record, subject.wall, subject.curve, dampings, scale=scale, tail=TAIL
                )
            if str(histories["outcome"].sel(damping_model=REFERENCE).item()) == "completed":
                intensity = float(answer[answer.attrs["intensity_measure"].lower()][index])
                peak = float(histories["peak_ratio"].sel(damping_model=REFERENCE))
                return {
                    "record": str(name),
                    "intensity": _level(answer, intensity),
                    "peak": number(peak),
                    "histories": histories,
                }
    return {}


# --- tables -----------------------------------------------------------------------------------------------------------


def _inputs(subject: Subject) -> list[dict[str, Any]]:
    wall, curve = subject.wall, subject.curve
    rows: list[tuple[str, str, Any, str]] = [
        ("thickness", "t", wall.thickness, "m"),
        ("height", "h", wall.height, "m"),
        ("length of the strip", "", wall.width, "m"),
        ("density", "", wall.density, "kg m⁻³"),
        ("overburden over weight", "O/W", wall.overburden_ratio, "-"),
        ("eccentricity of the overburden", "", wall.eccentricity, "m"),
    ]
    if isinstance(wall, Wall):
        rows.append(("height of the hinge over h", "h₁/h", wall.hinge_ratio, "-"))
    rows += [
        ("yield displacement ratio", "a₁", curve.yield_displacement_ratio, "-"),
        ("strength ratio", "b₁", curve.strength_ratio, "-"),
        ("ultimate displacement ratio", "a₃", curve.ultimate_displacement_ratio, "-"),
    ]
    return [_line(*row) | {"value": plain(row[2])} for row in rows]


def _derived(subject: Subject) -> list[dict[str, Any]]:
    wall = subject.wall
    onset = float(subject.answer["rocking_onset"])
    rows: list[tuple[str, str, Any, str]] = [
        ("slenderness", "h/t", wall.slenderness, "-"),
        ("weight", "W", float(wall.weight) / 1000, "kN"),
        ("strength of the rigid wall", "F₀", float(wall.rigid_strength) / 1000, "kN"),
        ("instability displacement", U_INS, 1000 * float(wall.instability_displacement), "mm"),
        ("frequency parameter", "p", wall.frequency_parameter, "rad s⁻¹"),
        ("rocking starts at", "", onset / STANDARD_GRAVITY, "g"),
    ]
    return [_line(*row) for row in rows]


def _line(name: str, symbol: str, value: Any, unit: str) -> dict[str, Any]:
    return {"name": name, "symbol": symbol, "value": number(float(value)), "unit": unit}


def _dampers(subject: Subject) -> list[dict[str, Any]]:
    """Return the damping ratio of each viscous model for e: of the closed form, and of least error if any."""
    curve, e = subject.curve, float(subject.answer["restitution"])
    a1, b1, a3 = (
        float(value)
        for value in (curve.yield_displacement_ratio, curve.strength_ratio, curve.ultimate_displacement_ratio)
    )
    release = 0.5 * a3
    try:
        rows = equivalent(e, a1, b1, a3, curve.softening, release_amplitude=release)
        fitted = {row["damping_model"]: (row["damping_ratio"], row["rms_error"]) for row in rows}
    except InputError:  # for some curves no damping ratio within reach errs least
        fitted = {}
    return [
        {
            "model": model,
            "title": kinds()[model].title,
            "energy": percent(float(damping_ratio_energy(curve, model, e, release)), 3),
            "ratio": percent(fitted[model][0], 3) if fitted else None,
            "error": percent(fitted[model][1]) if fitted else None,
        }
        for model in VISCOUS_MODELS
    ]


def _shares(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return the shares that collapse at `MOST_ROWS` intensities, evenly spread over all of them, at most."""
    count = answer.sizes["intensity"]
    rows = []
    for index in np.unique(np.linspace(0, count - 1, min(count, MOST_ROWS)).round().astype(int)):
        at = answer.isel(intensity=int(index))
        models = [_share(at.sel(damping_model=model)) for model in (REFERENCE, RECOMMENDED)]
        rows.append(
            {"intensity": _level(answer, float(at[answer.attrs["intensity_measure"].lower()])), "models": models}
        )
    return rows


def _share(of_model: xr.Dataset) -> Mapping[str, Any]:
    low, high = of_model["collapse_probability_interval"].values
    return {
        "collapses": int(of_model["collapses"]),
        "share": percent(float(of_model["collapse_probability"])),
        "interval": f"{percent(low)} to {percent(high)}",
    }


def _fragility(answer: xr.Dataset) -> list[dict[str, Any]]:
    name = answer.attrs["intensity_measure"].lower()
    rows = []
    for model in (REFERENCE, RECOMMENDED):
        of_model = answer.sel(damping_model=model)
        rows.append(
            {
                "model": model,
                "median": number(float(of_model[f"median_{name}"])),
                "median_interval": _span(of_model[f"median_{name}_interval"].values),
                "dispersion": number(float(of_model["dispersion"]), 2),
                "dispersion_interval": _span(of_model["dispersion_interval"].values),
            }
        )
    return rows


def _span(bounds: Array) -> str:
    return " to ".join(map(number, bounds)) if np.isfinite(bounds).all() else DASH


def _headline(answer: xr.Dataset) -> dict[str, Any]:
    """Return the answer under restitution at the highest intensity asked for."""
    name = answer.attrs["intensity_measure"].lower()
    at = answer.isel(intensity=-1).sel(damping_model=REFERENCE)
    median = float(at[f"median_{name}"])
    return {
        "intensity": _level(answer, float(at[name])),
        **_share(at),
        "records": int(answer["records"]),
        "median": _level(answer, median, 3) if np.isfinite(median) else None,
        "onset": number(float(answer["rocking_onset"]) / STANDARD_GRAVITY, 2),
    }


def _level(answer: xr.Dataset, value: float, digits: int = 4) -> str:
    """Return an intensity with its unit, an acceleration in g too."""
    measure = answer.attrs["intensity_measure"]
    also = f" ({value / STANDARD_GRAVITY:.3g} g)" if measure == "PGA" else ""
    return f"{value:.{digits}g} {PRINTED[UNITS[measure]]}{also}"


def _records(motions: Sequence[GroundMotion]) -> str:
    names = [motion.name for motion in motions]
    if len(names) > MOST_NAMES:
        names = [*names[: MOST_NAMES // 2], "…", *names[-MOST_NAMES // 2 :]]
    stations = len({motion.group for motion in motions})
    return f"{len(motions)} records of {stations} station{'s' if stations > 1 else ''}: {', '.join(names)}"


# --- pictures ---------------------------------------------------------------------------------------------------------


def _image(figure: Figure) -> str:
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=RESOLUTION)
    return f"data:image/png;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}"


def _text(name: str) -> str:
    return files("rockdamp.report.one_wall").joinpath(name).read_text(encoding="utf-8")
