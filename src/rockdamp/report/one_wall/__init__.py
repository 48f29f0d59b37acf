"""The page of one wall, that `rockdamp assess --report` writes: its assumptions and its answers, on three sheets.

The report of all studies does not read it.
"""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np
import xarray as xr
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from rockdamp import __version__
from rockdamp.assessment.answers import reasons
from rockdamp.assessment.assess import REPLICATES
from rockdamp.assessment.checks import Check, sensitivity
from rockdamp.assessment.collapses import LEAST_OF_DAMPER, STRIPES, UNITS, side_by_side
from rockdamp.constants import (
    REFERENCE,
    RELEASES,
    SMALL_RELEASE_OVERSTATES,
    STANDARD_GRAVITY,
)
from rockdamp.equivalence.programs import REQUIREMENT, frequencies, missed_collapses, program_inputs
from rockdamp.figures.commands import fragility_figure, response_figure, wall_figure
from rockdamp.histories.respond import respond
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS
from rockdamp.mechanics.floors import Building, Diaphragm
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.storage.files import replace_file
from rockdamp.text import DASH, RAISED, count_noun, number, percent, plain

# Files of this package that the page is made of; named here, so that an edit of one is an edit of the page.
TEMPLATE = "wall.html.j2"
STYLE = "wall.css"
U_INS = Markup("u<sub>ins</sub>")
RESOLUTION = 200  # dots per inch
MOST_ROWS = 4  # intensities in the table
MOST_NAMES = 8  # records named
Row = tuple[str, str, Any, str]  # name, symbol, value and unit of a quantity


@dataclass(frozen=True)
class Placement:
    """Where a wall stands, in words; what `assess --json` says of its building, and the check at each intensity."""

    checks: Sequence[Check] = ()
    place: str = ""
    values: Mapping[str, Any] | None = None
    building: Building | None = None
    diaphragm: Diaphragm | None = None


@dataclass(frozen=True)
class Subject:
    """A wall, its records, the dataset that `rockdamp.assess` returned for them, and the command as it was typed."""

    wall: Wall | Parapet
    curve: TrilinearCurve
    motions: Sequence[GroundMotion]
    answer: xr.Dataset
    placement: Placement = Placement()
    command: str = ""

    @property
    def models(self) -> tuple[str, str]:
        """Restitution, and the damping model beside it."""
        reference, other = map(str, self.answer["damping_model"].values)
        return reference, other


def build(subject: Subject) -> str:
    """Return the page as HTML, which needs nothing but itself."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"number": number, "percent": percent, "span": _span}
    environment.filters |= {"unit": _unit, "displacement": _displacement, "level": partial(_level, subject.answer)}
    environment.globals |= {"number": number, "percent": percent, "isfinite": np.isfinite, "gravity": STANDARD_GRAVITY}
    answer, placement, worst = subject.answer, subject.placement, worst_standing(subject)
    measure = answer.attrs["intensity_measure"]
    name, asked, last = measure.lower(), answer[measure.lower()].values, answer.sizes["intensity"] - 1
    both = answer.rename({f"median_{name}": "median", f"median_{name}_interval": "median_interval", name: "asked"})
    frequency, period = map(number, frequencies(subject.wall, subject.curve))
    moved = sensitivity(
        *(subject.wall, subject.curve, float(answer["restitution"]), subject.motions, measure, float(asked[-1])),
        *(float(answer["tail"]), placement.building, placement.diaphragm),
    )
    cr = both.isel(intensity=-1).sel(damping_model=REFERENCE)
    return environment.from_string(_text(TEMPLATE)).render(
        style=Markup(_text(STYLE)),
        command=subject.command,
        wall=subject.wall,
        kind="parapet" if isinstance(subject.wall, Parapet) else "wall",
        inputs=_inputs(subject),
        plain=plain,
        derived=_derived(subject),
        reason=answer.attrs["restitution_reason"],
        e=number(float(answer["restitution"])),
        releases=RELEASES,
        overstates=SMALL_RELEASE_OVERSTATES,
        **_losses(subject),
        frequency=frequency,
        period=period,
        moved=moved,
        missing=list(dict.fromkeys(why for model in subject.models for why in reasons(answer, model))),
        outcomes=int(answer["records"]) * answer.sizes["stripe"],
        # At most `MOST_ROWS` intensities, evenly spread over all of them.
        shares=[
            both.isel(intensity=i)
            for i in np.unique(np.linspace(0, last, min(last + 1, MOST_ROWS)).round()).astype(int)
        ],
        left_out=max(last + 1 - MOST_ROWS, 0),
        fragility=[both.sel(damping_model=model) for model in subject.models],
        cr=cr,
        onset=float(answer["rocking_onset"]),
        placement=placement,
        check=placement.checks[-1] if placement.checks else None,
        measure=measure,
        intensity_unit=_unit(UNITS[measure]),
        records=_records(subject.motions),
        worst=worst,
        images={
            "wall": _image(wall_figure(subject.wall, subject.curve)),
            "fragility": _image(fragility_figure(answer)),
            "response": _image(worst["figure"]) if worst else "",
        },
        recommended=subject.models[1],
        stripes=STRIPES.size,
        replicates=REPLICATES,
        tail=plain(answer["tail"]),
        method=answer.attrs["collapse_probability_interval"],
        version=__version__,
    )


def write(subject: Subject, path: str | os.PathLike[str]) -> None:
    """Write the page, complete or not at all."""
    html = build(subject)
    with replace_file(path) as temporary:
        Path(temporary).write_text(html, encoding="utf-8", newline="\n")


def worst_standing(subject: Subject) -> dict[str, Any]:
    """Return the history of the largest peak that the wall survives, at the highest intensity that it may survive.

    It is run again at the finer step of `respond`; where it then collapses, the next largest peak is taken. The
    mapping is empty where the wall survives no record.
    """
    answer, motions = subject.answer, {motion.name: motion for motion in subject.motions}
    peaks = answer["peak"].sel(damping_model=REFERENCE)
    for index in reversed(range(answer.sizes["intensity"])):
        at = peaks.isel(intensity=index).dropna("record")
        for name in at["record"].values[np.argsort(-at.values, kind="stable")]:
            scale = float(answer["scale_factor"].sel(record=name).isel(intensity=index))
            histories, peak = _response(subject, motions[str(name)], scale)
            if np.isfinite(peak):
                intensity = float(answer[answer.attrs["intensity_measure"].lower()][index])
                return {
                    "record": str(name),
                    "intensity": intensity,
                    "peak": peak,
                    "histories": histories,
                    "figure": response_figure(histories),
                }
    return {}


def _response(subject: Subject, motion: GroundMotion, scale: float) -> tuple[xr.Dataset, float]:
    """Return the history under a record, and its peak under restitution, NaN after a collapse."""
    e, tail, wall = float(subject.answer["restitution"]), float(subject.answer["tail"]), subject.wall
    histories = respond(wall, subject.curve, side_by_side(e), motion, scale=scale, tail=tail)
    cr = histories.sel(damping_model=REFERENCE)
    return histories, float(cr["peak"].where(cr["collapsed"] == 0))


def _losses(subject: Subject) -> dict[str, Any]:
    """Return the dampers that stand for restitution."""
    e, wall = float(subject.answer["restitution"]), subject.wall
    typed = {row.damping_model: row for row in program_inputs(wall, subject.curve, max(e, LEAST_OF_DAMPER))}
    return {
        "dampers": [(offer, DAMPERS[model].title, typed[model]) for model, offer in REQUIREMENT.items()],
        "studied_e": plain(missed_collapses(e)[0]),
    }


# --- tables -----------------------------------------------------------------------------------------------------------


def _inputs(subject: Subject) -> list[Row]:
    wall, curve = subject.wall, subject.curve
    rows: list[Row] = [
        ("thickness", "t", wall.thickness, "m"),
        ("height", "h", wall.height, "m"),
        ("width of the wall", "", wall.width, "m"),
        ("density", "", wall.density, "kg m-3"),
        ("overburden over weight", "O/W", wall.overburden_ratio, "-"),
    ]
    if float(wall.overburden):
        rows += [
            ("overburden per metre of wall", "", float(np.divide(wall.overburden, wall.width)) / 1000, "kN/m"),
            ("eccentricity of the overburden", "", wall.eccentricity, "m"),
        ]
    if isinstance(wall, Wall):
        rows.append(("height of the hinge over h", "h₁/h", wall.hinge_ratio, "-"))
        if float(wall.overburden_mass):
            rows.append(("part of the overburden that moves as a mass", "", wall.overburden_mass, "-"))
    rows += [
        ("yield displacement ratio", "a₁", curve.yield_displacement_ratio, "-"),
        ("strength ratio", "b₁", curve.strength_ratio, "-"),
        ("ultimate displacement ratio", "a₃", curve.ultimate_displacement_ratio, "-"),
    ]
    if (building := subject.placement.building) is not None:
        rows += [
            ("period of the building", "", building.period, "s"),
            ("damping ratio of the building", "", building.damping_ratio, "-"),
        ]
    if (diaphragm := subject.placement.diaphragm) is not None:
        rows += [
            ("period of the flexible floor", "", diaphragm.period, "s"),
            ("damping ratio of the flexible floor", "", diaphragm.damping_ratio, "-"),
        ]
    return rows


def _derived(subject: Subject) -> list[Row]:
    wall = subject.wall
    onset = float(subject.answer["rocking_onset"])
    return [
        ("slenderness", "h/t", wall.slenderness, "-"),
        ("weight", "W", float(wall.weight) / 1000, "kN"),
        ("overburden", "O", float(wall.overburden) / 1000, "kN"),
        ("strength of the rigid wall", "F₀", float(wall.rigid_strength) / 1000, "kN"),
        ("instability displacement", U_INS, 1000 * float(wall.instability_displacement), "mm"),
        ("frequency parameter", "p", wall.frequency_parameter, "rad s-1"),
        ("rocking starts at", "", onset / STANDARD_GRAVITY, "g"),
        ("rocking starts at", "", onset, "m s-2"),
    ]


def _unit(unit: str) -> str:
    """Return a unit with raised exponents."""
    return unit if unit == "-" else unit.translate(RAISED)


def _displacement(metres: SupportsFloat, digits: int = 3) -> str:
    """Return a displacement in millimetres."""
    return f"{number(1000 * float(metres), digits)}\u00a0mm"


def _span(bounds: xr.DataArray, show: Callable[[float], str] = number) -> str:
    return " to ".join(map(show, bounds.values)) if np.isfinite(bounds).all() else DASH


def _level(answer: xr.Dataset, value: SupportsFloat, digits: int = 4) -> str:
    """Return an intensity with its unit, an acceleration in g too; a dash where it is not finite."""
    value = float(value)
    if not np.isfinite(value):
        return DASH
    measure = answer.attrs["intensity_measure"]
    also = f" ({value / STANDARD_GRAVITY:.3g} g)" if measure == "PGA" else ""
    return f"{value:.{digits}g} {_unit(UNITS[measure])}{also}"


def _records(motions: Sequence[GroundMotion]) -> str:
    names = [motion.name for motion in motions]
    count = len(names)
    if count > MOST_NAMES:
        names = [*names[: MOST_NAMES // 2], "…", *names[-MOST_NAMES // 2 :]]
    stations = len({motion.group for motion in motions})
    return f"{count_noun(count, 'record')} of {count_noun(stations, 'station')}: {', '.join(names)}"


# --- pictures ---------------------------------------------------------------------------------------------------------


def _image(figure: Figure) -> str:
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=RESOLUTION)
    return f"data:image/png;base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}"


def _text(name: str) -> str:
    return files("rockdamp.report.one_wall").joinpath(name).read_text(encoding="utf-8")
