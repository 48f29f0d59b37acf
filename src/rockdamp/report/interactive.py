"""What the explorer needs from here: constants of the closed form, looks, starting values, and the stored decays."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from bokeh.resources import Resources

from rockdamp.equivalence.closed_form import NODES, PLATEAU_PIECES, WEIGHTS
from rockdamp.figures.style import style_of
from rockdamp.mechanics import half_cycle_loss
from rockdamp.mechanics.curve import ROUNDING, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.vocabulary import PRESETS, REFERENCE, TITLES, VISCOUS_MODELS

# Bokeh draws the plots: well kept, on PyPI with its script, and at 1.4 MB a quarter of what plotly brings, which counts
# on a phone. Of its components only these two are needed.
COMPONENTS: list[Literal["bokeh", "bokeh-api"]] = ["bokeh", "bokeh-api"]
DECIMALS = 4  # of the stored displacements: a ten thousandth of u_ins is less than a screen shows
MISSING = -(2**15)
DASHES = {"solid": [], "dashed": [6, 3], "dashdot": [8, 3, 2, 3], "dotted": [2, 3]}
WIDTH = 2  # of the lines; dashes are in line widths [pixels]


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
)


def library() -> str:
    """Return the script of the plotting library."""
    return "\n".join(Resources(mode="inline", minified=True, components=[*COMPONENTS]).js_raw)


def dash(style: str | tuple[float, Sequence[float]]) -> list[float]:
    """Return a line style of the figures as lengths of dashes and gaps. [pixels]"""
    if isinstance(style, str):
        return list(DASHES[style])
    return [round(WIDTH * length, 1) for length in style[1]]


def styles() -> dict[str, dict[str, Any]]:
    """Return each damping model's name, colour and dashes, those of the figures."""
    return {
        model: {"title": title, "colour": style_of(model).colour, "dash": dash(style_of(model).linestyle)}
        for model, title in TITLES.items()
    }


def data(explorer: xr.Dataset, restitution: float, release_amplitude: float) -> dict[str, Any]:
    """Return what the page's script reads.

    Parameters
    ----------
    explorer : xarray.Dataset
        What `rockdamp.studies.explorer_decays.explorer` returned.
    restitution, release_amplitude : float
        e and u0/u_ins that the sliders start at. [-]
    """
    study = study_curve(explorer)
    curve = {
        "a1": float(study.cracked_stiffness_ratio),
        "b1": float(study.plateau_ratio),
        "a3": float(study.ultimate_ratio),
        "softening": study.softening,
    }
    presets = {name: {"a1": a1, "b1": b1, "a3": 1.0, "softening": "steeper"} for name, (b1, a1) in PRESETS.items()}
    return {
        "constants": {
            "nodes": NODES.tolist(),
            "weights": WEIGHTS.tolist(),
            "plateau_pieces": PLATEAU_PIECES,
            "rounding": ROUNDING,
            "exact": exact_dampers(),
            "decrement_step": half_cycle_loss.STEP,
            "decrement_reach": half_cycle_loss.REACH,
        },
        "reference": REFERENCE,
        "models": [str(model) for model in explorer["damping_model"].values],
        "styles": styles(),
        "start": {"e": restitution, "x0": release_amplitude, **curve},
        "presets": {"study": curve, **presets},
        "decays": {"curve": curve, **_decays(explorer)},
    }


def study_curve(explorer: xr.Dataset) -> TrilinearCurve:
    """Return the curve whose decays the explorer's dataset holds."""
    names = ("cracked_stiffness_ratio", "plateau_ratio", "ultimate_ratio", "plateau_end_ratio")
    a1, b1, a3, a2 = (float(explorer[name]) for name in names)
    return TrilinearCurve(a1, b1, a3, "steeper" if abs(a2 + b1 - 1) < 1e-9 else "translated")


def exact_dampers() -> dict[str, dict[str, float]]:
    """Order m and N_m of the dampers that lose the same fraction from every amplitude."""
    of_unit = {model: Damping(model, 1.0) for model in VISCOUS_MODELS}
    orders = {model: float(one.order) for model, one in of_unit.items() if one.same_loss_at_any_amplitude}
    return {
        model: {"order": order, "normalisation": float(half_cycle_loss.normalisation(order))}
        for model, order in orders.items()
    }


def _decays(explorer: xr.Dataset) -> dict[str, Any]:
    """The stored decays: whole numbers of a ten thousandth, two bytes each, in base 64."""
    dims = ("damping_model", "release_amplitude", "restitution", "tau")
    displacement = explorer["displacement"].transpose(*dims).values
    whole = np.where(np.isfinite(displacement), np.round(displacement * 10**DECIMALS), MISSING).astype("<i2")
    tau = explorer["tau"].values
    ratio = explorer["damping_ratio"].transpose(*dims[:3]).values
    return {
        "releases": explorer["release_amplitude"].values.tolist(),
        "restitutions": explorer["restitution"].values.tolist(),
        "points": int(tau.size),
        "spacing": round(float(tau[1] - tau[0]), 12),
        "window": float(explorer["window"]),
        "ratios": [[[None if np.isnan(v) else round(v, 6) for v in row] for row in part] for part in ratio.tolist()],
        "missing": MISSING,
        "scale": 10.0**-DECIMALS,
        "displacement": base64.b64encode(whole.tobytes()).decode("ascii"),
    }
