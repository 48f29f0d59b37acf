"""A free-rocking test: the decay with its peaks, half periods and e of each impact against the amplitude."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.single import TIME, record_title
from rockdamp.figures.style import DISPLACEMENT, GREY, PALE, line_of, new_figure, one_two_five, styled
from rockdamp.figures.test_series import measured_name
from rockdamp.figures.validation import MEASURED, MILLIMETRES
from rockdamp.text import number
from rockdamp.vocabulary import PAPER_MODELS, REFERENCE

MARKERS = ("o", "s", "^", "D", "v")
INK = "#0072B2"
HEIGHT = 150.0  # [mm]


@styled
def free_rocking_figure(fitted: xr.Dataset) -> Figure:
    """Draw the first release with its fit, and half periods and e of the impacts of all releases."""
    figure = new_figure(HEIGHT)
    rows = figure.add_gridspec(2, 1, height_ratios=[1.25, 1.0])
    above, below = rows[0].subgridspec(2, 1, height_ratios=[2.6, 1.0]), rows[1].subgridspec(1, 2)
    history, periods, impacts = (figure.add_subplot(cell) for cell in (above[0], below[0], below[1]))
    left = figure.add_subplot(above[1], sharex=history)
    history.tick_params(labelbottom=False)
    _decay(history, left, fitted)
    _half_periods(periods, fitted)
    _restitution(impacts, fitted)
    figure.suptitle(record_title(fitted), fontsize=8)
    figure.align_ylabels([history, left])
    return figure


def _decay(history: Axes, left: Axes, fitted: xr.Dataset) -> None:
    """Draw the first release: measured, fitted, its peaks; and what is left between the two."""
    of_release = fitted.isel(sample=(fitted["sample_release"] == 1).values)
    peaks = fitted.isel(half_cycle=(fitted["half_cycle_release"] == 1).values)
    elapsed = of_release["sample_elapsed"]
    measured, computed = (MILLIMETRES * of_release[name] for name in ("measured", "displacement"))
    history.plot(elapsed, measured, label=measured_name(fitted), **MEASURED)
    history.plot(elapsed, computed, label="fitted", **line_of(REFERENCE))
    at, height = peaks["peak_elapsed"].values, MILLIMETRES * peaks["peak_displacement"].values
    history.plot(at[1:], height[1:], "o", color=INK, markersize=3.5, label="peaks")
    history.plot(at[:1], height[:1], ">", color="black", markersize=6, label="release")
    left.plot(elapsed, measured - computed, color=GREY, linewidth=0.7)
    left.set(ylabel="residual [mm]", xlabel=TIME)
    count = fitted.sizes["release"]
    history.set(ylabel="$u$ [mm]", title="(a) free rocking" + (f", the first of {count} releases" if count > 1 else ""))
    history.legend(loc="upper right", ncols=4)
    for axes in (history, left):
        axes.margins(x=0.015)
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)


def _half_periods(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw half periods against the amplitude, with those of the fitted curve and of the rigid wall."""
    u_ins, p = float(fitted["instability_displacement"]), float(fitted["frequency_parameter"])
    amplitude = abs(fitted["peak_displacement"].values) / u_ins
    for release in fitted["release"].values:
        chosen = fitted["half_cycle_release"].values == release
        label = "measured" if release == 1 else None
        axes.plot(amplitude[chosen], fitted["half_period"].values[chosen], color=INK, **_marker(release), label=label)
    order = np.argsort(amplitude)
    axes.plot(amplitude[order], fitted["half_period_fitted"].values[order], label="fitted curve", **line_of(REFERENCE))
    rigid = 2 * np.arccosh(1 / (1 - amplitude[order])) / p
    axes.plot(amplitude[order], rigid, color=GREY, linestyle="dotted", label="rigid wall")
    axes.set_xlabel(DISPLACEMENT)
    axes.set_ylabel("half period [s]")
    a1, b1 = (_with_error(fitted, name) for name in ("yield_displacement_ratio", "strength_ratio"))
    axes.set_title(f"(b) $a_1$ = {a1}, $b_1$ = {b1}")
    axes.margins(x=0.03)
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(loc="lower right")


def _restitution(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw e of each impact with its interval, the mean, the analytical value, and what the dampers would show."""
    rocking = fitted.isel(impact=(fitted["impact_rocking"] == 1).values)
    amplitude, e = rocking["impact_amplitude"].values, rocking["impact_restitution"].values
    low, high = (rocking["impact_restitution_interval"].sel(bound=bound).values for bound in ("low", "high"))
    for release in fitted["release"].values:
        chosen = rocking["impact_release"].values == release
        label = "impact" if release == 1 else None
        errors = np.stack([e - low, high - e])[:, chosen]
        axes.errorbar(amplitude[chosen], e[chosen], errors, color=INK, elinewidth=0.8, label=label, **_marker(release))
    ends = fitted["interval"].sel(parameter="restitution").values
    axes.axhspan(*ends, color=PALE, alpha=0.45, linewidth=0, label="mean, 90 %", zorder=0)
    axes.axhline(float(fitted["restitution_analytical"]), color="black", linestyle="dotted", label="$e_{an}$")
    order = np.argsort(amplitude)
    for model in PAPER_MODELS:
        expected = rocking["expected_restitution"].sel(damping_model=model).values[order]
        axes.plot(amplitude[order], expected, linewidth=0.9, label=model, **line_of(model))
    axes.set_xscale("log")
    one_two_five(axes.xaxis)
    axes.margins(x=0.04)
    axes.set_xlabel(f"peak before the impact, {DISPLACEMENT}")
    axes.set_ylabel("$e$ [-]")
    gamma = " to ".join(number(bound, 2) for bound in fitted["amplitude_exponent_interval"].values)
    axes.set_title(f"(c) $e$ = {_with_error(fitted, 'restitution')}, $\\gamma$ = {gamma}")
    axes.legend(loc="best", ncols=2, fontsize=7)


def _marker(release: int) -> dict[str, Any]:
    return {"marker": MARKERS[(release - 1) % len(MARKERS)], "markersize": 3.5, "linestyle": "none"}


def _with_error(fitted: xr.Dataset, name: str) -> str:
    """Return an estimate and its standard error, to the error's second digit."""
    of_name = fitted.sel(parameter=name)
    error = float(of_name["standard_error"])
    decimals = int(np.clip(1 - np.floor(np.log10(error)), 0, 6)) if error > 0 else 3
    return f"{float(of_name['estimate']):.{decimals}f} ± {error:.{decimals}f}"
