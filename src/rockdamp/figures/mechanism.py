"""Fig. 1: the mechanism at rest and displaced."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle

from rockdamp.arrays import Array
from rockdamp.figures.bodies import rotation, wall_corners
from rockdamp.figures.style import GREY, SINGLE_COLUMN, new_figure, styled
from rockdamp.text import number, plain

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
    for pivot, length, facing, symbol in (
        (base, 0.62 * ratio * h, 90.0, r"$\theta_1$"),
        (top, 0.62 * (1 - ratio) * h, 270.0, r"$\theta_2$"),
    ):
        end = pivot[1] + (1.25 if facing == 90 else -1.25) * length
        axes.plot([pivot[0]] * 2, [pivot[1], end], color=GREY, linewidth=THIN, linestyle="dashed")
        first, last = (90 - lower_angle, 90.0) if facing == 90 else (270.0, 270 + upper_angle)
        _angle(axes, pivot, length, first, last, symbol, t, outwards=0.2 * t)
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


def fig1_caption(mechanism: xr.Dataset) -> str:
    """Write the caption of Fig. 1, HTML."""
    t, h, hinge_ratio = (plain(mechanism[name]) for name in ("thickness", "height", "hinge_ratio"))
    return f"""
    The wall at rest and displaced. The study's wall is {t}&nbsp;m thick and {h}&nbsp;m high with its hinge at
    h<sub>1</sub>/h&nbsp;=&nbsp;{hinge_ratio}. It is unstable from
    u<sub>ins</sub>&nbsp;=&nbsp;{number(1000 * mechanism["instability_displacement"])}&nbsp;mm on. It is drawn stockier
    than it is, to show its rotations.
    """
