"""How accurate the solver is, and how its error falls with the step."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator, ScalarFormatter

from rockdamp.figures.style import GREY, PALE, by_model, line_of, marks_of, new_figure, style_of, styled
from rockdamp.text import at_most, number, plain

TITLES = {"free": "(a) free decay", "forced": "(b) forced response"}
LEAST, LARGEST = 1e-6, 4e-3  # smaller uncertainties are drawn at the least: some are zero, and the axis is logarithmic
THOUSANDTH = 1e-3
FEATURES: dict[str, tuple[dict[str, Any], str]] = {
    "p": ({"color": "#1A1A1A", "linestyle": "solid", "marker": "o"}, "$p$, with the mass at $u = 0$"),
    "first impact": ({"color": "#0072B2", "linestyle": (0, (8.0, 1.6)), "marker": "s"}, "time of the first impact"),
    "peaks": ({"color": "#D55E00", "linestyle": "dashdot", "marker": "^"}, "peak that differs most"),
}
SLENDERNESS_TICKS = (4, 6, 10, 15, 20, 30, 40)


@styled
def fig_accuracy(accuracy: xr.Dataset) -> Figure:
    """Draw the solver's error against the step, and the uncertainty and the errors of published damping ratios."""
    figure = new_figure(140.0)
    (free, forced), (shares, exact) = figure.subplots(2, 2)
    forced.sharey(free)
    low, high = float(accuracy["median_solver_error"].min()), float(accuracy["largest_solver_error"].max())
    for axes, excitation in ((free, "free"), (forced, "forced")):
        _errors(axes, accuracy.sel(excitation=excitation))
        axes.set_title(TITLES[excitation])
    free.set_ylim(low / 100, high * 3)  # the legend stands below
    _shares(shares, accuracy)
    _sample(exact, accuracy)
    return figure


def _errors(axes: Axes, errors: xr.Dataset) -> None:
    """Draw the median error of each model as a line, and the largest as markers."""
    step = errors["step"].values
    for model in map(str, errors["damping_model"].values):
        curve = errors.sel(damping_model=model)
        label = f"{model}: {float(curve['convergence_order']):.2f}"
        axes.plot(step, curve["median_solver_error"], label=label, **line_of(model))
        axes.plot(step, curve["largest_solver_error"], markerfacecolor="none", **marks_of(model))
    for name in ("solver_step", "published_step"):
        axes.axvline(float(errors[name]), color=PALE, linewidth=0.6, zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(step.min() / 1.4, step.max() * 1.4)
    axes.set_xlabel(r"step $p\,\Delta t$ [-]")
    axes.set_ylabel(r"RMS error of $u/u_\mathrm{ins}$ [-]")
    axes.legend(title="median, with its order;\nmarkers: largest", loc="lower right", alignment="left")


def _shares(axes: Axes, accuracy: xr.Dataset) -> None:
    """Draw the share of the published damping ratios whose uncertainty is beyond a value."""
    axes.axvline(THOUSANDTH, color=GREY, linewidth=0.8, zorder=0)
    for model in map(str, accuracy["viscous_model"].values):
        certainty = accuracy.sel(viscous_model=model)
        bound = np.maximum(certainty["uncertainty_quantile"].values, LEAST)
        within = np.floor(1000 * float(certainty["share_within_thousandth"])) / 10  # rounded down: all is only all
        label = f"{model}: {within:g} %"
        axes.plot(bound, 1 - certainty["quantile"].values, label=label, **line_of(model))
    axes.set(xscale="log", xlim=(LEAST, LARGEST), ylim=(0, 1))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    axes.set_xlabel(r"uncertainty of $\xi$ over $\xi$ [-]")
    axes.set_ylabel(r"share of $\xi$ with a larger uncertainty")
    axes.set_title(f"(c) all {int(accuracy['published_count'])} published $\\xi$ of each model")
    axes.legend(title="within 0.1 %", loc="lower left", alignment="left")


def _sample(axes: Axes, accuracy: xr.Dataset) -> None:
    """Draw the true errors of the sample against their uncertainties; on the line both are equal."""
    axes.plot([LEAST, LARGEST], [LEAST, LARGEST], color=GREY, linewidth=0.8, zorder=0)
    for model in map(str, accuracy["viscous_model"].values):
        of_model = accuracy.sel(viscous_model=model)
        bound, error = (
            np.maximum(np.abs(of_model[name].values), LEAST) for name in ("sample_bound", "sample_difference")
        )
        axes.plot(bound, error, markerfacecolor="none", label=model, clip_on=False, **marks_of(model))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(LEAST, LARGEST)
    axes.set_ylim(LEAST, LARGEST)
    axes.set_xlabel(r"uncertainty of $\xi$ over $\xi$ [-]")
    axes.set_ylabel(r"error of $\xi$ over $\xi$ [-]")
    axes.set_title("(d) against exact minima, a sample")
    axes.legend(loc="upper left")


@styled
def fig_rigid(accuracy: xr.Dataset) -> Figure:
    """Draw how far rigid rocking at large rotations is from the slender limit, against slenderness."""
    releases, hinges = accuracy["rocking_release_amplitude"].values.tolist(), accuracy["hinge_ratio"].values.tolist()
    figure = new_figure(25.0 + 55.0 * len(releases))
    grid = figure.subplots(len(releases), len(hinges), sharex=True, sharey=True, squeeze=False)
    for row, x0 in zip(grid, releases, strict=True):
        for axes, r in zip(row, hinges, strict=True):
            _differences(axes, accuracy.sel(rocking_release_amplitude=x0, hinge_ratio=r))
            axes.set_title(f"$u_0/u_\\mathrm{{ins}} = {x0:g}$, $h_1/h = {r:g}$")
        row[0].set_ylabel("|difference| [%]")
    for axes in grid[-1]:
        axes.set_xlabel("slenderness $h/t$ [-]")
    handles = [Line2D([], [], label=meaning, **line) for line, meaning in FEATURES.values()]
    title = f"large rotations against the slender limit, $e = {float(accuracy['rocking_restitution']):g}$"
    figure.legend(handles=handles, title=title, loc="outside lower center", ncols=3)
    return figure


def _differences(axes: Axes, differences: xr.Dataset) -> None:
    slenderness = differences["slenderness"].values
    for tolerance in differences["tolerance"].values.tolist():
        axes.axhline(tolerance, color=GREY, linewidth=0.6, zorder=0)
        text, at = f"{100 * tolerance:g} %", (slenderness.max(), tolerance)
        axes.annotate(text, at, (0, 1), textcoords="offset points", ha="right", fontsize=7, color=GREY)
    for feature, (line, meaning) in FEATURES.items():
        values = np.abs(differences["rocking_difference"].sel(rocking_feature=feature).values)
        axes.plot(slenderness, values, label=meaning, **line)
    axes.set(xscale="log", yscale="log", xlim=(slenderness.min() / 1.05, slenderness.max() * 1.05))
    axes.xaxis.set_major_locator(FixedLocator([h for h in SLENDERNESS_TICKS if h <= slenderness.max()]))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))


def fig_accuracy_caption(accuracy: xr.Dataset) -> str:
    """Write the caption, HTML."""
    order, quantile = accuracy["convergence_order"], accuracy["quantile"].values
    largest = accuracy["uncertainty_quantile"].isel(quantile=int(np.argmax(quantile)))
    return f"""
    Against the exact, event-driven solution the solver has order {float(order.min()):.2f} to {float(order.max()):.2f}.
    At its step, {plain(accuracy["solver_step"])} in τ, u/u<sub>ins</sub> is off by
    {number(accuracy["largest_history_error"].max())} at most in the cases studied. The published ξ have uncertainties
    of at most {by_model(largest, at_most, "viscous_model")}.
    """


def fig_rigid_caption(accuracy: xr.Dataset) -> str:
    """Write the caption, HTML."""
    away = abs(accuracy["rocking_difference"]).max(["hinge_ratio", "rocking_release_amplitude"]).sortby("slenderness")
    squat = plain(away["slenderness"][0])
    differences = {str(name): at_most(away.sel(rocking_feature=name)[0]) for name in FEATURES}
    return f"""
    At h/t&nbsp;=&nbsp;{squat} and e&nbsp;=&nbsp;{plain(accuracy["rocking_restitution"])} two rigid bodies with large
    rotations differ from the slender limit by at most {differences["first impact"]} in the time of the first impact,
    {differences["peaks"]} in a peak and {differences["p"]} in the frequency parameter.
    """


# --- convergence ------------------------------------------------------------------------------------------------------


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


def fig_convergence_caption(convergence: xr.Dataset) -> str:
    """Write the caption, HTML."""

    def least_to_most(order: xr.DataArray) -> str:
        return f"{float(order.min()):.2f} to {float(order.max()):.2f}"

    newmark, printed = (
        convergence["convergence_order"].sel(scheme="newmark"),
        convergence["finest_convergence_order"].sel(scheme="paper"),
    )
    constant = printed["damping_model"] == "CDC"
    return f"""
    Over all steps explicit Newmark with located impacts has order {least_to_most(newmark)}. At the finest steps the
    scheme as printed has order {least_to_most(printed.where(constant))} for a constant coefficient, and
    {least_to_most(printed.where(~constant))} for the other models.
    """
