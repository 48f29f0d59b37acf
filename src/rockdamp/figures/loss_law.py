"""What a constant e costs if the loss of an impact falls with the amplitude: collapse, and peaks by band."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from rockdamp.figures.style import PALE, new_figure, styled
from rockdamp.text import by_name, number, percent, plain

SHADES = ("#0072B2", "#D0267F", "#E69F00", "#009E73", "#56B4E9", "#8C6D1F")  # of exponents, and of amplitudes
MARKERS = "o^sDv<"
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


def _collapses(axes: Axes, whole: xr.Dataset) -> None:
    axes.axhline(1.0, color=PALE, linewidth=0.8)
    for count, g in enumerate(whole["loss_exponent"].values.tolist()):
        one = whole.sel(loss_exponent=g)
        median, ends = one["median_intensity_ratio"].values, one["median_intensity_ratio_interval"].values.T
        axes.errorbar(
            one["reference_amplitude"].values + APART * (count - (whole.sizes["loss_exponent"] - 1) / 2),
            median,
            yerr=np.abs(ends - median),
            color=SHADES[count % 6],
            marker=MARKERS[count % 6],
            markersize=4,
            linewidth=0.9,
            capsize=2,
            label=f"$g = {g:g}$",
        )
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
        median, ends = one["median_ratio"].values, one["median_ratio_interval"].values.T
        axes.errorbar(
            place * 1.04 ** (count - 1),
            median,
            yerr=np.abs(ends - median),
            color=SHADES[count % 6],
            marker=MARKERS[count % 6],
            markersize=4,
            linewidth=0.9,
            capsize=2,
            label=rf"$e$ at ${at:g}\,u_\mathrm{{ins}}$",
        )
    axes.set(xscale="log", xlim=(edges[0], edges[-1]))
    axes.xaxis.set_major_locator(FixedLocator(edges))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axes.set_title(f"(b) peaks, $g = {float(of_exponent['loss_exponent']):g}$")
    axes.set(xlabel=r"peak with constant $e$, $u/u_\mathrm{ins}$ [-]", ylabel="median peak over constant $e$'s [-]")
    axes.legend()


def fig_loss_law_caption(loss_law: xr.Dataset) -> str:
    """Write the caption, HTML."""
    whole = loss_law.isel(wall=0)
    one = whole.isel(loss_exponent=middle(whole))
    names = {f"{at:g}&nbsp;u<sub>ins</sub>": one.sel(reference_amplitude=at) for at in amplitudes(one)}
    ratio = {name: number(at["median_intensity_ratio"]) for name, at in names.items()}
    added = {name: percent(at["false_collapse_rate"]) for name, at in names.items()}
    return f"""
    A loss that falls with the amplitude, with the exponent g of measured free rocking and others about it, beside the
    constant e&nbsp;=&nbsp;{plain(whole["restitution"])} in the same histories: {int(whole["records"])} records of
    {int(whole["stations"])} stations, all walls together; bars are bootstrap intervals over stations. At
    g&nbsp;=&nbsp;{plain(one["loss_exponent"])} the median intensity of collapse is, over that of the constant e,
    {by_name(ratio)} where e was measured at these amplitudes; of the histories that survive with the constant
    e, {by_name(added)} collapse under the law.
    """


def amplitudes(study: xr.Dataset) -> list[float]:
    """Return the amplitudes that e belongs to."""
    values: list[float] = study["reference_amplitude"].values.tolist()
    return values
