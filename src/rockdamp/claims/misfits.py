"""Judge the claims on the error of the matches, and on which model is best: sections 6 and 8."""

from __future__ import annotations

from dataclasses import replace

import xarray as xr
from scipy.stats import spearmanr

from rockdamp.claims.ratios import MODELS, is_smallest, mean_spread, papers, ratios, spans_of
from rockdamp.claims.verdicts import (
    Limits,
    Measured,
    Part,
    brief,
    by_id,
    judged,
    measured,
    number,
    per_model,
    percent,
    spans,
    steady,
    words_by_model,
)
from rockdamp.storage.dataset import Datasets

ROUNDING = 1e-9


def matched_error(data: Datasets) -> xr.DataArray:
    """Return rms_error (damping_model, restitution) at the matched length, released at the reference amplitude."""
    reference = float(data["damping_force"]["release_amplitude"])
    at_reference = data["match/amplitude"]["rms_error"].sel(release_amplitude=reference, method="nearest")
    return at_reference.sel(damping_model=MODELS).sortby("restitution")


def mean_errors(data: Datasets) -> tuple[xr.DataArray, tuple[Measured, ...]]:
    """Return the mean over e for each model over the release amplitude, and the same in words."""
    mean = matched_error(data).mean("restitution")
    relative = mean / float(data["damping_force"]["release_amplitude"])
    return relative, measured(f"mean rms error {per_model(relative, percent)} of the release")


def lengths(held: xr.DataArray, claim: str) -> Part:
    """Return a part that holds at every length of the response, or at some."""
    holds = held.astype(bool)
    count = f"{claim} at {int(holds.sum())} of {holds.size} lengths"
    return judged(holds, measured(count, spans(holds, "tau")), "tau")


def err_secant(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the errors of CDR and SDR with those of CDC."""
    error = matched_error(data)
    held = error.sel(damping_model=["CDR", "SDR"]).max("damping_model") < error.sel(damping_model="CDC")
    mean, mean_in_words = mean_errors(data)
    below = measured(f"both below CDC at {spans_of(held)}")
    finding = {**words_by_model(mean), "both": spans_of(held)}
    return {
        "matched": judged(held, below + mean_in_words, "e", limits["enough"], finding),
        "lengths": lengths(data["response_lengths"]["secant_below_constant"], "below CDC at every e"),
    }


def err_range(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Name the model that errs least at each e, at the inferred length."""
    response_lengths = data["response_lengths"]
    inferred = response_lengths["error"].sel(
        response_length=float(response_lengths["inferred_response_length"]), method="nearest"
    )
    error = inferred.sel(damping_model=MODELS).transpose("damping_model", ...)
    lowest = error["damping_model"][error.argmin("damping_model")].drop_vars("damping_model")
    e = error["restitution"]
    in_range = (e >= limits["low"] - ROUNDING) & (e <= limits["high"] + ROUNDING)
    exact = spans(response_lengths["cdr_lowest_in_paper_range"], "tau")
    wrong = response_lengths["misclassified"].drop_sel(response_length=inferred["response_length"])
    others = measured(f"at least {int(wrong.min())} misfits at any other length studied") if wrong.size else ()
    near = response_lengths["near_misclassified"]
    none, few = spans(near == 0, "tau"), spans(near <= 2, "tau")
    others += measured(f"between those next to it none at {none}, at most 2 at {few}")
    length = response_lengths["inferred_response_length_of_release"].dropna("release_amplitude")
    implied = ", ".join(
        f"{number(at)} (u0/u_ins {number(release)})"
        for release, at in zip(length["release_amplitude"].values, length.values, strict=True)
    )
    others += measured("other releases would imply other lengths", implied)
    parts = {}
    for name, model, where in (("inside", "CDR", in_range), ("outside", "SDR", ~in_range)):
        held = (lowest == model)[where.values]
        at = f", at {number(inferred['response_length'])} in tau" if name == "outside" else ""
        lowest_at = measured(f"{model} lowest at {spans_of(held)} {name}{at}")
        parts[name] = judged(held, lowest_at, "e", limits["enough"], {name: spans_of(held)})
    last = parts["outside"]
    all_measured = last.measured + measured(f"the range is exactly so for {exact}") + others
    finding = {
        "response_length": number(inferred["response_length"]),
        "elsewhere": f"At any other it misses at least {int(wrong.min())} e" if wrong.size else "No other was studied",
    }
    return parts | {"outside": replace(last, measured=all_measured, finding={**last.finding, **finding})}


def err_e(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Follow the error over e, model by model."""
    error = matched_error(data)
    rises = steady(error, "restitution", -1)
    steps = (error.diff("restitution") < 0).sum("restitution")
    count = error.sizes["restitution"] - 1
    correlation = xr.DataArray(
        [spearmanr(error["restitution"], errors).statistic for errors in error.transpose("damping_model", ...).values],
        coords={"damping_model": MODELS},
    )
    parts = {}
    for model in MODELS:
        rising = int(steps.sel(damping_model=model))
        steps_up = measured(f"{model} rises at {rising} of {count} steps to lower e")
        finding = {model.lower(): f"{rising} of {count}"}
        parts[model.lower()] = Part(bool(rises.sel(damping_model=model)), steps_up, finding)
    parts["trend"] = Part(
        bool((correlation <= limits["correlation"]).all()), measured(f"rank correlation {per_model(correlation)}")
    )
    flag = data["response_lengths"]["error_rises_as_restitution_falls"].sel(damping_model=MODELS)
    by_model = ", ".join(f"{model} {spans(flag.sel(damping_model=model), 'tau')}" for model in MODELS)
    together = lengths(flag.all("damping_model"), "all rise at every step")
    (item,) = together.measured
    return parts | {"lengths": replace(together, measured=measured(item.quantity, f"{item.values[0]} ({by_model})"))}


def best_cdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare error and dependence of CDR with those of the others."""
    error, mean_in_words = mean_errors(data)
    amplitudes = papers(ratios(data["match/amplitude"]), limits["release_amplitudes"])
    amplitude = mean_spread(amplitudes, "release_amplitude")
    stiffness = mean_spread(ratios(data["match/cracked_stiffness"]), "yield_displacement_ratio")
    of_lengths = data["response_lengths"]["rms_error"].sel(damping_model=MODELS).mean("restitution")
    parts = {}
    for name, values, in_words in (
        ("error", error, mean_in_words),
        ("amplitude", amplitude, measured(f"spread over amplitude {per_model(amplitude, percent)}")),
        ("stiffness", stiffness, measured(f"over a1 {per_model(stiffness, percent)}")),
    ):
        cdr, others = values.sel(damping_model="CDR"), values.drop_sel(damping_model="CDR")
        finding = {name: brief(cdr), f"{name}_others": brief(others.min())}
        parts[name] = Part(bool(is_smallest(values, "CDR")), in_words, finding)
    return parts | {"lengths": lengths(is_smallest(of_lengths, "CDR"), "CDR errs least")}


def good_sdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the error of SDR with a limit and with the others'."""
    error, mean_in_words = mean_errors(data)
    sdr, cdc = error.sel(damping_model="SDR"), error.sel(damping_model="CDC")
    times = float(sdr / error.min("damping_model"))
    of_lengths = data["response_lengths"]["rms_error"].mean("restitution")
    below = of_lengths.sel(damping_model="SDR").drop_vars("damping_model") < of_lengths.sel(damping_model="CDC")
    return {
        "small": Part(bool(sdr <= limits["small"]), mean_in_words, words_by_model(error)),
        "better": Part(bool(sdr < cdc)),
        "near": Part(times <= limits["near"], measured(f"SDR {number(times)} times the lowest")),
        "lengths": lengths(below.drop_vars("damping_model", errors="ignore"), "below CDC in the mean"),
    }


JUDGES = by_id(err_secant, err_range, err_e, best_cdr, good_sdr)
