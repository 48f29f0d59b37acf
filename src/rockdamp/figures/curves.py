"""Fig. 2: the force-displacement curves."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import DISPLACEMENT, GREY, PALE, new_figure, styled
from rockdamp.text import plain
from rockdamp.vocabulary import PRESETS

RED = "#C1121F"  # the secant, as in the paper
SECANT_AT = 0.45  # u/u_ins
TOP = 1.34  # leaves room for the legends
PARAMETERS = ("yield_displacement_ratio", "strength_ratio")  # a1, b1
FORCE = "$F/F_0$ [-]"


@styled
def fig2(mechanism: xr.Dataset) -> Figure:
    """Draw the tri-linear law on the bi-linear one, the softening variants and Doherty's stages of degradation."""
    figure = new_figure(68.0)
    panels = figure.subplots(1, 3, sharey=True)
    titles = ("(a) definitions", "(b) softening variants, $a_3 < 1$", "(c) Doherty's stages of degradation")
    for axes, title in zip(panels, titles, strict=True):
        curve = mechanism.sel(curve_name="bi-linear")
        axes.plot(curve["displacement"], curve["force"], color=GREY, linestyle="dashed", label="bi-linear, rigid")
        axes.set_title(title, pad=16)
        axes.set(xlabel=DISPLACEMENT, xlim=(0, 1.04), ylim=(0, TOP), yticks=[0, 0.2, 0.4, 0.6, 0.8, 1.0])
    panels[0].set_ylabel(FORCE)
    _definitions(panels[0], mechanism)
    _variants(panels[1], mechanism)
    _presets(panels[2], mechanism)
    return figure


def _definitions(axes: Axes, mechanism: xr.Dataset) -> None:
    curve = mechanism.sel(curve_name="tri-linear")
    a1, a2, a3, b1 = (
        float(curve[name])
        for name in ("yield_displacement_ratio", "plateau_end_ratio", "ultimate_displacement_ratio", "strength_ratio")
    )
    axes.plot(curve["displacement"], curve["force"], color="black", label="tri-linear")
    for x, y in ((a1, b1), (a2, b1), (a3, 0.0)):
        axes.plot([x, x], [y, TOP], color=PALE, linewidth=0.6, linestyle="dotted", zorder=0)
    axes.plot([a2, 1.04], [b1, b1], color=PALE, linewidth=0.6, linestyle="dotted", zorder=0)
    axes.plot([0, 1.04], [1, 1], color=PALE, linewidth=0.6, linestyle="dotted", zorder=0)
    at = _force_at(SECANT_AT, curve)
    axes.plot([0, SECANT_AT], [0, at], color=RED, label=r"secant, slope $K_\mathrm{sec}$")
    axes.plot(SECANT_AT, at, "o", color=RED)
    axes.text(0.6 * SECANT_AT, 0.6 * at - 0.05, r"$K_\mathrm{sec}$", color=RED, ha="left", va="top")
    _slope(axes, mechanism)
    above = axes.secondary_xaxis("top")
    same = abs(a3 - 1) < 1e-9
    above.set_xticks([a1, a2, a3], ["$u_1$", "$u_2$", r"$u_3 = u_\mathrm{ins}$" if same else "$u_3$"])
    beside = axes.secondary_yaxis("right")
    beside.set_yticks([b1, 1.0], ["$F_y$", "$F_0$"])
    for extra in (above, beside):
        extra.tick_params(labelsize=8)
        extra.spines[:].set_visible(False)
    axes.legend(loc="upper right", bbox_to_anchor=(0.93, 1.0))


def _force_at(displacement: float, curve: xr.Dataset) -> float:
    """Read a curve; by xarray's own reader a figure would wait for the import of SciPy."""
    return float(np.interp(displacement, curve["displacement"].values, curve["force"].values))


def _slope(axes: Axes, mechanism: xr.Dataset) -> None:
    """Draw the triangle that shows the slope -K0 of the bi-linear law."""
    rigid = mechanism.sel(curve_name="bi-linear")
    left, right = 0.66, 0.84
    high, low = (_force_at(x, rigid) for x in (left, right))
    axes.plot([left, left, right], [high, low, low], color="black", linewidth=0.5)
    axes.text(left - 0.015, (high + low) / 2, "$K_0$", ha="right", va="center")
    axes.text((left + right) / 2, low - 0.02, "1", ha="center", va="top", fontsize=7)


def _variants(axes: Axes, mechanism: xr.Dataset) -> None:
    for name, linestyle, meaning in (
        ("steeper", "solid", "steeper: $u_2$ on the bi-linear law"),
        ("translated", "dashdot", "translated: slope $-K_0$"),
    ):
        curve = mechanism.sel(curve_name=name)
        axes.plot(curve["displacement"], curve["force"], color="black", linestyle=linestyle, label=meaning)
    ultimate = float(mechanism["ultimate_displacement_ratio"].sel(curve_name="steeper"))
    axes.plot(ultimate, 0, "o", color="black", clip_on=False, zorder=5)
    axes.annotate(
        f"$a_3 = {ultimate:g}$",
        (ultimate, 0),
        (ultimate - 0.2, 0.12),
        ha="right",
        va="center",
        fontsize=7,
        arrowprops={"arrowstyle": "-", "linewidth": 0.5, "shrinkB": 3},
    )
    axes.legend(loc="upper right")


def _presets(axes: Axes, mechanism: xr.Dataset) -> None:
    for name, linestyle, colour in zip(
        PRESETS, ("solid", "dashed", "dashdot"), ("black", "#404040", "#707070"), strict=True
    ):
        curve = mechanism.sel(curve_name=name)
        a1, b1 = float(curve["yield_displacement_ratio"]), float(curve["strength_ratio"])
        label = f"{name}: $a_1 = {a1:.2f}$, $b_1 = {b1:.2f}$"
        axes.plot(curve["displacement"], curve["force"], color=colour, linestyle=linestyle, label=label)
    axes.legend(loc="upper right")


def fig2_caption(mechanism: xr.Dataset) -> str:
    """Write the caption of Fig. 2, HTML."""
    curves = {str(name): mechanism.sel(curve_name=name) for name in mechanism["curve_name"].values}
    a1, b1 = ({name: plain(curve[key]) for name, curve in curves.items()} for key in PARAMETERS)
    stages = "; ".join(f"{name}: {a1[name]}, {b1[name]}" for name in PRESETS)
    return f"""
    (a) The tri-linear curve of the study, a<sub>1</sub>&nbsp;=&nbsp;{a1["tri-linear"]} and
    b<sub>1</sub>&nbsp;=&nbsp;{b1["tri-linear"]}, under the bi-linear law of rigid bodies. (b) The two variants of a
    last branch that ends before u<sub>ins</sub>, here at
    a<sub>3</sub>&nbsp;=&nbsp;{plain(curves["steeper"]["ultimate_displacement_ratio"])}. (c) Doherty's stages of
    degradation (a<sub>1</sub>, b<sub>1</sub>): {stages}.
    """
