"""Equivalent damping ratios: Figs 5 to 7, and the error of the best match."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from rockdamp.arrays import Array
from rockdamp.figures.style import (
    DAMPING_RATIO,
    GREY,
    PALE,
    REFERENCE_A1,
    REFERENCE_AMPLITUDE,
    RESTITUTION,
    SINGLE_COLUMN,
    dampers,
    line_of,
    marks_of,
    nearest,
    new_figure,
    paper_models,
    present,
    scaling,
    shades,
    style_of,
    styled,
    texts,
)

PAPER_AMPLITUDES = (0.9, 0.5, 0.3)  # u0/u_ins, Fig. 5
MARKS = 7  # markers on a curve, about
MARKERS = "osD^vpX*hd"
FIXED = "damping_ratio_fixed_seconds"
CLOSED_FORM: dict[str, Any] = {"linewidth": 0.6, "linestyle": (0, (4.0, 2.0))}


def title_panel(axes: Axes, model: str) -> None:
    """Put the model's name over its panel, in its colour."""
    axes.set_title(model, color=style_of(model).colour, fontweight="bold")


def every(e: xr.DataArray) -> int:
    """Return at which interval of points a curve has a marker."""
    return max(1, e.size // MARKS)


def head(figure: Figure, *texts: str) -> None:
    """Write over all panels what they share."""
    figure.suptitle(", ".join(texts), fontsize=8)


def response_length_text(dataset: xr.Dataset) -> str:
    """Write over which length of the response the ratios are matched."""
    return f"matched over the response length $\\tau = {float(dataset['response_length']):g}$"


@styled
def fig5(amplitude: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for the paper's release amplitudes, with the closed form."""
    amplitude = paper_models(amplitude)
    models = dampers(amplitude)
    figure = new_figure(78.0)
    panels = figure.subplots(1, len(models), sharex=True, sharey=True, squeeze=False)[0]
    values = amplitude["release_amplitude"].values.tolist()
    chosen = present(values, PAPER_AMPLITUDES)
    for axes, model in zip(panels, models, strict=True):
        for index, colour, marker in zip(chosen, shades(model, len(chosen)), MARKERS[: len(chosen)], strict=True):
            curve = amplitude.sel(damping_model=model).isel(release_amplitude=index)
            e, label = curve["restitution"], f"$u_0/u_\\mathrm{{ins}} = {values[index]:g}$"
            axes.plot(e, curve["damping_ratio"], color=colour, marker=marker, markevery=every(e), label=label)
            axes.plot(e, curve["damping_ratio_energy"], color=colour, **CLOSED_FORM)
        axes.plot([], [], color=GREY, label="closed form", **CLOSED_FORM)
        title_panel(axes, model)
        axes.legend(loc="upper right")
        axes.set_xlabel(RESTITUTION)
    panels[0].locator_params("x", nbins=3, steps=[1, 2, 5, 10])
    drawn = amplitude[["damping_ratio", "damping_ratio_energy"]].isel(release_amplitude=chosen)
    panels[0].set(ylabel=DAMPING_RATIO, ylim=(0, 1.05 * float(drawn.to_array().max())))
    head(figure, response_length_text(amplitude))
    return figure


def with_one_plateau(cracked_stiffness: xr.Dataset) -> xr.Dataset:
    """Keep the a1 whose curves have the first one's b1."""
    b1 = cracked_stiffness["strength_ratio"].values
    return cracked_stiffness.isel(yield_displacement_ratio=np.isclose(b1, b1[0]))


@styled
def fig6(slenderness: xr.Dataset, overburden: xr.Dataset, cracked_stiffness: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for every slenderness, overburden and a1, one row each."""
    cracked_stiffness = with_one_plateau(cracked_stiffness)
    b1 = float(cracked_stiffness["strength_ratio"][0])
    studies = (
        (paper_models(slenderness), "slenderness", "$h/t$ [-]"),
        (paper_models(overburden), "overburden_ratio", "$O/W$ [-]"),
        (paper_models(cracked_stiffness), "yield_displacement_ratio", f"$a_1$ [-]\nat $b_1 = {b1:g}$"),
    )
    models = dampers(studies[0][0])
    figure = new_figure(178.0)
    # A low strip above the first two rows: what a fixed length in seconds changes is too small for the panels.
    ratios = [0.36, 1.0, 0.36, 1.0, 1.0]
    grid = figure.subplots(
        5, len(models), sharex=True, sharey="row", squeeze=False, gridspec_kw={"height_ratios": ratios}
    )
    for panels, strips, (dataset, parameter, title) in zip(
        grid[[1, 3, 4]], (grid[0], grid[2], None), studies, strict=True
    ):
        for column, model in enumerate(models):
            _study(panels[column], dataset.sel(damping_model=model), parameter, model)
            if strips is not None:
                _change(strips[column], dataset.sel(damping_model=model), parameter, model)
        panels[0].set_ylabel(DAMPING_RATIO)
        panels[0].set_ylim(0, 1.05 * max(float(study["damping_ratio"].max()) for study, _, _ in studies))
        _legend(panels[-1], models, title, dataset[parameter].values.tolist(), strips is not None)
    for axes, model in zip(grid[0], models, strict=True):
        title_panel(axes, model)
    for strip in grid[[0, 2], 0]:
        strip.set_ylabel(r"$10^3\,\Delta\xi$ [-]")
    for axes in grid[-1]:
        axes.set_xlabel(RESTITUTION)
    grid[0, 0].locator_params("x", nbins=3, steps=[1, 2, 5, 10])
    figure.align_ylabels(grid[:, 0])
    head(figure, response_length_text(slenderness))
    return figure


def _study(axes: Axes, match: xr.Dataset, parameter: str, model: str) -> None:
    colours = shades(model, match.sizes[parameter])
    for index, colour in enumerate(colours):
        curve = match.isel({parameter: index})
        axes.plot(match["restitution"], curve["damping_ratio"], color=colour, linewidth=0.9)
        if FIXED in match:
            axes.plot(match["restitution"], curve[FIXED], color=colour, **CLOSED_FORM)


def _change(axes: Axes, match: xr.Dataset, parameter: str, model: str) -> None:
    """Draw how much the same length in seconds, instead of in tau, changes the damping ratio, in thousandths."""
    change = 1000 * (match[FIXED] - match["damping_ratio"])
    for index, colour in enumerate(shades(model, match.sizes[parameter])):
        axes.plot(match["restitution"], change.isel({parameter: index}), color=colour, **CLOSED_FORM)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)


def _legend(axes: Axes, models: Sequence[str], title: str, values: Sequence[float], fixed: bool) -> None:
    """Give one entry for each value, with its shade for every model."""
    ramps = [shades(model, len(values)) for model in models]
    handles: list[Any] = [
        tuple(Line2D([], [], color=ramp[index], linewidth=2.5) for ramp in ramps) for index in range(len(values))
    ]
    labels = texts(values)
    if fixed:
        handles.append(Line2D([], [], color=GREY, **CLOSED_FORM))
        labels.append("same length\nin seconds,\n$\\Delta\\xi$ above")
    axes.legend(
        handles,
        labels,
        title=title,
        loc="center left",
        bbox_to_anchor=(1.02, 0.5),
        alignment="left",
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0)},
    )


# --- the error of the best match --------------------------------------------------------------------------------------


PAPER_RANGE = (0.80, 0.91)  # of e where CDR's error is the lowest, Section 6


@styled
def fig6_error(amplitude: xr.Dataset) -> Figure:
    """Draw the root of Err at the best match against e, with the range in which the paper finds CDR's the lowest."""
    study = paper_models(amplitude).sel(release_amplitude=REFERENCE_AMPLITUDE, method="nearest")
    e, root, models = study["restitution"], study["error"] ** 0.5, dampers(study)
    figure = new_figure(82.0, SINGLE_COLUMN)
    axes = figure.subplots()
    for model in models:
        look = {"marker": style_of(model).marker, **line_of(model)}
        axes.plot(e, root.sel(damping_model=model), markevery=every(e), label=model, **look)
    top = 1.35 * float(root.max())
    axes.set_ylim(0, top)
    axes.axvspan(*PAPER_RANGE, color="#EDEDED", linewidth=0, zorder=0)
    low, high = PAPER_RANGE
    axes.text(
        (low + high) / 2,
        0.99 * top,
        f"paper: CDR lowest,\n${low:.2f} \\leq e \\leq {high:.2f}$",
        ha="center",
        va="top",
        fontsize=7,
    )
    _lowest(axes, root, 0.8 * top)
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(r"$\sqrt{\mathrm{Err}}$, Eq. (17) [-]")
    # Err is a sum over the response: its root over the number of samples does not depend on the step.
    per_sample = float((study["rms_error"] / root).mean())
    beside = axes.secondary_yaxis("right", functions=scaling(1000 * per_sample))
    beside.set_ylabel(r"$10^3\,\sqrt{\mathrm{Err}/k}$ [-]")
    figure.legend(loc="outside upper center", ncols=len(models))
    axes.locator_params("x", nbins=6, steps=[1, 2, 5, 10])
    release = f"$u_0/u_\\mathrm{{ins}} = {float(study['release_amplitude']):g}$"
    length = f"$\\tau = {float(study['response_length']):g}$ in $k = {int(study['steps'])}$ steps"
    axes.set_title(f"{release}, {length},\na length that was inferred from this figure")
    return figure


def with_lowest(error: xr.DataArray) -> Array:
    """Return the model of the lowest error at each e."""
    models: Array = error["damping_model"].values
    return models[error.argmin("damping_model").values]


def _lowest(axes: Axes, root: xr.DataArray, height: float) -> None:
    """Draw a row of markers that names the paper's model with the lowest error at each e."""
    best = with_lowest(root)
    for model in map(str, root["damping_model"].values):
        e = root["restitution"].values[best == model]
        axes.plot(e, np.full(e.size, height), **marks_of(model))
    names = ", ".join(map(str, root["damping_model"].values))
    axes.text(
        float(root["restitution"][0]), height * 1.02, f" lowest of {names} here:", fontsize=7, ha="left", va="bottom"
    )


# --- polynomials ------------------------------------------------------------------------------------------------------


SHARED = {
    "strength_ratio": "$b_1",
    "ultimate_displacement_ratio": "$a_3",
    "release_amplitude": r"$u_0/u_\mathrm{ins}",
}
EQUATION_15: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0, (8.0, 1.4, 2.6, 1.4))}


@styled
def fig7(equivalence: xr.Dataset) -> Figure:
    """Draw the second-order polynomials xi(e) of each model and a1, the matched points and Eq. (15)."""
    equivalence = paper_models(equivalence)
    models, e = dampers(equivalence), equivalence["restitution"]
    values = equivalence["yield_displacement_ratio"].values.tolist()
    names = texts(values)
    figure = new_figure(92.0)
    grid = figure.add_gridspec(1, 1 + len(models), width_ratios=[1.75] + [1.0] * len(models))
    together = figure.add_subplot(grid[0])
    _ranges(together, equivalence)
    for position, model in enumerate(models):
        axes = figure.add_subplot(grid[1 + position], sharex=together, sharey=together)
        keys = []
        for index, (colour, marker) in enumerate(zip(shades(model, len(values)), cycle(MARKERS), strict=False)):
            fit = equivalence.sel(damping_model=model).isel(yield_displacement_ratio=index)
            line: dict[str, Any] = {"color": colour, "linewidth": 0.8, "markersize": 2.6, "markeredgewidth": 0.3}
            axes.plot(e, fit["damping_ratio_fit"], **line)
            points = slice(None, None, every(e))
            axes.plot(e[points], fit["damping_ratio"][points], marker, **line)
            keys.append(Line2D([], [], marker=marker, label=names[index], **line))
        axes.plot(e, equivalence["giannini_masiani"], **EQUATION_15)
        title_panel(axes, model)
        axes.legend(handles=keys, title="$a_1$ [-]", loc="upper right", ncols=2, handlelength=1.2, columnspacing=0.8)
        axes.tick_params(labelleft=position == 0)
        axes.set_xlabel("restitution $e$ [-]")
    together.locator_params("x", nbins=3, steps=[1, 2, 5, 10])  # shared by the narrow panels
    together.set_ylim(0, 1.05 * float(equivalence["damping_ratio"].max()))
    least = f"$R^2 \\geq {_rounded_down(equivalence['r_squared'])}$"
    lines = f"lines: polynomials, {least}; markers: {response_length_text(equivalence)}"
    head(figure, lines, *_shared(equivalence))
    return figure


def _rounded_down(r_squared: xr.DataArray) -> str:
    """Write the least R², rounded down: neither figure nor caption claims more than the least fit."""
    return f"{np.floor(1e4 * float(r_squared.min())) / 1e4:.4f}"


def _shared(dataset: xr.Dataset) -> list[str]:
    """Write what all values of a dataset share of the curve and release."""
    scalars = {name: symbol for name, symbol in SHARED.items() if name in dataset and dataset[name].ndim == 0}
    return [f"{symbol} = {float(dataset[name]):g}$" for name, symbol in scalars.items()]


def _ranges(axes: Axes, equivalence: xr.Dataset) -> None:
    """Draw all models together: the polynomial at the reference a1, and the band that the other a1 fill."""
    e, values = equivalence["restitution"], equivalence["yield_displacement_ratio"].values.tolist()
    index = nearest(values, REFERENCE_A1)
    fits = equivalence["damping_ratio_fit"]
    for model in dampers(equivalence):
        band = fits.sel(damping_model=model)
        low, high = band.min("yield_displacement_ratio"), band.max("yield_displacement_ratio")
        axes.fill_between(e, low, high, color=style_of(model).colour, alpha=0.18, linewidth=0)
        axes.plot(e, band.isel(yield_displacement_ratio=index), label=model, **line_of(model))
    axes.plot(e, equivalence["giannini_masiani"], label="Eq. (15)", **EQUATION_15)
    axes.set_title(f"all models at $a_1 = {values[index]:g}$, bands: ${min(values):g} \\leq a_1 \\leq {max(values):g}$")
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(DAMPING_RATIO)
    axes.legend(loc="upper right")
