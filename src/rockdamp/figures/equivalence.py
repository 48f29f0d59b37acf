"""Figs 5 to 7: the damping ratio that is equivalent to a coefficient of restitution, and the error of the match."""

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

from rockdamp.figures.style import (
    DAMPING_RATIO,
    DOUBLE_COLUMN,
    GREY,
    PALE,
    RESTITUTION,
    SINGLE_COLUMN,
    columns_of,
    few_ticks,
    grid_of,
    is_beyond_paper,
    line_of,
    nearest,
    new_figure,
    numbers,
    present,
    scaling,
    shades,
    style_of,
    styled,
    texts,
    title_of,
)

PAPER_AMPLITUDES = (0.9, 0.5, 0.3)  # u0/u_ins, Fig. 5
REFERENCE_AMPLITUDE = 0.5  # of all that follows Fig. 5
REFERENCE_CRACKED_STIFFNESS = 0.04  # a1
PAPER_RANGE = (0.80, 0.91)  # of e where CDR's error is the lowest, Section 6
MARKS = 7  # markers on a curve, about
MARKERS = "osD^vpX*hd"
FIXED = "damping_ratio_fixed_seconds"
SHARED = {
    "plateau_ratio": "$b_1",
    "ultimate_ratio": "$a_3",
    "release_amplitude": r"$u_0/u_\mathrm{ins}",
}
CLOSED_FORM: dict[str, Any] = {"linewidth": 0.6, "linestyle": (0, (4.0, 2.0))}
EQUATION_15: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0, (8.0, 1.4, 2.6, 1.4))}


def models_of(dataset: xr.Dataset) -> list[str]:
    """Return the viscous models of a dataset, in its order."""
    return [str(model) for model in dataset["damping_model"].values]


def _title(axes: Axes, model: str, lines: int = 1) -> None:
    axes.set_title(title_of(model, lines), color=style_of(model).colour, fontweight="bold")


def _every(e: xr.DataArray) -> int:
    return max(1, e.size // MARKS)


def _note(axes: Axes, text: str) -> None:
    axes.text(0.04, 0.04, text, transform=axes.transAxes, fontsize=7, ha="left", va="bottom")


def _window(dataset: xr.Dataset) -> str:
    return f"response length $\\tau = {float(dataset['window']):g}$"


def _shared(dataset: xr.Dataset) -> list[str]:
    """What a dataset says of the curve and release that all its values share."""
    scalars = {name: symbol for name, symbol in SHARED.items() if name in dataset and dataset[name].ndim == 0}
    return [f"{symbol} = {float(dataset[name]):g}$" for name, symbol in scalars.items()]


@styled
def fig5(amplitude: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for the paper's release amplitudes, with the closed form.

    Parameters
    ----------
    amplitude : xarray.Dataset
        ``damping_ratio`` and ``damping_ratio_energy`` (damping_model, release_amplitude, restitution).
    """
    models = models_of(amplitude)
    columns = columns_of(len(models), 4)
    figure = new_figure(DOUBLE_COLUMN, 78.0 * -(-len(models) // columns))
    panels = grid_of(figure, len(models), columns)
    values = numbers(amplitude, "release_amplitude")
    chosen = present(values, PAPER_AMPLITUDES)
    for axes, model in zip(panels, models, strict=True):
        for index, colour, marker in zip(chosen, shades(model, len(chosen)), MARKERS[: len(chosen)], strict=True):
            curve = amplitude.sel(damping_model=model).isel(release_amplitude=index)
            e, label = curve["restitution"], f"$u_0/u_\\mathrm{{ins}} = {values[index]:g}$"
            axes.plot(e, curve["damping_ratio"], color=colour, marker=marker, markevery=_every(e), label=label)
            axes.plot(e, curve["damping_ratio_energy"], color=colour, **CLOSED_FORM)
        axes.plot([], [], color=GREY, label="closed form", **CLOSED_FORM)
        _title(axes, model)
        axes.legend(loc="upper right")
    for axes in panels[-columns:]:
        axes.set_xlabel(RESTITUTION)
    for axes in panels[::columns]:
        axes.set_ylabel(DAMPING_RATIO)
    few_ticks(panels[0], 3)
    panels[0].set_ylim(0, 1.05 * _largest(amplitude.isel(release_amplitude=chosen)))
    _note(panels[-1], _window(amplitude))
    return figure


def _largest(dataset: xr.Dataset) -> float:
    return float(max(dataset["damping_ratio"].max(), dataset["damping_ratio_energy"].max()))


@styled
def fig6(slenderness: xr.Dataset, overburden: xr.Dataset, cracked_stiffness: xr.Dataset) -> Figure:
    """Draw xi(e) of each model for every slenderness, overburden and a1, one row each.

    Parameters
    ----------
    slenderness, overburden : xarray.Dataset
        ``damping_ratio`` and ``damping_ratio_fixed_seconds`` (damping_model, parameter, restitution).
    cracked_stiffness : xarray.Dataset
        ``damping_ratio`` and ``plateau_ratio``; only the values of a1 with the first one's b1 are drawn.
    """
    b1 = cracked_stiffness["plateau_ratio"].values
    cracked_stiffness = cracked_stiffness.isel(cracked_stiffness_ratio=np.isclose(b1, b1[0]))
    studies = (
        (slenderness, "slenderness", "$h/t$ [-]"),
        (overburden, "overburden_ratio", "$O/W$ [-]"),
        (cracked_stiffness, "cracked_stiffness_ratio", f"$a_1$ [-]\nat $b_1 = {b1[0]:g}$"),
    )
    models = models_of(slenderness)
    figure = new_figure(DOUBLE_COLUMN, 178.0)
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
        _legend(panels[-1], models, title, numbers(dataset, parameter), strips is not None)
    for axes, model in zip(grid[0], models, strict=True):
        _title(axes, model, lines=3 if len(models) > 4 else 1)
    for strip in grid[[0, 2], 0]:
        strip.set_ylabel(r"$10^3\,\Delta\xi$ [-]")
    for axes in grid[-1, :: 1 + (len(models) > 5)]:  # of many panels every second one, so that labels stay apart
        axes.set_xlabel("restitution $e$ [-]")
    few_ticks(grid[0, 0], 3)
    figure.align_ylabels(grid[:, 0])
    _note(grid[-1, -1], _window(slenderness).replace("length ", "length\n"))
    return figure


def _study(axes: Axes, match: xr.Dataset, parameter: str, model: str) -> None:
    colours = shades(model, match.sizes[parameter])
    for index, colour in enumerate(colours):
        curve = match.isel({parameter: index})
        marks = _marks(index, len(colours), match["restitution"].size)
        axes.plot(match["restitution"], curve["damping_ratio"], color=colour, linewidth=0.9, **marks)
        if FIXED in match:
            axes.plot(match["restitution"], curve[FIXED], color=colour, **CLOSED_FORM)


def _change(axes: Axes, match: xr.Dataset, parameter: str, model: str) -> None:
    """What the same length in seconds, instead of in tau, changes of the damping ratio, in thousandths."""
    change = 1000 * (match[FIXED] - match["damping_ratio"])
    for index, colour in enumerate(shades(model, match.sizes[parameter])):
        axes.plot(match["restitution"], change.isel({parameter: index}), color=colour, **CLOSED_FORM)
    axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)


def _marks(index: int, count: int, points: int) -> dict[str, Any]:
    """Markers at different e for each curve, since curves coincide or differ in shade alone."""
    apart = 2 if points >= 4 * count else 1
    return {"marker": MARKERS[index % len(MARKERS)], "markevery": (apart * index, apart * count)}


def _legend(axes: Axes, models: Sequence[str], title: str, values: Sequence[float], fixed: bool) -> None:
    """One entry for each value, with its shade for every model."""
    ramps = [shades(model, len(values)) for model in models]
    handles: list[Any] = []
    for index in range(len(values)):
        entry = [Line2D([], [], color=ramp[index], linewidth=2.5) for ramp in ramps]
        entry.append(Line2D([], [], color=GREY, linestyle="none", marker=MARKERS[index % len(MARKERS)]))
        handles.append(tuple(entry))
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


@styled
def fig6_error(amplitude: xr.Dataset) -> Figure:
    """Draw the root of Err at the best match against e, with the range in which the paper finds CDR's the lowest.

    Parameters
    ----------
    amplitude : xarray.Dataset
        ``error`` and ``rms_error`` (damping_model, release_amplitude, restitution), ``window`` and ``steps``.
    """
    values = numbers(amplitude, "release_amplitude")
    index = nearest(values, REFERENCE_AMPLITUDE)
    study = amplitude.isel(release_amplitude=index)
    e, root, models = study["restitution"], study["error"] ** 0.5, models_of(study)
    figure = new_figure(SINGLE_COLUMN, 82.0)
    axes = figure.subplots()
    for model in models:
        marker = style_of(model).marker
        axes.plot(
            e,
            root.sel(damping_model=model),
            marker=marker,
            markevery=_every(e),
            label=title_of(model),
            **line_of(model),
        )
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
    _lowest(axes, root.sel(damping_model=[model for model in models if not is_beyond_paper(model)]), 0.8 * top)
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(r"$\sqrt{\mathrm{Err}}$, Eq. (17) [-]")
    # Err is a sum over the response: its root over the number of samples does not depend on the step.
    per_sample = float((study["rms_error"] / root).mean())
    beside = axes.secondary_yaxis("right", functions=scaling(1000 * per_sample))
    beside.set_ylabel(r"$10^3\,\sqrt{\mathrm{Err}/k}$ [-]")
    figure.legend(loc="outside upper center", ncols=len(models) if len(models) <= 4 else 2)
    few_ticks(axes, 6)
    length = f"$\\tau = {float(study['window']):g}$ in $k = {int(study['steps'])}$ steps"
    axes.set_title(
        f"$u_0/u_\\mathrm{{ins}} = {values[index]:g}$, {length},\na length that was inferred from this figure"
    )
    return figure


def _lowest(axes: Axes, root: xr.DataArray, height: float) -> None:
    """A row of markers that names the paper's model with the lowest error at each e."""
    best = root["damping_model"].values[root.argmin("damping_model").values]
    for model in map(str, root["damping_model"].values):
        e = root["restitution"].values[best == model]
        style = style_of(model)
        axes.plot(e, np.full(e.size, height), linestyle="none", marker=style.marker, color=style.colour)
    names = ", ".join(map(str, root["damping_model"].values))
    axes.text(
        float(root["restitution"][0]), height * 1.02, f" lowest of {names} here:", fontsize=7, ha="left", va="bottom"
    )


@styled
def fig7(equivalence: xr.Dataset) -> Figure:
    """Draw the second-order polynomials xi(e) of each model and a1, the matched points and Eq. (15).

    Parameters
    ----------
    equivalence : xarray.Dataset
        ``damping_ratio`` and ``damping_ratio_fit`` (damping_model, cracked_stiffness_ratio, restitution) and
        ``giannini_masiani`` (restitution).
    """
    models, e = models_of(equivalence), equivalence["restitution"]
    values = numbers(equivalence, "cracked_stiffness_ratio")
    names = texts(values)
    figure = new_figure(DOUBLE_COLUMN, 120.0)
    columns = -(-len(models) // 2)
    grid = figure.add_gridspec(2, 1 + columns, width_ratios=[1.75] + [1.0] * columns)
    together = figure.add_subplot(grid[:, 0])
    _ranges(together, equivalence)
    for position, model in enumerate(models):
        axes = figure.add_subplot(grid[position // columns, 1 + position % columns], sharex=together, sharey=together)
        keys = []
        for index, (colour, marker) in enumerate(zip(shades(model, len(values)), cycle(MARKERS), strict=False)):
            fit = equivalence.sel(damping_model=model).isel(cracked_stiffness_ratio=index)
            line: dict[str, Any] = {"color": colour, "linewidth": 0.8, "markersize": 2.6, "markeredgewidth": 0.3}
            axes.plot(e, fit["damping_ratio_fit"], **line)
            points = slice(None, None, _every(e))
            axes.plot(e[points], fit["damping_ratio"][points], marker, **line)
            keys.append(Line2D([], [], marker=marker, label=names[index], **line))
        axes.plot(e, equivalence["giannini_masiani"], **EQUATION_15)
        _title(axes, model, lines=1 + (columns > 2))
        if model == models[-1]:
            _note(axes, "lines: polynomials\nmarkers: matched")
        axes.legend(handles=keys, title="$a_1$ [-]", loc="upper right", ncols=2, handlelength=1.2, columnspacing=0.8)
        below = position + columns >= len(models)
        axes.tick_params(labelleft=position % columns == 0, labelbottom=below)
        if below:
            axes.set_xlabel("restitution $e$ [-]")
    few_ticks(together, 3)  # shared by the narrow panels
    together.set_ylim(0, 1.05 * float(equivalence["damping_ratio"].max()))
    return figure


def _ranges(axes: Axes, equivalence: xr.Dataset) -> None:
    """All models together: the polynomial at the reference a1, and the band that the other a1 fill."""
    e, values = equivalence["restitution"], numbers(equivalence, "cracked_stiffness_ratio")
    index = nearest(values, REFERENCE_CRACKED_STIFFNESS)
    fits = equivalence["damping_ratio_fit"]
    for model in models_of(equivalence):
        band = fits.sel(damping_model=model)
        low, high = band.min("cracked_stiffness_ratio"), band.max("cracked_stiffness_ratio")
        axes.fill_between(e, low, high, color=style_of(model).colour, alpha=0.18, linewidth=0)
        axes.plot(e, band.isel(cracked_stiffness_ratio=index), label=title_of(model), **line_of(model))
    axes.plot(e, equivalence["giannini_masiani"], label="Eq. (15)", **EQUATION_15)
    axes.set_title(f"all models at $a_1 = {values[index]:g}$, bands: ${min(values):g} \\leq a_1 \\leq {max(values):g}$")
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(DAMPING_RATIO)
    axes.legend(loc="upper right")
    fit = float(np.floor(1e4 * equivalence["r_squared"].min()) / 1e4)
    _note(axes, "\n".join([*_shared(equivalence), _window(equivalence), f"$R^2 \\geq {fit:.4f}$"]))
