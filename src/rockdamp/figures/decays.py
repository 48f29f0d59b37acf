"""Fig. 3, damping laws and loops, and Fig. 4, decays of displacement and velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.style import (
    COLUMN,
    DISPLACEMENT,
    PALE,
    handles,
    legend,
    look,
    panels,
    zero_line,
)


def model_label(history: xr.Dataset, model: str) -> str:
    """Return the name of a model with its parameter."""
    if model == "CR":
        e = float(history["restitution"].max())  # one number, or NaN for every model but CR
        return f"CR, $e = {e:.4g}$"
    xi = float(history["damping_ratio"].sel(damping_model=model))
    return f"{model}, $\\xi = {xi:.4f}$"


def sign_changes(values: Array) -> NDArray[np.intp]:
    """Return the samples after which a history changes its sign."""
    return np.flatnonzero(np.diff(np.sign(values)))


# --- Fig. 3 ------------------------------------------------------------------------------------


def fig3(decays: xr.Dataset) -> Figure:
    """Draw the damping ratio against the secant frequency, and loops of the damping force."""
    figure, ((law,), (force,)) = panels(2, 1, 128.0, COLUMN, height_ratios=[1.0, 1.5])
    draw_laws(law, decays)
    draw_loops(force, decays)
    legend(figure, handles(force), columns=2)
    return figure


def draw_laws(axes: Axes, decays: xr.Dataset) -> None:
    """Draw the damping ratio of each model against the secant frequency."""
    for model in PAPER_MODELS:
        ratio = decays["damping_ratio_law"].sel(viscous_model=model)
        axes.plot(decays["frequency_ratio"], ratio, **look(model, markevery=(5, 20)))
    axes.set(xlim=(0, 1.02), ylim=(0, 4), title="(a) damping laws")
    axes.set_xlabel(r"secant frequency $\omega/\omega_1$ [-]")
    axes.set_ylabel(r"damping ratio $\xi(\omega)/\xi$ [-]")


def draw_loops(axes: Axes, decays: xr.Dataset) -> None:
    """Draw the damping force against the displacement in the first cycle."""
    for model in PAPER_MODELS:
        decay = decays.sel(damping_model=model)
        turns = sign_changes(decay["velocity"].values)
        second_turn = int(turns[turns > 0][1])  # the release is at rest too
        cycle = decay.isel(tau=slice(0, second_turn + 1))
        label = model_label(decays, model)
        line = look(model, marker="")
        axes.plot(cycle["displacement"], cycle["damping_force"], label=label, **line)
    for draw_zero in (axes.axhline, axes.axvline):
        draw_zero(0, color=PALE, linewidth=0.6, zorder=0)
    axes.set(xlabel=DISPLACEMENT, ylabel=r"damping force $C\,\dot u/F_0$ [-]")
    e = float(decays["restitution"])
    axes.set_title(f"(b) first cycle of the decays matched to $e = {e:g}$")


# --- Fig. 4 ------------------------------------------------------------------------------------


def fig4(decays: xr.Dataset) -> Figure:
    """Draw the rocking decay against the rigid wall's, and CR against the CDR matched to it."""
    figure, grid = panels(2, 2, 106.0, COLUMN)
    (rocking, displacement), (velocity, impact) = grid
    draw_rocking(rocking, decays)
    crossings = sign_changes(decays["displacement"].sel(damping_model="CR").values)
    tau = decays["tau"].values
    end = tau[crossings[:8][-1]]  # eight crossings are four cycles
    first = tau[crossings[0] + 1]
    near_impact = slice(first - 0.25, first + 0.25)
    for model in ("CR", "CDR"):
        history = decays.sel(damping_model=model)
        line = look(model, marker="", label=f"(b)–(d) {model_label(decays, model)}")
        displacement.plot(tau, history["displacement"], **line)
        velocity.plot(tau, history["velocity"], **line)
        detail = history.sel(tau=near_impact)
        impact.plot(detail["tau"], detail["velocity"], **line)
    displacement.set(title="(b) displacement", xlim=(0, end), ylabel=DISPLACEMENT)
    velocity.set(title="(c) velocity", xlim=(0, end))
    impact.set(title="(d) first impact")
    for axes in (velocity, impact):
        axes.set_ylabel(r"$\dot u/(p\,u_\mathrm{ins})$ [-]")
    for axes in grid.flat:
        axes.set_xlabel(r"$\tau = p\,t$ [-]")
        if axes is not impact:
            zero_line(axes)
    legend(figure, [*handles(rocking), *handles(displacement)], columns=2)
    return figure


def draw_rocking(axes: Axes, decays: xr.Dataset) -> None:
    """Draw the nearly rigid wall, and rigid bodies with small and with large rotations."""
    lines: dict[str, dict[str, Any]] = {
        "slender": {"color": "#9A9A9A", "linewidth": 2.6, "label": "(a) rigid, slender limit"},
        "tri-linear": {"color": "#1A1A1A", "linewidth": 0.9, "label": "(a) tri-linear"},
        "large rotation": {
            "color": "#C1121F",
            "linestyle": "dashed",
            "label": "(a) rigid, large rotations",
        },
    }
    for name, line in lines.items():
        history = decays["rocking_displacement"].sel(rocking_model=name)
        axes.plot(decays["tau"], history, **line)
    e = float(decays["rocking_restitution"])
    axes.set(title=f"(a) rocking, $e = {e:g}$", ylabel=DISPLACEMENT)
