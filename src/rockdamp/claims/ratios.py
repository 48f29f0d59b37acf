"""Judge the claims on the damping ratio that matches a decay, its error, and the best model: sections 6 to 8."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr

from rockdamp.claims.decays import Judgement, Limits, extremes, list_models
from rockdamp.constants import PAPER_MODELS
from rockdamp.storage.dataset import Datasets
from rockdamp.text import number, percent, plain

MODELS = list(PAPER_MODELS)
A1, RELEASE = "yield_displacement_ratio", "release_amplitude"
short = partial(number, digits=2)


def ratios(matched: xr.Dataset, variable: str = "damping_ratio") -> xr.DataArray:
    """Select the paper's models and, in the cracked-stiffness study, the a1 that have the plateau of the first."""
    xi = matched[variable].sel(damping_model=MODELS)
    if "strength_ratio" in matched.coords:
        plateau = matched["strength_ratio"].values
        xi = xi.isel({A1: np.flatnonzero(np.isclose(plateau, plateau[0]))})
    return xi


def paper_amplitudes(data: Datasets, limits: Limits) -> xr.DataArray:
    """Select the release amplitudes of Fig. 5; all in a study that holds fewer than two of those."""
    xi = ratios(data["match/amplitude"]).sortby(RELEASE)
    selected = np.isclose(xi[RELEASE].values[:, None], limits["release_amplitudes"]).any(axis=1)
    return xi.isel({RELEASE: selected}) if selected.sum() > 1 else xi


def spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return (largest - smallest)/mean over `dim`."""
    return (xi.max(dim) - xi.min(dim)) / xi.mean(dim)


def mean_spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return the spread over `dim`, mean over e: one value for each model."""
    return spread(xi, dim).mean("restitution")


def largest(values: xr.DataArray, model: str) -> xr.DataArray:
    """Return true where `model` has the largest of the models' values."""
    return (values.sel(damping_model=model) > values.drop_sel(damping_model=model)).all(
        "damping_model"
    )


def steady(values: xr.DataArray, dim: str, sign: int) -> xr.DataArray:
    """Return true where `values` change with that sign from each coordinate of `dim` to the next."""
    return (sign * values.sortby(dim).diff(dim) > 0).all(dim)


def spans(held: xr.DataArray) -> str:
    """Write where a condition of one dimension holds: ``3 to 5, 8``, or ``none``."""
    values, true = held[held.dims[0]].values, np.flatnonzero(held.values.astype(bool))
    runs = np.split(true, np.flatnonzero(np.diff(true) > 1) + 1) if true.size else []
    ends = [(plain(values[run[0]]), plain(values[run[-1]])) for run in runs]
    return (
        ", ".join(first if first == last else f"{first} to {last}" for first, last in ends)
        or "none"
    )


def count_cases(held: xr.DataArray) -> str:
    """Count the e that hold: ``28 of 29 e``."""
    return f"{int(held.sum())} of {held.size} e"


def ends(xi: xr.DataArray, dim: str) -> dict[str, str]:
    """Write each model's mean over e at the smallest and at the largest of a parameter."""
    means = xi.sortby(dim).isel({dim: [0, -1]}).mean("restitution").transpose("damping_model", dim)
    return {
        model: f"{number(low)} to {number(high)}"
        for model, (low, high) in zip(MODELS, means.values, strict=True)
    }


# --- amplitude -------------------------------------------------------------------------------------------------------


def amp_cdc(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDC's spread over amplitude with the others'."""
    xi = paper_amplitudes(data, limits)
    values = mean_spread(xi, RELEASE)
    return (
        {"CDC": bool(largest(values, "CDC"))},
        list_models(values),
        f"Spread of ξ over releases from {extremes(xi[RELEASE], plain)} u_ins, mean over e.",
    )


def amp_cdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR's spread over amplitude with a limit."""
    studied = ratios(data["match/amplitude"])
    paper, wide = (
        mean_spread(xi, RELEASE).sel(damping_model="CDR")
        for xi in (paper_amplitudes(data, limits), studied)
    )
    return (
        {"CDR": bool(paper <= limits["slight"])},
        f"CDR {percent(paper)}",
        f"Over all releases that were studied, from {extremes(studied[RELEASE], plain)} u_ins, it is {percent(wide)}.",
    )


def amp_sign(data: Datasets, limits: Limits) -> Judgement:
    """Follow the direction of the change with amplitude at each e."""
    xi = paper_amplitudes(data, limits)
    signs = {"CDC less": ("CDC", -1), "CDR less": ("CDR", -1), "SDR more": ("SDR", 1)}
    parts = {
        part: bool(steady(xi.sel(damping_model=model), RELEASE, sign).all())
        for part, (model, sign) in signs.items()
    }
    sdr = mean_spread(xi, RELEASE).sel(damping_model="SDR")
    return (
        parts | {"SDR slightly": bool(sdr <= limits["slight"])},
        ", ".join(f"{model} {values}" for model, values in ends(xi, RELEASE).items()),
        f"Mean ξ at the smallest and at the largest amplitude of Fig. 5; SDR's spread is {percent(sdr)}.",
    )


def amp_dispersion(data: Datasets, limits: Limits) -> Judgement:
    """Divide the dispersion over amplitude at high e by that at low e, in the axis of Fig. 5."""
    xi = paper_amplitudes(data, limits).sortby("restitution")
    third = max(xi.sizes["restitution"] // 3, 1)
    growth, relative = (
        dispersion.isel(restitution=slice(-third, None)).mean("restitution")
        / dispersion.isel(restitution=slice(None, third)).mean("restitution")
        for dispersion in (xi.max(RELEASE) - xi.min(RELEASE), spread(xi, RELEASE))
    )
    return (
        {"dispersion": bool((growth > limits["more"]).all())},
        list_models(growth, short),
        "Dispersion of ξ at high e over that at low e, in the axis of Fig. 5; as a fraction of the mean ξ it is"
        f" {extremes(relative, short)}.",
    )


def low_amp(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR and SDR at the lowest amplitude with those at the reference."""
    xi = ratios(data["match/amplitude"]).sortby(RELEASE)
    low = xi.isel({RELEASE: 0})
    reference = xi.sel({RELEASE: float(data["damping_force"][RELEASE])}, method="nearest")
    gap, gap_reference = (
        float(np.abs(ratio.sel(damping_model="SDR") / ratio.sel(damping_model="CDR") - 1).mean())
        for ratio in (low, reference)
    )
    excess = (reference / low).sel(damping_model="SDR") - 1
    mean = float(excess.mean())
    return (
        {
            "CDR and SDR come together": gap <= limits["closer"] * gap_reference,
            "SDR overdamps": bool((excess > 0).all()),
            "slightly": mean <= limits["slight"],
        },
        f"SDR {percent(mean)} more",
        f"ξ of SDR differs from that of CDR by {percent(gap)} at {plain(low[RELEASE])} u_ins and by"
        f" {percent(gap_reference)} at {plain(reference[RELEASE])} u_ins, mean over e.",
    )


# --- the wall's parameters -------------------------------------------------------------------------------------------


def _independence(matched: xr.Dataset, dim: str, limits: Limits) -> Judgement:
    tau, seconds = (
        spread(ratios(matched, variable), dim).max()
        for variable in ("damping_ratio", "damping_ratio_fixed_seconds")
    )
    return (
        {"damping ratios": bool(tau <= limits["same"])},
        percent(tau),
        "The dimensionless equations do not contain the parameter; of responses that are equally long in seconds ξ"
        f" differs by up to {percent(seconds)}.",
    )


def slenderness(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over the slenderness with a limit."""
    return _independence(data["match/slenderness"], "slenderness", limits)


def overburden(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over the overburden with a limit."""
    return _independence(data["match/overburden"], "overburden_ratio", limits)


def a1_most(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over a1 with those over slenderness and overburden, equally long in seconds."""
    a1 = mean_spread(ratios(data["match/cracked_stiffness"]), A1)
    others = [
        mean_spread(ratios(data[f"match/{study}"], "damping_ratio_fixed_seconds"), dim)
        for study, dim in (("slenderness", "slenderness"), ("overburden", "overburden_ratio"))
    ]
    other = xr.concat(others, "parameter").max("parameter")
    return (
        {"a1": bool((a1 > other).all())},
        f"a1 {list_models(a1)}",
        f"Over slenderness and overburden it is at most {percent(other.max())}, and only of responses that are equally"
        " long in seconds.",
    )


def a1_rank(data: Datasets, limits: Limits) -> Judgement:
    """Rank the models' spreads over a1."""
    xi = ratios(data["match/cracked_stiffness"])
    spreads = spread(xi, A1)
    values = spreads.mean("restitution")
    ranked = largest(spreads, "CDC") & largest(-spreads, "CDR")
    return (
        {"CDC most": bool(largest(values, "CDC")), "CDR least": bool(largest(-values, "CDR"))},
        list_models(values),
        f"Spread of ξ over a1 from {extremes(xi[A1], plain)}, mean over e; the rank is this at {count_cases(ranked)}.",
    )


def a1_sign(data: Datasets, limits: Limits) -> Judgement:
    """Follow the direction of the change with a1 at each e."""
    xi = ratios(data["match/cracked_stiffness"])
    change, sdr = ends(xi, A1), xi.sel(damping_model="SDR")
    return (
        {
            f"{model} less": bool(steady(xi.sel(damping_model=model), A1, 1).all())
            for model in ("CDC", "CDR")
        },
        f"CDC {change['CDC']}, CDR {change['CDR']}",
        "Mean ξ at the lowest and at the highest a1. SDR, of which the text says both, needs more at lower a1 at"
        f" {count_cases(steady(sdr, A1, -1))}.",
    )


def fit_order(data: Datasets, limits: Limits) -> Judgement:
    """Compare the polynomials with Eq. (15)."""
    xi = data["equivalence"]["damping_ratio_fit"].sel(damping_model=MODELS)
    cdc, cdr, sdr = (
        xi.sel(damping_model=model) / data["equivalence"]["giannini_masiani"] - 1
        for model in MODELS
    )
    apart = float(np.abs(cdr).mean())
    return (
        {
            "CDC below": bool((cdc < 0).all()),
            "SDR above": bool((sdr > 0).all()),
            "CDR below": bool((cdr < 0).all()),
            "CDR slightly": apart <= limits["slight"],
            "CDR least dependent on a1": bool(largest(-mean_spread(xi, A1), "CDR")),
        },
        f"CDC {extremes(cdc)}, CDR {extremes(cdr)}, SDR {extremes(sdr)}",
        f"CDR differs from Eq. (15) by {percent(apart)} in the mean; it lies below at {percent((cdr < 0).mean())} of"
        " all e and a1.",
    )


# --- error of the matches --------------------------------------------------------------------------------------------


def matched_error(data: Datasets) -> xr.DataArray:
    """Return rms_error (damping_model, restitution) at the matched length, over the release amplitude of reference."""
    release = float(data["damping_force"][RELEASE])
    errors = data["match/amplitude"]["rms_error"].sel({RELEASE: release}, method="nearest")
    return errors.sel(damping_model=MODELS).sortby("restitution") / release


def err_secant(data: Datasets, limits: Limits) -> Judgement:
    """Compare the errors of CDR and SDR with those of CDC."""
    error, lengths = (
        matched_error(data),
        data["response_lengths"]["secant_below_constant"].astype(bool),
    )
    below = {
        model: error.sel(damping_model=model) < error.sel(damping_model="CDC")
        for model in ("CDR", "SDR")
    }
    return (
        {model: bool(lower.all()) for model, lower in below.items()},
        list_models(error.mean("restitution")),
        f"Root mean square over the release, mean over e; both are lower at {count_cases(below['CDR'] & below['SDR'])},"
        f" and at every e at {int(lengths.sum())} of {lengths.size} lengths of the response.",
    )


def err_range(data: Datasets, limits: Limits) -> Judgement:
    """Name the model that errs least at each e, at the length that was inferred from this claim."""
    lengths = data["response_lengths"]
    inferred = lengths["error"].sel(
        response_length=float(lengths["inferred_response_length"]), method="nearest"
    )
    error = inferred.sel(damping_model=MODELS).transpose("damping_model", "restitution")
    lowest = np.array(MODELS)[error.argmin("damping_model")]
    low, high = limits["range"]
    inside = ((error["restitution"] > low - 1e-9) & (error["restitution"] < high + 1e-9)).values
    cdr, sdr = lowest[inside] == "CDR", lowest[~inside] == "SDR"
    others = lengths["misclassified"].drop_sel(response_length=inferred["response_length"])
    return (
        {"CDR within": bool(cdr.all()), "SDR outside": bool(sdr.all())},
        f"CDR {cdr.sum()} of {cdr.size} e, SDR {sdr.sum()} of {sdr.size}",
        f"The length of the response, τ = {plain(inferred['response_length'])}, was inferred from this claim, as the"
        f" paper does not state it; at every other length studied at least {int(others.min())} e differ.",
    )


def err_e(data: Datasets, limits: Limits) -> Judgement:
    """Follow the error over e, model by model."""
    error = matched_error(data)
    rising = (error.diff("restitution") < 0).sum("restitution")
    steps = error.sizes["restitution"] - 1
    together = data["response_lengths"]["error_rises_as_restitution_falls"].sel(
        damping_model=MODELS
    )
    return (
        {model: int(rising.sel(damping_model=model)) == steps for model in MODELS},
        list_models(rising, lambda count: f"{int(count)} of {steps}"),
        "Steps from one e to the next lower at which the error rises; all do for all three only where the response is"
        f" τ = {spans(together.all('damping_model'))} long.",
    )


def best_cdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare error and dependence of CDR with those of the others."""
    error = matched_error(data).mean("restitution")
    amplitude = mean_spread(paper_amplitudes(data, limits), RELEASE)
    stiffness = mean_spread(ratios(data["match/cracked_stiffness"]), A1)
    length_errors = (
        data["response_lengths"]["rms_error"].sel(damping_model=MODELS).mean("restitution")
    )
    return (
        {
            "least error": bool(largest(-error, "CDR")),
            "least dependence on amplitude": bool(largest(-amplitude, "CDR")),
            "least dependence on a1": bool(largest(-stiffness, "CDR")),
        },
        f"error {list_models(error)}",
        f"The spread over amplitude is {list_models(amplitude)}, over a1 {list_models(stiffness)}; CDR errs least where"
        f" the response is τ = {spans(largest(-length_errors, 'CDR'))} long.",
    )


def good_sdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare the error of SDR with a limit and with CDC's."""
    error = matched_error(data).mean("restitution")
    sdr, cdc = error.sel(damping_model="SDR"), error.sel(damping_model="CDC")
    return (
        {"error": bool(sdr <= limits["small"]) and bool(sdr < cdc)},
        f"SDR {percent(sdr)}",
        f"Root mean square error over the release, mean over e; CDC's is {percent(cdc)}.",
    )
