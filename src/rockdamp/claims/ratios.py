"""Judge the claims on the damping ratio that matches a decay: Figs 5 to 7 of the paper."""

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
    dispersion,
    extremes,
    falls,
    is_largest,
    is_smallest,
    list_models,
    low_over_high_restitution,
    mean_spread,
    rises,
    select_paper_values,
    several,
    short,
    spread,
)
from rockdamp.storage.dataset import Datasets
from rockdamp.text import number, percent, plain


def ratios(match: xr.Dataset, variable: str = "damping_ratio") -> xr.DataArray:
    """Select the ratios of the paper's models.

    In the study of the cracked stiffness, only the a1 with the same plateau b1 as the first.
    """
    xi = match[variable].sel(damping_model=MODELS)
    if "strength_ratio" not in match.coords:
        return xi
    plateau = match["strength_ratio"].values
    return xi.isel({A1: np.isclose(plateau, plateau[0])})


def select_amplitudes(data: Datasets, limits: Limits) -> xr.DataArray:
    """Select the ratios at the release amplitudes of Fig. 5."""
    xi = ratios(data["match/amplitude"]).sortby(RELEASE)
    return several(select_paper_values(xi, RELEASE, limits["release_amplitudes"]), RELEASE)


def amplitude_spread(data: Datasets, limits: Limits) -> xr.DataArray:
    """Return each model's spread over the amplitudes of Fig. 5, averaged over e."""
    return mean_spread(select_amplitudes(data, limits), RELEASE)


def select_fits(data: Datasets, limits: Limits) -> xr.DataArray:
    """Select the polynomials at the a1 that the paper names with Fig. 7."""
    fits = data["equivalence"]["damping_ratio_fit"].sel(damping_model=MODELS)
    return several(select_paper_values(fits, A1, limits["a1"]), A1)


def list_ends(xi: xr.DataArray, dim: str) -> dict[str, str]:
    """Write each model's mean over e at the smallest and at the largest coordinate of `dim`."""
    means = xi.sortby(dim).isel({dim: [0, -1]}).mean("restitution")
    words = {}
    for model in MODELS:
        low, high = means.sel(damping_model=model).values
        words[model] = f"{number(low)} to {number(high)}"
    return words


# --- amplitude ---------------------------------------------------------------------------------


def amp_cdc(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDC's spread over the amplitude with the others'."""
    xi = select_amplitudes(data, limits)
    spreads = amplitude_spread(data, limits)
    parts = {"CDC": bool(is_largest(spreads, "CDC"))}
    numbers = list_models(spreads)
    finding = (
        f"Spread of ξ over releases from {extremes(xi[RELEASE], plain)} u_ins, averaged over e."
    )
    return Judgement(parts, numbers, finding)


def amp_cdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR's spread over the amplitude with a limit."""
    cdr = amplitude_spread(data, limits).sel(damping_model="CDR")
    all_releases = ratios(data["match/amplitude"])
    wide = mean_spread(all_releases, RELEASE).sel(damping_model="CDR")
    parts = {"CDR": bool(cdr <= limits["slight"])}
    numbers = f"CDR {percent(cdr)}"
    finding = (
        f"Over all releases of the study, from {extremes(all_releases[RELEASE], plain)} u_ins, the"
        f" spread of ξ is {percent(wide)}."
    )
    return Judgement(parts, numbers, finding)


def amp_sign(data: Datasets, limits: Limits) -> Judgement:
    """Follow the change with the amplitude at each e."""
    xi = select_amplitudes(data, limits)
    cdc, cdr, sdr = (xi.sel(damping_model=model) for model in MODELS)
    sdr_spread = mean_spread(sdr, RELEASE)
    ends = list_ends(xi, RELEASE)
    parts = {
        "CDC less": bool(falls(cdc, RELEASE).all()),
        "CDR less": bool(falls(cdr, RELEASE).all()),
        "SDR more": bool(rises(sdr, RELEASE).all()),
        "SDR slightly": bool(sdr_spread <= limits["slight"]),
    }
    numbers = ", ".join(f"{model} {words}" for model, words in ends.items())
    finding = (
        "Mean ξ at the smallest and at the largest amplitude of Fig. 5. The spread of SDR is"
        f" {percent(sdr_spread)}."
    )
    return Judgement(parts, numbers, finding)


def amp_dispersion(data: Datasets, limits: Limits) -> Judgement:
    """Divide the dispersion over the amplitude at high e by that at low e, in absolute values."""
    xi = select_amplitudes(data, limits)
    growth = 1 / low_over_high_restitution(dispersion(xi, RELEASE))
    relative_growth = 1 / low_over_high_restitution(spread(xi, RELEASE))
    parts = {"dispersion": bool((growth > limits["more"]).all())}
    numbers = list_models(growth, short)
    finding = (
        "Ratio of the dispersion of ξ (in absolute values, as plotted in Fig. 5) at high e to that"
        " at low e. For the dispersion divided by the mean ξ it is"
        f" {list_models(relative_growth, short)}."
    )
    return Judgement(parts, numbers, finding)


def low_amp(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR with SDR by amplitude, and SDR with its ratio at the reference amplitude."""
    xi = select_amplitudes(data, limits)
    reference = float(data["damping_force"][RELEASE])
    cdr = xi.sel(damping_model="CDR")
    sdr = xi.sel(damping_model="SDR")
    gap = abs(sdr / cdr - 1).mean("restitution")
    low = float(gap[0])
    high = float(gap[-1])
    excess = sdr.sel({RELEASE: reference}, method="nearest") / sdr.isel({RELEASE: 0}) - 1
    mean_excess = float(excess.mean())
    parts = {
        "CDR and SDR come together": low <= limits["closer"] * high,
        "SDR overdamps": bool((excess > 0).all()),
        "slightly": mean_excess <= limits["slight"],
    }
    numbers = f"gap {percent(high)} to {percent(low)}, SDR {percent(mean_excess)} more"
    finding = (
        f"ξ of SDR differs from that of CDR by {percent(high)} at {plain(xi[RELEASE][-1])} u_ins"
        f" and by {percent(low)} at {plain(xi[RELEASE][0])} u_ins, averaged over e. From"
        f" {plain(reference)} u_ins, ξ of SDR is {percent(mean_excess)} larger than from the"
        " smallest."
    )
    return Judgement(parts, numbers, finding)


# --- the wall's parameters ---------------------------------------------------------------------


def judge_independence(match: xr.Dataset, dim: str, limits: Limits) -> Judgement:
    """Compare the spread over a parameter with a limit, for equally long responses in tau."""
    spread_tau = spread(ratios(match), dim).max()
    spread_seconds = spread(ratios(match, "damping_ratio_fixed_seconds"), dim).max()
    parts = {"damping ratios": bool(spread_tau <= limits["same"])}
    numbers = percent(spread_tau)
    finding = (
        "The dimensionless equations do not contain the parameter. For responses that are equally"
        f" long in seconds, ξ differs by up to {percent(spread_seconds)}."
    )
    return Judgement(parts, numbers, finding)


def slenderness(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over the slenderness with a limit."""
    return judge_independence(data["match/slenderness"], "slenderness", limits)


def overburden(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over the overburden with a limit."""
    return judge_independence(data["match/overburden"], "overburden_ratio", limits)


def a1_most(data: Datasets, limits: Limits) -> Judgement:
    """Compare the spread over a1 with those over slenderness and overburden."""
    a1 = mean_spread(ratios(data["match/cracked_stiffness"]), A1)
    other_spreads = []
    for study, dim in (("slenderness", "slenderness"), ("overburden", "overburden_ratio")):
        xi = ratios(data[f"match/{study}"], "damping_ratio_fixed_seconds")
        other_spreads.append(mean_spread(xi, dim))
    largest_other = xr.concat(other_spreads, "parameter").max("parameter")
    parts = {"a1": bool((a1 > largest_other).all())}
    numbers = f"a1 {list_models(a1)}"
    finding = (
        f"Spread of ξ over a1. Over slenderness and overburden it is at most"
        f" {list_models(largest_other)}, and only for responses that are equally long in seconds."
    )
    return Judgement(parts, numbers, finding)


def a1_rank(data: Datasets, limits: Limits) -> Judgement:
    """Rank the models' spreads over a1."""
    xi = ratios(data["match/cracked_stiffness"])
    spreads = spread(xi, A1)
    mean = spreads.mean("restitution")
    is_ranked = is_largest(spreads, "CDC") & is_smallest(spreads, "CDR")
    parts = {
        "CDC most": bool(is_largest(mean, "CDC")),
        "CDR least": bool(is_smallest(mean, "CDR")),
    }
    numbers = list_models(mean)
    finding = (
        f"Spread of ξ over a1 from {extremes(xi[A1], plain)}, averaged over e. The ranking is the"
        f" same at {count_cases(is_ranked)}."
    )
    return Judgement(parts, numbers, finding)


def a1_sign(data: Datasets, limits: Limits) -> Judgement:
    """Follow the change with a1 at each e."""
    xi = ratios(data["match/cracked_stiffness"])
    cdc, cdr, sdr = (xi.sel(damping_model=model) for model in MODELS)
    ends = list_ends(xi, A1)
    parts = {"CDC less": bool(rises(cdc, A1).all()), "CDR less": bool(rises(cdr, A1).all())}
    numbers = f"CDC {ends['CDC']}, CDR {ends['CDR']}"
    finding = (
        "Mean ξ at the lowest and at the highest a1. For SDR the paper states both trends; here SDR"
        f" needs more damping at lower a1, at {count_cases(falls(sdr, A1))}."
    )
    return Judgement(parts, numbers, finding)


def a1_low_e(data: Datasets, limits: Limits) -> Judgement:
    """Divide the dispersion over a1 at low e by that at high e, in absolute values."""
    xi = ratios(data["match/cracked_stiffness"])
    growth = low_over_high_restitution(dispersion(xi, A1))
    relative_growth = low_over_high_restitution(spread(xi, A1))
    parts = {"dispersion": bool((growth > limits["more"]).all())}
    numbers = list_models(growth, short)
    finding = (
        "Ratio of the dispersion of ξ with a1 (in absolute values, as plotted in Fig. 6) at low e"
        " to that at high e. For the dispersion divided by the mean ξ it is"
        f" {list_models(relative_growth, short)}."
    )
    return Judgement(parts, numbers, finding)


def fit_order(data: Datasets, limits: Limits) -> Judgement:
    """Compare the polynomials with Eq. (15)."""
    fits = select_fits(data, limits)
    relative = fits / data["equivalence"]["giannini_masiani"] - 1
    cdc, cdr, sdr = (relative.sel(damping_model=model) for model in MODELS)
    difference = float(np.abs(cdr).mean())
    parts = {
        "CDC below": bool((cdc < 0).all()),
        "SDR above": bool((sdr > 0).all()),
        "CDR below": bool((cdr < 0).all()),
        "CDR slightly": difference <= limits["slight"],
        "CDR least dependent on a1": bool(is_smallest(mean_spread(fits, A1), "CDR")),
    }
    numbers = f"CDC {extremes(cdc)}, CDR {extremes(cdr)}, SDR {extremes(sdr)}"
    finding = (
        "Relative difference of the polynomials from Eq. (15), for a1 from"
        f" {extremes(fits[A1], plain)}. CDR differs by {percent(difference)} on average."
    )
    return Judgement(parts, numbers, finding)
