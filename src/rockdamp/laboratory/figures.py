"""Pictures of measured tests: a record and its fits, free rocking, and the studies of both."""

from __future__ import annotations

from collections.abc import Callable
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator

from rockdamp.figures.single import ACCELERATION, TIME, record_title
from rockdamp.figures.style import (
    DISPLACEMENT,
    GREY,
    PALE,
    line_of,
    literal,
    new_figure,
    one_two_five,
    style_of,
    styled,
)
from rockdamp.figures.validation import MEASURED, MILLIMETRES, measured_name
from rockdamp.laboratory.releases import FreeRocking
from rockdamp.motions.records import Record
from rockdamp.text import listed, number, percent, plain
from rockdamp.vocabulary import CANDIDATES, PAPER_MODELS, REFERENCE

# --- records and least squares ----------------------------------------------------------------------------------------

PARAMETERS = {
    "yield_displacement_ratio": "$a_1 = {:.4f} \\pm {:.4f}$",
    "strength_ratio": "$b_1 = {:.4f} \\pm {:.4f}$",
    "restitution": "$e = {:.4f} \\pm {:.4f}$",
}


@styled
def record_figure(record: Record | FreeRocking) -> Figure:
    """Draw the histories of a record, or that of a free-rocking test."""
    shown = [(ACCELERATION, record.ground_acceleration)] if isinstance(record, Record) else []
    if record.displacement is not None:
        shown.append(("$u$ [mm]", MILLIMETRES * record.displacement))
    if isinstance(record, FreeRocking) and record.rotation is not None:
        shown.append((r"rotation [rad]", record.rotation))
    figure = new_figure(20.0 + 42.0 * len(shown))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False).ravel()
    for axes, (label, values) in zip(panels, shown, strict=True):
        axes.plot(record.elapsed, values, color="black", linewidth=0.8)
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)
        axes.set_ylabel(label)
    panels[-1].set_xlabel(TIME)
    figure.align_ylabels(panels)
    kind = "SYNTHETIC record" if record.synthetic else "Record"
    figure.suptitle(fill(literal(f"{kind}: {record.header.get('source', 'not stated')}"), 120, max_lines=2), fontsize=8)
    return figure


@styled
def calibration_figure(calibration: xr.Dataset) -> Figure:
    """Draw the measured response and the fitted one, and what is left between them."""
    figure = new_figure(105.0)
    axes, left = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [2.6, 1.0]})
    measured, fitted = (MILLIMETRES * calibration[name] for name in ("measured", "control_displacement"))
    axes.plot(calibration["elapsed"], measured, label=measured_name(calibration), **MEASURED)
    axes.plot(calibration["elapsed"], fitted, label="fitted, CR", **line_of(REFERENCE))
    values = [calibration[name].sel(parameter=list(PARAMETERS)).values for name in ("estimate", "standard_error")]
    estimates = ",  ".join(text.format(*of_name) for text, *of_name in zip(PARAMETERS.values(), *values, strict=True))
    axes.set(ylabel="$u$ [mm]", title=estimates)
    axes.legend(loc="upper right")
    left.plot(calibration["elapsed"], measured - fitted, color=GREY, linewidth=0.8)
    left.set(ylabel="residual [mm]", xlabel=TIME)
    for each in (axes, left):
        each.axhline(0, color=PALE, linewidth=0.5, zorder=0)
    figure.align_ylabels([axes, left])
    figure.suptitle(record_title(calibration), fontsize=8)
    return figure


# --- identification ---------------------------------------------------------------------------------------------------

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
    """Draw which model the records of each maker support."""
    table = confusion(identification).stack(row=("record_made_by", "noise_factor")).transpose("row", "damping_model")
    figure = new_figure(35.0 + 8.0 * table.sizes["row"])
    _supported(figure.subplots(), table, _origins(identification))
    return figure


def compared(identification: xr.Dataset) -> xr.DataArray:
    """Return the probability of each model, NaN for a record of which the evidence of one was not determined."""
    return identification["probability"].where(identification["log_evidence"].notnull().all("damping_model"))


def confusion(identification: xr.Dataset) -> xr.DataArray:
    """Return the mean probability of each model, over the records of one origin, at each noise."""
    return compared(identification).groupby(identification["record_made_by"]).mean()


def _origins(identification: xr.Dataset) -> dict[tuple[str, float], tuple[int, int]]:
    """Return of how many records, by maker and noise, the evidence of all models was determined, and how many exist."""
    known = compared(identification).notnull().all("damping_model").groupby(identification["record_made_by"])
    return {
        (str(maker), float(factor)): (int(of.sel(noise_factor=factor).sum()), of.sizes["record"])
        for maker, of in known
        for factor in of["noise_factor"].values
    }


def _supported(axes: Axes, table: xr.DataArray, origins: dict[tuple[str, float], tuple[int, int]]) -> None:
    """Draw the mean probability of each model for the records of each origin, at each noise."""
    models = [str(model) for model in table["damping_model"].values]
    shown = np.ma.masked_invalid(table.values)
    axes.set_facecolor(PALE)  # of what is not determined, which is no 0
    axes.imshow(shown, cmap="Blues", vmin=0, vmax=1.6, aspect="auto")
    for row, column in np.ndindex(table.shape):
        value = float(table[row, column])
        text = f"{value:.2f}" if np.isfinite(value) else "not determined"
        axes.text(column, row, text, ha="center", va="center", fontsize=7)
    keys = [(str(maker), float(factor)) for maker, factor in table["row"].values]
    rows = [f"{maker}; noise × {factor:g} ({count_of(origins[maker, factor])})" for maker, factor in keys]
    axes.set_yticks(np.arange(len(rows)), rows, fontsize=7)
    axes.set_xticks(np.arange(len(models)), models)
    axes.set_ylabel("record made by (records)")
    axes.set_xlabel("damping model that explains it")
    axes.set_title("mean probability of the models [-]")


def count_of(known: tuple[int, int]) -> str:
    """Return how many records a mean is of: "4", or "3 of 4" where one was not determined."""
    return str(known[1]) if known[0] == known[1] else f"{known[0]} of {known[1]}"


def fig_identification_caption(identification: xr.Dataset) -> str:
    """Write the caption, HTML."""
    origins, shares = _origins(identification), confusion(identification)
    own = [
        f"{number(shares.sel(record_made_by=maker, noise_factor=factor, damping_model=maker), 2)} ({maker},"
        f" {count_of(known)} records{f', noise × {factor:g}' if factor != 1 else ''})"
        for (maker, factor), known in origins.items()
        if maker in identification["damping_model"].values and known[0]
    ]
    whose = f"The mean probability of the model that made the records is {listed(own)}." if own else ""
    missing = sum(count - known for known, count in origins.values())
    left_out = "records are left out, for which the evidence of a model was not determined."
    return f"""
    {whose} The models are equally probable before. {f"{missing} {left_out}" if missing else ""}
    """


# --- free rocking -----------------------------------------------------------------------------------------------------

MARKERS = ("o", "s", "^", "D", "v")
FREE_ROCKING_HEIGHT = 150.0  # [mm]


@styled
def free_rocking_figure(fitted: xr.Dataset) -> Figure:
    """Draw the first release with its fit, and half periods and e of the impacts of all releases."""
    figure = new_figure(FREE_ROCKING_HEIGHT)
    rows = figure.add_gridspec(2, 1, height_ratios=[1.25, 1.0])
    above, below = rows[0].subgridspec(2, 1, height_ratios=[2.6, 1.0]), rows[1].subgridspec(1, 2)
    history, periods, impacts = (figure.add_subplot(cell) for cell in (above[0], below[0], below[1]))
    left = figure.add_subplot(above[1], sharex=history)
    history.tick_params(labelbottom=False)
    _decay(history, left, fitted)
    _half_periods(periods, fitted)
    _impacts(impacts, fitted)
    figure.suptitle(record_title(fitted), fontsize=8)
    figure.align_ylabels([history, left])
    return figure


def _decay(history: Axes, left: Axes, fitted: xr.Dataset) -> None:
    """Draw the first release: measured, fitted, its peaks; and what is left between the two."""
    of_release = fitted.isel(sample=(fitted["sample_release"] == 1).values)
    peaks = fitted.isel(half_cycle=(fitted["half_cycle_release"] == 1).values)
    elapsed = of_release["sample_elapsed"]
    measured, computed = (MILLIMETRES * of_release[name] for name in ("measured", "control_displacement"))
    history.plot(elapsed, measured, label=measured_name(fitted), **MEASURED)
    history.plot(elapsed, computed, label="fitted", **line_of(REFERENCE))
    at, height = peaks["peak_elapsed"].values, MILLIMETRES * peaks["peak_displacement"].values
    history.plot(at[1:], height[1:], "o", color=INK, markersize=3.5, label="peaks")
    history.plot(at[:1], height[:1], ">", color="black", markersize=6, label="release")
    left.plot(elapsed, measured - computed, color=GREY, linewidth=0.7)
    left.set(ylabel="residual [mm]", xlabel=TIME)
    count = fitted.sizes["release"]
    history.set(ylabel="$u$ [mm]", title="(a) free rocking" + (f", the first of {count} releases" if count > 1 else ""))
    history.legend(loc="upper right", ncols=4)
    for axes in (history, left):
        axes.margins(x=0.015)
        axes.axhline(0, color=PALE, linewidth=0.5, zorder=0)


def _half_periods(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw half periods against the amplitude, with those of the fitted curve and of the rigid wall."""
    u_ins, p = float(fitted["instability_displacement"]), float(fitted["frequency_parameter"])
    amplitude = abs(fitted["peak_displacement"].values) / u_ins
    for release in fitted["release"].values:
        chosen = fitted["half_cycle_release"].values == release
        label = "measured" if release == 1 else None
        axes.plot(amplitude[chosen], fitted["half_period"].values[chosen], color=INK, **_marker(release), label=label)
    order = np.argsort(amplitude)
    axes.plot(amplitude[order], fitted["half_period_fitted"].values[order], label="fitted curve", **line_of(REFERENCE))
    rigid = 2 * np.arccosh(1 / (1 - amplitude[order])) / p
    axes.plot(amplitude[order], rigid, color=GREY, linestyle="dotted", label="rigid wall")
    axes.set_xlabel(DISPLACEMENT)
    axes.set_ylabel("half period [s]")
    a1, b1 = (_with_error(fitted, name) for name in ("yield_displacement_ratio", "strength_ratio"))
    axes.set_title(f"(b) $a_1$ = {a1}, $b_1$ = {b1}")
    axes.margins(x=0.03)
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(loc="lower right")


def _impacts(axes: Axes, fitted: xr.Dataset) -> None:
    """Draw e of each impact with its interval, the mean, the analytical value, and what the dampers would show."""
    rocking = fitted.isel(impact=(fitted["impact_rocking"] == 1).values)
    amplitude, e = rocking["impact_amplitude"].values, rocking["impact_restitution"].values
    low, high = (rocking["impact_restitution_interval"].sel(bound=bound).values for bound in ("low", "high"))
    for release in fitted["release"].values:
        chosen = rocking["impact_release"].values == release
        label = "impact" if release == 1 else None
        errors = np.stack([e - low, high - e])[:, chosen]
        axes.errorbar(amplitude[chosen], e[chosen], errors, color=INK, elinewidth=0.8, label=label, **_marker(release))
    ends = fitted["interval"].sel(parameter="restitution").values
    axes.axhspan(*ends, color=PALE, alpha=0.45, linewidth=0, label="mean, 90 %", zorder=0)
    axes.axhline(float(fitted["restitution_rigid"]), color="black", linestyle="dotted", label="$e_{an}$")
    order = np.argsort(amplitude)
    for model in PAPER_MODELS:
        expected = rocking["expected_restitution"].sel(damping_model=model).values[order]
        axes.plot(amplitude[order], expected, linewidth=0.9, label=model, **line_of(model))
    axes.set_xscale("log")
    one_two_five(axes.xaxis)
    axes.margins(x=0.04)
    axes.set_xlabel(f"peak before the impact, {DISPLACEMENT}")
    axes.set_ylabel("$e$ [-]")
    g = " to ".join(number(bound, 2) for bound in fitted["loss_exponent_interval"].values)
    axes.set_title(f"(c) $e$ = {_with_error(fitted, 'restitution')}, $g$ = {g}")
    axes.legend(loc="best", ncols=2, fontsize=7)


def _marker(release: int) -> dict[str, Any]:
    return {"marker": MARKERS[(release - 1) % len(MARKERS)], "markersize": 3.5, "linestyle": "none"}


def _with_error(fitted: xr.Dataset, name: str) -> str:
    """Return an estimate and its standard error, to the error's second digit."""
    of_name = fitted.sel(parameter=name)
    error = float(of_name["standard_error"])
    decimals = int(np.clip(1 - np.floor(np.log10(error)), 0, 6)) if error > 0 else 3
    return f"{float(of_name['estimate']):.{decimals}f} ± {error:.{decimals}f}"


# --- trials of blocks -------------------------------------------------------------------------------------------------

EXPONENTS = {"SDR": -0.5, REFERENCE: 0.0, "CDC": 0.5}  # of the energy left, of a rigid block to first order in the loss
POINTS: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": "black", "markersize": 3.5, "elinewidth": 0.9}


@styled
def fig_measured_rocking(measured: xr.Dataset) -> Figure:
    """Draw what measurement says: exponent of the amplitude, loss at each impact, and e over Housner's."""
    figure = new_figure(80.0)
    exponent, by_impact, restitution = figure.subplots(1, 3, width_ratios=[1.0, 1.2, 1.1])
    _exponent(exponent, measured)
    _by_impact(by_impact, measured)
    _over_housner(restitution, measured)
    figure.legend(*by_impact.get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def _bars(values: xr.DataArray, interval: xr.DataArray) -> Any:
    """Return the lengths of error bars below and above values."""
    lower, upper = (interval.sel(bound=bound) for bound in ("lower", "upper"))
    return np.array([values - lower, upper - values])


def _by_impact(axes: Axes, measured: xr.Dataset) -> None:
    impact, loss = measured["impact"], measured["loss_by_impact"]
    for model in (REFERENCE, *PAPER_MODELS):
        line = measured["loss_by_impact_of_model"].sel(damping_model=model)
        axes.plot(impact, line, label="CR, ECD" if model == REFERENCE else model, **line_of(model))
    bars = _bars(loss, measured["loss_by_impact_interval"])
    axes.errorbar(impact.values, loss.values, bars, label="measured, 90 %", zorder=3, **POINTS)
    axes.set_ylim(0.0, None)
    axes.set_xlim(0.4, float(impact.max()) + 0.6)
    axes.set_xlabel("impact [-]")
    axes.set_ylabel("loss over the trial's mean [-]")


def _exponent(axes: Axes, measured: xr.Dataset) -> None:
    place = np.arange(measured.sizes["impacts_used"], dtype=float)
    for model, at in EXPONENTS.items():
        axes.axvline(at, **line_of(model))
    exponent = measured["amplitude_exponent"]
    axes.errorbar(exponent.values, place, xerr=_bars(exponent, measured["amplitude_exponent_interval"]), **POINTS)
    axes.set_yticks(place, [f"{int(count)}" for count in measured["impacts_used"]])
    axes.set_ylim(place[-1] + 0.6, -0.6)
    axes.set_xlim(-0.75, 0.75)
    axes.set_xticks(list(EXPONENTS.values()))
    axes.set_xlabel(r"$\gamma$: loss $\propto$ energy$^\gamma$ [-]")
    axes.set_ylabel("impacts used of each trial [-]")
    above = axes.secondary_xaxis("top")
    above.set_xticks(list(EXPONENTS.values()), ["SDR", "CR", "CDC"])
    above.tick_params(length=0)
    for label, model in zip(above.get_xticklabels(), EXPONENTS, strict=True):
        label.set_color(style_of(model).colour)


def _over_housner(axes: Axes, measured: xr.Dataset) -> None:
    slenderness, ratio = measured["geometry"], measured["restitution_over_housner"]
    low, high = (measured["trial_over_housner_interval"].sel(bound=bound) for bound in ("lower", "upper"))
    axes.fill_between(slenderness, low, high, color=PALE, alpha=0.5, linewidth=0)
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.errorbar(
        slenderness.values, ratio.values, _bars(ratio, measured["restitution_over_housner_interval"]), **POINTS
    )
    axes.set_xlim(float(slenderness.min()) - 0.5, float(slenderness.max()) + 0.5)
    axes.set_xlabel("$H/B$ of the block [-]")
    axes.set_ylabel("$e$ over Housner's [-]")


def fig_measured_rocking_caption(measured: xr.Dataset) -> str:
    """Write the caption, HTML."""
    shown, counts = int(measured["shown_impacts"]), measured["impacts_used"].values
    best = measured["log_likelihood"].sel(damping_model=[REFERENCE, *PAPER_MODELS])
    behind = (best.max("damping_model") - best).sel(impacts_used=shown, method="nearest")
    first = str(behind.idxmin("damping_model").item())
    exponents = listed(
        f"{number(one['amplitude_exponent'], 2)} ({_ends(one['amplitude_exponent_interval'])}) with {int(count)}"
        for count, one in ((count, measured.sel(impacts_used=count)) for count in counts)
    )
    kept = int(measured["trials"] - measured["duplicates"])
    squat, slender = (percent(measured["trial_deviation"][end]) for end in (0, -1))
    return f"""
    {kept} measured trials of limestone blocks that rock freely, without overburden; no walls, and no earthquakes. Left,
    the power γ of the energy left with which the relative loss goes: {exponents} impacts; the lines are the dampers'
    powers to first order in the loss. Of CR and the paper's dampers {first} has the largest likelihood. Right, the mean
    of e over Housner's is {number(measured["restitution_over_housner_mean"])}; the standard deviation of ln&nbsp;e of
    one trial is {squat} at H/B&nbsp;=&nbsp;{plain(measured["geometry"][0])} and {slender} at
    {plain(measured["geometry"][-1])}.
    """


def _ends(interval: xr.DataArray) -> str:
    return f"{number(interval.sel(bound='lower'), 2)} to {number(interval.sel(bound='upper'), 2)}"
