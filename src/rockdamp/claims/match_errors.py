"""Judge the claims on the error of the matches and on the best model: sections 6 and 8."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.claims.judgement import (
    A1,
    MODELS,
    RELEASE,
    Judgement,
    Limits,
    count_cases,
    extremes,
    is_largest,
    is_smallest,
    list_models,
    mean_spread,
    several,
    spans,
)
from rockdamp.claims.ratios import amplitude_spread, select_fits
from rockdamp.storage.dataset import Datasets
from rockdamp.text import percent, plain


def matched_error(data: Datasets) -> xr.DataArray:
    """Return the rms error / release, at the reference amplitude (damping_model, e)."""
    release = float(data["damping_force"][RELEASE])
    errors = data["match/amplitude"]["rms_error"].sel({RELEASE: release}, method="nearest")
    return errors.sel(damping_model=MODELS).sortby("restitution") / release


def err_secant(data: Datasets, limits: Limits) -> Judgement:
    """Compare the errors of CDR and SDR with those of CDC."""
    error = matched_error(data)
    lengths = data["response_lengths"]["secant_below_constant"].astype(bool)
    cdc = error.sel(damping_model="CDC")
    cdr_below = error.sel(damping_model="CDR") < cdc
    sdr_below = error.sel(damping_model="SDR") < cdc
    parts = {"CDR": bool(cdr_below.all()), "SDR": bool(sdr_below.all())}
    numbers = list_models(error.mean("restitution"))
    finding = (
        "Root mean square error, divided by the release amplitude and averaged over e. Both are"
        f" lower than that of CDC at {count_cases(cdr_below & sdr_below)}; this is so at all"
        f" values of e for {int(lengths.sum())} of {lengths.size} response lengths."
    )
    return Judgement(parts, numbers, finding)


def err_range(data: Datasets, limits: Limits) -> Judgement:
    """Find the model with the smallest error at each e, at the length inferred from this claim."""
    lengths = data["response_lengths"]
    inferred_length = float(lengths["inferred_response_length"])
    inferred = lengths["error"].sel(response_length=inferred_length, method="nearest")
    error = inferred.sel(damping_model=MODELS).transpose("damping_model", "restitution")
    best_model = np.array(MODELS)[error.argmin("damping_model")]
    low, high = limits["range"]
    e = error["restitution"].values
    # The range includes its ends, to rounding.
    is_inside = (e > low - 1e-9) & (e < high + 1e-9)
    cdr = best_model[is_inside] == "CDR"
    sdr = best_model[~is_inside] == "SDR"
    other_lengths = lengths["misclassified"].drop_sel(response_length=inferred["response_length"])
    parts = {"CDR within": bool(cdr.all()), "SDR outside": bool(sdr.all())}
    numbers = f"CDR {cdr.sum()} of {cdr.size} values of e, SDR {sdr.sum()} of {sdr.size}"
    finding = (
        "Number of values of e at which the model has the smallest error, for a response length of"
        f" τ = {plain(inferred['response_length'])}. At every other length of the study the claim"
        f" fails at {int(other_lengths.min())} or more values of e."
    )
    return Judgement(parts, numbers, finding)


def err_e(data: Datasets, limits: Limits) -> Judgement:
    """Follow the error over e, model by model."""
    error = several(matched_error(data), "restitution")
    steps = error.sizes["restitution"] - 1
    # e ascends, so an error that falls here rises towards the lower e.
    rising = (error.diff("restitution") < 0).sum("restitution")
    every_length = data["response_lengths"]["error_rises_as_restitution_falls"]
    all_rise = every_length.sel(damping_model=MODELS).all("damping_model")

    def write_count(count: float) -> str:
        return f"{int(count)} of {steps}"

    parts = {model: int(rising.sel(damping_model=model)) == steps for model in MODELS}
    numbers = list_models(rising, write_count)
    finding = (
        "Number of steps to the next lower e at which the error rises. The errors of all three"
        f" models rise at every step only for response lengths of τ = {spans(all_rise)}."
    )
    return Judgement(parts, numbers, finding)


def cdc_poor(data: Datasets, limits: Limits) -> Judgement:
    """Compare dependence on the amplitude and error of CDC with those of the others."""
    error = matched_error(data).mean("restitution")
    amplitude = amplitude_spread(data, limits)
    parts = {
        "most dependent on amplitude": bool(is_largest(amplitude, "CDC")),
        "largest error": bool(is_largest(error, "CDC")),
    }
    numbers = f"spread {list_models(amplitude)}; error {list_models(error)}"
    finding = (
        "The spread of ξ over the amplitudes of Fig. 5, and the root mean square error divided by"
        " the release amplitude; both are averaged over e."
    )
    return Judgement(parts, numbers, finding)


def best_cdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare the dependence of CDR on amplitude and stiffness with that of the others."""
    amplitude = amplitude_spread(data, limits)
    fits = select_fits(data, limits)
    stiffness = mean_spread(fits, A1)
    error = matched_error(data).mean("restitution")
    errors = data["response_lengths"]["rms_error"].sel(damping_model=MODELS).mean("restitution")
    parts = {
        "least dependent on amplitude": bool(is_smallest(amplitude, "CDR")),
        "least dependent on a1": bool(is_smallest(stiffness, "CDR")),
    }
    numbers = f"amplitude {list_models(amplitude)}; a1 {list_models(stiffness)}"
    finding = (
        f"Spread of ξ, averaged over e, over the amplitudes of Fig. 5 and over a1 from"
        f" {extremes(fits[A1], plain)}. The mean error is {list_models(error)}; that of CDR is the"
        f" smallest for response lengths of τ = {spans(is_smallest(errors, 'CDR'))}."
    )
    return Judgement(parts, numbers, finding)


def good_sdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare the error of SDR with a limit and with that of CDC."""
    error = matched_error(data).mean("restitution")
    sdr = error.sel(damping_model="SDR")
    cdc = error.sel(damping_model="CDC")
    parts = {"error": bool(sdr <= limits["small"]) and bool(sdr < cdc)}
    numbers = f"SDR {percent(sdr)}"
    finding = (
        "Root mean square error, divided by the release amplitude and averaged over e. The error"
        f" of CDC is {percent(cdc)}."
    )
    return Judgement(parts, numbers, finding)
