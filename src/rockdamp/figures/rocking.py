"""An animation of the wall that rocks, beside the history of its displacement."""

from __future__ import annotations

import math
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.style
import numpy as np
import xarray as xr
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.figures.bodies import wall_corners
from rockdamp.figures.single import TIME, label_of, record_title
from rockdamp.figures.style import GREY, PALE, STYLE, line_of, new_figure, style_of
from rockdamp.figures.validation import MILLIMETRES
from rockdamp.progress import track
from rockdamp.storage.atomic import replacing

RATE = 12  # frames per second of the film
SAMPLED = 24  # frames per second of the response: walls rock too fast for the eye
MOST_FRAMES = 100  # longer histories are shown faster
RESOLUTION = 100  # dots per inch
WIDTH, HEIGHT = 170.0, 95.0  # [mm]
FIXED_LAYOUT: dict[Any, Any] = {"figure.constrained_layout.use": False}  # finding it for each frame doubles the time
VISIBLE = 0.5  # of the thickness: smaller largest displacements are drawn enlarged
ENLARGED = 1.0  # of the thickness that they are enlarged to, at most


def enlargement(largest: float, thickness: float) -> float:
    """Return the factor on the drawn displacements: 1, or where they are small 1, 2 or 5 times a power of ten."""
    if largest <= 0 or largest >= VISIBLE * thickness:
        return 1.0
    wanted = ENLARGED * thickness / largest
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(step * power for step in (1, 2, 5) if step * power <= wanted)


def animate(response: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write an animated GIF of one model's response: the bodies, and the history up to the moment shown."""
    history = response.isel(damping_model=0)
    alive = np.isfinite(history["displacement"].values)
    elapsed, displacement = history["elapsed"].values[alive], history["displacement"].values[alive]
    moments = _moments(elapsed)
    with matplotlib.style.context([STYLE, FIXED_LAYOUT], after_reset=True):
        stage = _Stage(response, elapsed, displacement, moments)
        film = FuncAnimation(
            stage.figure,
            stage.show,
            frames=iter(track(moments, "animation", len(moments))),
            save_count=len(moments),
            cache_frame_data=False,
            init_func=list,
        )
        with TemporaryDirectory() as folder:  # Pillow tells the format by the suffix
            drawn = Path(folder, "film.gif")
            film.save(drawn, writer=PillowWriter(fps=RATE), dpi=RESOLUTION)
            with replacing(path) as temporary:
                temporary.write_bytes(drawn.read_bytes())


def _moments(elapsed: Array) -> NDArray[np.intp]:
    """Return the samples that are shown, the first and the last among them."""
    duration = float(elapsed[-1] - elapsed[0])
    count = int(np.clip(round(duration * SAMPLED) + 1, 2, MOST_FRAMES))
    return np.searchsorted(elapsed, np.linspace(elapsed[0], elapsed[-1], count) - 1e-9 * duration)


class _Stage:
    """The figure and what moves in it."""

    def __init__(self, response: xr.Dataset, elapsed: Array, displacement: Array, moments: NDArray[np.intp]) -> None:
        self.elapsed, self.displacement = elapsed, displacement
        self.model = str(response["damping_model"].values[0])
        self.thickness, self.height = float(response["thickness"]), float(response["height"])
        self.hinge_ratio = float(response.get("hinge_ratio", np.nan))
        self.factor = enlargement(float(np.abs(displacement).max()), self.thickness)
        self.figure = new_figure(HEIGHT, WIDTH)
        wall, axes = self.figure.add_axes((0.01, 0.02, 0.27, 0.82)), self.figure.add_axes((0.37, 0.12, 0.61, 0.72))
        self._draw_wall(wall)
        self._draw_history(axes, response)
        speed = float(elapsed[-1] - elapsed[0]) * RATE / (len(moments) - 1)
        pace = "in real time" if abs(speed - 1) < 0.05 else f"{speed:.2g} times as fast as in reality"
        self.figure.suptitle(f"{record_title(response)}\n{label_of(response, self.model)}; {pace}", fontsize=8)

    def _draw_wall(self, axes: Axes) -> None:
        self.bodies = [
            Polygon(corners, closed=True, facecolor="#D9C3B0", edgecolor="black", linewidth=0.8)
            for corners in wall_corners(self.thickness, self.height, self.hinge_ratio, 0.0)
        ]
        for body in self.bodies:
            axes.add_patch(body)
        reach = self.factor * float(np.abs(self.displacement).max()) + self.thickness
        margin = 0.04 * self.height
        axes.plot([-reach, reach], [0, 0], color="black", linewidth=1.2)
        axes.axvline(0, color=PALE, linewidth=0.5, zorder=0)
        half = max(reach, 0.25 * self.height)
        axes.set(xlim=(-half, half), ylim=(-margin, 1.05 * self.height + margin), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        enlarged = "displacements to scale" if self.factor == 1 else f"displacements drawn {self.factor:g} times"
        axes.set_title(enlarged, color="black" if self.factor == 1 else style_of("CDR").colour)

    def _draw_history(self, axes: Axes, response: xr.Dataset) -> None:
        mm = MILLIMETRES * self.displacement
        axes.plot(self.elapsed, mm, color=PALE, linewidth=0.8)
        (self.line,) = axes.plot([], [], **line_of(self.model))
        (self.dot,) = axes.plot([], [], "o", color=style_of(self.model).colour, markersize=5)
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
        axes.set(xlabel=TIME, ylabel="$u$ [mm]")
        where = "at the top" if math.isnan(self.hinge_ratio) else "at the hinge"
        collapsed = str(response["outcome"].values[0]) == "collapsed"
        axes.set_title(f"displacement {where}" + (", up to the collapse" if collapsed else ""))
        self.clock = axes.text(0.99, 0.02, "", transform=axes.transAxes, ha="right", va="bottom", color=GREY)

    def show(self, sample: int) -> list[Polygon]:
        """Move everything to a moment."""
        offset = self.factor * float(self.displacement[sample])
        for body, corners in zip(
            self.bodies, wall_corners(self.thickness, self.height, self.hinge_ratio, offset), strict=True
        ):
            body.set_xy(corners)
        mm = MILLIMETRES * self.displacement
        self.line.set_data(self.elapsed[: sample + 1], mm[: sample + 1])
        self.dot.set_data(self.elapsed[sample : sample + 1], mm[sample : sample + 1])
        self.clock.set_text(f"t = {self.elapsed[sample]:.2f} s")
        return self.bodies
