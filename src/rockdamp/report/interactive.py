"""The data of the explorer: constants of the closed form and of the solver, looks, and starting values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from rockdamp.equivalence import minima
from rockdamp.equivalence.closed_form import NODES, PLATEAU_PIECES, WEIGHTS
from rockdamp.equivalence.minima import RIVALS, SCAN, SCAN_STEP
from rockdamp.figures.style import style_of
from rockdamp.mechanics.curve import ROUNDING, TrilinearCurve
from rockdamp.mechanics.damping import Damping, damper_classes
from rockdamp.mechanics.damping.ecd import normalisation
from rockdamp.mechanics.wall import Wall
from rockdamp.vocabulary import MODELS, PRESETS, RECOMMENDED, REFERENCE, SOFTENING, VISCOUS_MODELS

DASHES = {"solid": [], "dashed": [6, 3], "dashdot": [8, 3, 2, 3], "dotted": [2, 3]}
WIDTH = 2  # of the lines; dashes are in line widths [pixels]
REFINEMENT = 4  # of the search; beyond it ratios move by less than 1e-4 of themselves
REST = 300  # of the sliders before the search begins [ms]
LENGTH, DRAWN = 20.0, 0.02  # of the decays, and from one point that is drawn to the next [in tau]


class Control(NamedTuple):
    """A slider with its number input."""

    name: str
    label: str
    meaning: str
    smallest: float
    largest: float
    step: float


CONTROLS = (
    Control("e", "e", "coefficient of restitution", 0.5, 1.0, 0.005),
    Control("a1", "a1", "end of the first branch, u1/u_ins", 0.005, 0.5, 0.005),
    Control("b1", "b1", "plateau over rigid strength, F_y/F0", 0.05, 0.99, 0.01),
    Control("a3", "a3", "displacement of zero force, u3/u_ins", 0.1, 1.0, 0.01),
    Control("x0", "u0/u_ins", "release amplitude", 0.01, 0.99, 0.01),
    Control("m", "m", "order of ECD", 0, 32, 1),
    Control("t", "t", "thickness [m]", 0.05, 1.0, 0.01),
    Control("h", "h", "height [m]", 0.5, 12.0, 0.1),
)


def dash(style: str | tuple[float, Sequence[float]]) -> list[float]:
    """Return a line style of the figures as lengths of dashes and gaps. [pixels]"""
    if isinstance(style, str):
        return list(DASHES[style])
    return [round(WIDTH * length, 1) for length in style[1]]


def styles() -> dict[str, dict[str, Any]]:
    """Return each damping model's name, colour and dashes, those of the figures."""
    return {
        model: {
            "title": damper_classes()[model].title,
            "colour": style_of(model).colour,
            "dash": dash(style_of(model).linestyle),
        }
        for model in MODELS
    }


def data(
    curve: TrilinearCurve, wall: Wall, step: float, response_length: float, restitution: float, release_amplitude: float
) -> dict[str, Any]:
    """Return the data of the page's scripts: constants, the study's wall, and the values at which the sliders start.

    `response_length`, over which Eq. (17) is summed, is in tau.
    """
    start = {
        "e": restitution,
        "x0": release_amplitude,
        "m": 0,
        "a1": float(curve.yield_displacement_ratio),
        "b1": float(curve.strength_ratio),
        "a3": float(curve.ultimate_displacement_ratio),
        "softening": curve.softening,
        "t": float(wall.thickness),
        "h": float(wall.height),
    }
    presets = {name: {"a1": a1, "b1": b1, "a3": 1.0, "softening": "steeper"} for name, (b1, a1) in PRESETS.items()}
    return {
        "constants": {
            "nodes": NODES.tolist(),
            "weights": WEIGHTS.tolist(),
            "plateau_pieces": PLATEAU_PIECES,
            "rounding": ROUNDING,
            "exact": exact_dampers(),
        },
        "solver": {
            "step": step,
            "steps": round(LENGTH / step),
            "compared": round(response_length / step),
            "drawn": max(1, round(DRAWN / step)),
        },
        # Of walls that differ in thickness and height alone: u_ins goes with the one, p with the root of the other.
        "wall": {
            "u_ins_over_thickness": float(wall.instability_displacement / wall.thickness),
            "frequency_root_height": float(wall.frequency_parameter * np.sqrt(wall.height)),
            "hinge": float(wall.hinge_ratio),
        },
        "search": {
            "scan": np.geomspace(SCAN.smallest, SCAN.largest, SCAN.points).tolist(),
            "every": max(1, round(SCAN_STEP / step)),
            "rivals": RIVALS,
            "nodes": minima.NODES.tolist(),
            "inner": float(minima.NODES[minima.INNER][-1]),
            "half_width": minima.HALF_WIDTH,
            "widest": minima.WIDEST,
            "moves": minima.MOVES,
            "refinement": REFINEMENT,
            "rest": REST,
        },
        "reference": REFERENCE,
        "recommended": RECOMMENDED,
        "models": list(MODELS),
        "softening": list(SOFTENING),
        "styles": styles(),
        "start": start,
        "presets": {"study": start, **presets},
    }


def formulas() -> str:
    """Return a script with the coefficient of each damper, as the damper's file has it."""
    known = {
        model: damper_classes()[model].javascript for model in VISCOUS_MODELS if damper_classes()[model].javascript
    }
    lines = [f'  "{model}": (z, f, doubleV, v, w1, m, N, xi) => {formula},' for model, formula in known.items()]
    return "\n".join(['"use strict";', "const dampingFormulas = {", *lines, "};"])


def exact_dampers() -> dict[str, dict[str, float]]:
    """Return order m and N_m of the dampers that lose the same fraction from every amplitude."""
    of_unit = {model: Damping(model, 1.0) for model in VISCOUS_MODELS}
    orders = {model: float(one.order) for model, one in of_unit.items() if one.amplitude_independent}
    return {model: {"order": order, "normalisation": float(normalisation(order))} for model, order in orders.items()}
