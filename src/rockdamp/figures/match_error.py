"""The paper's second Fig. 6: the error that the best damping ratio leaves."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.arrays import Array
from rockdamp.figures.equivalence import every
from rockdamp.figures.style import (
    REFERENCE_AMPLITUDE,
    RESTITUTION,
    SINGLE_COLUMN,
    by_model,
    dampers,
    line_of,
    marks_of,
    new_figure,
    papers,
    scaling,
    style_of,
    styled,
)
from rockdamp.text import listed, number, plain, ranges

PAPER_RANGE = (0.80, 0.91)  # of e where CDR's error is the lowest, Section 6


@styled
def fig6_error(amplitude: xr.Dataset) -> Figure:
    """Draw the root of Err at the best match against e, with the range in which the paper finds CDR's the lowest."""
    study = papers(amplitude).sel(release_amplitude=REFERENCE_AMPLITUDE, method="nearest")
    e, root, models = study["restitution"], study["error"] ** 0.5, dampers(study)
    figure = new_figure(82.0, SINGLE_COLUMN)
    axes = figure.subplots()
    for model in models:
        look = {"marker": style_of(model).marker, **line_of(model)}
        axes.plot(e, root.sel(damping_model=model), markevery=every(e), label=model, **look)
    top = 1.35 * float(root.max())
    axes.set_ylim(0, top)
    axes.axvspan(*PAPER_RANGE, color="#EDEDED", linewidth=0, zorder=0)
    low, high = PAPER_RANGE
    axes.text(
        (low + high) / 2,
        0.99 * top,
        f"paper: CDR lowest,\n${low:.2f} \\leq e \\leq {high:.2f}$",
        ha="center",
        va="top",
        fontsize=7,
    )
    _lowest(axes, root, 0.8 * top)
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel(r"$\sqrt{\mathrm{Err}}$, Eq. (17) [-]")
    # Err is a sum over the response: its root over the number of samples does not depend on the step.
    per_sample = float((study["rms_error"] / root).mean())
    beside = axes.secondary_yaxis("right", functions=scaling(1000 * per_sample))
    beside.set_ylabel(r"$10^3\,\sqrt{\mathrm{Err}/k}$ [-]")
    figure.legend(loc="outside upper center", ncols=len(models))
    axes.locator_params("x", nbins=6, steps=[1, 2, 5, 10])
    release = f"$u_0/u_\\mathrm{{ins}} = {float(study['release_amplitude']):g}$"
    length = f"$\\tau = {float(study['response_length']):g}$ in $k = {int(study['steps'])}$ steps"
    axes.set_title(f"{release}, {length},\na length that was inferred from this figure")
    return figure


def fig6_error_caption(amplitude: xr.Dataset) -> str:
    """Write the caption of the second Fig. 6, HTML."""
    study = papers(amplitude).sel(release_amplitude=REFERENCE_AMPLITUDE, method="nearest")
    lowest, e = with_lowest(study["error"]), study["restitution"].values.tolist()
    named = listed(
        f"{model} at e = {ranges(e, lowest == model)}" for model in dampers(study) if (lowest == model).any()
    )
    largest = by_model(study["rms_error"].max("restitution"), lambda error: number(error, 2))
    return f"""
    Of the paper's models that of the lowest error is {named}. It is what remains with the best ξ, for a release from
    {plain(study["release_amplitude"])}&nbsp;u<sub>ins</sub> over τ&nbsp;=&nbsp;{plain(study["response_length"])}, and
    at most {largest} (root mean square of the difference of u/u<sub>ins</sub>). The length of the response was inferred
    from this very comparison, so this confirms nothing by itself.
    """


def with_lowest(error: xr.DataArray) -> Array:
    """Return the model of the lowest error at each e."""
    models: Array = error["damping_model"].values
    return models[error.argmin("damping_model").values]


def _lowest(axes: Axes, root: xr.DataArray, height: float) -> None:
    """Draw a row of markers that names the paper's model with the lowest error at each e."""
    best = with_lowest(root)
    for model in map(str, root["damping_model"].values):
        e = root["restitution"].values[best == model]
        axes.plot(e, np.full(e.size, height), **marks_of(model))
    names = ", ".join(map(str, root["damping_model"].values))
    axes.text(
        float(root["restitution"][0]), height * 1.02, f" lowest of {names} here:", fontsize=7, ha="left", va="bottom"
    )
