"""One wall as it rocks, and its force-displacement curve, for the page of a wall."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from rockdamp.figures.rocking import wall_corners
from rockdamp.figures.style import DOUBLE_COLUMN, GREY, PALE, new_figure, styled

DRAWN = 0.6  # of the thickness: the displacement of the sketch
MASONRY = "#D9C3B0"


@styled
def wall_figure(facts: xr.Dataset) -> Figure:
    """Draw a wall with its sizes, displaced, and its curve beside the rigid law.

    Parameters
    ----------
    facts : xarray.Dataset
        ``thickness``, ``height``, ``hinge_ratio`` (NaN of a parapet), ``overburden_ratio``; ``force`` [kN] and
        ``rigid_force`` over ``displacement`` [mm], and ``corner_displacement`` with ``corner_force``.
    """
    figure = new_figure(DOUBLE_COLUMN, 70.0)
    sketch, curve = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.0, 1.7]})
    _draw_wall(sketch, facts)
    _draw_curve(curve, facts)
    return figure


def _draw_wall(axes: Axes, facts: xr.Dataset) -> None:
    thickness, height = float(facts["thickness"]), float(facts["height"])
    hinge = float(facts["hinge_ratio"])
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
    if float(facts["overburden_ratio"]) > 0:
        arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.0}
        axes.annotate("", (0.0, top), (0.0, top + 0.12 * height), arrowprops=arrow)
        axes.text(0.25 * thickness, top + 0.1 * height, f"$O$ = {float(facts['overburden_ratio']):g} $W$", va="center")
    axes.set(ylim=(-0.12 * height, top + 0.16 * height), aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(-0.75 * height, 0.75 * height)
    axes.spines[:].set_visible(False)


def _draw_curve(axes: Axes, facts: xr.Dataset) -> None:
    displacement = facts["displacement"]
    axes.plot(displacement, facts["rigid_force"], color=GREY, linestyle="dashed", label="rigid wall")
    axes.plot(displacement, facts["force"], color="black", label="this wall")
    axes.plot(facts["corner_displacement"], facts["corner_force"], "o", color="black", markersize=3.5)
    for name, u, force in zip(
        ("$u_1$", "$u_2$", "$u_3$"),
        facts["corner_displacement"].values,
        facts["corner_force"].values,
        strict=True,
    ):
        axes.annotate(name, (u, force), xytext=(4, 5), textcoords="offset points")
    axes.set_xlim(left=0)
    axes.set_ylim(0, 1.12 * float(facts["rigid_force"].max()))
    axes.set_xlabel("$u$ [mm]")
    axes.set_ylabel("force [kN]")
    axes.legend(loc="upper right")
