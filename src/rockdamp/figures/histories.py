"""Fig. 3, damping laws and decays, and Fig. 4, decays of the displacement and velocity."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.constants import REFERENCE
from rockdamp.figures.single import label_of
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    TAU,
    dampers,
    line_of,
    new_figure,
    paper_models,
    scaling,
    style_of,
    styled,
)
from rockdamp.histories.half_cycles import passes_zero

LARGEST_LAW = 4.0  # of xi(w)/xi that is shown: CDC's grows without bound towards w = 0
LOOP_HALF_CYCLES = 2  # drawn strong, the later ones pale
SHOWN_HALF_CYCLES = 8  # of the matched decays of Fig. 4
ROCKING = {  # curve: colour, line, width, meaning
    "slender": ("#8C8C8C", "solid", 3.0, "rigid, slender limit"),
    "tri-linear": ("#1A1A1A", "solid", 0.9, "tri-linear SDOF"),
    "large rotation": ("#C1121F", "dashed", 0.9, "rigid, large rotations"),
}


@styled
def fig3(decays: xr.Dataset) -> Figure:
    """Draw the damping ratio against the secant frequency, and the damping force against the displacement."""
    decays = paper_models(decays)
    figure = new_figure(82.0)
    law, force = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.7]})
    _laws(law, decays)
    _loops(force, decays)
    return figure


def _laws(axes: Axes, decays: xr.Dataset) -> None:
    for model in dampers(decays):
        axes.plot(decays["frequency_ratio"], decays["damping_ratio_law"].sel(viscous_model=model), **line_of(model))
    axes.plot(1, 1, "o", color="black", clip_on=False, zorder=5)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, LARGEST_LAW)
    axes.set_xlabel(r"secant frequency $\omega/\omega_1$ [-]")
    axes.set_ylabel(r"damping ratio $\xi(\omega)/\xi$ [-]")
    axes.set_title("(a) damping ratio and frequency")


def _loops(axes: Axes, decays: xr.Dataset) -> None:
    for model in dampers(decays):
        decay = decays.sel(damping_model=model)
        u, force = decay["displacement"].values, decay["damping_force"].values
        last = 1 + np.flatnonzero(passes_zero(u))[LOOP_HALF_CYCLES - 1]
        end = last + int(np.argmax(np.abs(u[last:]))) + 1  # the peak of the last half cycle that is drawn strong
        axes.plot(u[end - 1 :], force[end - 1 :], color=style_of(model).colour, linewidth=0.4, alpha=0.35, zorder=1)
        axes.plot(u[:end], force[:end], label=label_of(decays, model), zorder=3, **line_of(model))
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    axes.axvline(0, color=PALE, linewidth=0.5, zorder=0)
    limit = 1.06 * float(np.abs(decays["displacement"]).max())
    axes.set_xlim(-limit, limit)
    axes.set_xlabel(DISPLACEMENT)
    axes.set_ylabel(r"damping force $C\,\dot u/F_0$ [-]")
    axes.set_title(f"(b) decays matched to $e = {float(decays['restitution']):g}$: first cycle, later ones pale")
    axes.legend(loc="upper right", title="(a) and (b)", alignment="left")


@styled
def fig4(decays: xr.Dataset) -> Figure:
    """Draw the rocking decay against the rigid wall's, and CR against the CDR that is matched to it."""
    figure = new_figure(90.0)
    left, right = figure.subfigures(1, 2, wspace=0.03, squeeze=False)[0]
    _rocking(left.subplots(), decays)
    upper, lower = right.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 1.6]})
    _matched(upper, lower, decays)
    right.align_ylabels()
    return figure


def _rocking(axes: Axes, decays: xr.Dataset) -> None:
    for name, (colour, linestyle, width, meaning) in ROCKING.items():
        values = decays["rocking_displacement"].sel(rocking_model=name)
        axes.plot(decays["tau"], values, color=colour, linestyle=linestyle, linewidth=width, label=meaning)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    axes.set(xlabel=TAU, ylabel=DISPLACEMENT, ylim=(-1, 1.4), yticks=[-1, -0.5, 0, 0.5, 1])
    p = float(decays["rocking_frequency_parameter"])
    seconds = axes.secondary_xaxis("top", functions=scaling(1 / p))
    seconds.set_xlabel(f"$t$ [s], with $p = {p:.3g}$ rad/s")
    axes.set_title(f"(a) rocking decay, $e = {float(decays['rocking_restitution']):g}$")
    axes.legend(loc="upper right")


def _matched(upper: Axes, lower: Axes, decays: xr.Dataset) -> None:
    reference = decays.sel(damping_model=REFERENCE)
    at = 1 + np.flatnonzero(passes_zero(reference["displacement"].values))
    end = at[min(SHOWN_HALF_CYCLES, at.size) - 1]
    shown = decays.isel(tau=slice(0, int(end) + 1))
    for model in (REFERENCE, "CDR"):
        decay = shown.sel(damping_model=model)
        label = label_of(decays, model)
        upper.plot(shown["tau"], decay["displacement"], label=label, **line_of(model))
        lower.plot(shown["tau"], decay["velocity"], label=label, **line_of(model))
    for axes in (upper, lower):
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    lower.set(ylabel=r"$\dot u/(p\,u_\mathrm{ins})$ [-]", xlabel=TAU)
    upper.set(ylabel=DISPLACEMENT, title="(b) coefficient of restitution and matched CDR")
    upper.legend(loc="upper right", ncols=2)
    _jump(lower, shown, int(at[0]))


def _jump(axes: Axes, shown: xr.Dataset, impact: int) -> None:
    """Enlarge the velocity around the first impact, where CR's jumps and CDR's does not."""
    tau = shown["tau"].values
    centre = float(tau[impact])
    near = np.abs(tau - centre) <= 0.25
    low, high = float(shown["velocity"].min()), float(shown["velocity"].max())
    axes.set_ylim(low - 1.1 * (high - low) / 2, high + 0.1 * (high - low))
    axes.set_yticks([tick for tick in axes.get_yticks() if low <= tick <= high])
    inset = axes.inset_axes((0.38, 0.11, 0.55, 0.26))
    for model in (REFERENCE, "CDR"):
        velocity = shown["velocity"].sel(damping_model=model).values
        inset.plot(tau[near], velocity[near], **line_of(model))
    inset.spines[:].set_visible(True)
    inset.yaxis.tick_right()
    inset.set_xlim(centre - 0.25, centre + 0.25)
    axes.indicate_inset_zoom(inset, edgecolor=GREY)
