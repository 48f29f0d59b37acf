"""A measured record identified: its posterior in pairs of parameters, the predictive band, and the models' evidence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from scipy.stats import kstwo

from rockdamp.figures.single import TIME, record_title
from rockdamp.figures.style import GREY, PALE, new_figure, styled
from rockdamp.figures.test_series import measured_name
from rockdamp.figures.validation import MILLIMETRES
from rockdamp.text import by_name, listed, number, percent, span
from rockdamp.vocabulary import CANDIDATES

SYMBOLS = {
    "yield_displacement_ratio": "$a_1$",
    "strength_ratio": "$b_1$",
    "restitution": "$e$",
    "damping_ratio": r"$\xi$",
    "order": "$m$",
    "thickness": "$t$ [m]",
    "height": "$h$ [m]",
    "hinge_ratio": "$h_1/h$",
    "overburden_ratio": "$O/W$",
}
ALL_SYMBOLS = {**SYMBOLS, "sensor_deviation": r"$\sigma$", "sensor_correlation": r"$\varphi$"}
LINES = ("#0072B2", "#D55E00", "#009E73", "#9A4C95", "#8C6D1F", "#1A1A1A")
BINS = 28
INK, MARK = "#0072B2", "#D55E00"
ROW, BAND = 40.0, 66.0  # heights [mm]


@styled
def posterior_figure(posterior: xr.Dataset) -> Figure:
    """Draw the record in its predictive band, the posterior in pairs of parameters, and any evidence."""
    names = [name for name in posterior["parameter"].values.tolist() if _symbol(name)]
    count, band = len(names), BAND if "predicted" in posterior else 0.0  # several runs have no band here
    figure = new_figure(band + ROW * count)
    parts = figure.add_gridspec(2, 1, height_ratios=[band, ROW * count]) if band else figure.add_gridspec(1, 1)
    if band:
        record = parts[0].subgridspec(2, 1)
        above = figure.add_subplot(record[0])
        _band(above, figure.add_subplot(record[1], sharex=above), posterior)
    cells = parts[-1].subgridspec(count, count)
    for row, name in enumerate(names):
        for column, other in enumerate(names[: row + 1]):
            axes = figure.add_subplot(cells[row, column])
            _marginal(axes, posterior, name) if row == column else _pair(axes, posterior, other, name)
            _label(axes, other, name, at_bottom=row == count - 1, at_left=0 == column < row)
    if "log_evidence" in posterior:
        _evidence(figure, cells[0, 1:], posterior)
    figure.suptitle(f"{record_title(posterior)}; {posterior.attrs['identified_model']}", fontsize=8)
    return figure


def _symbol(name: str) -> str:
    """Return the symbol of a parameter of wall or damper, of a run too, as of "restitution 2"; "" of another."""
    symbol, run = SYMBOLS.get(name.split()[0], ""), name.split()[1:]
    return f"{symbol[:-1]}_{run[0]}$" if symbol and run else symbol


def _band(above: Axes, below: Axes, posterior: xr.Dataset) -> None:
    """Draw the record, and it and the band from the band's middle, where the two can be told apart."""
    elapsed = posterior["elapsed"]
    low, high = (MILLIMETRES * posterior["predicted"].sel(bound=bound).values for bound in ("low", "high"))
    measured, middle = MILLIMETRES * posterior["measured"].values, (low + high) / 2
    name = measured_name(posterior)
    above.plot(elapsed, measured, color="black", linewidth=0.9)
    below.fill_between(
        elapsed, low - middle, high - middle, color=INK, alpha=0.45, linewidth=0, label="predicted, 90 %"
    )
    below.plot(elapsed, measured - middle, color="black", linewidth=0.5, label=name)
    below.set(ylabel="from middle [mm]", xlabel=TIME)
    above.tick_params(labelbottom=False)
    above.set(ylabel="$u$ [mm]", title=f"{float(posterior['share_inside']):.1%} of the record inside the band")
    above.figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _marginal(axes: Axes, posterior: xr.Dataset, name: str) -> None:
    of_name = posterior.sel(parameter=name)
    axes.hist(of_name["draws"].values, BINS, color=INK, alpha=0.6)
    for bound in of_name["interval"].sel(level=0.9).values:
        axes.axvline(float(bound), color=GREY, linewidth=0.8, linestyle="dashed")
    _true(axes.axvline, of_name)
    axes.set_yticks([])
    axes.set_title(f"{_symbol(name)} = {float(of_name['mean']):.4g} ± {float(of_name['standard_deviation']):.2g}")


def _pair(axes: Axes, posterior: xr.Dataset, across: str, up: str) -> None:
    x, y = (posterior["draws"].sel(parameter=name).values for name in (across, up))
    axes.hist2d(x, y, BINS, cmap="Blues", rasterized=True)
    _true(axes.axvline, posterior.sel(parameter=across))
    _true(axes.axhline, posterior.sel(parameter=up))


def _true(draw: Callable[..., Any], parameter: xr.Dataset) -> None:
    """Mark the value that made the record, where it is known."""
    value = float(parameter["true_value"])
    if np.isfinite(value):
        draw(value, color=MARK, linewidth=0.9)


def _label(axes: Axes, across: str, up: str, *, at_bottom: bool, at_left: bool) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.tick_params(labelbottom=at_bottom)
    if at_bottom:
        axes.set_xlabel(_symbol(across))
        axes.ticklabel_format(axis="x", useOffset=False)
    if at_left:
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.set_ylabel(_symbol(up))
        axes.ticklabel_format(axis="y", useOffset=False)
    elif across != up:
        axes.tick_params(labelleft=False)


def _evidence(figure: Figure, place: SubplotSpec, posterior: xr.Dataset) -> None:
    """Draw by how much the logarithm of each model's evidence is below the best one's."""
    axes = figure.add_subplot(place)
    models = [name for name in CANDIDATES if name in posterior["damping_model"].values]
    below = (posterior["log_evidence"].max() - posterior["log_evidence"]).sel(damping_model=models).values
    axes.barh(models, np.nan_to_num(below), color=INK, alpha=0.6)
    for place_of, value in enumerate(below):
        text = f" {value:.1f}" if np.isfinite(value) else " not determined"
        axes.text(float(np.nan_to_num(value)), place_of, text, va="center", fontsize=7)
    axes.set_xlim(0, 1.25 * max(float(np.nanmax(below)), 1.0))
    axes.invert_yaxis()
    axes.set_title("logarithm of the evidence, below the best model's")


@styled
def fig_identification(identification: xr.Dataset) -> Figure:
    """Draw ranks of true values, how often intervals hold these values, and which model the records support."""
    figure = new_figure(150.0)
    rows = figure.add_gridspec(2, 1, height_ratios=[1, 1.1])
    above = rows[0].subgridspec(1, 2)
    _ranks(figure.add_subplot(above[0]), identification)
    _coverage(figure.add_subplot(above[1]), identification)
    _supported(figure.add_subplot(rows[1]), identification)
    return figure


def _ranks(axes: Axes, identification: xr.Dataset) -> None:
    """Draw the share of true values with at most a rank, less that rank, in the band of a uniform distribution."""
    count = int(identification["identified_records"])
    for index, name in enumerate(identification["parameter"].values):
        ranks = np.sort(identification["rank"].sel(parameter=name).dropna("draw").values)
        grid = np.concatenate([[0.0], ranks, [1.0]])
        share = np.searchsorted(ranks, grid, side="right") / max(ranks.size, 1)
        axes.step(grid, share - grid, where="post", color=LINES[index % len(LINES)], label=ALL_SYMBOLS[str(name)])
    if count:
        bound = float(kstwo.ppf(0.95, count))
        axes.fill_between([0, 1], -bound, bound, color=PALE, alpha=0.4, linewidth=0, zorder=0)
        axes.set_ylim(-2.2 * bound, 2.2 * bound)
    axes.axhline(0, color=GREY, linewidth=0.6)
    axes.set_xlabel("rank of the true value [-]")
    axes.set_ylabel("share of records up to it, less the rank [-]")
    axes.set_title(f"(a) {count} simulated records")
    axes.legend(ncols=3, loc="upper center", fontsize=7)


def _coverage(axes: Axes, identification: xr.Dataset) -> None:
    """Draw the shares of intervals that hold the true value, beside twice the standard error of so many records."""
    names = [str(name) for name in identification["parameter"].values]
    place = np.arange(len(names))
    for level in identification["level"].values:
        at = identification.sel(level=level)
        error = 2 * float(at["coverage_error"])
        axes.fill_between([-0.5, len(names) - 0.5], level - error, level + error, color=PALE, alpha=0.4, linewidth=0)
        first = level == identification["level"].values[0]
        axes.plot(place - 0.1, at["coverage"], "o", color=INK, label="posterior" if first else None)
        axes.plot(
            place + 0.1, at["coverage_by_least_squares"], "x", color=MARK, label="least squares" if first else None
        )
    axes.set_xticks(place, [ALL_SYMBOLS[name] for name in names])
    axes.set_ylim(0, 1.3)
    axes.set_yticks([0, 0.5, 0.9])
    axes.set_ylabel("share of intervals that hold the truth [-]")
    axes.set_title("(b) intervals of 50 and 90 %")
    axes.legend(loc="upper center", ncols=2, fontsize=7)


def compared(identification: xr.Dataset) -> xr.DataArray:
    """Return the probability of each model, NaN for a record of which the evidence of one was not determined."""
    return identification["probability"].where(identification["log_evidence"].notnull().all("damping_model"))


def confusion(identification: xr.Dataset) -> xr.DataArray:
    """Return the mean probability of each model, over the records of one origin, at each noise."""
    return compared(identification).groupby(identification["record_made_by"]).mean()


def _supported(axes: Axes, identification: xr.Dataset) -> None:
    """Draw the mean probability of each model for the records of each origin, at each noise."""
    shares = confusion(identification)
    table = shares.stack(row=("record_made_by", "noise_factor")).transpose("row", "damping_model")
    models = [str(model) for model in table["damping_model"].values]
    axes.imshow(table.fillna(0.0), cmap="Blues", vmin=0, vmax=1.6, aspect="auto")
    for row in range(table.sizes["row"]):
        for column in range(len(models)):
            value = float(table[row, column])
            text = f"{value:.2f}" if np.isfinite(value) else "not determined"
            axes.text(column, row, text, ha="center", va="center", fontsize=7)
    rows = [f"{maker}; noise × {factor:g}" for maker, factor in table["row"].values]
    axes.set_yticks(np.arange(len(rows)), rows, fontsize=7)
    axes.set_xticks(np.arange(len(models)), models)
    axes.set_ylabel("record made by")
    axes.set_xlabel("damping model that explains it")
    axes.set_title("(c) mean probability of the models [-]")


def fig_identification_caption(identification: xr.Dataset) -> str:
    """Write the caption, HTML."""
    identified, draws = int(identification["identified_records"]), identification.sizes["draw"]
    held = [
        f"{span(at['coverage'], percent)} ± {percent(at['coverage_error'])} (of {percent(at['level'])})"
        for at in (identification.sel(level=level) for level in identification["level"].values)
    ]
    true_model = {
        str(maker): number(shares.sel(damping_model=maker).mean(), 2)
        for maker, shares in confusion(identification).groupby("record_made_by")
        if maker in identification["damping_model"].values
    }
    return f"""
    Of {identified} simulated records, posterior intervals hold the truth in {listed(held)} (least to most of the
    parameters, ± the standard error that so many records leave). Of {draws} records {draws - identified} could not be
    identified. Below: the model that made a record of the test series has a mean probability of {by_name(true_model)}.
    A test series with a curve that degrades is made by none of the models.
    """
