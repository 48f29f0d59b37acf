"""The mechanism: Fig. 1, the wall at rest and displaced, and Fig. 2, force-displacement curves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle

from rockdamp.arrays import Array
from rockdamp.constants import PRESETS
from rockdamp.figures.style import COLUMN, DISPLACEMENT, GREY, handles, legend, panels

# --- Fig. 1: geometry --------------------------------------------------------------------------


def rotation(thickness: float, height: float, offset: float) -> float:
    """Return the rotation of a body whose top left corner moves `offset` >= 0 to the right. [rad]

    It follows from t - t cos(theta) + h sin(theta) = offset, or
    sqrt(t^2 + h^2) sin(theta - alpha) = offset - t with tan(alpha) = t/h.
    """
    across = (offset - thickness) / math.hypot(thickness, height)
    return math.atan2(thickness, height) + math.asin(across)


def rotate_body(thickness: float, height: float, offset: float) -> Array:
    """Return the corners of a body that turns about its bottom right one, the origin. [m]

    They are bottom left, bottom right, top right, top left: shape (4, 2).
    """
    angle = rotation(thickness, height, offset)
    sine = math.sin(angle)
    cosine = math.cos(angle)
    upright = np.array([(-thickness, 0.0), (0.0, 0.0), (0.0, height), (-thickness, height)])
    return upright @ np.array([(cosine, -sine), (sine, cosine)])


def wall_corners(
    thickness: float, height: float, hinge_ratio: float, offset: float
) -> tuple[Array, Array]:
    """Return the corners of the lower and the upper body at a displacement of the hinge. [m]

    x is from mid-thickness. The lower body turns about its right base corner. The upper one turns
    about its right top corner, which the support holds. They touch at the hinge, on the left face.

    Parameters
    ----------
    thickness, height : float
        Size of the wall. [m]
    hinge_ratio : float
        Height of the hinge, divided by that of the wall. [-]
    offset : float
        Displacement of the hinge, at least 0. [m]
    """
    lower = rotate_body(thickness, hinge_ratio * height, offset)
    upside_down = rotate_body(thickness, (1 - hinge_ratio) * height, offset)
    upper = upside_down * (1.0, -1.0)
    upper[:, 1] += lower[3, 1] - upper[3, 1]
    middle = (thickness / 2, 0.0)
    return lower + middle, upper + middle


# --- Fig. 1: drawing ---------------------------------------------------------------------------

THIN_LINE: dict[str, Any] = {"color": GREY, "linewidth": 0.5}


def fig1(mechanism: xr.Dataset) -> Figure:
    """Draw the wall at rest and displaced, with the symbols of Section 2."""
    h = float(mechanism["height"])
    ratio = float(mechanism["hinge_ratio"])
    t = h / 5.0  # stouter than the wall and displaced far, so that angles and gaps can be seen
    u = 0.6 * t
    figure, ((at_rest, displaced),) = panels(1, 2, 112.0, COLUMN, sharey=True)
    lower, upper = wall_corners(t, h, ratio, 0.0)
    draw_bodies(at_rest, lower, upper, t)
    draw_sizes(at_rest, t, h, ratio)
    at_rest.set_title("(a) at rest")
    lower, upper = wall_corners(t, h, ratio, u)
    draw_bodies(displaced, lower, upper, t)
    draw_rotations(displaced, lower, upper, t, u)
    displaced.set_title("(b) displaced")
    top = upper[:, 1].max()  # the wall grows as it turns on its corners
    for axes in (at_rest, displaced):
        axes.set(aspect="equal", xlim=(-1.5 * t, 1.25 * t), ylim=(-0.75 * t, top + 1.5 * t))
        axes.set_axis_off()
    return figure


def draw_bodies(axes: Axes, lower: Array, upper: Array, t: float) -> None:
    """Draw both bodies with their weights, the supports and the overburden."""
    for body, colour, symbol in ((lower, "#D9D9D9", "$W_1$"), (upper, "#ECECEC", "$W_2$")):
        axes.add_patch(Polygon(body, facecolor=colour, edgecolor="black", linewidth=0.9))
        x, y = body.mean(axis=0)
        draw_arrow(axes, (x, y), (x, y - 0.6 * t))
        axes.plot(x, y, "o", color="white", markeredgecolor="black", markersize=4)
        axes.text(x - 0.06 * t, y - 0.36 * t, symbol, ha="right", va="center")
    top = upper[:, 1].max()
    hatch: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "hatch": "/////", "lw": 0}
    for y, depth in ((0.0, -0.22 * t), (top, 0.16 * t)):
        axes.add_patch(Rectangle((-0.7 * t, y), 1.4 * t, depth, **hatch))
        axes.plot([-0.7 * t, 0.7 * t], [y, y], color="black", linewidth=0.9)
    draw_overburden(axes, top + 0.16 * t, t)


def draw_overburden(axes: Axes, plate: float, t: float) -> None:
    """Draw the overburden on the plate that keeps the top from sliding, with its eccentricity."""
    x = 0.25 * t
    draw_arrow(axes, (x, plate + 0.8 * t), (x, plate))
    axes.text(x + 0.1 * t, plate + 0.6 * t, "$O$", va="center")
    axes.plot([0, 0], [plate, plate + 1.2 * t], linestyle="dashdot", **THIN_LINE)
    axes.plot([x, x], [plate + 0.85 * t, plate + 1.2 * t], **THIN_LINE)
    draw_dimension(axes, (0.0, plate + 1.1 * t), (x, plate + 1.1 * t))
    axes.text(x + 0.1 * t, plate + 1.1 * t, "ecc", va="center")


def draw_sizes(axes: Axes, t: float, h: float, ratio: float) -> None:
    """Write the sizes, the contacts A, B, C, and the angles from the faces to the diagonals."""
    level = ratio * h
    side = -1.05 * t
    for start, end, symbol in ((0.0, level, "$h_1$"), (level, h, "$h_2$")):
        draw_dimension(axes, (side, start), (side, end))
        axes.text(side - 0.1 * t, (start + end) / 2, symbol, ha="right", va="center")
    for y in (0.0, level, h):
        axes.plot([side - 0.1 * t, -0.56 * t], [y, y], **THIN_LINE)
    draw_dimension(axes, (-t / 2, -0.45 * t), (t / 2, -0.45 * t))
    axes.text(0, -0.5 * t, "$t$", ha="center", va="top")
    base = (t / 2, 0.0)
    top = (t / 2, h)
    for pivot, size, up, symbol in (
        (base, level, 1, r"$\alpha_1$"),
        (top, h - level, -1, r"$\alpha_2$"),
    ):
        axes.plot([pivot[0], -t / 2], [pivot[1], level], linestyle="dashed", **THIN_LINE)
        draw_angle(axes, pivot, 0.55 * size, up, math.atan2(t, size), symbol)
    draw_contacts(axes, t, {"$A$": top, "$B$": (-t / 2, level), "$C$": base})


def draw_rotations(axes: Axes, lower: Array, upper: Array, t: float, u: float) -> None:
    """Write the displacement of the hinge, the contacts, and the rotations from the vertical."""
    hinge = lower[3]
    base = lower[1]
    top = upper[1]
    axes.plot([-t / 2] * 2, [hinge[1] - 0.3 * t, hinge[1] + 0.3 * t], **THIN_LINE)
    draw_dimension(axes, (-t / 2, hinge[1]), tuple(hinge))
    axes.text(-t / 2 - 0.1 * t, hinge[1], "$u$", ha="right", va="center")
    for pivot, size, up, symbol in (
        (base, hinge[1] - base[1], 1, r"$\theta_1$"),
        (top, top[1] - hinge[1], -1, r"$\theta_2$"),
    ):
        end = pivot[1] + 0.75 * up * size
        axes.plot([pivot[0]] * 2, [pivot[1], end], linestyle="dashed", **THIN_LINE)
        draw_angle(axes, pivot, 0.6 * size, up, -rotation(t, size, u), symbol)
    draw_contacts(axes, t, {"$A'$": top, "$B$": hinge, "$C'$": base})


def draw_contacts(axes: Axes, t: float, points: dict[str, Any]) -> None:
    """Draw the contacts with their symbols."""
    for symbol, (x, y) in points.items():
        axes.plot(x, y, "o", color="black", markersize=3.5)
        if symbol == "$B$":  # on the left face
            axes.text(x - 0.12 * t, y + 0.2 * t, symbol, ha="right", va="center")
        else:
            axes.text(x + 0.3 * t, y, symbol, va="center")


def draw_angle(axes: Axes, pivot: Any, radius: float, up: int, angle: float, symbol: str) -> None:
    """Draw an angle from the vertical through a pivot, to the left if positive.

    `up` is 1 for an angle above the pivot, -1 for one below.
    """
    vertical = 90.0 * up
    start, end = sorted((vertical, vertical + up * math.degrees(angle)))
    diameter = 2 * radius
    axes.add_patch(Arc(tuple(pivot), diameter, diameter, theta1=start, theta2=end, linewidth=0.7))
    middle = math.radians((start + end) / 2)
    x = pivot[0] + 1.2 * radius * math.cos(middle)
    y = pivot[1] + 1.2 * radius * math.sin(middle)
    axes.text(x, y, symbol, ha="center", va="center")


def draw_arrow(axes: Axes, start: Any, end: Any) -> None:
    """Draw a force."""
    ends: dict[str, Any] = {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.0, **ends}
    axes.annotate("", end, start, arrowprops=arrow)


def draw_dimension(axes: Axes, start: Any, end: Any) -> None:
    """Draw an arrow with two heads from one end of a length to the other."""
    ends: dict[str, Any] = {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
    axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", "linewidth": 0.5, **ends})


# --- Fig. 2 ------------------------------------------------------------------------------------


def fig2(mechanism: xr.Dataset) -> Figure:
    """Draw the tri-linear law on the bi-linear one, its variants and stages of degradation."""
    figure, grid = panels(1, 3, 72.0, sharey=True)
    definitions, variants, stages = grid[0]
    definitions.set_title("(a) definitions", y=1.1)
    variants.set_title(r"(b) last branch that ends before $u_\mathrm{ins}$", y=1.1)
    stages.set_title("(c) stages of degradation", y=1.1)
    for axes in grid[0]:
        axes.set(xlabel=DISPLACEMENT, xlim=(0, 1.04), ylim=(0, 1.04))
    definitions.set_ylabel("$F/F_0$ [-]")
    draw_definitions(definitions, mechanism)
    draw_variants(variants, mechanism)
    draw_stages(stages, mechanism)
    for axes in grid[0]:  # last, so that no curve hides it
        label = "bi-linear, rigid" if axes is definitions else ""
        draw_law(axes, mechanism, "bi-linear", label, color=GREY, linestyle=(0, (2, 2)))
    legend(figure, handles(*grid[0]), columns=3)
    return figure


def draw_law(axes: Axes, mechanism: xr.Dataset, name: str, label: str, **look: Any) -> None:
    """Draw a force-displacement curve."""
    curve = mechanism.sel(curve_name=name)
    axes.plot(curve["displacement"], curve["force"], label=label, **look)


def draw_definitions(axes: Axes, mechanism: xr.Dataset) -> None:
    """Draw the curve of the study with its corners, its secant and the slope of the rigid law."""
    curve = mechanism.sel(curve_name="tri-linear")
    a1 = float(curve["yield_displacement_ratio"])
    a2 = float(curve["plateau_end_ratio"])
    a3 = float(curve["ultimate_displacement_ratio"])
    b1 = float(curve["strength_ratio"])
    draw_law(axes, mechanism, "tri-linear", "tri-linear", color="black")
    faint: dict[str, Any] = {"color": GREY, "linewidth": 0.5, "linestyle": "dotted"}
    axes.vlines([a1, a2], [b1, b1], 1.04, **faint)
    axes.hlines([b1, 1.0], [a2, 0], 1.04, **faint)
    end = 0.45  # of the secant, as in the paper
    force = float(np.interp(end, curve["displacement"], curve["force"]))
    secant: dict[str, Any] = {"color": "#C1121F", "marker": "o", "markevery": [1]}
    axes.plot([0, end], [0, force], label=r"secant, slope $K_\mathrm{sec}$", **secant)
    axes.text(0.32, 0.25, r"$K_\mathrm{sec}$", color=secant["color"])
    # The triangle of the slope K0, which is 1 in these units.
    axes.plot([0.66, 0.66, 0.84], [0.34, 0.16, 0.16], color="black", linewidth=0.5)
    axes.text(0.645, 0.22, "$K_0$", ha="right", va="center")
    axes.text(0.75, 0.14, "1", ha="center", va="top")
    axes.secondary_xaxis("top").set_xticks([a1, a2, a3], ["$u_1$", "$u_2$", "$u_3$"])
    axes.secondary_yaxis("right").set_yticks([b1, 1.0], ["$F_y$", "$F_0$"])


def draw_variants(axes: Axes, mechanism: xr.Dataset) -> None:
    """Draw both variants of a last branch that ends before u_ins."""
    black: dict[str, Any] = {"color": "black"}
    draw_law(axes, mechanism, "steeper", "steeper: $u_2$ on the bi-linear law", **black)
    translated = "translated: slope $-K_0$"
    draw_law(axes, mechanism, "translated", translated, linestyle="dashdot", **black)
    a3 = float(mechanism["ultimate_displacement_ratio"].sel(curve_name="steeper"))
    label = f"$u_3 = {a3:g}\\,u_\\mathrm{{ins}}$"
    axes.plot(a3, 0, "ko", clip_on=False, zorder=5, label=label)


def draw_stages(axes: Axes, mechanism: xr.Dataset) -> None:
    """Draw Doherty's stages of degradation."""
    looks = (("solid", "#1A1A1A"), ("dashed", "#0072B2"), ("dashdot", "#D55E00"))
    for (name, (b1, a1)), (linestyle, colour) in zip(PRESETS.items(), looks, strict=True):
        label = f"{name}: $a_1 = {a1:.2f}$, $b_1 = {b1:.2f}$"
        draw_law(axes, mechanism, name, label, linestyle=linestyle, color=colour)
