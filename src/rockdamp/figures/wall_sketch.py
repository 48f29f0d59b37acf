"""One wall as it rocks, and its force-displacement curve, for the page of a wall."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from rockdamp.figures.bodies import wall_corners
from rockdamp.figures.style import GREY, PALE, new_figure, styled
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall

DRAWN = 0.6  # of the thickness: the displacement of the sketch
MASONRY = "#D9C3B0"
POINTS = 400  # of the curve


@styled
def wall_figure(wall: Wall | Parapet, curve: TrilinearCurve) -> Figure:
    """Draw a wall with its sizes, displaced, and its curve beside the rigid law."""
    figure = new_figure(70.0)
    sketch, forces = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.7]})
    _draw_wall(sketch, wall)
    _draw_curve(forces, wall, curve)
    return figure


def _draw_wall(axes: Axes, wall: Wall | Parapet) -> None:
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
        axes.annotate(f"hinge, $h_1$ = {hinge * height:.3g} m", (offset, level), (2.0 * thickness, level), va="center")
    if float(wall.overburden_ratio) > 0:
        arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.0}
        axes.annotate("", (0.0, top), (0.0, top + 0.12 * height), arrowprops=arrow)
        axes.text(0.25 * thickness, top + 0.1 * height, f"$O$ = {float(wall.overburden_ratio):g} $W$", va="center")
    axes.set(ylim=(-0.12 * height, top + 0.16 * height), aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(-0.75 * height, 0.75 * height)
    axes.spines[:].set_visible(False)


def _draw_curve(axes: Axes, wall: Wall | Parapet, curve: TrilinearCurve) -> None:
    u_ins, strength = 1000 * float(wall.instability_displacement), float(wall.rigid_strength) / 1000  # [mm], [kN]
    ratio = np.linspace(0.0, 1.0, POINTS)
    axes.plot(u_ins * ratio, strength * (1.0 - ratio), color=GREY, linestyle="dashed", label="rigid wall")
    axes.plot(u_ins * ratio, strength * curve.force(ratio), color="black", label="this wall")
    corners = np.array([curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio], float)
    at, force = u_ins * corners, strength * curve.force(corners)
    axes.plot(at, force, "o", color="black", markersize=3.5)
    for number, corner in enumerate(zip(at, force, strict=True), start=1):
        axes.annotate(f"$u_{number}$", corner, xytext=(4, 5), textcoords="offset points")
    axes.set(xlim=(0, None), ylim=(0, 1.12 * strength), xlabel="$u$ [mm]", ylabel="force [kN]")
    axes.legend(loc="upper right")
