"""Pictures of measured tests: a record and its fits, free rocking, and the studies of both."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.figures.single import TIME, record_title
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    line_of,
    new_figure,
    one_two_five,
    style_of,
    styled,
)
from rockdamp.figures.validation import MEASURED, MILLIMETRES, measured_name
from rockdamp.text import number

# --- records and least squares ----------------------------------------------------------------------------------------

PARAMETERS = {
    "yield_displacement_ratio": "$a_1 = {:.4f} \\pm {:.4f}$",
    "strength_ratio": "$b_1 = {:.4f} \\pm {:.4f}$",
    "restitution": "$e = {:.4f} \\pm {:.4f}$",
}


@styled
def calibration_figure(calibration: xr.Dataset) -> Figure:
    """Draw the measured response and the fitted one, and what is left between them."""
    figure = new_figure(105.0)
    axes, left = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [2.6, 1.0]})
    measured, fitted = (MILLIMETRES * calibration[name] for name in ("measured", "control_displacement"))
    axes.plot(calibration["elapsed"], measured, label=measured_name(calibration), **MEASURED)
    axes.plot(calibration["elapsed"], fitted, label="fitted, CR", **line_of(REFERENCE))
    values = [calibration[name].sel(parameter=list(PARAMETERS)).values for name in ("estimate", "standard_error")]
    estimates = ",  ".join(text.format(*of_name) for text, *of_name in zip(PARAMETERS.values(), *values, strict=True))
    axes.set(ylabel="$u$ [mm]", title=estimates)
    axes.legend(loc="upper right")
    left.plot(calibration["elapsed"], measured - fitted, color=GREY, linewidth=0.8)
    left.set(ylabel="residual [mm]", xlabel=TIME)
    for each in (axes, left):
        each.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    figure.align_ylabels([axes, left])
    figure.suptitle(record_title(calibration), fontsize=8)
    return figure


# --- free rocking -----------------------------------------------------------------------------------------------------

INK = "#0072B2"
MARKERS = ("o", "s", "^", "D", "v")
FREE_ROCKING_HEIGHT = 150.0  # [mm]


@styled
def free_rocking_figure(fitted: xr.Dataset) -> Figure:
    """Draw the first release with its fit, and half periods and e of the impacts of all releases."""
    figure = new_figure(FREE_ROCKING_HEIGHT)
    rows = figure.add_gridspec(2, 1, height_ratios=[1.25, 1.0])
    above, below = rows[0].subgridspec(2, 1, height_ratios=[2.6, 1.0]), rows[1].subgridspec(1, 2)
    history, periods, impacts = (figure.add_subplot(cell) for cell in (above[0], below[0], below[1]))
    left = figure.add_subplot(above[1], sharex=history)
    history.tick_params(labelbottom=False)
    _decay(history, left, fitted)
    _half_periods(periods, fitted)
    _impacts(impacts, fitted)
    figure.suptitle(record_title(fitted), fontsize=8)
    figure.align_ylabels([history, left])
    return figure


def _decay(history: Axes, left: Axes, fitted: xr.Dataset) -> None:
    """Draw the first release: measured, fitted, its peaks; and what is left between the two."""
    of_release = fitted.isel(sample=(fitted["sample_release"] == 1).values)
    peaks = fitted.isel(half_cycle=(fitted["half_cycle_release"] == 1).values)
    elapsed = of_release["sample_elapsed"]
    measured, computed = (MILLIMETRES * of_release[name] for name in ("measured", "control_displacement"))
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


def _impacts(axes: Axes, fitted: xr.Dataset) -> None:
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
    axes.axhline(float(fitted["restitution_rigid"]), color="black", linestyle="dotted", label="$e_{an}$")
    order = np.argsort(amplitude)
    for model in PAPER_MODELS:
        expected = rocking["expected_restitution"].sel(damping_model=model).values[order]
        axes.plot(amplitude[order], expected, linewidth=0.9, label=model, **line_of(model))
    axes.set_xscale("log")
    one_two_five(axes.xaxis)
    axes.margins(x=0.04)
    axes.set_xlabel(f"peak before the impact, {DISPLACEMENT}")
    axes.set_ylabel("$e$ [-]")
    g = " to ".join(number(bound, 2) for bound in fitted["loss_exponent_interval"].values)
    axes.set_title(f"(c) $e$ = {_with_error(fitted, 'restitution')}, $g$ = {g}")
    axes.legend(loc="best", ncols=2, fontsize=7)


def _marker(release: int) -> dict[str, Any]:
    return {"marker": MARKERS[(release - 1) % len(MARKERS)], "markersize": 3.5, "linestyle": "none"}


def _with_error(fitted: xr.Dataset, name: str) -> str:
    """Return an estimate and its standard error, to the error's second digit."""
    of_name = fitted.sel(parameter=name)
    error = float(of_name["standard_error"])
    decimals = int(np.clip(1 - np.floor(np.log10(error)), 0, 6)) if error > 0 else 3
    return f"{float(of_name['estimate']):.{decimals}f} ± {error:.{decimals}f}"


# --- trials of blocks -------------------------------------------------------------------------------------------------

EXPONENTS = {"SDR": -0.5, REFERENCE: 0.0, "CDC": 0.5}  # of the energy left, of a rigid block to first order in the loss
POINTS: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": "black", "markersize": 3.5, "elinewidth": 0.9}


@styled
def fig_measured_rocking(measured: xr.Dataset) -> Figure:
    """Draw what measurement says: exponent of the amplitude, loss at each impact, and e over Housner's."""
    figure = new_figure(80.0)
    exponent, by_impact, restitution = figure.subplots(1, 3, width_ratios=[1.0, 1.2, 1.1])
    _exponent(exponent, measured)
    _by_impact(by_impact, measured)
    _over_housner(restitution, measured)
    figure.legend(*by_impact.get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def _bars(values: xr.DataArray, interval: xr.DataArray) -> Any:
    """Return the lengths of error bars below and above values."""
    lower, upper = (interval.sel(bound=bound) for bound in ("lower", "upper"))
    return np.array([values - lower, upper - values])


def _by_impact(axes: Axes, measured: xr.Dataset) -> None:
    impact, loss = measured["impact"], measured["loss_by_impact"]
    for model in (REFERENCE, *PAPER_MODELS):
        line = measured["loss_by_impact_of_model"].sel(damping_model=model)
        axes.plot(impact, line, label="CR, ECD" if model == REFERENCE else model, **line_of(model))
    bars = _bars(loss, measured["loss_by_impact_interval"])
    axes.errorbar(impact.values, loss.values, bars, label="measured, 90 %", zorder=3, **POINTS)
    axes.set_ylim(0.0, None)
    axes.set_xlim(0.4, float(impact.max()) + 0.6)
    axes.set_xlabel("impact [-]")
    axes.set_ylabel("loss over the trial's mean [-]")


def _exponent(axes: Axes, measured: xr.Dataset) -> None:
    place = np.arange(measured.sizes["impacts_used"], dtype=float)
    for model, at in EXPONENTS.items():
        axes.axvline(at, **line_of(model))
    exponent = measured["amplitude_exponent"]
    axes.errorbar(exponent.values, place, xerr=_bars(exponent, measured["amplitude_exponent_interval"]), **POINTS)
    axes.set_yticks(place, [f"{int(count)}" for count in measured["impacts_used"]])
    axes.set_ylim(place[-1] + 0.6, -0.6)
    axes.set_xlim(-0.75, 0.75)
    axes.set_xticks(list(EXPONENTS.values()))
    axes.set_xlabel(r"$\gamma$: loss $\propto$ energy$^\gamma$ [-]")
    axes.set_ylabel("impacts used of each trial [-]")
    above = axes.secondary_xaxis("top")
    above.set_xticks(list(EXPONENTS.values()), ["SDR", "CR", "CDC"])
    above.tick_params(length=0)
    for label, model in zip(above.get_xticklabels(), EXPONENTS, strict=True):
        label.set_color(style_of(model).colour)


def _over_housner(axes: Axes, measured: xr.Dataset) -> None:
    slenderness, ratio = measured["geometry"], measured["restitution_over_housner"]
    low, high = (measured["trial_over_housner_interval"].sel(bound=bound) for bound in ("lower", "upper"))
    axes.fill_between(slenderness, low, high, color=PALE, alpha=0.5, linewidth=0)
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.errorbar(
        slenderness.values, ratio.values, _bars(ratio, measured["restitution_over_housner_interval"]), **POINTS
    )
    axes.set_xlim(float(slenderness.min()) - 0.5, float(slenderness.max()) + 0.5)
    axes.set_xlabel("$H/B$ of the block [-]")
    axes.set_ylabel("$e$ over Housner's [-]")
