"""Measured free rocking: the loss impact by impact, its dependence on the amplitude, and restitution over Housner's."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rockdamp.figures.style import GREY, PALE, line_of, new_figure, style_of, styled
from rockdamp.text import by_name, listed, number, percent
from rockdamp.vocabulary import PAPER_MODELS, REFERENCE

EXPONENTS = {"SDR": -0.5, REFERENCE: 0.0, "CDC": 0.5}  # of the energy left, of a rigid block to first order in the loss
POINTS: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": "black", "markersize": 3.5, "elinewidth": 0.9}


@styled
def fig_measured_rocking(measured: xr.Dataset) -> Figure:
    """Draw what measurement says: loss at each impact, exponent of the amplitude, and e over Housner's."""
    figure = new_figure(80.0)
    by_impact, exponent, restitution = figure.subplots(1, 3, width_ratios=[1.2, 1.0, 1.1])
    _by_impact(by_impact, measured)
    _exponent(exponent, measured)
    _restitution(restitution, measured)
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


def _restitution(axes: Axes, measured: xr.Dataset) -> None:
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
    others = {str(model): number(behind.sel(damping_model=model), 2) for model in best["damping_model"].values}
    exponents = listed(
        f"{number(one['amplitude_exponent'], 2)} ({_span(one['amplitude_exponent_interval'])}) with {int(count)}"
        for count, one in ((count, measured.sel(impacts_used=count)) for count in counts)
    )
    kept = int(measured["trials"] - measured["duplicates"])
    later = by_name({model: value for model, value in others.items() if model != first})
    within, between = percent(measured["deviation_within"]), percent(measured["deviation_between"])
    return f"""
    {kept} measured trials of limestone blocks that rock freely, without overburden; no walls, and no earthquakes.
    Left, the loss at each of {shown} impacts over the trial's mean, and each damper's; bars hold the value nine times
    in ten, here and in the other panels. Of CR and the paper's dampers {first} has the largest likelihood; ln&nbsp;L of
    the others is lower by {later}. Odd impacts may differ from even ones, as those of a block that leans. Middle, the
    power γ of the energy left with which the loss goes: {exponents} impacts; the lines are the dampers' powers to first
    order in the loss. Right, e over Housner's: points for each
    block, and the band that holds nine in ten of its trials. The mean is
    {number(measured["restitution_over_housner_mean"])}; ln&nbsp;e scatters by {within} from trial to trial and by
    {between} from block to block.
    """


def _span(interval: xr.DataArray) -> str:
    return f"{number(interval.sel(bound='lower'), 2)} to {number(interval.sel(bound='upper'), 2)}"
