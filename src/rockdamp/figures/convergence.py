"""How the error of each scheme falls with the step."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from rockdamp.figures.style import GREY, line_of, new_figure, style_of, styled

SCHEMES = {"newmark": "explicit Newmark, located impacts", "paper": "linear acceleration, as printed"}

LEFT = 3.0  # room for the names of the slopes, as a factor on the smallest step


@styled
def fig_convergence(convergence: xr.Dataset) -> Figure:
    """Draw the error against the step for each scheme, excitation and damping model."""
    schemes, excitations = convergence["scheme"].values, convergence["excitation"].values
    figure = new_figure(135.0)
    grid = figure.subplots(len(schemes), len(excitations), sharex=True, sharey=True, squeeze=False)
    for row, scheme in zip(grid, schemes, strict=True):
        for axes, excitation in zip(row, excitations, strict=True):
            _panel(axes, convergence.sel(scheme=scheme, excitation=excitation))
            axes.set_title(f"{SCHEMES.get(str(scheme), scheme)}: {excitation}")
        row[0].set_ylabel(r"error of $u/u_\mathrm{ins}$ [-]")
    for axes in grid[-1]:
        axes.set_xlabel(r"step $p\,\Delta t$ [-]")
    low, high = float(convergence["solver_error"].min()), float(convergence["solver_error"].max())
    grid[0, 0].set_ylim(low / 3, high * 3)
    steps = convergence["step"].values
    grid[0, 0].set_xlim(steps.min() / LEFT, steps.max() * 1.3)
    return figure


def _panel(axes: Axes, errors: xr.Dataset) -> None:
    step = errors["step"].values
    for model in map(str, errors["damping_model"].values):
        curve = errors.sel(damping_model=model)
        label = f"{model}: {float(curve['convergence_order']):.2f} ({float(curve['finest_convergence_order']):.2f})"
        axes.plot(step, curve["solver_error"], marker=style_of(model).marker, label=label, **line_of(model))
    axes.set(xscale="log", yscale="log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    _slopes(axes, errors)
    axes.legend(title="order (finest steps)", loc="center left", bbox_to_anchor=(1.0, 0.5), alignment="left")


def _slopes(axes: Axes, errors: xr.Dataset) -> None:
    """Draw lines of slope 1 and 2 from the coarsest step's median error."""
    step = errors["step"].values
    for slope in (1, 2):
        start = float(errors["solver_error"].sel(step=step.max()).max()) * 1.6
        line = start * (step / step.max()) ** slope
        axes.plot(step, line, color=GREY, linewidth=0.6, zorder=0)
        left = np.argmin(step)
        axes.text(step[left] / 1.08, line[left], f"slope {slope}", fontsize=7, color=GREY, ha="right", va="center")
