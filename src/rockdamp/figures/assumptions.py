"""What assumptions cost: what holds a wall, what its equation of motion leaves out, and one e at all amplitudes."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from rockdamp.figures.style import PALE, new_figure, pick_look, styled
from rockdamp.text import plain

ALL, RATIO = "all", "median_intensity_ratio"


@styled
def fig_supports(supports: xr.Dataset) -> Figure:
    """Draw the effect of a flexible floor by its period, and that of each other assumption."""
    figure = new_figure(95.0)
    left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.1)})
    _floors(left, supports.isel(assumption=floors(supports)).sortby("diaphragm_period"))
    _others(right, supports.isel(assumption=~floors(supports)))
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def floors(supports: xr.Dataset) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return which cases are of a flexible floor."""
    return np.isfinite(supports["diaphragm_period"].values)


def _floors(axes: Axes, cases: xr.Dataset) -> None:
    period = np.concatenate([[0.0], cases["diaphragm_period"].values])
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for column, wall in enumerate(_walls(cases)):
        ratio = np.concatenate([[1.0], cases[RATIO].sel(wall=wall).values])
        axes.plot(period, ratio, markersize=2.5, linewidth=0.6, label=wall, **pick_look(column))
    whole = cases.isel(wall=0)
    _bars(axes, period[1:], whole, RATIO, color="#1A1A1A", linewidth=1.8, marker="o", markersize=3, label=ALL)
    axes.set_title("(a) a flexible floor at the top")
    axes.set(xlim=(0, 1.04 * period[-1]))  # room for the last bar's ends
    axes.set(xlabel="period of the floor [s]", ylabel="median intensity of collapse over the assumed [-]")


def _others(axes: Axes, cases: xr.Dataset) -> None:
    names = [*map(str, cases["assumption"].values)]
    place = np.arange(len(names))[::-1]
    axes.axvline(1.0, color=PALE, linewidth=0.8)
    for column, wall in enumerate(_walls(cases)):
        ratio = cases[RATIO].sel(wall=wall).values
        axes.plot(ratio, place, markersize=3, **{**pick_look(column), "linestyle": "none"})
    whole = cases.isel(wall=0)
    look = {"linestyle": "none", "color": "#1A1A1A", "marker": "o", "markersize": 4}
    _bars(axes, place - 0.25, whole, RATIO, upright=False, **look)
    axes.set(xscale="log", yticks=place, yticklabels=names, xlabel="median intensity of collapse over the assumed [-]")
    ticks = [0.5, 0.7, 1.0, 1.4, 2.0, 2.8]
    axes.set_xticks(ticks, [plain(tick) for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.set_title("(b) other assumptions")


def _bars(axes: Axes, place: Any, case: xr.Dataset, name: str, upright: bool = True, **look: Any) -> None:
    """Draw a statistic and its interval at some places."""
    value = case[name].values
    errors = np.abs(case[f"{name}_interval"].transpose("bound", ...).values - value)
    x, y = (place, value) if upright else (value, place)
    axes.errorbar(x, y, **{"yerr" if upright else "xerr": errors}, capsize=2, **look)


def _walls(cases: xr.Dataset) -> list[str]:
    return [str(wall) for wall in cases["wall"].values[1:]]


# --- one e at all amplitudes ------------------------------------------------------------------------------------------

APART = 0.006  # of the marks of two exponents [u/u_ins]


@styled
def fig_loss_law(loss_law: xr.Dataset) -> Figure:
    """Draw the median intensity of collapse by amplitude, and the median of the peaks by band, over those of e."""
    whole = loss_law.isel(wall=0)
    figure = new_figure(80.0)
    left, right = figure.subplots(1, 2)
    _collapses(left, whole)
    _peaks(right, whole.isel(loss_exponent=middle(whole)))
    return figure


def middle(study: xr.Dataset) -> int:
    """Return the place of the exponent for which the peaks are shown: that of the middle."""
    return study.sizes["loss_exponent"] // 2


def _look(count: int) -> dict[str, Any]:
    return {**pick_look(count), "markersize": 4, "linewidth": 0.9}


def _collapses(axes: Axes, whole: xr.Dataset) -> None:
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for count, g in enumerate(whole["loss_exponent"].values.tolist()):
        one = whole.sel(loss_exponent=g)
        places = one["reference_amplitude"].values + APART * (count - (whole.sizes["loss_exponent"] - 1) / 2)
        _bars(axes, places, one, RATIO, label=f"$g = {g:g}$", **_look(count))
    at = whole["reference_amplitude"].values
    axes.set_xlim(at[0] - 0.05, at[-1] + 0.05)
    axes.set_title(f"(a) collapse, $e = {float(whole['restitution']):g}$")
    axes.set(
        xlabel=r"amplitude that $e$ belongs to, $u/u_\mathrm{ins}$ [-]", ylabel="median intensity over that of $e$ [-]"
    )
    axes.legend()


def _peaks(axes: Axes, of_exponent: xr.Dataset) -> None:
    edges = [*of_exponent["band_start"].values.tolist(), float(of_exponent["band_end"][-1])]
    place = np.sqrt(np.multiply(edges[:-1], edges[1:]))
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for count, at in enumerate(of_exponent["reference_amplitude"].values.tolist()):
        one = of_exponent.sel(reference_amplitude=at)
        label = rf"$e$ at ${at:g}\,u_\mathrm{{ins}}$"
        _bars(axes, place * 1.04 ** (count - 1), one, "median_ratio", label=label, **_look(count))
    axes.set(xscale="log", xlim=(edges[0], edges[-1]))
    axes.xaxis.set_major_locator(FixedLocator(edges))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axes.set_title(f"(b) peaks, $g = {float(of_exponent['loss_exponent']):g}$")
    axes.set(xlabel=r"peak with constant $e$, $u/u_\mathrm{ins}$ [-]", ylabel="median peak over constant $e$'s [-]")
    axes.legend()


def amplitudes(study: xr.Dataset) -> list[float]:
    """Return the amplitudes that e belongs to."""
    values: list[float] = study["reference_amplitude"].values.tolist()
    return values
