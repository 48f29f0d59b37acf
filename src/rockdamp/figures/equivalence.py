"""Equivalent damping ratios: Figs 5 to 7, the error of the best match, and the amplitude."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.style import (
    COLUMN,
    GREY,
    LOOK,
    MARKERS,
    PALE,
    RESTITUTION,
    handles,
    legend,
    look,
    panels,
    tints,
)

DAMPING_RATIO = r"damping ratio $\xi$ [-]"


def restitution_axis(axes: Axes, e: xr.DataArray) -> None:
    """Give a panel the axis of e, with a tick at its first and last value."""
    first = float(e[0])
    last = float(e[-1])
    # Tenths, at least 0.04 from both ends.
    inner = np.arange(np.ceil(10 * first + 0.4), 10 * last - 0.4) / 10
    axes.set_xticks([first, *inner, last])
    axes.set(xlim=(first, last), xlabel="restitution $e$ [-]")


def title_model(axes: Axes, model: str) -> None:
    """Give a panel the name of a model in its colour."""
    axes.set_title(model, color=LOOK[model]["color"], fontweight="bold")


def model_panels(rows: int, height: float, e: xr.DataArray) -> tuple[Figure, Any]:
    """Return a figure with a column for each damper of the paper."""
    figure, grid = panels(rows, 3, height, sharex=True, sharey=True)
    for axes, model in zip(grid[0], PAPER_MODELS, strict=True):
        title_model(axes, model)
    for axes in grid[-1]:
        restitution_axis(axes, e)
    for axes in grid[:, 0]:
        axes.set_ylabel(DAMPING_RATIO)
    return figure, grid


def parameter_lines(
    axes: Axes,
    curves: xr.DataArray,
    model: str,
    parameter: str,
    *,
    marks: bool = False,
    **look: Any,
) -> None:
    """Draw a model's curves over e, one for each value of a parameter, light to dark."""
    for index, colour in enumerate(tints(LOOK[model]["color"], curves.sizes[parameter])):
        curve = curves.sel(damping_model=model).isel({parameter: index})
        marker: dict[str, Any] = {}
        if marks:
            marker = {"marker": MARKERS[index % len(MARKERS)], "markevery": 4}
        axes.plot(curve["restitution"], curve, color=colour, **marker, **look)


def parameter_keys(values: xr.DataArray, *, marks: bool = False) -> list[Line2D]:
    """Return an entry of a legend, in grey, for every value of a parameter."""
    keys = []
    greys = tints("#808080", values.size)
    for index, (grey, value) in enumerate(zip(greys, values.values, strict=True)):
        marker = MARKERS[index % len(MARKERS)] if marks else ""
        keys.append(Line2D([], [], color=grey, marker=marker, label=f"{value:g}"))
    return keys


def fig5(amplitude: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for the paper's release amplitudes, with the closed form."""
    releases = amplitude["release_amplitude"].values
    # The releases of the paper's Fig. 5.
    nearest = [int(abs(releases - value).argmin()) for value in (0.3, 0.5, 0.9)]
    study = amplitude.isel(release_amplitude=np.unique(nearest))
    figure, grid = model_panels(1, 76.0, study["restitution"])
    dashes: dict[str, Any] = {"linewidth": 0.6, "linestyle": (0, (4.0, 2.0))}
    for axes, model in zip(grid[0], PAPER_MODELS, strict=True):
        parameter_lines(axes, study["damping_ratio"], model, "release_amplitude", marks=True)
        closed_form = study["damping_ratio_energy"]
        parameter_lines(axes, closed_form, model, "release_amplitude", **dashes)
    grid[0, 0].set_ylim(0)
    keys = parameter_keys(study["release_amplitude"], marks=True)
    keys.append(Line2D([], [], color=GREY, label="closed form", **dashes))
    legend(figure, keys, title=r"release amplitude $u_0/u_\mathrm{ins}$ [-]")
    return figure


def fig6(slenderness: xr.Dataset, overburden: xr.Dataset, cracked_stiffness: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for every slenderness, overburden and a1, one row each."""
    a1 = "yield_displacement_ratio"
    b1 = cracked_stiffness["strength_ratio"]
    same_strength = cracked_stiffness.isel({a1: np.isclose(b1, b1[0])})
    rows = (
        (slenderness, "slenderness", "$h/t$ [-]"),
        (overburden, "overburden_ratio", "$O/W$ [-]"),
        (same_strength, a1, f"$a_1$ [-]\nat $b_1 = {float(b1[0]):g}$"),
    )
    figure, grid = model_panels(3, 132.0, slenderness["restitution"])
    for row, (study, parameter, title) in zip(grid, rows, strict=True):
        for axes, model in zip(row, PAPER_MODELS, strict=True):
            parameter_lines(axes, study["damping_ratio"], model, parameter, linewidth=0.9)
        legend(row[-1], parameter_keys(study[parameter]), title=title)
    grid[0, 0].set_ylim(0)
    return figure


def fig6_error(amplitude: xr.Dataset) -> Figure:
    """Draw the root of Err at the best match against e, and where CDR is best in the paper."""
    # The paper's release and, from section 6, its range of e in which CDR has the smallest error.
    cdr_range = (0.80, 0.91)
    study = amplitude.sel(release_amplitude=0.5, method="nearest")
    figure, ((axes,),) = panels(1, 1, 80.0, COLUMN)
    for model in PAPER_MODELS:
        root = study["error"].sel(damping_model=model) ** 0.5
        axes.plot(study["restitution"], root, label=model, **look(model, markevery=4))
    band: dict[str, Any] = {"color": PALE, "alpha": 0.6, "linewidth": 0, "zorder": 0}
    axes.axvspan(*cdr_range, label="CDR lowest in the paper", **band)
    restitution_axis(axes, study["restitution"])
    release = float(study["release_amplitude"])
    length = float(study["response_length"])
    axes.set_title(f"$u_0/u_\\mathrm{{ins}} = {release:g}$, response length $\\tau = {length:g}$")
    axes.set(ylim=(0, None), ylabel=r"$\sqrt{\mathrm{Err}}$, Eq. (17) [-]")
    legend(figure, handles(axes), columns=2)
    return figure


def fig7(equivalence: xr.Dataset) -> Figure:
    """Draw the polynomials xi(e) of each model and a1, the matched points and Eq. (15)."""
    a1 = "yield_displacement_ratio"
    e = equivalence["restitution"]
    fits = equivalence["damping_ratio_fit"]
    figure, grid = panels(1, 4, 92.0, sharex=True, sharey=True, width_ratios=[1.5, 1, 1, 1])
    all_models, *columns = grid[0]
    paper_fit = fits.sel({a1: 0.04}, method="nearest")  # the paper's reference curve
    points: dict[str, Any] = {"linestyle": "none", "markersize": 2.6}
    for axes, model in zip(columns, PAPER_MODELS, strict=True):
        low = fits.min(a1).sel(damping_model=model)
        high = fits.max(a1).sel(damping_model=model)
        all_models.fill_between(e, low, high, color=LOOK[model]["color"], alpha=0.18, linewidth=0)
        fit = paper_fit.sel(damping_model=model)
        all_models.plot(e, fit, label=model, **look(model, marker=""))
        parameter_lines(axes, fits, model, a1, linewidth=0.7)
        parameter_lines(axes, equivalence["damping_ratio"], model, a1, marks=True, **points)
        title_model(axes, model)
    dashes = (0, (8.0, 1.4, 2.6, 1.4))
    line: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": dashes}
    for axes in grid[0]:
        label = "Eq. (15)" if axes is all_models else ""
        axes.plot(e, equivalence["giannini_masiani"], label=label, **line)
        restitution_axis(axes, e)
    all_models.set_title(f"at $a_1 = {float(paper_fit[a1]):g}$; bands: all $a_1$")
    all_models.set(ylim=(0, None), ylabel=DAMPING_RATIO)
    keys = [*handles(all_models), *parameter_keys(equivalence[a1], marks=True)]
    legend(figure, keys, columns=6, title="left: dampers; right: $a_1$ [-]")
    return figure


def fig_amplitude(amplitude: xr.Dataset) -> Figure:
    """Draw the damping ratio divided by that of ECD, which does not depend on the amplitude."""
    ratio = amplitude["damping_ratio_peaks"].sel(restitution=RESTITUTION, method="nearest")
    figure, ((axes,),) = panels(1, 1, 80.0, COLUMN)
    for model in amplitude["damping_model"].values.tolist():
        relative = ratio.sel(damping_model=model) / ratio.sel(damping_model="ECD")
        axes.plot(amplitude["release_amplitude"], relative, label=model, **look(model))
    axes.set(xlim=(0, 1), xlabel=r"release amplitude $u_0/u_\mathrm{ins}$ [-]")
    axes.set_ylabel(r"$\xi\,/\,\xi_\mathrm{ECD}$ [-]")
    axes.set_title(f"$e = {float(ratio['restitution']):g}$")
    legend(figure, handles(axes))
    return figure
