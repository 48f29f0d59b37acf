"""The mechanism: rigid bodies as they are drawn, the sketch of one wall, force-displacement curves, and Fig. 1."""

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
from rockdamp.figures.style import DISPLACEMENT, GREY, PALE, SINGLE_COLUMN, new_figure, styled
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall

# --- bodies, at displacements of any size -----------------------------------------------------------------------------


def rotation(thickness: float, height: float, offset: float) -> float:
    """Return the rotation of a body whose top left corner moves `offset` >= 0 to the right. [rad]

    It follows from t - t cos(theta) + h sin(theta) = offset. Beyond its diagonal the body lies on its side.
    """
    across = min((offset - thickness) / math.hypot(thickness, height), 1.0)
    return math.atan2(thickness, height) + math.asin(across)


def turned(thickness: float, height: float, offset: float) -> Array:
    """Return the corners of a body that turns about its bottom right one, the origin, shape (4, 2). [m]

    They are bottom left, bottom right, top right, top left.
    """
    angle = rotation(thickness, height, offset)
    upright = np.array([(-thickness, 0.0), (0.0, 0.0), (0.0, height), (-thickness, height)])
    turn = np.array([(math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))])
    return upright @ turn


def wall_corners(thickness: float, height: float, hinge_ratio: float, offset: float) -> list[Array]:
    """Return the corners of the lower and the upper body, or of a parapet alone where `hinge_ratio` is NaN. [m]

    x is from mid-thickness. For offset > 0 the lower body turns about its right base corner. The upper one turns about
    its right top corner, which the support holds. They touch at the hinge, on the left face; offset < 0 mirrors all.
    """
    side, size = (-1.0 if offset < 0 else 1.0), abs(offset)
    lower_height = height if math.isnan(hinge_ratio) else hinge_ratio * height
    bodies = [turned(thickness, lower_height, size)]
    if not math.isnan(hinge_ratio):
        upper = turned(thickness, height - lower_height, size) * (1.0, -1.0)  # upside down about its top corner
        upper[:, 1] += bodies[0][3, 1] - upper[3, 1]
        bodies.append(upper)
    return [(corners + (thickness / 2, 0.0)) * (side, 1.0) for corners in bodies]


# --- one wall ---------------------------------------------------------------------------------------------------------


DRAWN = 0.6  # of the thickness: the displacement of the sketch
MASONRY = "#D9C3B0"
POINTS = 400  # of the curve


@styled
def wall_figure(wall: Wall | Parapet, curve: TrilinearCurve) -> Figure:
    """Draw a wall with its sizes, displaced, and its curve beside the rigid law."""
    figure = new_figure(70.0)
    sketch, forces = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.7]})
    _draw_sketch(sketch, wall)
    _draw_curve(forces, wall, curve)
    return figure


def _draw_sketch(axes: Axes, wall: Wall | Parapet) -> None:
    thickness, height = float(wall.thickness), float(wall.height)
    hinge = float(wall.hinge_ratio) if isinstance(wall, Wall) else np.nan
    offset = DRAWN * thickness
    for corners in wall_corners(thickness, height, hinge, 0.0):
        axes.add_patch(Polygon(corners, closed=True, facecolor="none", edgecolor=PALE, linewidth=0.8))
    bodies = wall_corners(thickness, height, hinge, offset)
    for corners in bodies:
        axes.add_patch(Polygon(corners, closed=True, facecolor=MASONRY, edgecolor="black", linewidth=0.8))
    top = max(float(corners[:, 1].max()) for corners in bodies)
    axes.plot([-2 * thickness, 2 * thickness], [0, 0], color="black", linewidth=1.2)
    side = -1.6 * thickness
    axes.annotate("", (side, 0), (side, height), arrowprops={"arrowstyle": "<->", "color": GREY, "linewidth": 0.8})
    axes.text(side, height / 2, f"$h$ = {height:g} m ", ha="right", va="center")
    axes.text(0, -0.03 * height, f"$t$ = {thickness:g} m", ha="center", va="top")
    if np.isfinite(hinge):
        level = float(bodies[0][3, 1])
        words = f"hinge, $h_1$ = {hinge * height:.3g} m"
        axes.annotate(words, (offset, level), (2.0 * thickness, level), va="center")
    if float(wall.overburden_ratio) > 0:
        arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.0}
        axes.annotate("", (0.0, top), (0.0, top + 0.12 * height), arrowprops=arrow)
        axes.text(0.25 * thickness, top + 0.1 * height, f"$O$ = {float(wall.overburden_ratio):.3g} $W$", va="center")
    axes.set(ylim=(-0.12 * height, top + 0.16 * height), aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(-0.75 * height, 0.75 * height)
    axes.spines[:].set_visible(False)


def _draw_curve(axes: Axes, wall: Wall | Parapet, curve: TrilinearCurve) -> None:
    u_ins = 1000 * float(wall.instability_displacement)
    strength = float(wall.rigid_strength) / 1000
    ratio = np.linspace(0.0, 1.0, POINTS)
    axes.plot(u_ins * ratio, strength * (1.0 - ratio), color=GREY, linestyle="dashed", label="rigid wall")
    axes.plot(u_ins * ratio, strength * curve.force(ratio), color="black", label="this wall")
    corners = np.array([curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio], float)
    at, force = u_ins * corners, strength * curve.force(corners)
    axes.plot(at, force, "o", color="black", markersize=3.5)
    for nth, corner in enumerate(zip(at, force, strict=True), start=1):
        axes.annotate(f"$u_{nth}$", corner, xytext=(4, 5), textcoords="offset points")
    axes.set(xlim=(0, None), ylim=(0, 1.12 * strength), xlabel="$u$ [mm]", ylabel="force [kN]")
    axes.legend(loc="upper right")


# --- Fig. 2 -----------------------------------------------------------------------------------------------------------


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


# --- Fig. 1 -----------------------------------------------------------------------------------------------------------


# Drawn stouter than the wall and displaced far, so that angles and gaps can be seen.
DRAWN_SLENDERNESS = 5.0
DRAWN_DISPLACEMENT = 0.6  # u over the drawn thickness
DRAWN_ECCENTRICITY = 0.25  # over the drawn thickness
LOWER, UPPER = "#D9D9D9", "#ECECEC"
EDGE, THIN = 0.9, 0.5  # line widths [pt]
DIMENSION_ARROW: dict[str, Any] = {"linewidth": THIN, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
FORCE_ARROW: dict[str, Any] = {"linewidth": 1.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}


def bodies(thickness: float, height: float, hinge_ratio: float, u: float) -> tuple[Array, Array]:
    """Return the corners of both bodies at hinge displacement `u`, each from the lower left anticlockwise. [m]

    x is from the left face at rest. The lower body turns about its lower right corner, C'. The upper one meets it at
    its left edge, B, and the top support at its upper right corner, A', which moves up and not sideways.
    """
    lower, upper = (body + (thickness / 2, 0.0) for body in wall_corners(thickness, height, hinge_ratio, u))
    return lower, upper[::-1]


@styled
def fig1(mechanism: xr.Dataset) -> Figure:
    """Draw the wall at rest and displaced, with the symbols of Section 2."""
    height, ratio = float(mechanism["height"]), float(mechanism["hinge_ratio"])
    slenderness = height / float(mechanism["thickness"])
    t = max(height / DRAWN_SLENDERNESS, float(mechanism["thickness"]))
    u = DRAWN_DISPLACEMENT * t
    figure = new_figure(115.0, SINGLE_COLUMN)
    rest, displaced = figure.subplots(1, 2, sharey=True, gridspec_kw={"width_ratios": [1.0, 1.0]})
    _draw_rest(rest, t, height, ratio)
    _draw_displaced(displaced, t, height, ratio, u)
    top = float(bodies(t, height, ratio, u)[1][2, 1])  # the wall grows as it turns on its corners
    for axes, title in ((rest, "(a) at rest"), (displaced, "(b) displaced")):
        axes.set(title=title, aspect="equal")
        axes.set_axis_off()
        axes.set(xlim=(-0.95 * t, 1.75 * t), ylim=(-0.75 * t, top + 1.5 * t))
    note = f"$h/t = {slenderness:g}$, $h_1/h = {ratio:g}$"
    if t > float(mechanism["thickness"]):
        note += f"; thickness drawn {t / float(mechanism['thickness']):g} times its own"
    figure.supxlabel(
        f"{note};\n displacement exaggerated, $u = {DRAWN_DISPLACEMENT:g}\\,t$. The bodies are rigid.", fontsize=7
    )
    return figure


def _draw_rest(axes: Axes, t: float, h: float, ratio: float) -> None:
    lower, upper = bodies(t, h, ratio, 0.0)
    _draw_wall(axes, lower, upper, t)
    h1 = ratio * h
    for start, end, symbol in ((0.0, h1, "$h_1$"), (h1, h, "$h_2$")):
        _dimension(axes, (-0.55 * t, start), (-0.55 * t, end), symbol, (-0.12 * t, 0.0), "right")
    for y in (0.0, h1, h):
        axes.plot([-0.7 * t, -0.06 * t], [y, y], color=GREY, linewidth=THIN)
    _dimension(axes, (0.0, -0.48 * t), (t, -0.48 * t), "$t$", (0.0, -0.06 * t), "center", "top")
    # The slenderness of a body is the angle between its face and the line from pivot to pivot: tan(alpha) = t/h_i.
    hinge = np.array([0.0, h1])
    for pivot, part, radius, facing, symbol in (
        (np.array([t, 0.0]), h1, 0.62 * h1, 90.0, r"$\alpha_1$"),
        (np.array([t, h]), h - h1, 0.4 * (h - h1), 270.0, r"$\alpha_2$"),
    ):
        axes.plot(*zip(pivot, hinge, strict=True), color=GREY, linewidth=THIN, linestyle="dashed")
        angle = np.degrees(np.arctan2(t, part))
        first, last = (facing, facing + angle) if facing == 90 else (facing - angle, facing)
        _angle(axes, pivot, radius, first, last, symbol, t, outwards=0.2 * t)
    for point, symbol, shift in (((t, h), "$A$", 0.27), ((0.0, h1), "$B$", -0.1), ((t, 0.0), "$C$", 0.27)):
        _pivot(axes, point, symbol, (shift * t, 0.0 if shift > 0 else 0.12 * t))
    _weights(axes, lower, upper, t, sides=(-1, 1))
    _overburden(axes, t, h)


def _draw_displaced(axes: Axes, t: float, h: float, ratio: float, u: float) -> None:
    for body in bodies(t, h, ratio, 0.0):
        axes.add_patch(Polygon(body, fill=False, edgecolor=GREY, linewidth=THIN, linestyle="dotted"))
    lower, upper = bodies(t, h, ratio, u)
    _draw_wall(axes, lower, upper, t)
    hinge, top, base = lower[3], upper[2], lower[1]
    # u at the hinge: from the left face at rest to B.
    axes.plot([0, 0], [hinge[1] - 0.3 * t, hinge[1] + 0.3 * t], color=GREY, linewidth=THIN)
    _dimension(axes, (0.0, hinge[1]), tuple(hinge), "$u$", (0.0, 0.05 * t), "center", "bottom")
    lower_angle, upper_angle = (np.degrees(rotation(t, part * h, u)) for part in (ratio, 1 - ratio))
    for pivot, radius, facing, symbol in (
        (base, 0.62 * ratio * h, 90.0, r"$\theta_1$"),
        (top, 0.62 * (1 - ratio) * h, 270.0, r"$\theta_2$"),
    ):
        end = pivot[1] + (1.25 if facing == 90 else -1.25) * radius
        axes.plot([pivot[0]] * 2, [pivot[1], end], color=GREY, linewidth=THIN, linestyle="dashed")
        first, last = (90 - lower_angle, 90.0) if facing == 90 else (270.0, 270 + upper_angle)
        _angle(axes, pivot, radius, first, last, symbol, t, outwards=0.2 * t)
    for point, symbol, shift in ((top, "$A'$", 0.27), (hinge, "$B$", -0.1), (base, "$C'$", 0.27)):
        _pivot(axes, point, symbol, (shift * t, 0.0 if shift > 0 else -0.15 * t))
    _weights(axes, lower, upper, t, sides=(-1, -1))
    _overburden(axes, t, float(top[1]))


def _draw_wall(axes: Axes, lower: Array, upper: Array, t: float) -> None:
    """Draw both bodies between the ground and the plate that carries the overburden and keeps the top from sliding."""
    for body, colour, name in ((lower, LOWER, "lower body"), (upper, UPPER, "upper body")):
        axes.add_patch(Polygon(body, facecolor=colour, edgecolor="black", linewidth=EDGE, label=name))
    top = float(upper[:, 1].max())
    for y, depth in ((0.0, -0.22 * t), (top, 0.16 * t)):
        axes.add_patch(Rectangle((-0.2 * t, y), 1.4 * t, depth, facecolor="none", edgecolor=GREY, hatch="/////", lw=0))
        axes.plot([-0.2 * t, 1.2 * t], [y, y], color="black", linewidth=EDGE)


def _weights(axes: Axes, lower: Array, upper: Array, t: float, sides: tuple[int, int]) -> None:
    for body, symbol, side in ((lower, "$W_1$", sides[0]), (upper, "$W_2$", sides[1])):
        centre = body.mean(axis=0)
        _arrow(axes, centre, centre - [0.0, 0.6 * t])
        axes.plot(*centre, marker="o", color="white", markeredgecolor="black", markersize=4, zorder=5)
        ha = "right" if side < 0 else "left"
        axes.text(centre[0] + side * 0.06 * t, centre[1] - 0.36 * t, symbol, ha=ha, va="center")


def _overburden(axes: Axes, t: float, top: float) -> None:
    """Draw O, off mid-thickness by the eccentricity, towards the contact corner."""
    plate, at = top + 0.16 * t, (0.5 + DRAWN_ECCENTRICITY) * t
    _arrow(axes, np.array([at, plate + 0.8 * t]), np.array([at, plate]))
    axes.text(at + 0.1 * t, plate + 0.62 * t, "$O$", ha="left", va="center")
    axes.plot([t / 2] * 2, [plate + 0.05 * t, plate + 1.2 * t], color=GREY, linewidth=THIN, linestyle="dashdot")
    axes.plot([at] * 2, [plate + 0.85 * t, plate + 1.2 * t], color=GREY, linewidth=THIN)
    level = plate + 1.1 * t
    _dimension(axes, (t / 2, level), (at, level), "ecc", (at / 2 - 0.15 * t, 0.0), "left")


def _pivot(axes: Axes, point: Any, symbol: str, shift: tuple[float, float]) -> None:
    axes.plot(*point, marker="o", color="black", markersize=3.5, zorder=6)
    ha = "left" if shift[0] > 0 else "right"
    axes.text(point[0] + shift[0], point[1] + shift[1], symbol, ha=ha, va="center")


def _angle(
    axes: Axes, pivot: Array, radius: float, first: float, last: float, symbol: str, t: float, outwards: float
) -> None:
    """Draw an arc about `pivot` between two directions in degrees, with its symbol beyond it."""
    axes.add_patch(Arc(tuple(pivot), 2 * radius, 2 * radius, theta1=first, theta2=last, linewidth=THIN + 0.2))
    middle = np.radians((first + last) / 2)
    at = pivot + (radius + outwards) * np.array([np.cos(middle), np.sin(middle)])
    axes.text(at[0], at[1], symbol, ha="center", va="center")


def _dimension(
    axes: Axes, start: Any, end: Any, symbol: str, shift: tuple[float, float], ha: str, va: str = "center"
) -> None:
    axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", **DIMENSION_ARROW})
    middle = (np.asarray(start) + np.asarray(end)) / 2 + shift
    axes.text(middle[0], middle[1], symbol, ha=ha, va=va)


def _arrow(axes: Axes, start: Array, end: Array) -> None:
    axes.annotate("", tuple(end), tuple(start), arrowprops={"arrowstyle": "-|>", "color": "black", **FORCE_ARROW})
