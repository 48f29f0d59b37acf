"""Judge the claims on the wall, its curve and its restitution: sections 2 to 4 of the paper."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.claims.judgement import Judgement, Limits, extremes
from rockdamp.storage.dataset import Datasets
from rockdamp.text import number, percent, plain


def by_hinge(data: Datasets, variable: str) -> xr.DataArray:
    """Return a variable of the mechanism over the hinge's height and slenderness, ascending."""
    order = ("hinge_height_ratio", "slenderness")
    return data["mechanism"][variable].transpose(*order).sortby(list(order))


def hinge_mass(data: Datasets, limits: Limits) -> Judgement:
    """Compare effective mass and excitation factor at rest between the lowest and highest hinge."""
    variables = {
        "effective mass": "effective_mass_ratio",
        "excitation factor": "excitation_factor",
    }
    parts = {}
    changes = []
    for name, variable in variables.items():
        ratio = by_hinge(data, variable)
        change = ratio.values[-1] / ratio.values[0] - 1
        size = np.abs(change)
        is_slight = (size > limits["none"]) & (size <= limits["slight"])
        parts[name] = bool(is_slight.all())
        changes.append(f"{name} {percent(change[0])} to {percent(change[-1])}")
    hinge = extremes(ratio["hinge_height_ratio"], plain)
    slenderness = extremes(ratio["slenderness"], plain)
    numbers = ", ".join(changes)
    finding = (
        f"The change at rest from h1/h = {hinge}, for h/t = {slenderness}. Eqs (2) and (4), for"
        " slender bodies, show no change."
    )
    return Judgement(parts, numbers, finding)


def uncracked_capacity(data: Datasets, limits: Limits) -> Judgement:
    """Compare the largest forces of the curves; neither of them has a cracking force."""
    largest_force = data["mechanism"]["force"].max("displacement")
    bilinear = largest_force.sel(curve_name="bi-linear")
    trilinear = largest_force.sel(curve_name="tri-linear")
    numbers = f"largest force {number(trilinear)} F0"
    finding = (
        f"The largest force of the tri-linear curve; the bi-linear curve has {number(bilinear)} F0."
        " The force at which the wall cracks depends on the tensile strength of the masonry."
    )
    return Judgement({}, numbers, finding)


def bilinear_demand(data: Datasets, limits: Limits) -> Judgement:
    """Divide peaks with the bi-linear curve by those with the tri-linear one, in pairs."""
    ratio = paired_ratio(data["bilinear"])
    pairs = ratio.notnull().sum()
    numbers = f"median ratio {number(ratio.median())}"
    finding = (
        "Peak with the bi-linear curve, divided by that with the tri-linear one. It is above 1 in"
        f" {percent((ratio > 1).sum() / pairs)} of the pairs in which the tri-linear wall rocks and"
        " at least one wall survives."
    )
    return Judgement({}, numbers, finding)


def paired_ratio(pairs: xr.Dataset) -> xr.DataArray:
    """Return the peak with the bi-linear curve divided by that with the tri-linear one.

    A collapse counts as larger than any peak. NaN where the tri-linear wall does not rock or both
    walls collapse.
    """
    peak = pairs["peak"].where(pairs["collapsed"] == 0, np.inf)
    bilinear = peak.sel(force_curve="bi-linear", drop=True)
    trilinear = peak.sel(force_curve="tri-linear", drop=True)
    first_branch = float(pairs["yield_displacement_ratio"].sel(force_curve="tri-linear"))
    ratio = bilinear / trilinear.where(trilinear > first_branch)  # inf/inf is NaN
    return ratio.drop_vars("force_curve", errors="ignore")


def ean_slender(data: Datasets, limits: Limits) -> Judgement:
    """Compare e of Eq. (7) at each slenderness with that at the next."""
    rigid = by_hinge(data, "restitution_rigid")
    impulsive = by_hinge(data, "restitution_impulsive")
    steps = rigid.diff("slenderness")
    parts = {"e": bool((steps > 0).all())}
    numbers = f"e {extremes(rigid[0], number)}"
    finding = (
        f"With the hinge at {plain(rigid['hinge_height_ratio'][0])} h, for h/t ="
        f" {extremes(rigid['slenderness'], plain)}. With the impulses of all supports, e is"
        f" {extremes(impulsive[0], number)}."
    )
    return Judgement(parts, numbers, finding)


def e_measured(data: Datasets, limits: Limits) -> Judgement:
    """Compare the measured restitution that the paper quotes with Eq. (7) for the tested wall."""
    analytical = float(data["mechanism"]["tested_restitution_rigid"])
    low, mean, high = limits["measured"]
    # By the loss, which dampers need: in e itself nearly all values agree, as e is near 1.
    loss_ratio = np.log(mean) / np.log(limits["share"] * analytical)
    parts = {
        "below Eq. (7)": high < analytical,
        "0.90 of it": bool(abs(loss_ratio - 1) <= limits["same"]),
    }
    numbers = f"mean {number(mean / analytical)} of Eq. (7)"
    finding = (
        f"Eq. (7) gives {number(analytical)}; the tests have {number(low / analytical)} to"
        f" {number(high / analytical)} of it. Their mean loss −ln e is {number(loss_ratio)} times"
        f" that of {plain(limits['share'])} of Eq. (7)."
    )
    return Judgement(parts, numbers, finding)


def sdr_collapse(data: Datasets, limits: Limits) -> Judgement:
    """Compute SDR's damping ratio close to collapse; it is proportional to the secant frequency."""
    curve = data["mechanism"].sel(curve_name="tri-linear")
    first_stiffness = float(curve["strength_ratio"] / curve["yield_displacement_ratio"])
    amplitudes = np.array([limits["reference"], limits["close"]])
    force = np.interp(amplitudes, curve["displacement"], curve["force"])
    # omega/omega1 = sqrt(K_sec/K_1), with the secant stiffness K_sec = F/u.
    reference, close = np.sqrt(force / amplitudes / first_stiffness)
    parts = {"very low": bool(close <= limits["very_low"])}
    numbers = f"{percent(close)} of ξ on the first branch"
    finding = (
        f"Secant frequency at {plain(amplitudes[1])} u_ins, divided by ω1, on the paper's curve:"
        " under SDR the damping ratio is proportional to it. At"
        f" {plain(amplitudes[0])} u_ins it is {percent(reference)}."
    )
    return Judgement(parts, numbers, finding)
