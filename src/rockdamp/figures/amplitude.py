"""How the damping ratio depends on the amplitude."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rockdamp.figures.style import REFERENCE_RESTITUTION, line_of, new_figure, style_of, styled

REFERENCE = "ECD"  # whose ratio is the same at every amplitude


def _at_reference_restitution(amplitude: xr.Dataset) -> xr.Dataset:
    return amplitude.sel(restitution=REFERENCE_RESTITUTION, method="nearest")


@styled
def fig_amplitude(amplitude: xr.Dataset) -> Figure:
    """Draw the damping ratio over that of ECD: a damper that needs no amplitude is a horizontal line."""
    at_e = _at_reference_restitution(amplitude)
    relative = at_e["damping_ratio_peaks"] / at_e["damping_ratio_peaks"].sel(damping_model=REFERENCE)
    figure = new_figure(84.0)
    axes = figure.subplots()
    release = at_e["release_amplitude"].values
    for model in map(str, at_e["damping_model"].values):
        ratio = relative.sel(damping_model=model).values
        axes.plot(release, ratio, **line_of(model))
        look: dict[str, Any] = {"color": style_of(model).colour, "fontweight": "bold", "fontsize": 8}
        end = (float(release[-1]), float(ratio[-1]))
        axes.annotate(model, end, xytext=(4, 0), textcoords="offset points", va="center", annotation_clip=False, **look)
    axes.set(xlim=(0, release[-1]), xlabel=r"release amplitude $u_0/u_\mathrm{ins}$ [-]")
    axes.set_ylabel(r"$\xi\,/\,\xi_\mathrm{ECD}$ [-]")
    axes.set_title(f"the same first peak as with $e = {float(at_e['restitution']):g}$")
    return figure
