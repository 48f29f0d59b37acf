"""Pictures that the commands draw: a decay, a response, fragility, and fits to measured tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import ndtr

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.decays import model_label
from rockdamp.figures.measured import (
    ACCELERATION,
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
)
from rockdamp.mechanics.free_motion import rigid_period
from rockdamp.text import number

SYMBOLS = {"yield_displacement_ratio": "$a_1$", "strength_ratio": "$b_1$", "restitution": "$e$"}


def decay_figure(decay: xr.Dataset) -> Figure:
    """Draw a free decay under each of its models, against seconds where it has ``elapsed``."""
    figure, ((axes,),) = panels(1, 1, 82.0)
    time = "elapsed" if "elapsed" in decay.coords else "tau"
    for model in map(str, decay["damping_model"].values):
        history = decay["displacement"].sel(damping_model=model)
        axes.plot(decay[time], history, **look(model, marker="", label=model_label(decay, model)))
    axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)
    axes.set(xlabel=TIME if time == "elapsed" else TAU, ylabel=DISPLACEMENT)
    legend(figure, handles(axes), columns=min(3, decay.sizes["damping_model"]))
    return figure


def response_figure(response: xr.Dataset) -> Figure:
    """Draw the ground's motion and the response under each model, up to a cross where the wall collapses."""
    figure, ((ground,), (axes,)) = panels(2, 1, 112.0, sharex=True, height_ratios=[1.0, 2.2])
    ground.plot(response["elapsed"], response["ground_acceleration"], color="black", linewidth=0.8)
    for model in map(str, response["damping_model"].values):
        run, label = response.sel(damping_model=model), model_label(response, model)
        displacement = 1000 * run["control_displacement"].values
        if run["collapsed"]:
            label += f", collapses at {float(run['end_elapsed']):.2f} s"
            last = int(np.flatnonzero(np.isfinite(displacement))[-1])
            cross = look(model, marker="x", markersize=6, clip_on=False)
            axes.plot(response["elapsed"][last], displacement[last], **cross)
        axes.plot(response["elapsed"], displacement, **look(model, marker="", label=label))
    for panel in (ground, axes):
        panel.axhline(0, color=PALE, linewidth=0.6, zorder=0)
    ground.set_ylabel(ACCELERATION)
    axes.set(xlabel=TIME, ylabel=DISPLACEMENT_MM)
    over_u_ins(axes, response)
    figure.align_ylabels()
    figure.suptitle(record_title(response), fontsize=8)
    legend(figure, handles(axes), columns=min(3, response.sizes["damping_model"]))
    return figure


def fragility_figure(answer: xr.Dataset) -> Figure:
    """Draw the fragility under each damping model, with its stripes and the share at the intensities asked for."""
    measure = str(answer.attrs["intensity_measure"]).lower()  # pgv or pga
    unit = "m s$^{-1}$" if measure == "pgv" else "m s$^{-2}$"
    figure, ((axes,),) = panels(1, 1, 72.0)
    stripes, records = answer[f"stripe_{measure}"].values, int(answer["records"])
    levels = np.geomspace(stripes[0], stripes[-1], 200)
    for model in map(str, answer["damping_model"].values):
        curve = answer.sel(damping_model=model)
        median, dispersion = float(curve[f"median_{measure}"]), float(curve["dispersion"])
        # CR's markers are larger and open, so that a damper's markers on them are seen.
        size: dict[str, Any] = (
            {"markersize": 5, "markerfacecolor": "none"} if model == "CR" else {"markersize": 3}
        )
        axes.plot(
            stripes,
            curve["stripe_collapses"] / records,
            **look(model, linestyle="none", clip_on=False, **size),
        )
        known = np.isfinite(median)
        label = (
            f"{model}: median {median:.3g}, dispersion {dispersion:.2f}"
            if known
            else f"{model}: no lognormal curve"
        )
        axes.plot(
            levels,
            ndtr(np.log(levels / median) / dispersion),
            **look(model, marker="", label=label),
        )
    cr = answer.isel(damping_model=0)
    point: dict[str, Any] = {
        "fmt": "_",
        "color": GREY,
        "label": f"{cr['damping_model'].item()} at the intensity asked for, 95 %",
    }
    error_bars(
        axes,
        cr[measure],
        cr["collapse_probability"].values,
        cr["collapse_probability_interval"],
        **point,
    )
    log_ticks(axes.xaxis)
    axes.set(xlim=stripes[[0, -1]], ylim=(-0.03, 1.03), xlabel=f"{measure.upper()} [{unit}]")
    runs = (
        "histories" if answer.sizes["damping_model"] == 1 else "records"
    )  # against a stop each acts both ways
    axes.set_ylabel(f"share of {records} {runs} that collapse")
    legend(figure, handles(axes), columns=3)
    return figure


def calibration_figure(calibration: xr.Dataset) -> Figure:
    """Draw the measured and the fitted response of the first run, and their difference."""
    figure, ((history,), (residual,)) = panels(2, 1, 108.0, sharex=True, height_ratios=[2.6, 1.0])
    _fit(
        history,
        residual,
        calibration.isel(sample=(calibration["sample_run"] == 1).values),
        "elapsed",
    )
    history.set_title(",  ".join(_estimate(calibration, name) for name in SYMBOLS))
    figure.suptitle(record_title(calibration), fontsize=8)
    figure.align_ylabels()
    legend(figure, handles(history))
    return figure


def free_rocking_figure(fitted: xr.Dataset) -> Figure:
    """Draw the first release with its fit, and half periods and e of the impacts of all releases."""
    figure, ((history, periods), (residual, impacts)) = panels(2, 2, 150.0)
    _fit(
        history,
        residual,
        fitted.isel(sample=(fitted["sample_release"] == 1).values),
        "sample_elapsed",
    )
    peaks = fitted.isel(half_cycle=(fitted["half_cycle_release"] == 1).values)
    height = 1000 * peaks["peak_displacement"]
    history.plot(peaks["peak_elapsed"], height, **series(0, linestyle="none", label="peaks"))
    releases = fitted.sizes["release"]
    history.set_title(
        "(a) free rocking" + (f", the first of {releases} releases" if releases > 1 else "")
    )
    _half_periods(periods, fitted)
    _impacts(impacts, fitted)
    figure.suptitle(record_title(fitted), fontsize=8)
    figure.align_ylabels()
    legend(figure, [*handles(history), *handles(periods, impacts)], columns=5)
    return figure


def _fit(history: Axes, residual: Axes, fitted: xr.Dataset, time: str) -> None:
    """Draw a measured and a fitted history, and below it their difference."""
    measured, computed = (1000 * fitted[name] for name in ("measured", "control_displacement"))
    history.plot(fitted[time], measured, label=record_name(fitted), **MEASURED)
    history.plot(
        fitted[time],
        computed,
        **look("CR", marker="", label=f"fitted, {fitted.attrs.get('damping_model', 'CR')}"),
    )
    residual.plot(fitted[time], measured - computed, color=GREY, linewidth=0.8)
    history.set_ylabel(DISPLACEMENT_MM)
    residual.set(ylabel="residual [mm]", xlabel=TIME)
    for axes in (history, residual):
        axes.margins(x=0.02)
        axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)


def _half_periods(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw half periods against the amplitude: measured, of the fitted curve, and of the rigid wall."""
    amplitude = abs(fitted["peak_displacement"].values) / float(fitted["instability_displacement"])
    order = np.argsort(amplitude)
    rigid = rigid_period(amplitude[order]) / 2 / float(fitted["frequency_parameter"])
    axes.plot(amplitude, fitted["half_period"], **series(0, linestyle="none"))
    axes.plot(amplitude[order], fitted["half_period_fitted"][order], **look("CR", marker=""))
    axes.plot(amplitude[order], rigid, color=GREY, linestyle="dotted", label="rigid wall")
    axes.set(xlabel=DISPLACEMENT, ylabel="half period [s]", xlim=(0, None), ylim=(0, None))
    axes.set_title(
        f"(b) {_estimate(fitted, 'yield_displacement_ratio')}, {_estimate(fitted, 'strength_ratio')}"
    )


def _impacts(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw e of each impact with its interval, the mean, the analytical value, and what the dampers would show."""
    rocking = fitted.isel(impact=(fitted["impact_rocking"] == 1).values).sortby("impact_amplitude")
    amplitude, e = rocking["impact_amplitude"].values, rocking["impact_restitution"].values
    points = series(0, linestyle="none", label="impacts")
    error_bars(axes, amplitude, e, rocking["impact_restitution_interval"], **points)
    ends = fitted["interval"].sel(parameter="restitution").values
    axes.axhspan(*ends, color=PALE, linewidth=0, label="mean, 90 %", zorder=0)
    rigid = float(fitted["restitution_rigid"])
    axes.axhline(rigid, color=GREY, linestyle="dashed", label="$e$ of rigid bodies")
    for model in PAPER_MODELS:
        axes.plot(
            amplitude,
            rocking["expected_restitution"].sel(damping_model=model),
            **look(model, marker="", label=model),
        )
    log_ticks(axes.xaxis)
    axes.margins(x=0.04)
    axes.set(xlabel=f"peak before the impact, {DISPLACEMENT}", ylabel="$e$ [-]")
    g = " to ".join(number(bound, 2) for bound in fitted["loss_exponent_interval"].values)
    axes.set_title(f"(c) {_estimate(fitted, 'restitution')}, $g$ = {g}")


def _estimate(fitted: xr.Dataset, name: str) -> str:
    """Return an estimate and its standard error, to the error's second digit."""
    estimate, error = (
        float(fitted[value].sel(parameter=name)) for value in ("estimate", "standard_error")
    )
    decimals = int(np.clip(1 - np.floor(np.log10(error)), 0, 6)) if error > 0 else 3
    return f"{SYMBOLS[name]} = {estimate:.{decimals}f} ± {error:.{decimals}f}"
