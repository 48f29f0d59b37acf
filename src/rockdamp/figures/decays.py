"""Fig. 3, damping laws and loops, and Fig. 4, decays of displacement and velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.style import COLUMN, DISPLACEMENT, PALE, handles, legend, look, panels


def model_label(history: xr.Dataset, model: str) -> str:
    """Return the name of a model with its parameter."""
    if model == "CR":
        return f"CR, $e = {float(history['restitution'].max()):g}$"
    return f"{model}, $\\xi = {float(history['damping_ratio'].sel(damping_model=model)):.4f}$"


def fig3(decays: xr.Dataset) -> Figure:
    """Draw the damping ratio against the secant frequency, and the damping force against the displacement."""
    figure, ((law,), (force,)) = panels(2, 1, 128.0, COLUMN, height_ratios=[1.0, 1.5])
    for model in PAPER_MODELS:
        ratio = decays["damping_ratio_law"].sel(viscous_model=model)
        law.plot(decays["frequency_ratio"], ratio, **look(model, markevery=(5, 20)))
        decay = decays.sel(damping_model=model)
        turned = np.flatnonzero(
            np.diff(np.sign(decay["velocity"].values))
        )  # at rest, then at each turn
        cycle = decay.isel(tau=slice(0, int(turned[turned > 0][1]) + 1))
        force.plot(
            cycle["displacement"],
            cycle["damping_force"],
            label=model_label(decays, model),
            **look(model, marker=""),
        )
    for zero in (force.axhline, force.axvline):
        zero(0, color=PALE, linewidth=0.6, zorder=0)
    law.set(xlim=(0, 1.02), ylim=(0, 4), title="(a) damping laws")
    law.set(
        xlabel=r"secant frequency $\omega/\omega_1$ [-]",
        ylabel=r"damping ratio $\xi(\omega)/\xi$ [-]",
    )
    force.set(xlabel=DISPLACEMENT, ylabel=r"damping force $C\,\dot u/F_0$ [-]")
    force.set_title(
        f"(b) first cycle of the decays matched to $e = {float(decays['restitution']):g}$"
    )
    legend(figure, handles(force), columns=2)
    return figure


def fig4(decays: xr.Dataset) -> Figure:
    """Draw the rocking decay against the rigid wall's, and CR against the CDR that is matched to it."""
    figure, grid = panels(2, 2, 106.0, COLUMN)
    (rocking, displacement), (velocity, impact) = grid
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
        rocking.plot(decays["tau"], decays["rocking_displacement"].sel(rocking_model=name), **line)
    rocking.set(
        title=f"(a) rocking, $e = {float(decays['rocking_restitution']):g}$", ylabel=DISPLACEMENT
    )
    crossings = np.flatnonzero(np.diff(np.sign(decays["displacement"].sel(damping_model="CR"))))
    tau = decays["tau"].values
    end, first = tau[crossings[:8][-1]], tau[crossings[0] + 1]
    near_impact = slice(first - 0.25, first + 0.25)
    for model in ("CR", "CDR"):
        history = decays.sel(damping_model=model)
        line = look(model, marker="", label=f"(b)–(d) {model_label(decays, model)}")
        displacement.plot(tau, history["displacement"], **line)
        velocity.plot(tau, history["velocity"], **line)
        near = history.sel(tau=near_impact)
        impact.plot(near["tau"], near["velocity"], **line)
    displacement.set(title="(b) displacement", xlim=(0, end), ylabel=DISPLACEMENT)
    velocity.set(title="(c) velocity", xlim=(0, end))
    impact.set(title="(d) first impact")
    for axes in (velocity, impact):
        axes.set_ylabel(r"$\dot u/(p\,u_\mathrm{ins})$ [-]")
    for axes in grid.flat:
        axes.set_xlabel(r"$\tau = p\,t$ [-]")
        if axes is not impact:
            axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)
    legend(figure, [*handles(rocking), *handles(displacement)], columns=2)
    return figure
