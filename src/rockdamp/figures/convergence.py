"""How the error of each scheme falls with the step."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterMathtext

from rockdamp.figures.style import COLUMN, GREY, handles, legend, log_ticks, look, panels


def fig_convergence(convergence: xr.Dataset) -> Figure:
    """Draw the error against the step for each scheme, excitation and damping model, and lines of slope 1 and 2."""
    figure, grid = panels(2, 2, 108.0, COLUMN, sharex=True, sharey=True)
    step = convergence["step"].values
    for row, scheme, words in zip(grid, ("newmark", "paper"), ("Newmark", "as printed"), strict=True):
        for axes, excitation in zip(row, ("free", "forced"), strict=True):
            errors = convergence["solver_error"].sel(scheme=scheme, excitation=excitation)
            for model in map(str, errors["damping_model"].values):
                axes.plot(step, errors.sel(damping_model=model), label=model, **look(model))
            for slope, line in ((1, "dashed"), (2, "dotted")):
                guide = 1.6 * float(errors.sel(step=step.max()).max()) * (step / step.max()) ** slope
                axes.plot(step, guide, color=GREY, linewidth=0.8, linestyle=line, label=f"slope {slope}")
            axes.set_title(f"{words}, {excitation}")
        row[0].set_ylabel(r"error of $u/u_\mathrm{ins}$ [-]")
    for axes in grid[-1]:
        axes.set_xlabel(r"step $p\,\Delta t$ [-]")
    log_ticks(grid[0, 0].xaxis, [0.001, 0.005, 0.02])
    log_ticks(grid[0, 0].yaxis, 10.0 ** np.arange(-12, 1))
    grid[0, 0].yaxis.set_major_formatter(LogFormatterMathtext())
    legend(figure, handles(grid[0, 0]), columns=4)
    return figure
