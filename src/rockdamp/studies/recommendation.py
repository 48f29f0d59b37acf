"""Recommend a damper in place of restitution, from the studies of earthquakes, orders, pulses and decays.

The damper to use is the one that errs least from restitution under earthquakes, or whose error is not significantly
larger than the least, at every coefficient of restitution. Beside it stands what a user has to know of it: the typical
error and the tail beside those that another e makes, what it misses, and its error under single pulses.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.damping import Damping
from rockdamp.statistics.against_restitution import CHANGES_OF_E, of_pairs
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER, RECOMMENDED_SOURCE, REFERENCE

EXACT_SOURCE = "closed form"  # of a damping ratio that is exact for some dampers, and needs no history

# ASSUME: a damper holds where its error is no more than twice what CR's own answer moves after a small change of e or
# of the analysis, or where it is a tenth.
MULTIPLE = 2.0  # of the small-change error of CR
TOLERANCE = 0.10

CHOICES = ("damping_model", "damping_ratio_source")
SIZES = ("log_error", "log_error_median", "log_error_90")  # of the difference of the peaks: rms, typical, tail


def recommend(
    config: Config, compared: xr.Dataset, orders: xr.Dataset, by_order: xr.Dataset, pulses: xr.Dataset
) -> xr.Dataset:
    """Recommend a damper and the source of its damping ratio, and collect the reasons.

    `compared` and `orders` hold the dampers, and ECD of each order, under earthquakes. `by_order` and `pulses` hold ECD
    of each order in free decay, and the dampers under pulses.
    """
    e, models = compared["restitution"].values, compared["damping_model"].values
    ratio = [
        np.full(e.size, np.nan)
        if model == REFERENCE
        else damping_ratio_energy(config.curve, str(model), e, config.release_amplitude)
        for model in models
    ]
    near = by_order.sel(order=RECOMMENDED_ORDER, method="nearest")
    before = near["pulse_before_impact_log_error"]
    advice = under_earthquakes(compared).merge(_under_pulses(pulses, models))
    return advice.assign(
        # Under pulses at the shown e, and in the shown decay, of the order nearest to the recommended one.
        before_impact_log_error=float(before.sel(restitution=by_order["shown_restitution"], method="nearest")),
        damping_ratio_energy=(("damping_model", "restitution"), np.stack(ratio)),
        release_amplitude=config.release_amplitude,
        crossing_force=float(abs(near["shown_damping_force"]).max()),
        recommended_order=orders["recommended_order"].sel(change=DECISIVE_CHANGE, drop=True),
        restitution_change=orders["restitution_change"],
        records=orders["records"],
    )


def under_earthquakes(compared: xr.Dataset) -> xr.Dataset:
    """Return the part of the recommendation that the comparison under earthquakes gives."""
    whole, largest = (compared.isel(band=band, drop=True) for band in (0, -1))
    own = compared["varied_log_error"].max("variation")
    # The smaller of both sides: what a change of e makes at the least.
    change = {name: compared[f"varied_{name}"].sel(variation=list(CHANGES_OF_E)).min("variation") for name in SIZES}
    more_loss, less_loss = (compared.sel(variation=side) for side in CHANGES_OF_E)
    sizes = {name: whole[name] for name in SIZES}
    sizes |= {_of_change(name): change[name].isel(band=0, drop=True) for name in SIZES}
    sizes |= {f"near_collapse_{name}": largest[name] for name in SIZES}
    sizes |= {f"near_collapse_{_of_change(name)}": change[name].isel(band=-1, drop=True) for name in SIZES}
    return judge(whole).assign(
        {
            **sizes,
            "tail_share": whole["tail_share"],
            "log_error_interval": whole["log_error_interval"],
            "excess": whole["log_error_excess"],
            "excess_interval": whole["log_error_excess_interval"],
            "sensitivity": own,
            "holds": holds(compared["log_error"], own).astype(np.int8),
            "near_collapse_start": compared["band_start"].values[-1],
            "false_safe_rate": whole["false_safe_rate"],
            "false_collapse_rate": whole["false_collapse_rate"],
            # More loss misses collapses, less loss adds them.
            "sensitivity_false_safe_rate": more_loss["varied_false_safe_rate"].drop_vars("variation"),
            "sensitivity_false_collapse_rate": less_loss["varied_false_collapse_rate"].drop_vars("variation"),
        }
    )


def _of_change(name: str) -> str:
    """Return the name of a size of the difference that a change of e makes."""
    return f"sensitivity_to_restitution{name.removeprefix('log_error')}"


# --- which damper -----------------------------------------------------------------------------------------------------


def judge(whole: xr.Dataset) -> xr.Dataset:
    """Mark at each e the least error and those not significantly larger, and over all e what to use.

    Significantly larger is where the interval of the difference of both errors, over the same histories, is above zero.
    That the intervals of both errors overlap says nothing: the dampers share the records. `whole` is over all
    amplitudes.
    """
    ordered = whole.transpose("restitution", *CHOICES, ...)
    is_damper = (whole["damping_model"] != REFERENCE).values[:, None]
    error = np.where(is_damper, ordered["log_error"].values, np.nan)
    known = np.isfinite(error).any(axis=(1, 2), keepdims=True)  # e at which any damper has an error
    least = np.zeros(error.shape, dtype=bool)
    for e in np.flatnonzero(known):
        least[e].flat[np.nanargmin(error[e])] = True
    lower = ordered["log_error_excess_interval"].sel(bound="lower").values
    near = least | ((lower <= 0) & is_damper & known)
    everywhere: NDArray[np.bool_] = near.all(axis=0)
    use = np.zeros_like(everywhere)
    if everywhere.any():
        # Of several the one of least error over all e; if its damper has an exact ratio, with that.
        square = np.where(everywhere, (error**2).mean(axis=0), np.inf)
        model, source = divmod(int(np.argmin(square)), square.shape[1])
        exact = whole["damping_ratio_source"].values.tolist().index(EXACT_SOURCE)
        if str(whole["damping_model"].values[model]) in Damping.exact_models() and everywhere[model, exact]:
            source = exact
        use[model, source] = True
    by_e = ("restitution", *CHOICES)
    return xr.Dataset(
        {
            "least_error": (by_e, least.astype(np.int8)),
            "not_told_apart": (by_e, near.astype(np.int8)),
            "recommended": (CHOICES, use.astype(np.int8)),
            "as_good": (CHOICES, (everywhere & ~use).astype(np.int8)),
        },
        coords={name: whole[name].values for name in (*by_e, "bound")},
    )


# --- when, and when not -----------------------------------------------------------------------------------------------


def holds(error: xr.DataArray, own: xr.DataArray) -> xr.DataArray:
    """Tell where an error is within the multiple of CR's small-change error, or the tolerance; unknown is not."""
    return error <= np.maximum(MULTIPLE * own, TOLERANCE)


def _under_pulses(pulses: xr.Dataset, models: NDArray[Any]) -> xr.Dataset:
    """Errors of each damper under the slowest and the quickest pulses, at the middle e of these."""
    at_e = pulses.isel(restitution=pulses.sizes["restitution"] // 2).sel(
        damping_ratio_source=RECOMMENDED_SOURCE, drop=True
    )
    stand = (at_e["collapsed"] == 0) & (at_e["reference_collapsed"] == 0)
    ratio = (at_e["peak"] / at_e["reference_peak"]).where(stand).sortby("pulse_frequency")
    error = of_pairs(ratio, ["pulse", "load_ratio"])["log_error"].reindex(damping_model=models)
    slow, quick = (error.isel(pulse_frequency=end).values for end in (0, -1))
    return xr.Dataset(
        {
            "slow_pulse_log_error": ("damping_model", slow),
            "quick_pulse_log_error": ("damping_model", quick),
            "pulse_restitution": float(at_e["restitution"]),
        }
    )
