"""Judge the claims on the wall, its curve, its decays and the test: sections 2 to 5 and 7 of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.constants import PAPER_MODELS
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.storage.dataset import Datasets
from rockdamp.text import join_words, number, percent, plain

Limits: TypeAlias = Mapping[str, Any]
Judgement: TypeAlias = tuple[
    dict[str, bool], str, str
]  # parts of the claim that hold or not, numbers, a sentence


def list_models(values: xr.DataArray, write: Any = percent) -> str:
    """Write a value for each model: ``CDC 48 %, CDR 8.2 %``."""
    return ", ".join(
        f"{name} {write(value)}"
        for name, value in zip(values["damping_model"].values, values, strict=True)
    )


def extremes(values: Any, write: Any = percent) -> str:
    """Write the smallest and the largest: ``37 % to 43 %``."""
    return f"{write(np.min(values))} to {write(np.max(values))}"


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def hinge_mass(data: Datasets, limits: Limits) -> Judgement:
    """Compare effective mass and excitation factor at rest between the lowest and the highest hinge."""
    mechanism = data["mechanism"].sortby(["slenderness", "hinge_height_ratio"])
    parts, changes = {}, []
    for name, variable in (
        ("effective mass", "effective_mass_ratio"),
        ("excitation factor", "excitation_factor"),
    ):
        at_hinge = mechanism[variable].transpose("hinge_height_ratio", "slenderness").values
        change = at_hinge[-1] / at_hinge[0] - 1
        size = np.abs(change)
        parts[name] = bool(((size > limits["none"]) & (size <= limits["slight"])).all())
        changes.append(f"{name} {percent(change[0])} to {percent(change[-1])}")
    hinge, slenderness = (
        extremes(mechanism[name], plain) for name in ("hinge_height_ratio", "slenderness")
    )
    return (
        parts,
        ", ".join(changes),
        f"From h1/h = {hinge} at rest, over h/t = {slenderness}; Eqs (2) and (4), of slender bodies, show no change.",
    )


def bilinear_demand(data: Datasets, limits: Limits) -> Judgement:
    """Divide peaks with the bi-linear by those with the tri-linear curve, in pairs."""
    ratio = paired_ratio(data["bilinear"])
    median = ratio.median("record").dropna("velocity_ratio")
    return (
        {"displacement demand": bool((median > limits["more"]).all())},
        f"median ratio {number(ratio.median())}",
        f"The bi-linear curve gives the larger peak in {percent((ratio > 1).sum() / ratio.notnull().sum())} of the"
        " pairs in which the tri-linear wall rocks and not both collapse.",
    )


def paired_ratio(pairs: xr.Dataset) -> xr.DataArray:
    """Return the bi-linear over the tri-linear peak; NaN where the latter does not rock or both collapse.

    A collapse is larger than any peak.
    """
    peak = pairs["peak"].where(pairs["collapsed"] == 0, np.inf)
    bilinear, trilinear = (
        peak.sel(force_curve=curve, drop=True) for curve in ("bi-linear", "tri-linear")
    )
    first_branch = float(pairs["yield_displacement_ratio"].sel(force_curve="tri-linear"))
    both = np.isinf(bilinear) & np.isinf(trilinear)
    return (bilinear / trilinear.where(~both & (trilinear > first_branch))).drop_vars(
        "force_curve", errors="ignore"
    )


def ean_slender(data: Datasets, limits: Limits) -> Judgement:
    """Compare e of Eq. (7) at each slenderness with that at the next."""
    mechanism = data["mechanism"].sortby(["slenderness", "hinge_height_ratio"])
    e, impulsive = (
        mechanism[name].transpose("hinge_height_ratio", "slenderness")
        for name in ("restitution_rigid", "restitution_impulsive")
    )
    return (
        {"e": bool((e.diff("slenderness") > 0).all())},
        f"e {extremes(e[0], number)}",
        f"With the hinge at {plain(e['hinge_height_ratio'][0])} h, over h/t = {extremes(e['slenderness'], plain)}; with"
        f" the impulse of every support e is {extremes(impulsive[0], number)}.",
    )


def e_measured(data: Datasets, limits: Limits) -> Judgement:
    """Divide the measured restitution that the paper quotes by the analytical value of the tested wall."""
    analytical = float(data["mechanism"]["tested_restitution_rigid"])
    low, mean, high = (e / analytical for e in limits["measured"])
    return (
        {"mean of the tests": bool(abs(mean / limits["share"] - 1) <= limits["same"])},
        f"mean {number(mean)}",
        f"Eq. (7) gives {number(analytical)}; all tests lie from {number(low)} to {number(high)} of it.",
    )


# --- loops -----------------------------------------------------------------------------------------------------------


def half_cycle_areas(
    histories: xr.Dataset, model: str, response_length: float, inner: float = 1.0
) -> Array:
    """Return the work of the damping force in each half cycle that ends within `response_length`, over K0 u_ins^2.

    Only of displacements up to `inner` times the peak that the half cycle starts from.
    """
    u, v, force = (
        histories[name].sel(damping_model=model).values
        for name in ("displacement", "velocity", "damping_force")
    )
    turns = turning_samples(v[histories["tau"].values <= response_length])
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(u)
    middle = np.abs(0.5 * (u[1:] + u[:-1]))
    return np.array([work[i:j][middle[i:j] <= inner * abs(u[i])].sum() for i, j in pairwise(turns)])


def turning_samples(velocity: Array) -> NDArray[np.intp]:
    """Return the samples of a decay's peaks: the release at rest, and the last sample before each change of sign.

    An impact is no peak: it scales the velocity and keeps its sign.
    """
    return np.concatenate([[0], 1 + np.flatnonzero(passes_zero(velocity[1:]))])


def fig3_energy(data: Datasets, limits: Limits) -> Judgement:
    """Compare the areas of the models' loops, one for each whole cycle: over a whole decay they are equal by energy."""
    length = float(data["match/amplitude"]["response_length"])
    halves = [half_cycle_areas(data["damping_force"], model, length) for model in PAPER_MODELS]
    totals, count = (
        np.array([areas.sum() for areas in halves]),
        min(areas.size for areas in halves) // 2,
    )
    loops = np.stack([areas[: 2 * count].reshape(count, 2).sum(axis=1) for areas in halves])
    apart = np.abs(loops / loops.mean(axis=0) - 1).max(axis=0)
    return (
        {"each loop": bool((apart <= limits["same"]).all())},
        f"up to {percent(apart.max())} from their mean",
        f"The first loops differ from their mean by {percent(apart[0])}, and the areas in total over the matched length"
        f" by {percent(np.abs(totals / totals.mean() - 1).max())}.",
    )


def fig3_impact(data: Datasets, limits: Limits) -> Judgement:
    """Compute the share of the matched decay's dissipation near zero displacement."""
    length, share, ranges = float(data["match/amplitude"]["response_length"]), {}, []
    for model in PAPER_MODELS:
        whole = half_cycle_areas(data["damping_force"], model, length)
        inner = half_cycle_areas(data["damping_force"], model, length, limits["inner"])
        share[model] = inner.sum() / whole.sum()
        ranges.append(f"{model} {extremes(inner / whole)}")
    concentrated = {model: bool(part > limits["concentrated"]) for model, part in share.items()}
    return (
        {
            "CDR": concentrated["CDR"],
            "SDR": concentrated["SDR"],
            "CDC does not": not concentrated["CDC"],
        },
        ", ".join(f"{model} {percent(part)}" for model, part in share.items()),
        f"Shares of the decay within the inner {percent(limits['inner'])} of the amplitude; by half cycle"
        f" {join_words(ranges)}.",
    )


# --- histories -------------------------------------------------------------------------------------------------------


def fig4_rigid(data: Datasets, limits: Limits) -> Judgement:
    """Compare the nearly rigid tri-linear model with two bodies of small rotations, as in Eq. (1), and exact ones."""
    rocking = data["damping_force"]["rocking_displacement"]
    model, release = rocking.sel(rocking_model="tri-linear").values, abs(float(rocking[0, 0]))
    apart, peaks_apart = {}, {}
    for reference in ("slender", "large rotation"):
        rigid = rocking.sel(rocking_model=reference).values
        ours, theirs = (first_peaks(history, limits["peaks"]) for history in (model, rigid))
        count = min(ours.size, theirs.size)
        apart[reference] = rms(model - rigid) / release
        peaks_apart[reference] = float(np.abs(ours[:count] - theirs[:count]).max()) / release
    return (
        {"decay": max(apart["slender"], peaks_apart["slender"]) <= limits["same"]},
        f"{percent(apart['slender'])} of the release",
        f"Root mean square to Eq. (1); the first {limits['peaks']} peaks differ by up to"
        f" {percent(peaks_apart['slender'])}. From exact rotations the history differs by"
        f" {percent(apart['large rotation'])}, its peaks by {percent(peaks_apart['large rotation'])}.",
    )


def first_peaks(displacement: Array, count: int) -> Array:
    """Return the first peaks of |u| after the release."""
    return np.abs(displacement)[turning_samples(np.gradient(displacement))[1 : count + 1]]


def fig4_smooth(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR with CR over the matched length: velocity step by step, and the histories."""
    histories, length = data["damping_force"], float(data["match/amplitude"]["response_length"])
    matched = histories.isel(tau=histories["tau"].values <= length)
    cr, cdr = (matched.sel(damping_model=model) for model in ("CR", "CDR"))
    step_cr, step_cdr = (
        float(np.abs(np.diff(decay["velocity"].values)).max()) for decay in (cr, cdr)
    )
    u, v = (
        rms(cdr[name].values - cr[name].values) / float(np.abs(cr[name]).max())
        for name in ("displacement", "velocity")
    )
    jump = step_cdr / step_cr
    return (
        {
            "smooth": jump <= limits["jump"],
            "follows CR": u <= limits["same"] and v <= limits["same_velocity"],
        },
        f"step {percent(jump)} of CR's, displacement {percent(u)}",
        "The largest change of velocity in a step, and the root mean square difference; the velocity differs by"
        f" {percent(v)} of CR's largest.",
    )


def fig8_sdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare decrement and peaks of the models after the largest peak of the test."""
    validation = data["validation"].sel(damping_model=["CR", *PAPER_MODELS])
    decrement, misfit = validation["log_decrement"], validation["decay_peak_misfit"]
    sdr, others = decrement.sel(damping_model="SDR"), decrement.drop_sel(damping_model="SDR")
    more = float(sdr / others.mean(skipna=False)) - 1
    nearer = misfit.sel(damping_model="SDR") < misfit.drop_sel(damping_model="SDR")
    return (
        {
            "SDR damps most": bool((sdr > others).all()),
            "slightly": 0 < more <= limits["slight"],
            "SDR follows the peaks best": bool(nearer.all()),
        },
        f"logarithmic decrement {list_models(decrement, number)}",
        "The laboratory's record is not public. On the record of the config the peaks of the decay are off by"
        f" {list_models(1000 * misfit, lambda value: f'{number(value, 2)} mm')}.",
    )
