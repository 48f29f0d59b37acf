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

# --- Fig. 1 -----------------------------------------------------------------------------------------------------------


def rotation(thickness: float, height: float, offset: float) -> float:
    """Return the rotation of a body whose top left corner moves `offset` >= 0 to the right. [rad]

    It follows from t - t cos(theta) + h sin(theta) = offset.
    """
    across = (offset - thickness) / math.hypot(thickness, height)
    return math.atan2(thickness, height) + math.asin(across)


def rotate_body(thickness: float, height: float, offset: float) -> Array:
    """Return the corners of a body that turns about its bottom right one, the origin, shape (4, 2). [m]

    They are bottom left, bottom right, top right, top left.
    """
    angle = rotation(thickness, height, offset)
    upright = np.array([(-thickness, 0.0), (0.0, 0.0), (0.0, height), (-thickness, height)])
    return upright @ np.array(
        [(math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))]
    )


def wall_corners(
    thickness: float, height: float, hinge_ratio: float, offset: float
) -> tuple[Array, Array]:
    """Return the corners of the lower and the upper body at a displacement `offset` >= 0 of the hinge. [m]

    x is from mid-thickness. The lower body turns about its right base corner. The upper one turns about its right top
    corner, which the support holds. They touch at the hinge, on the left face.
    """
    lower = rotate_body(thickness, hinge_ratio * height, offset)
    upper = rotate_body(thickness, (1 - hinge_ratio) * height, offset) * (1.0, -1.0)  # upside down
    upper[:, 1] += lower[3, 1] - upper[3, 1]
    return lower + (thickness / 2, 0.0), upper + (thickness / 2, 0.0)


THIN: dict[str, Any] = {"color": GREY, "linewidth": 0.5}


def fig1(mechanism: xr.Dataset) -> Figure:
    """Draw the wall at rest and displaced, with the symbols of Section 2."""
    h, ratio = float(mechanism["height"]), float(mechanism["hinge_ratio"])
    t = h / 5.0  # stouter than the wall and displaced far, so that angles and gaps can be seen
    offset = 0.6 * t
    figure, grid = panels(1, 2, 112.0, COLUMN, sharey=True)
    top = wall_corners(t, h, ratio, offset)[1][
        :, 1
    ].max()  # the wall grows as it turns on its corners
    for axes, u, title in zip(
        grid[0], (0.0, offset), ("(a) at rest", "(b) displaced"), strict=True
    ):
        lower, upper = wall_corners(t, h, ratio, u)
        _bodies(axes, lower, upper, t)
        _rest(axes, t, h, ratio) if u == 0 else _displaced(axes, lower, upper, t, u)
        axes.set(
            title=title, aspect="equal", xlim=(-1.5 * t, 1.25 * t), ylim=(-0.75 * t, top + 1.5 * t)
        )
        axes.set_axis_off()
    return figure


def _bodies(axes: Axes, lower: Array, upper: Array, t: float) -> None:
    """Draw both bodies, their weights, and the overburden on the plate that keeps the top from sliding."""
    top = upper[:, 1].max()
    for body, colour, symbol in ((lower, "#D9D9D9", "$W_1$"), (upper, "#ECECEC", "$W_2$")):
        axes.add_patch(Polygon(body, facecolor=colour, edgecolor="black", linewidth=0.9))
        x, y = body.mean(axis=0)
        _arrow(axes, (x, y), (x, y - 0.6 * t))
        axes.plot(x, y, "o", color="white", markeredgecolor="black", markersize=4)
        axes.text(x - 0.06 * t, y - 0.36 * t, symbol, ha="right", va="center")
    for y, depth in ((0.0, -0.22 * t), (top, 0.16 * t)):
        axes.add_patch(
            Rectangle(
                (-0.7 * t, y), 1.4 * t, depth, facecolor="none", edgecolor=GREY, hatch="/////", lw=0
            )
        )
        axes.plot([-0.7 * t, 0.7 * t], [y, y], color="black", linewidth=0.9)
    plate, x = top + 0.16 * t, 0.25 * t
    _arrow(axes, (x, plate + 0.8 * t), (x, plate))
    axes.text(x + 0.1 * t, plate + 0.6 * t, "$O$", va="center")
    axes.plot([0, 0], [plate, plate + 1.2 * t], linestyle="dashdot", **THIN)
    axes.plot([x, x], [plate + 0.85 * t, plate + 1.2 * t], **THIN)
    _dimension(axes, (0.0, plate + 1.1 * t), (x, plate + 1.1 * t))
    axes.text(x + 0.1 * t, plate + 1.1 * t, "ecc", va="center")


def _rest(axes: Axes, t: float, h: float, ratio: float) -> None:
    """Write the sizes, the contacts A, B, C, and the angles between the faces and the lines from pivot to pivot."""
    level, side = ratio * h, -1.05 * t
    for start, end, symbol in ((0.0, level, "$h_1$"), (level, h, "$h_2$")):
        _dimension(axes, (side, start), (side, end))
        axes.text(side - 0.1 * t, (start + end) / 2, symbol, ha="right", va="center")
    for y in (0.0, level, h):
        axes.plot([side - 0.1 * t, -0.56 * t], [y, y], **THIN)
    _dimension(axes, (-t / 2, -0.45 * t), (t / 2, -0.45 * t))
    axes.text(0, -0.5 * t, "$t$", ha="center", va="top")
    for pivot, size, up, symbol in (
        ((t / 2, 0.0), level, 1, r"$\alpha_1$"),
        ((t / 2, h), h - level, -1, r"$\alpha_2$"),
    ):
        axes.plot([pivot[0], -t / 2], [pivot[1], level], linestyle="dashed", **THIN)
        _angle(axes, pivot, 0.55 * size, up, math.atan2(t, size), symbol)
    _contacts(axes, t, {"$A$": (t / 2, h), "$B$": (-t / 2, level), "$C$": (t / 2, 0.0)})


def _displaced(axes: Axes, lower: Array, upper: Array, t: float, u: float) -> None:
    """Write the displacement of the hinge, the contacts, and the rotations from the vertical."""
    hinge, base, top = lower[3], lower[1], upper[1]
    axes.plot([-t / 2] * 2, [hinge[1] - 0.3 * t, hinge[1] + 0.3 * t], **THIN)
    _dimension(axes, (-t / 2, hinge[1]), tuple(hinge))
    axes.text(-t / 2 - 0.1 * t, hinge[1], "$u$", ha="right", va="center")
    for pivot, size, up, symbol in (
        (base, hinge[1] - base[1], 1, r"$\theta_1$"),
        (top, top[1] - hinge[1], -1, r"$\theta_2$"),
    ):
        axes.plot(
            [pivot[0]] * 2, [pivot[1], pivot[1] + 0.75 * up * size], linestyle="dashed", **THIN
        )
        _angle(axes, pivot, 0.6 * size, up, -rotation(t, size, u), symbol)
    _contacts(axes, t, {"$A'$": top, "$B$": hinge, "$C'$": base})


def _contacts(axes: Axes, t: float, points: dict[str, Any]) -> None:
    for symbol, (x, y) in points.items():
        axes.plot(x, y, "o", color="black", markersize=3.5)
        if symbol == "$B$":  # on the left face
            axes.text(x - 0.12 * t, y + 0.2 * t, symbol, ha="right", va="center")
        else:
            axes.text(x + 0.3 * t, y, symbol, va="center")


def _angle(axes: Axes, pivot: Any, radius: float, up: int, angle: float, symbol: str) -> None:
    """Draw an angle from the vertical through a pivot: to the left where positive, seen from the pivot."""
    ends = sorted((90.0 * up, 90.0 * up + up * math.degrees(angle)))
    axes.add_patch(
        Arc(tuple(pivot), 2 * radius, 2 * radius, theta1=ends[0], theta2=ends[1], linewidth=0.7)
    )
    middle = math.radians(sum(ends) / 2)
    x, y = pivot[0] + 1.2 * radius * math.cos(middle), pivot[1] + 1.2 * radius * math.sin(middle)
    axes.text(x, y, symbol, ha="center", va="center")


def _arrow(axes: Axes, start: Any, end: Any) -> None:
    arrow = {
        "arrowstyle": "-|>",
        "color": "black",
        "linewidth": 1.0,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 7,
    }
    axes.annotate("", end, start, arrowprops=arrow)


def _dimension(axes: Axes, start: Any, end: Any) -> None:
    arrow = {"arrowstyle": "<->", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
    axes.annotate("", start, end, arrowprops=arrow)


# --- Fig. 2 -----------------------------------------------------------------------------------------------------------


def fig2(mechanism: xr.Dataset) -> Figure:
    """Draw the tri-linear law on the bi-linear one, the softening variants and Doherty's stages of degradation."""
    figure, grid = panels(1, 3, 72.0, sharey=True)
    titles = (
        "(a) definitions",
        "(b) last branch that ends before $u_\\mathrm{ins}$",
        "(c) stages of degradation",
    )
    for axes, title in zip(grid[0], titles, strict=True):
        axes.set_title(title, y=1.1)
        axes.set(xlabel=DISPLACEMENT, xlim=(0, 1.04), ylim=(0, 1.04))
    grid[0, 0].set_ylabel("$F/F_0$ [-]")
    _definitions(grid[0, 0], mechanism)
    black = {"color": "black"}
    _law(grid[0, 1], mechanism, "steeper", "steeper: $u_2$ on the bi-linear law", **black)
    _law(
        grid[0, 1],
        mechanism,
        "translated",
        "translated: slope $-K_0$",
        linestyle="dashdot",
        **black,
    )
    a3 = float(mechanism["ultimate_displacement_ratio"].sel(curve_name="steeper"))
    grid[0, 1].plot(
        a3, 0, "ko", clip_on=False, zorder=5, label=f"$u_3 = {a3:g}\\,u_\\mathrm{{ins}}$"
    )
    looks = (("solid", "#1A1A1A"), ("dashed", "#0072B2"), ("dashdot", "#D55E00"))
    for (name, (b1, a1)), (line, colour) in zip(PRESETS.items(), looks, strict=True):
        _law(
            grid[0, 2],
            mechanism,
            name,
            f"{name}: $a_1 = {a1:.2f}$, $b_1 = {b1:.2f}$",
            linestyle=line,
            color=colour,
        )
    for axes in grid[0]:  # last, so that no curve hides it
        _law(
            axes,
            mechanism,
            "bi-linear",
            "bi-linear, rigid" if axes is grid[0, 0] else "",
            color=GREY,
            linestyle=(0, (2, 2)),
        )
    legend(figure, handles(*grid[0]), columns=3)
    return figure


def _law(axes: Axes, mechanism: xr.Dataset, name: str, label: str, **look: Any) -> None:
    curve = mechanism.sel(curve_name=name)
    axes.plot(curve["displacement"], curve["force"], label=label, **look)


def _definitions(axes: Axes, mechanism: xr.Dataset) -> None:
    """Draw the curve of the study with its corners, its secant and the slope of the bi-linear law."""
    curve = mechanism.sel(curve_name="tri-linear")
    corners = (
        "yield_displacement_ratio",
        "plateau_end_ratio",
        "ultimate_displacement_ratio",
        "strength_ratio",
    )
    a1, a2, a3, b1 = (float(curve[name]) for name in corners)
    _law(axes, mechanism, "tri-linear", "tri-linear", color="black")
    faint: dict[str, Any] = {"color": GREY, "linewidth": 0.5, "linestyle": "dotted"}
    axes.vlines([a1, a2], [b1, b1], 1.04, **faint)
    axes.hlines([b1, 1.0], [a2, 0], 1.04, **faint)
    end, red = 0.45, "#C1121F"  # of the secant, as in the paper
    force = float(np.interp(end, curve["displacement"], curve["force"]))
    axes.plot(
        [0, end],
        [0, force],
        color=red,
        marker="o",
        markevery=[1],
        label=r"secant, slope $K_\mathrm{sec}$",
    )
    axes.text(0.32, 0.25, r"$K_\mathrm{sec}$", color=red)
    axes.plot([0.66, 0.66, 0.84], [0.34, 0.16, 0.16], color="black", linewidth=0.5)
    axes.text(0.645, 0.22, "$K_0$", ha="right", va="center")
    axes.text(0.75, 0.14, "1", ha="center", va="top")
    axes.secondary_xaxis("top").set_xticks([a1, a2, a3], ["$u_1$", "$u_2$", "$u_3$"])
    axes.secondary_yaxis("right").set_yticks([b1, 1.0], ["$F_y$", "$F_0$"])
