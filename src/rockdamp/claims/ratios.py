"""Judge the claims on the damping ratio that matches a decay, its error, and the best model: sections 6 to 8."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from rockdamp.claims.verdicts import (
    Judge,
    Limits,
    Measured,
    Part,
    between,
    brief,
    by_id,
    judged,
    listed,
    measured,
    number,
    per_model,
    percent,
    spans,
    steady,
    words_by_model,
)
from rockdamp.constants import PAPER_MODELS
from rockdamp.storage.dataset import Datasets

MODELS = list(PAPER_MODELS)
ROUNDING = 1e-9
OTHERS = {"slenderness": "slenderness", "overburden_ratio": "overburden"}  # what a1 is compared with: dimension, study


def ratios(matched: xr.Dataset, variable: str = "damping_ratio") -> xr.DataArray:
    """Select the paper's models and, in the cracked-stiffness study, the a1 that have the plateau of the first."""
    xi = matched[variable].sel(damping_model=MODELS)
    if "strength_ratio" in matched.coords:
        plateau = matched["strength_ratio"].values
        xi = xi.isel(yield_displacement_ratio=np.flatnonzero(np.isclose(plateau, plateau[0])))
    return xi


def paper_amplitudes(xi: xr.DataArray, amplitudes: list[float]) -> xr.DataArray:
    """Select the release amplitudes of the paper; all in a study that holds fewer than two of those."""
    in_paper = [i for i, x0 in enumerate(xi["release_amplitude"].values) if np.isclose(x0, amplitudes).any()]
    return xi.isel(release_amplitude=in_paper) if len(in_paper) > 1 else xi


def spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return (largest - smallest)/mean over `dim`."""
    return (xi.max(dim) - xi.min(dim)) / xi.mean(dim)


def mean_spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return the spread over `dim`, mean over e: one value for each model."""
    return spread(xi, dim).mean("restitution")


def spreads(values: xr.DataArray) -> str:
    """Return the spreads in percent. Where no digit differs, the equations do not hold the parameter."""
    return "identical by the equations, one case" if not values.values.any() else per_model(values, percent)


def is_largest(values: xr.DataArray, model: str) -> xr.DataArray:
    """Return true where `model` has the largest of the models' values."""
    return (values.sel(damping_model=model) > values.drop_sel(damping_model=model)).all("damping_model")


def is_smallest(values: xr.DataArray, model: str) -> xr.DataArray:
    """Return true where `model` has the smallest of the models' values."""
    return is_largest(-values, model)


def extent(values: xr.DataArray, symbol: str) -> str:
    """Return the range of a parameter in words: ``u0/u_ins 0.3 to 0.9``."""
    return f"{symbol} {number(values.min())} to {number(values.max())}"


# --- amplitude -----------------------------------------------------------------------------------------------------


def _amplitude_sets(limits: Limits, data: Datasets) -> dict[str, xr.DataArray]:
    wide = ratios(data["match/amplitude"])
    return {"paper": paper_amplitudes(wide, limits["release_amplitudes"]), "wide": wide}


def _spread_over_amplitude(xi: xr.DataArray) -> tuple[xr.DataArray, tuple[Measured, ...]]:
    values = mean_spread(xi, "release_amplitude")
    over = extent(xi["release_amplitude"], "u0/u_ins")
    return values, measured(f"spread over {over}", per_model(values, percent))


def amp_cdc(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare CDC's spread over amplitude with the others'."""
    parts = {}
    for name, xi in _amplitude_sets(limits, data).items():
        values, in_words = _spread_over_amplitude(xi)
        finding = words_by_model(values) if name == "paper" else {}
        parts[name] = Part(bool(is_largest(values, "CDC")), in_words, finding)
    return parts


def amp_cdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare CDR's spread over amplitude with a limit."""
    spreads = {name: _spread_over_amplitude(xi) for name, xi in _amplitude_sets(limits, data).items()}
    values, in_words = spreads["paper"]
    widest, widest_in_words = spreads["wide"]
    return {
        "slight": Part(
            bool(values.sel(damping_model="CDR") <= limits["slight"]),
            in_words,
            finding={"paper": brief(values.sel(damping_model="CDR")), "wide": brief(widest.sel(damping_model="CDR"))},
        ),
        "least": Part(bool(is_smallest(values, "CDR"))),
        "wide": Part(bool(widest.sel(damping_model="CDR") <= limits["slight"]), widest_in_words),
    }


SIGNS = {"CDC": -1, "CDR": -1, "SDR": 1}  # of the change of xi with amplitude, as the claim has it


def amp_sign(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Follow the direction of the change with amplitude at each e."""
    sets, parts = _amplitude_sets(limits, data), {}
    everywhere = []
    for model, sign in SIGNS.items():
        xi, wide = (values.sel(damping_model=model) for values in sets.values())
        held = steady(xi, "release_amplitude", sign)
        ends = xi.sortby("release_amplitude").isel(release_amplitude=[0, -1]).mean("restitution").values
        change = f"{number(ends[0])} to {number(ends[1])}"
        in_words, name = measured(f"{model} mean xi {change} ({spans_of(held)})"), model.lower()
        parts[name] = judged(held, in_words, "e", limits["enough"], {name: change})
        everywhere.append(steady(wide, "release_amplitude", sign))
    sdr = mean_spread(sets["paper"], "release_amplitude").sel(damping_model="SDR")
    of_sdr = measured(f"spread of SDR {percent(sdr)}")
    parts["sdr-slightly"] = Part(bool(sdr <= limits["slight"]), of_sdr, {"spread": brief(sdr)})
    wide_held = everywhere[0] & everywhere[1] & everywhere[2]
    counts = listed(f"{model} {spans_of(held)}" for model, held in zip(SIGNS, everywhere, strict=True))
    parts["wide"] = judged(wide_held, measured("all amplitudes", counts), "e", limits["enough"])
    return parts


def spans_of(held: xr.DataArray) -> str:
    """Count the cases that hold: ``28 of 29 e``."""
    return f"{int(held.sum())} of {held.size} e"


def amp_dispersion(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Divide the dispersion over amplitude at high e by that at low e."""
    xi = _amplitude_sets(limits, data)["paper"].sortby("restitution")
    dispersions = {
        "absolute": xi.max("release_amplitude") - xi.min("release_amplitude"),
        "relative": spread(xi, "release_amplitude"),
    }
    third = max(xi.sizes["restitution"] // 3, 1)
    parts: dict[str, Part] = {}
    for name, dispersion in dispersions.items():
        low, high = (dispersion.isel(restitution=part) for part in (slice(None, third), slice(-third, None)))
        growth = high.mean("restitution") / low.mean("restitution")
        growth_in_words = measured(f"{name}, high over low e", per_model(growth))
        held = growth > limits["more"]
        parts[name] = judged(held, growth_in_words, "models", limits["enough"], {name: between(growth, number)})
    return parts


def low_amp(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare CDR and SDR at the lowest amplitude with those at the reference."""
    xi = ratios(data["match/amplitude"]).sortby("release_amplitude")
    low = xi.isel(release_amplitude=0)
    reference = xi.sel(release_amplitude=float(data["damping_force"]["release_amplitude"]), method="nearest")
    gap, gap_reference = (
        float(np.abs(ratio.sel(damping_model="SDR") / ratio.sel(damping_model="CDR") - 1).mean())
        for ratio in (low, reference)
    )
    excess = (reference / low).sel(damping_model="SDR") - 1
    names = [f"u0/u_ins {number(ratio['release_amplitude'])}" for ratio in (low, reference)]
    mean, ends = float(excess.mean()), f"{percent(excess.min())} to {percent(excess.max())} more"
    more = measured(f"xi of SDR at {names[1]} over that at {names[0]}", ends)
    return {
        "together": Part(
            gap <= limits["closer"] * gap_reference,
            measured(f"SDR and CDR differ by {percent(gap)} at {names[0]}, {percent(gap_reference)} at {names[1]}"),
            finding={"gap": brief(gap), "gap_reference": brief(gap_reference)},
        ),
        "overdamps": judged(excess > 0, more, "e", limits["enough"]),
        "slightly": Part(
            bool(mean > 0) & bool(mean <= limits["slight"]),
            measured(f"in the mean {percent(mean)}"),
            finding={
                "excess": brief(mean),
                "low": number(low["release_amplitude"]),
                "reference": number(reference["release_amplitude"]),
            },
        ),
    }


# --- the wall's parameters -----------------------------------------------------------------------------------------


def _independence(dim: str, study: str) -> Judge:
    def judge(limits: Limits, data: Datasets) -> dict[str, Part]:
        """Compare the spread over a parameter that should not matter with a limit."""
        parts = {}
        for name, variable in (("tau", "damping_ratio"), ("seconds", "damping_ratio_fixed_seconds")):
            values = spread(ratios(data[study], variable), dim).max("restitution")
            in_words = measured(f"equal {name}", spreads(values))
            parts[name] = Part(bool((values <= limits[name]).all()), in_words, {f"in_{name}": brief(values.max())})
        return parts

    return judge


def a1_most(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the spread over a1 with those over slenderness and overburden."""
    a1 = mean_spread(ratios(data["match/cracked_stiffness"]), "yield_displacement_ratio")
    parts: dict[str, Part] = {}
    for name, variable in (("tau", "damping_ratio"), ("seconds", "damping_ratio_fixed_seconds")):
        others = {dim: mean_spread(ratios(data[f"match/{study}"], variable), dim) for dim, study in OTHERS.items()}
        held = xr.concat(list(others.values()), "parameter").max("parameter") * limits["times"] < a1
        of_others = [f"{dim.split('_')[0]} {spreads(values)}" for dim, values in others.items()]
        of_a1 = () if parts else measured("spread", f"a1 {per_model(a1, percent)}")
        largest = max(float(values.max()) for values in others.values())
        finding = {**words_by_model(a1), f"in_{name}": brief(largest)}
        in_words = of_a1 + measured(f"equal {name}", *of_others)
        parts[name] = judged(held, in_words, "models", limits["enough"], finding)
    return parts


def a1_rank(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Rank the models' spreads over a1."""
    xi = ratios(data["match/cracked_stiffness"])
    at_each, dim = spread(xi, "yield_displacement_ratio"), "yield_displacement_ratio"
    values = at_each.mean("restitution")
    held = is_largest(at_each, "CDC") & is_smallest(at_each, "CDR")
    ranked = spans_of(held)
    return {
        "cdc": Part(
            bool(is_largest(values, "CDC")),
            measured(f"spread over {extent(xi[dim], 'a1')}", per_model(values, percent)),
            finding={**words_by_model(values), "low": number(xi[dim].min()), "high": number(xi[dim].max())},
        ),
        "cdr": Part(bool(is_smallest(values, "CDR"))),
        "each": judged(held, measured(f"so ranked at {ranked}"), "e", limits["enough"], {"ranked": ranked}),
    }


def a1_sign(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Follow the direction of the change with a1 at each e."""
    xi, dim = ratios(data["match/cracked_stiffness"]).sortby("yield_displacement_ratio"), "yield_displacement_ratio"
    parts = {}
    for name, model in (("cdc", "CDC"), ("cdr", "CDR")):
        held = steady(xi.sel(damping_model=model), dim, 1)
        ends = xi.sel(damping_model=model).isel({dim: [0, -1]}).mean("restitution").values
        change = f"{number(ends[0])} to {number(ends[1])}"
        in_words = measured(f"{model} mean xi {change} (less at low a1 for {spans_of(held)})")
        parts[name] = judged(held, in_words, "e", limits["enough"], {name: change})
    return parts


def fit_order(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the polynomials with Eq. (15)."""
    fits, enough = data["equivalence"], limits["enough"]
    xi = fits["damping_ratio_fit"].sel(damping_model=MODELS)
    relative = xi / fits["giannini_masiani"] - 1
    parts = {}
    for name, model, sign in (("cdc", "CDC", -1), ("sdr", "SDR", 1), ("cdr", "CDR", -1)):
        of_model = relative.sel(damping_model=model)
        held = sign * of_model > 0
        in_words = measured(f"{model} {percent(of_model.min())} to {percent(of_model.max())} against (15)")
        partly = f"{percent(held.mean())} of e and a1" if float(held.mean()) >= enough else ""
        finding = {name: between(of_model)}
        parts[name] = Part(bool(held.all()), in_words, finding, "" if held.all() else partly)
    apart = float(np.abs(relative.sel(damping_model="CDR")).mean())
    values = mean_spread(xi, "yield_displacement_ratio")
    off = measured(f"CDR off by {percent(apart)} in the mean")
    parts["cdr-slightly"] = Part(apart <= limits["slight"], off, {"apart": brief(apart)})
    parts["cdr-a1"] = Part(
        bool(is_smallest(values, "CDR")),
        measured(f"spread over {extent(xi['yield_displacement_ratio'], 'a1')}", per_model(values, percent)),
    )
    return parts


# --- error of the matches -------------------------------------------------------------------------------------------


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
    others = measured(f"at least {int(wrong.min())} misfits at any other whole tau studied") if wrong.size else ()
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
        "elsewhere": f"At every other whole τ studied at least {int(wrong.min())} e differ"
        if wrong.size
        else "No other was studied",
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
    amplitudes = paper_amplitudes(ratios(data["match/amplitude"]), limits["release_amplitudes"])
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


JUDGES = by_id(amp_cdc, amp_cdr, amp_sign, amp_dispersion, a1_most, a1_rank, a1_sign, fit_order, low_amp)
JUDGES |= by_id(err_secant, err_range, err_e, best_cdr, good_sdr)
JUDGES |= {
    "slenderness": _independence("slenderness", "match/slenderness"),
    "overburden": _independence("overburden_ratio", "match/overburden"),
}
