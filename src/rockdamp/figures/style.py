"""Shared by all figures: print sizes, one colour, line and marker for each damping model, labels and legends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.style
import numpy as np
import xarray as xr
from matplotlib.axis import Axis
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from rockdamp.constants import MODELS, PAPER_MODELS, RECOMMENDED, REFERENCE

STYLE = Path(__file__).with_name("paper.mplstyle")
SINGLE_COLUMN, DOUBLE_COLUMN = 90.0, 190.0  # [mm]
# The paper's reference case, nearest to which a figure or its caption shows one e, u0/u_ins or a1.
REFERENCE_RESTITUTION, REFERENCE_AMPLITUDE, REFERENCE_A1 = 0.85, 0.5, 0.04
INCH = 25.4  # [mm]
COLOURS = {
    "CR": "#1A1A1A",
    "CDC": "#0072B2",
    "CDR": "#D55E00",
    "SDR": "#009E73",
    "ECD": "#9A4C95",
    "BAND": "#D0267F",
    "CQD": "#7F7F7F",
}
Colour = tuple[float, float, float]


class ModelStyle(NamedTuple):
    """Colour, line and marker of a damping model in every figure."""

    colour: str
    linestyle: str | tuple[float, tuple[float, ...]]
    marker: str


# Lines and markers. A damper's file has its colour, one that the colour-blind can tell apart (Okabe and Ito); in grey
# the lines and markers still differ.
CHOSEN: dict[str, tuple[str | tuple[float, tuple[float, ...]], str]] = {
    "CR": ("solid", "o"),
    "CDC": ((0, (3.0, 1.4)), "s"),
    "CDR": ((0, (8.0, 1.6)), "^"),
    "SDR": ("dashdot", "D"),
    "ECD": ("dotted", "v"),
    RECOMMENDED: ((0, (6.0, 1.2, 1.0, 1.2, 1.0, 1.2)), "X"),
}
# For other models: two cycles of unlike lengths, so that many differ. Lines differ in the order of their dots, short
# and long strokes, or in a gap as wide as a stroke, which is seen in any colour.
SPARE_LINES: tuple[tuple[float, tuple[float, ...]], ...] = (
    (0, (3.0, 4.0)),
    (0, (1.0, 3.5)),
    (0, (8.0, 1.4, 1.0, 1.4, 1.0, 1.4, 1.0, 1.4)),
    (0, (3.0, 1.4, 3.0, 1.4, 1.0, 1.4)),
    (0, (1.0, 1.4, 1.0, 4.0)),
)
SPARE_MARKERS = ("<", ">", "p", "h", "d", "H", "8")
GREY, PALE = "#6E6E6E", "#B5B5B5"
# Of walls, exponents and amplitudes.
SHADES = ("#0072B2", "#D0267F", "#E69F00", "#009E73", "#56B4E9", "#8C6D1F", "#9A4C95", GREY)
MARKERS, LINES = "o^sDv<>p", ("solid", "dashed", "dotted")

# Symbols and units of the axes; "-" is dimensionless.
RESTITUTION = "coefficient of restitution $e$ [-]"
DAMPING_RATIO = r"damping ratio $\xi$ [-]"
DISPLACEMENT = r"$u/u_\mathrm{ins}$ [-]"
TAU = r"dimensionless time $\tau = p\,t$ [-]"


def styled(draw: Callable[..., Figure]) -> Callable[..., Figure]:
    """Make a figure function use the shared style, whatever the user's own settings are."""

    @wraps(draw)
    def wrapper(*datasets: Any) -> Figure:
        with matplotlib.style.context(STYLE, after_reset=True):
            return draw(*datasets)

    return wrapper


def new_figure(height: float, width: float = DOUBLE_COLUMN) -> Figure:
    """Return an empty figure of a print size. [mm]"""
    return Figure(figsize=(width / INCH, height / INCH))


def columns_of(count: int, most: int) -> int:
    """Return how many columns, `most` of them at most, hold `count` panels or entries in rows of equal length."""
    return -(-count // -(-count // most))


def style_of(model: str) -> ModelStyle:
    """Return how a model is drawn, with a spare line and marker where none is chosen for it."""
    index = [name for name in (*MODELS, model) if name not in CHOSEN].index(model) if model not in CHOSEN else 0
    spare = SPARE_LINES[index % len(SPARE_LINES)], SPARE_MARKERS[index % len(SPARE_MARKERS)]
    return ModelStyle(COLOURS[model], *CHOSEN.get(model, spare))


def paper_models(dataset: xr.Dataset) -> xr.Dataset:
    """Keep the paper's models of a dataset: its figures show no others."""
    for dim in {"damping_model", "viscous_model"} & set(dataset.dims):
        dataset = dataset.sel({dim: np.isin(dataset[dim].values, (REFERENCE, *PAPER_MODELS))})
    return dataset


def dampers(data: xr.Dataset) -> list[str]:
    """Return the damping models of a dataset but the reference, CR."""
    return [str(model) for model in data["damping_model"].values if model != REFERENCE]


def literal(text: str) -> str:
    """Return a text from outside as it is drawn: a dollar is no formula, and a control character is an escape."""
    return " ".join(text.split()).replace("$", r"\$")


def line_of(model: str) -> dict[str, Any]:
    """Return the keyword arguments that draw a model's line."""
    return {"color": style_of(model).colour, "linestyle": style_of(model).linestyle}


def pick_look(index: int) -> dict[str, Any]:
    """Return the keyword arguments that draw one of several walls or values; 24 differ in colour and marker."""
    turn, column = divmod(index, len(SHADES))
    marker = MARKERS[(column + turn) % len(MARKERS)]
    return {"color": SHADES[column], "marker": marker, "linestyle": LINES[turn % len(LINES)]}


def marks_of(model: str) -> dict[str, Any]:
    """Return the keyword arguments that draw a model's markers, without a line."""
    return {"color": style_of(model).colour, "marker": style_of(model).marker, "linestyle": "none"}


def one_two_five(axis: Axis) -> None:
    """Label a logarithmic axis by plain numbers: 1, 2, 5 and their like."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def shades(model: str, count: int) -> list[Colour]:
    """Return `count` shades of a model's colour, light to dark, for the values of a parameter."""
    return ramp(style_of(model).colour, count)


def ramp(name: str, count: int) -> list[Colour]:
    """Return `count` shades of a colour, light to dark."""
    colour = to_rgb(name)
    light, dark = (tuple(0.45 * part + 0.55 * end for part in colour) for end in (1.0, 0.0))
    colours = LinearSegmentedColormap.from_list(name, [light, colour, dark])
    red_green_blue = colours([0.5] if count == 1 else [i / (count - 1) for i in range(count)])[:, :3]
    return [(float(r), float(g), float(b)) for r, g, b in red_green_blue]


def present(values: Sequence[float], wanted: Sequence[float]) -> list[int]:
    """Return the indices in `values` of those `wanted` that are there, in that order; of all where none is."""
    indices = [index for want in wanted for index, value in enumerate(values) if abs(value - want) < 1e-9]
    return indices or list(range(len(values)))


def nearest(values: Sequence[float], wanted: float) -> int:
    """Return the index in `values` of the one nearest to `wanted`."""
    return min(range(len(values)), key=lambda index: abs(values[index] - wanted))


def texts(values: Sequence[float]) -> list[str]:
    """Return numbers as text, all with the decimals that the longest of them needs."""
    decimals = max(len(f"{value:g}".partition(".")[2]) for value in values)
    return [f"{value:.{decimals}f}" for value in values]


def scaling(factor: float) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Return what a second axis needs to show `factor` times the first."""
    return (lambda value: value * factor), (lambda value: value / factor)
