"""How the damping ratio depends on the amplitude, with which exponent it does least, and the closed form's error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rockdamp.figures.style import (
    GREY,
    PALE,
    REFERENCE_RESTITUTION,
    dampers,
    marks_of,
    nearest,
    new_figure,
    one_two_five,
    ramp,
    style_of,
    styled,
    texts,
)
from rockdamp.mechanics.damping import Damping
from rockdamp.text import at_most, by_name, percent, plain, span
from rockdamp.vocabulary import PAPER_MODELS

BEST = "POWER"  # as the dataset names the general exponent at its best n
NAMES = {BEST: "best $n$"}
REFERENCE = {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85, "ultimate_displacement_ratio": 1.0}
SHARE = r"release amplitude $u_0/u_3$ [-]"
VARIANTS = {"none": "$a_3 = 1$", "steeper": "steeper", "translated": "translated"}
VARIANT_LINES: dict[str, Any] = {"none": "solid", "steeper": (0, (4.0, 1.6)), "translated": (0, (1.0, 1.2))}
MIDDLE: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0, (4.0, 2.0))}
PERCENT = 100.0


def name_of(model: str) -> str:
    """Return how a damper is called in these figures."""
    return NAMES.get(model, model)


def reference_case(dataset: xr.Dataset) -> int:
    """Return the index of the case nearest to the paper's curve."""
    away = sum(abs(dataset[key].values - value) for key, value in REFERENCE.items())
    return int(np.argmin(away))


@styled
def fig_amplitude_dependence(amplitude_dependence: xr.Dataset) -> Figure:
    """Draw the damping ratio over that of ECD against the amplitude, and what spread each damper leaves."""
    at_e = amplitude_dependence.sel(restitution=REFERENCE_RESTITUTION, method="nearest")
    figure = new_figure(92.0)
    fan, bars = figure.subplots(1, 2, width_ratios=[1.75, 1.0])
    _fan(fan, at_e)
    _bars(bars, at_e)
    e_text = f"the same first peak as with $e = {float(at_e['restitution']):g}$"
    fan.set_title(f"{e_text}; lines: the paper's curve, bands: all {at_e.sizes['case']}")
    return figure


def _fan(axes: Axes, at_e: xr.Dataset) -> None:
    """Draw all damping ratios over that of ECD: a damper that needs no amplitude is a horizontal line."""
    share = at_e["release_share"].values
    relative = at_e["damping_ratio_peaks"] / at_e["damping_ratio_peaks"].sel(damping_model="ECD")
    reference = reference_case(at_e)
    ends = []
    for model in map(str, at_e["damping_model"].values):
        curves, style = relative.sel(damping_model=model), style_of(model)
        low, high = curves.min("case").values, curves.max("case").values
        axes.fill_between(share, low, high, color=style.colour, alpha=0.2, linewidth=0)
        width = 2.2 if model == "ECD" else 1.3
        axes.plot(share, curves.isel(case=reference), color=style.colour, linestyle=style.linestyle, linewidth=width)
        ends.append((float(curves.isel(case=reference)[-1]), model))
    bottom, top = float(relative.min()), float(relative.max())
    axes.set_ylim(max(0.0, bottom - 0.08), top + 0.08)
    # Names at the lines' ends, apart enough to be read; models whose lines coincide share a name's place.
    gap, last = 0.055 * (top - bottom + 0.16), -np.inf
    places: dict[float, list[str]] = {}
    for value, model in sorted(ends):
        places.setdefault(round(value, 2), []).append(model)
    for value, (model, *others) in places.items():
        last = max(value, last + gap)
        look: dict[str, Any] = {"color": style_of(model).colour, "fontweight": "bold", "fontsize": 8}
        text = ", ".join(map(name_of, (model, *others)))
        _beside(axes, text, (share[-1], last), (4, 0), va="center", annotation_clip=False, **look)
    axes.set(xlim=(0, share[-1]), xlabel=SHARE, ylabel=r"$\xi\,/\,\xi_\mathrm{ECD}$ [-]")


def _bars(axes: Axes, at_e: xr.Dataset) -> None:
    """Draw the spread over the amplitudes of each damper: a mark for each curve, a bar for the range."""
    spread = PERCENT * at_e["spread_peaks"]
    reference = reference_case(at_e)
    models = [str(model) for model in at_e["damping_model"].values]
    for row, model in enumerate(models):
        values, style = spread.sel(damping_model=model).values, style_of(model)
        axes.barh(row, values.max(), height=0.62, color=style.colour, alpha=0.25, linewidth=0)
        axes.plot(values, np.full(values.size, row), "|", color=style.colour, markersize=9)
        axes.plot(values[reference], row, markersize=5, **marks_of(model))
        text = "0" if values.max() < 0.05 else f"{values.min():.1f} to {values.max():.1f} %"
        _beside(axes, text, (values.max(), row), (5, 0), va="center", fontsize=7, color=style.colour)
        look: dict[str, Any] = {"color": style.colour, "fontweight": "bold", "ha": "right", "va": "center"}
        axes.text(-0.03, row, name_of(model), transform=axes.get_yaxis_transform(), **look)
    axes.set_yticks([])
    axes.invert_yaxis()
    axes.set_xlim(0, 1.5 * float(spread.max()))
    axes.set_xlabel(
        r"spread of $\xi$ over the amplitudes,"
        "\n"
        r"standard deviation of $\ln\,\xi$ [%]"
    )
    axes.set_title("a mark for each curve")


def _beside(axes: Axes, text: str, point: tuple[float, float], offset: tuple[float, float], **look: Any) -> None:
    """Write a text beside a point, by an offset in points."""
    axes.annotate(text, point, xytext=offset, textcoords="offset points", **look)


@styled
def fig_exponent(amplitude_dependence: xr.Dataset) -> Figure:
    """Draw the exponent with the least spread against a1 for several b1, and the spread that it leaves."""
    a1, b1 = (amplitude_dependence[f"map_{name}_ratio"].values.tolist() for name in ("yield_displacement", "strength"))
    figure = new_figure(88.0)
    left, right = figure.subplots(1, 2)
    _exponents(left, amplitude_dependence, a1, b1)
    _spreads(right, amplitude_dependence, a1)
    for axes in (left, right):
        axes.set(xlabel="$a_1$ [-]", xlim=(0, 1.02 * max(a1)))
        axes.locator_params("x", nbins=5, steps=[1, 2, 5, 10])
    return figure


def _exponents(axes: Axes, amplitude_dependence: xr.Dataset, a1: list[float], b1: list[float]) -> None:
    colours = ramp(style_of(BEST).colour, len(b1))
    handles = []
    for colour, value, text in zip(colours, b1, texts(b1), strict=True):
        for variant in map(str, amplitude_dependence["map_softening"].values):
            n = amplitude_dependence["map_best_exponent"].sel(map_softening=variant, map_strength_ratio=value)
            axes.plot(
                a1, n, color=colour, linestyle=VARIANT_LINES[variant], linewidth=1.2 if variant == "none" else 0.7
            )
        handles.append(Line2D([], [], color=colour, label=text))
    legend = axes.legend(handles=handles, title="$b_1$ [-]", loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.08))
    axes.add_artist(legend)
    variants = [
        Line2D([], [], color=GREY, linestyle=VARIANT_LINES[variant], label=VARIANTS[variant])
        for variant in map(str, amplitude_dependence["map_softening"].values)
    ]
    axes.legend(handles=variants, loc="upper left", bbox_to_anchor=(0.0, 0.9))
    best = amplitude_dependence["map_best_exponent"]
    low, high = float(best.min()), float(best.max())
    axes.set_ylim(min(0.98, low - 0.05), max(2.02, high + 0.05))
    for order, model in ((1.0, "CDR"), (2.0, "SDR")):
        axes.axhline(order, color=style_of(model).colour, linewidth=0.8, linestyle=style_of(model).linestyle)
        inside = -1 if order > 1.5 else 1  # of the two lines
        look: dict[str, Any] = {"color": style_of(model).colour, "fontsize": 7, "va": "top" if inside < 0 else "bottom"}
        text, xycoords = f"{model}, $n = {order:g}$", axes.get_yaxis_transform()
        _beside(axes, text, (0.02, order), (0, 3 * inside), xycoords=xycoords, ha="left", **look)
    axes.set_ylabel(r"exponent $n$ with the least spread [-]")


def _spreads(axes: Axes, amplitude_dependence: xr.Dataset, a1: list[float]) -> None:
    """Draw the spread that every damper leaves: a band over b1 and the variants, a line for the paper's b1."""
    spread = PERCENT * amplitude_dependence["map_spread"]
    plain = nearest(amplitude_dependence["map_strength_ratio"].values.tolist(), REFERENCE["strength_ratio"])
    exact = [model for model in dampers(amplitude_dependence) if model in Damping.exact_models()]
    for model in map(str, amplitude_dependence["damping_model"].values):
        if model in exact:
            continue  # zero has no place on a logarithmic axis
        spreads, style = spread.sel(damping_model=model), style_of(model)
        over = ("map_softening", "map_strength_ratio")
        axes.fill_between(a1, spreads.min(over), spreads.max(over), color=style.colour, alpha=0.18, linewidth=0)
        line = spreads.sel(map_softening="none").isel(map_strength_ratio=plain)
        axes.plot(a1, line, color=style.colour, linestyle=style.linestyle, marker=style.marker, label=name_of(model))
    axes.set_yscale("log")
    one_two_five(axes.yaxis)
    axes.set_ylabel(r"standard deviation of $\ln\,\xi$ over the amplitudes [%]")
    b1 = amplitude_dependence["map_strength_ratio"].values.tolist()
    shown = f"lines: $b_1 = {b1[plain]:g}$, $a_3 = 1$; bands: all $b_1$ and variants; {', '.join(exact)}: 0"
    axes.legend(title=shown, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)


@styled
def fig_closed_form(amplitude_dependence: xr.Dataset) -> Figure:
    """Draw by how much the closed form differs from peaks and from Err, against the amplitude."""
    models = [str(model) for model in amplitude_dependence["damping_model"].values]
    exact = [model for model in dampers(amplitude_dependence) if model in Damping.exact_models()]
    figure = new_figure(112.0)
    grid = figure.subplots(2, len(models), sharex=True, sharey=True, squeeze=False)
    for row, (measure, name) in zip(
        grid, (("damping_ratio_peaks", "the first peak"), ("damping_ratio", "Err")), strict=True
    ):
        for axes, model in zip(row, models, strict=True):
            _differences(axes, amplitude_dependence.sel(damping_model=model), measure, model, exact)
        row[0].set_ylabel(f"closed form less {name} [%]")
    for axes, model in zip(grid[0], models, strict=True):
        axes.set_title(name_of(model), color=style_of(model).colour, fontweight="bold")
    for axes in grid[-1]:
        axes.set(xlabel=r"$u_0/u_3$ [-]", xticks=[0, 0.5, 1], xlim=(0, 1))
    e = texts(amplitude_dependence["restitution"].values.tolist())
    handles = [Line2D([], [], color=shade, linewidth=1.5) for shade in ramp(GREY, len(e))]
    handles.append(Line2D([], [], color=GREY, **MIDDLE))
    labels = [*(f"$e = {value}$" for value in e), f"at the half cycle's middle energy, $e = {e[len(e) // 2]}$"]
    band = f"band: all {amplitude_dependence.sizes['case']} curves at $e = {e[len(e) // 2]}$"
    title = f"lines: the paper's curve; {band}"
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=title)
    return figure


def _differences(axes: Axes, of_model: xr.Dataset, measure: str, model: str, exact: list[str]) -> None:
    share, reference = of_model["release_share"].values, reference_case(of_model)
    colours = ramp(style_of(model).colour, of_model.sizes["restitution"])
    shown = len(colours) // 2  # the bands of all e would cover each other
    for index, colour in enumerate(colours):
        at_e = of_model.isel(restitution=index)
        first = PERCENT * (at_e["damping_ratio_energy"] / at_e[measure] - 1)
        axes.plot(share, first.isel(case=reference), color=colour)
        if index == shown:
            axes.fill_between(share, first.min("case"), first.max("case"), color=colour, alpha=0.2, linewidth=0)
            middle = PERCENT * (at_e["damping_ratio_middle"] / at_e[measure] - 1)
            if model not in exact:
                axes.plot(share, middle.isel(case=reference), color=colour, **MIDDLE)
    axes.axhline(0, color=PALE, linewidth=0.6, zorder=0)


def by_named_damper(
    values: xr.DataArray, show: Callable[[xr.DataArray], str] = lambda values: span(values, percent)
) -> str:
    """Write a value, or the least and the largest, for each damper by the name that it has in these figures."""
    models = [str(model) for model in values["damping_model"].values]
    return by_name({name_of(model).replace("$", ""): show(values.sel(damping_model=model)) for model in models})


def fig_amplitude_dependence_caption(amplitude_dependence: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at_e = amplitude_dependence.sel(restitution=REFERENCE_RESTITUTION, method="nearest")
    share = at_e["release_share"]
    return f"""
    The standard deviation of ln&nbsp;ξ over the amplitudes is, over {at_e.sizes["case"]} curves,
    {by_named_damper(at_e["spread_peaks"])}. ξ is the damping ratio with which the first half cycle ends as at
    e&nbsp;=&nbsp;{plain(at_e["restitution"])}, for releases from {plain(share.min())} to {plain(share.max())} of
    u<sub>3</sub>.
    """


def fig_exponent_caption(amplitude_dependence: xr.Dataset) -> str:
    """Write the caption, HTML."""
    best, spread, a1 = (
        amplitude_dependence[f"map_{name}"] for name in ("best_exponent", "spread", "yield_displacement_ratio")
    )
    return f"""
    In C&nbsp;∝&nbsp;(ω/ω<sub>1</sub>)<sup>n</sup>, the n that makes ξ of the closed form depend least on the
    amplitude is between {float(best.min()):.2f} and {float(best.max()):.2f} for a<sub>1</sub> from
    {plain(a1.min())} to {plain(a1.max())}.
    With it the standard deviation of ln&nbsp;ξ is at most {at_most(spread.sel(damping_model=BEST).max())}; with the
    paper's dampers it is {by_named_damper(spread.sel(damping_model=list(PAPER_MODELS)))}.
    """


def fig_closed_form_caption(amplitude_dependence: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at_e = amplitude_dependence.sel(restitution=REFERENCE_RESTITUTION, method="nearest")

    def largest(measure: str) -> str:
        away = abs(at_e["damping_ratio_energy"] / at_e[measure] - 1)
        return by_named_damper(away, lambda of_damper: at_most(of_damper.max()))

    return f"""
    The closed form is off by {largest("damping_ratio_peaks")} at most of the ξ that matches the first peak (above), and
    by {largest("damping_ratio")} at most of the ξ of least error, Eq.&nbsp;(17) (below), at
    e&nbsp;=&nbsp;{plain(at_e["restitution"])} over {at_e.sizes["case"]} curves and
    {at_e.sizes["release_share"]} amplitudes.
    """
