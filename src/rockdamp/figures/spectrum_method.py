"""What an elastic spectrum at the secant period says of walls, beside their histories under restitution."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import GREY, PALE, REFERENCE_RESTITUTION, RESTITUTION, literal, new_figure, ramp, styled
from rockdamp.text import number, percent, plain, span

CAPACITY = 0.4  # that of the check, shown by e
QUANTILES = (0.16, 0.84)  # of the records, which a bar spans
MARKERS = ("o", "s", "^", "D")
COLOURS = {"5 %": "#0072B2", "equivalent": "#D55E00"}
LINES = {"ground": "solid", "storey": (0, (4.0, 2.0))}
TITLES = {"ground": "on the ground"}


@styled
def fig_spectrum_method(study: xr.Dataset) -> Figure:
    """Draw the demand over the capacity for each wall, and the share of unsafe answers against e."""
    figure = new_figure(100.0)
    left, middle, right = figure.subplots(1, 3, width_ratios=[1.2, 1.2, 1.0])
    middle.sharey(left)
    at_e = study.sel(spectrum_damping="5 %").sel(restitution=REFERENCE_RESTITUTION, method="nearest")
    for axes, support in zip((left, middle), study["support"].values, strict=True):
        _demands(axes, at_e.sel(support=support))
        axes.set_title(_place(study, str(support)))
    left.set_yticks(range(study.sizes["wall"]), [literal(str(name)) for name in study["wall"].values])
    left.invert_yaxis()
    middle.tick_params(labelleft=False)
    _shares(right, study.sel(capacity=CAPACITY, method="nearest"))
    handles, labels = left.get_legend_handles_labels()
    others = right.get_legend_handles_labels()
    figure.legend(handles + others[0], labels + others[1], loc="outside upper center", ncols=4)
    return figure


def _place(study: xr.Dataset, support: str) -> str:
    return TITLES.get(support, f"storey {int(study['storey'])} of {int(study['storeys'])}")


def _demands(axes: Axes, study: xr.Dataset) -> None:
    """Draw median and quantiles over the records for each wall, side by side for each capacity."""
    capacities = study["capacity"].values.tolist()
    for place, (capacity, colour) in enumerate(zip(capacities, ramp(GREY, len(capacities)), strict=True)):
        at = study.sel(capacity=capacity)
        low, high = (at["demand_ratio"].quantile(share, "record").values for share in QUANTILES)
        y = [row + 0.25 * (place - (len(capacities) - 1) / 2) for row in range(study.sizes["wall"])]
        axes.hlines(y, low, high, color=colour, linewidth=1.2)
        label = f"$u = {capacity:g}\\,u_\\mathrm{{ins}}$"
        axes.plot(
            at["bias"],
            y,
            linestyle="none",
            marker=MARKERS[place % len(MARKERS)],
            color=colour,
            markersize=4,
            label=label,
        )
    axes.axvline(1.0, color="black", linewidth=0.6)
    for row in range(1, study.sizes["wall"]):
        axes.axhline(row - 0.5, color=PALE, linewidth=0.4)
    axes.set_xscale("log")
    axes.set_xticks([0.5, 1.0, 2.0, 5.0], ["0.5", "1", "2", "5"])
    axes.minorticks_off()
    axes.set(xlim=(0.3, 10.0), xlabel="demand by spectrum\nover capacity [-]")


def _shares(axes: Axes, study: xr.Dataset) -> None:
    """Draw the share of all walls and records that pass and fail, against e, for each method and support."""
    for method in map(str, study["spectrum_damping"].values):
        for support in map(str, study["support"].values):
            at = study["overall_unsafe_share"].sel(spectrum_damping=method, support=support)
            kind = "5 %" if method == "5 %" else r"$\xi(e)$"
            line: dict[str, Any] = {"color": COLOURS[method], "linestyle": LINES[support]}
            axes.plot(at["restitution"], 100 * at, marker=".", label=f"{kind}, {_place(study, support)}", **line)
    axes.set_ylim(bottom=0)
    axes.set_xticks(study["restitution"].values)
    axes.set_xlabel(RESTITUTION)
    axes.set_ylabel("walls that pass and fail [%]")
    axes.set_title(f"$u = {float(study['capacity']):g}\\,u_\\mathrm{{ins}}$")


def fig_spectrum_method_caption(study: xr.Dataset) -> str:
    """Write the caption, HTML."""
    at = study.sel(capacity=CAPACITY, restitution=REFERENCE_RESTITUTION, method="nearest").sel(spectrum_damping="5 %")
    ground, storey = (at.sel(support=support) for support in ("ground", "storey"))
    bars = " to ".join(percent(share) for share in QUANTILES)
    return f"""
    With {percent(at["damping_ratio"], 1)} of damping the elastic spectrum errs on the safe side in most cases, and all
    the same {percent(ground["overall_unsafe_share"])} of the walls and records pass and fail on the ground, and
    {percent(storey["overall_unsafe_share"])} on the storey. A wall is asked about at the intensity at which its
    histories reach {plain(at["capacity"])}&nbsp;u<sub>ins</sub>; the demand is {span(ground["bias"])} times that on the
    ground (medians of the walls), and {span(storey["bias"])} times on the storey. It must be multiplied by
    {number(ground["overall_unsafe_factor"])} and {number(storey["overall_unsafe_factor"])} for one in twenty to pass
    and fail. Bars span {bars} of the records at e&nbsp;=&nbsp;{plain(at["restitution"])}; right, both damping ratios at
    every e. The building has a period of {plain(at["building_period"])}&nbsp;s.
    """
