"""Peaks and decrements of each damping model over those of the records of test series, against the amplitude."""

from __future__ import annotations

from textwrap import fill

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from rockdamp.arrays import Array
from rockdamp.figures.style import DISPLACEMENT, columns_of, line_of, literal, new_figure, style_of, styled
from rockdamp.text import listed, percent
from rockdamp.vocabulary import REFERENCE

RIGHT = 0.1  # of the record's value: as far as a model may be off to be called right
BAND = "#E8E8E8"


def amplitudes(validation: xr.Dataset) -> Array:
    """Return the largest displacement of each record, u/u_ins. [-]"""
    peaks: Array = (validation["measured_peak_displacement"] / validation["instability_displacement"]).values
    return peaks


def series_by_maker(validation: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the records by what made them, each test series from its lowest level up."""
    makers = [str(maker) for maker in validation["record_made_by"].values]
    levels = {maker: [i for i, other in enumerate(makers) if other == maker] for maker in dict.fromkeys(makers)}
    return {
        maker: validation.isel(record=sorted(indices, key=lambda i: amplitudes(validation)[i]))
        for maker, indices in levels.items()
    }


def off(validation: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return computed ``peak`` or ``decrement`` over measured; NaN after a collapse or without a free decay."""
    if quantity == "peak":
        return validation["peak_ratio_to_measured"].where(validation["collapsed"] == 0)
    return validation["log_decrement"] / validation["measured_log_decrement"]


def is_synthetic(validation: xr.Dataset) -> bool:
    """Say whether the record was computed: only one that says it was not counts as a test."""
    return str(validation.attrs.get("record_synthetic", "yes")) != "no"


def heading(validation: xr.Dataset) -> str:
    """Return the heading of a figure of records: their kind and specimen."""
    kind = "SYNTHETIC records" if is_synthetic(validation) else "Records"
    return fill(literal(f"{kind}: {validation.attrs.get('record_specimen', 'specimen not stated')}"), 120)


def measured_name(validation: xr.Dataset) -> str:
    """Return what the record's displacement is called: a synthetic one was not measured."""
    return "SYNTHETIC record" if is_synthetic(validation) else "measured"


@styled
def fig_test_series(validation: xr.Dataset) -> Figure:
    """Draw peak and decrement of every model over those of the record, against the amplitude, for each test series."""
    models = [str(model) for model in validation["damping_model"].values]
    by_maker = series_by_maker(validation)
    figure = new_figure(105.0)
    grid = figure.subplots(2, len(by_maker), sharex=True, sharey="row", squeeze=False)
    for panels, (maker, test_series) in zip(grid.T, by_maker.items(), strict=True):
        for axes, quantity in zip(panels, ("peak", "decrement"), strict=True):
            _right(axes, test_series, quantity, models)
        panels[0].set_title(literal("a test" if maker == "measured" else f"made by {maker}"))
        panels[1].set_xlabel(f"peak of the record\n{DISPLACEMENT}")
    for axes, quantity in zip(grid[:, 0], ("peak", "decrement"), strict=True):
        axes.set(ylabel=f"{quantity} over\nthat of the record [-]", ylim=(0, 1.75))
    handles: list[Line2D | Patch] = [
        Line2D([], [], label=model, marker=style_of(model).marker, markersize=3.5, **line_of(model)) for model in models
    ]
    handles.append(Patch(facecolor=BAND, label=f"within {percent(RIGHT)} of the record"))
    figure.suptitle(heading(validation), fontsize=8)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns_of(len(handles), 7))
    return figure


def _right(axes: Axes, test_series: xr.Dataset, quantity: str, models: list[str]) -> None:
    """Draw a quantity of every model over that of the record, against the amplitude of the levels."""
    axes.axhspan(1 - RIGHT, 1 + RIGHT, color=BAND, zorder=0, linewidth=0)
    values = off(test_series, quantity)
    for model in models:
        style = {"marker": style_of(model).marker, "markersize": 3.5, **line_of(model)}
        axes.plot(amplitudes(test_series), values.sel(damping_model=model), label=model, **style)
    axes.set_xlim(0, 1)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def fig_test_series_caption(validation: xr.Dataset) -> str:
    """Write the caption, HTML."""
    by_maker = series_by_maker(validation)
    (maker, first), *_ = by_maker.items()
    peaks = {name: off(levels, "peak").sel(damping_model=REFERENCE) for name, levels in by_maker.items()}
    reference = [f"{value:.2f}" for value in peaks.pop(maker).values]
    others = listed(f"{float(ratio.min()):.2f} to {float(ratio.max()):.2f} ({name})" for name, ratio in peaks.items())
    near = (
        f"The models' curve and e are near those that made the records, and not the same. That and the sensors' noise "
        f"leave {REFERENCE} at {reference[0]} of the record's peak on the lowest level."
    )
    return f"""
    Against the records made by {maker} the peak is right within {percent(RIGHT)} under {_right_at(first, "peak")}; the
    decrement of the free decay, under {_right_at(first, "decrement")}. Both depend on the pulse and on what made the
    record: the peaks of {REFERENCE} itself are {listed(reference)} times those of the records, level by
    level{f", and on the other test series {others}" if others else ""}. {near if maker == REFERENCE else ""}
    """


def _right_at(levels: xr.Dataset, quantity: str) -> str:
    """Name each model with the amplitudes at which a quantity of it is right: "CR at 0.50 and 0.88, CDC at none"."""
    near = abs(off(levels, quantity) - 1) <= RIGHT
    reached = amplitudes(levels)
    return ", ".join(
        f"{model} at {listed(f'{value:.2f}' for value in reached[near.sel(damping_model=model)]) or 'none'}"
        for model in near["damping_model"].values
    )
