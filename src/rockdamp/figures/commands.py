"""Pictures that the commands draw: a decay, a response, fragility, and fits to measured tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.special import ndtr

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.decays import model_label
from rockdamp.figures.measured import (
    DISPLACEMENT_MM,
    MEASURED,
    TIME,
    over_u_ins,
    record_name,
    record_title,
)
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    TAU,
    error_bars,
    handles,
    legend,
    log_ticks,
    look,
    panels,
    series,
    zero_line,
)
from rockdamp.mechanics.damping import DAMPERS
from rockdamp.mechanics.free_motion import rigid_period
from rockdamp.text import number
from rockdamp.units import intensity_unit

PARAMETER_SYMBOLS = {
    "yield_displacement_ratio": "$a_1$",
    "strength_ratio": "$b_1$",
    "restitution": "$e$",
}

PEAK: dict[str, Any] = {"marker": "o", "markersize": 4}
COLLAPSE: dict[str, Any] = {"marker": "x", "markersize": 6}

# --- histories ---------------------------------------------------------------------------------


def decay_figure(decay: xr.Dataset) -> Figure:
    """Draw a free decay under each model, against seconds if it has ``elapsed``, else tau."""
    figure, ((axes,),) = panels(1, 1, 82.0)
    has_seconds = "elapsed" in decay.coords
    time = decay["elapsed" if has_seconds else "tau"]
    models = decay["damping_model"].values.tolist()
    for model in models:
        history = decay.sel(damping_model=model)
        line = look(history["damper_family"].item(), marker="", label=model_label(decay, model))
        axes.plot(time, history["displacement"], **line)
    zero_line(axes)
    axes.set(xlabel=TIME if has_seconds else TAU, ylabel=f"displacement {DISPLACEMENT}")
    legend(figure, handles(axes), columns=min(3, len(models)))
    return figure


def response_figure(response: xr.Dataset) -> Figure:
    """Draw the ground's motion and the response under each model, up to a collapse."""
    figure, ((ground,), (axes,)) = panels(2, 1, 116.0, sharex=True, height_ratios=[1.0, 2.2])
    motion = response["ground_acceleration"]
    ground.plot(response["elapsed"], motion, color="black", linewidth=0.8)
    models = response["damping_model"].values.tolist()
    for model in models:
        draw_response(axes, response.sel(damping_model=model), model_label(response, model))
    for panel in (ground, axes):
        zero_line(panel)
    ground.set_ylabel("acceleration of\nthe ground [m/s$^2$]")
    axes.set(xlabel=TIME, ylabel="displacement $u$ [mm]")
    over_u_ins(axes, response)
    figure.align_ylabels()
    figure.suptitle(record_title(response), fontsize=8)
    keys = [*handles(axes), *outcome_keys(response)]
    legend(figure, keys, columns=1 if len(models) <= 3 else 2)
    return figure


def outcome_keys(response: xr.Dataset) -> list[Line2D]:
    """Return an entry of a legend, in grey, for the dot of a peak and the cross of a collapse."""
    collapsed = response["collapsed"].values.astype(bool)
    keys = []
    if not collapsed.all():
        keys.append(Line2D([], [], **PEAK, color=GREY, linestyle="none", label="peak"))
    if collapsed.any():
        keys.append(Line2D([], [], **COLLAPSE, color=GREY, linestyle="none", label="collapse"))
    return keys


def draw_response(axes: Axes, history: xr.Dataset, label: str) -> None:
    """Draw the displacement under one model, with a dot at its peak or a cross at its collapse."""
    family = history["damper_family"].item()
    displacement = 1000 * history["control_displacement"].values
    elapsed = history["elapsed"]
    if history["collapsed"]:
        outcome = f"collapse at {float(history['end_elapsed']):.2f} s"
        sample = int(np.flatnonzero(np.isfinite(displacement))[-1])
        marker = look(family, clip_on=False, **COLLAPSE)
    else:
        outcome = f"peak {1000 * float(history['peak_displacement']):.3g} mm"
        sample = int(np.argmax(np.abs(displacement)))
        marker = look(family, **PEAK)
    axes.plot(elapsed[sample], displacement[sample], **marker)
    text = f"{DAMPERS[family].title} ({label}): {outcome}"
    axes.plot(elapsed, displacement, **look(family, marker="", label=text))


# --- fragility ---------------------------------------------------------------------------------


def fragility_figure(answer: xr.Dataset, unit: str | None = None) -> Figure:
    """Draw the fragility under each model, with its stripes and the given intensities.

    Intensities are in `unit`; by default a PGA is in g and a PGV in m/s.
    """
    measure = str(answer.attrs["intensity_measure"]).lower()  # pgv or pga
    unit, size = intensity_unit(measure, unit)
    names = (measure, f"stripe_{measure}", f"median_{measure}")
    answer = answer.assign({name: answer[name] / size for name in names})
    figure, ((axes,),) = panels(1, 1, 72.0)
    stripes = answer[f"stripe_{measure}"].values
    models = answer["damping_model"].values.tolist()
    for model in models:
        draw_fragility(axes, answer.sel(damping_model=model), measure, unit)
    reference = answer.isel(damping_model=0)
    label = f"{models[0]} at the given intensity, 95 % interval"
    probability = reference["collapse_probability"].values
    interval = reference["collapse_probability_interval"]
    bars: dict[str, Any] = {"fmt": "_", "color": GREY, "label": label}
    error_bars(axes, reference[measure], probability, interval, **bars)
    log_ticks(axes.xaxis)
    axes.set(xlim=stripes[[0, -1]], ylim=(-0.03, 1.03), xlabel=f"{measure.upper()} [{unit}]")
    runs = "histories" if len(models) == 1 else "records"  # CR alone: a stop
    outcome = "with collapse" if len(models) == 1 else "that cause collapse"
    axes.set_ylabel(f"share of {int(answer['records'])} {runs} {outcome}")
    legend(figure, handles(axes), columns=3)
    return figure


def draw_fragility(axes: Axes, curve: xr.Dataset, measure: str, unit: str) -> None:
    """Draw the shares of one model at the stripes, and its lognormal curve."""
    model = curve["damping_model"].item()
    family = curve["damper_family"].item()
    stripes = curve[f"stripe_{measure}"].values
    share = curve["stripe_collapses"] / int(curve["records"])
    # CR's markers are larger and open, so that a damper's markers on them are seen.
    size: dict[str, Any] = {"markersize": 3}
    if model == "CR":
        size = {"markersize": 5, "markerfacecolor": "none"}
    axes.plot(stripes, share, **look(family, linestyle="none", clip_on=False, **size))
    median = float(curve[f"median_{measure}"])
    dispersion = float(curve["dispersion"])
    label = f"{model}: no lognormal curve"
    if np.isfinite(median):
        label = f"{model}: median {median:.3g} {unit}, dispersion {dispersion:.2f}"
    levels = np.geomspace(stripes[0], stripes[-1], 200)
    probability = ndtr(np.log(levels / median) / dispersion)
    axes.plot(levels, probability, **look(family, marker="", label=label))


# --- fits --------------------------------------------------------------------------------------


def calibration_figure(calibration: xr.Dataset) -> Figure:
    """Draw the measured and the fitted response of the first run, and their difference."""
    figure, ((history,), (residual,)) = panels(2, 1, 108.0, sharex=True, height_ratios=[2.6, 1.0])
    first_run = (calibration["sample_run"] == 1).values
    draw_fit(history, residual, calibration.isel(sample=first_run), "elapsed")
    estimates = [write_estimate(calibration, name) for name in PARAMETER_SYMBOLS]
    history.set_title(",  ".join(estimates))
    figure.suptitle(record_title(calibration), fontsize=8)
    figure.align_ylabels()
    legend(figure, handles(history))
    return figure


def free_rocking_figure(fitted: xr.Dataset) -> Figure:
    """Draw the first release with its fit, and half periods and e of all releases."""
    figure, ((history, periods), (residual, impacts)) = panels(2, 2, 150.0)
    first_release = (fitted["sample_release"] == 1).values
    draw_fit(history, residual, fitted.isel(sample=first_release), "sample_elapsed")
    first_half_cycles = (fitted["half_cycle_release"] == 1).values
    peaks = fitted.isel(half_cycle=first_half_cycles)
    height = 1000 * peaks["peak_displacement"]
    history.plot(peaks["peak_elapsed"], height, **series(0, linestyle="none", label="peaks"))
    title = "(a) free rocking"
    releases = fitted.sizes["release"]
    if releases > 1:
        title += f", the first of {releases} releases"
    history.set_title(title)
    history.set_xlabel(TIME)
    draw_half_periods(periods, fitted)
    draw_impacts(impacts, fitted)
    figure.suptitle(record_title(fitted), fontsize=8)
    figure.align_ylabels()
    legend(figure, [*handles(history), *handles(periods, impacts)], columns=5)
    return figure


def draw_fit(history: Axes, residual: Axes, fitted: xr.Dataset, time: str) -> None:
    """Draw a measured and a fitted history, and below it their difference."""
    record = 1000 * fitted["measured"]
    fit = 1000 * fitted["control_displacement"]
    model = fitted.attrs.get("damping_model", "CR")
    history.plot(fitted[time], record, label=record_name(fitted), **MEASURED)
    history.plot(fitted[time], fit, **look("CR", marker="", label=f"fitted, {model}"))
    history.set_ylabel(DISPLACEMENT_MM)
    residual.plot(fitted[time], record - fit, color=GREY, linewidth=0.8)
    residual.set(ylabel="residual [mm]", xlabel=TIME)
    for axes in (history, residual):
        axes.margins(x=0.02)
        zero_line(axes)


def draw_half_periods(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw half periods against the amplitude: measured, of the fitted curve and rigid."""
    u_ins = float(fitted["instability_displacement"])
    amplitude = abs(fitted["peak_displacement"].values) / u_ins
    order = np.argsort(amplitude)
    ascending = amplitude[order]
    # `rigid_period` is dimensionless, p T.
    rigid = rigid_period(ascending) / 2 / float(fitted["frequency_parameter"])
    axes.plot(amplitude, fitted["half_period"], **series(0, linestyle="none"))
    axes.plot(ascending, fitted["half_period_fitted"][order], **look("CR", marker=""))
    axes.plot(ascending, rigid, color=GREY, linestyle="dotted", label="rigid wall")
    axes.set(xlabel=f"peak, {DISPLACEMENT}", ylabel="half period [s]")
    axes.set(xlim=(0, None), ylim=(0, None))
    a1 = write_estimate(fitted, "yield_displacement_ratio")
    b1 = write_estimate(fitted, "strength_ratio")
    axes.set_title(f"(b) {a1}, {b1}")


def draw_impacts(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw e of each impact, the fitted e and that of Eq. (7), and that expected with dampers."""
    is_rocking = (fitted["impact_rocking"] == 1).values
    rocking = fitted.isel(impact=is_rocking).sortby("impact_amplitude")
    amplitude = rocking["impact_amplitude"].values
    e = rocking["impact_restitution"].values
    points = series(0, linestyle="none", label="impacts")
    error_bars(axes, amplitude, e, rocking["impact_restitution_interval"], **points)
    low, high = fitted["interval"].sel(parameter="restitution").values
    axes.axhspan(low, high, color=PALE, linewidth=0, label="fitted $e$, 90 % interval", zorder=0)
    rigid = float(fitted["restitution_rigid"])
    axes.axhline(rigid, color=GREY, linestyle="dashed", label="$e$ of Eq. (7)")
    for model in PAPER_MODELS:
        expected = rocking["expected_restitution"].sel(damping_model=model)
        axes.plot(amplitude, expected, **look(model, marker="", label=model))
    log_ticks(axes.xaxis)
    axes.margins(x=0.04)
    axes.set(xlabel=f"peak before the impact, {DISPLACEMENT}", ylabel="$e$ [-]")
    g_low, g_high = (number(bound, 2) for bound in fitted["loss_exponent_interval"].values)
    g = number(fitted["loss_exponent"], 2)
    e_words = write_estimate(fitted, "restitution")
    axes.set_title(f"(c) {e_words},\n$g$ = {g} (90 %: {g_low} to {g_high})")


def write_estimate(fitted: xr.Dataset, name: str) -> str:
    """Write an estimate and its standard error, unless this is below the fourth decimal."""
    parameter = fitted.sel(parameter=name)
    estimate = float(parameter["estimate"])
    error = float(parameter["standard_error"])
    if round(error, 4) == 0:
        return f"{PARAMETER_SYMBOLS[name]} = {estimate:.4f}"
    decimals = 3 if error >= 0.01 else 4
    return f"{PARAMETER_SYMBOLS[name]} = {estimate:.{decimals}f} ± {error:.{decimals}f}"
