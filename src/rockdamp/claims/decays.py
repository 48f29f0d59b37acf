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
Judgement: TypeAlias = tuple[dict[str, bool], str, str]  # parts of the claim that hold or not, numbers, a sentence


def list_models(values: xr.DataArray, write: Any = percent) -> str:
    """Write a value for each model: ``CDC 48 %, CDR 8.2 %``."""
    return ", ".join(
        f"{name} {write(value)}" for name, value in zip(values["damping_model"].values, values, strict=True)
    )


def phrase_models(values: xr.DataArray, write: Any = percent) -> str:
    """Write a value for each model in a sentence: ``48 % under CDC and 8.2 % under CDR``."""
    models = values["damping_model"].values
    return join_words(f"{write(value)} under {name}" for name, value in zip(models, values, strict=True))


def extremes(values: Any, write: Any = percent) -> str:
    """Write the smallest and the largest: ``37 % to 43 %``."""
    return f"{write(np.min(values))} to {write(np.max(values))}"


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def hinge_mass(data: Datasets, limits: Limits) -> Judgement:
    """Compare effective mass and excitation factor at rest between the lowest and the highest hinge."""
    mechanism = data["mechanism"].sortby(["slenderness", "hinge_height_ratio"])
    r, slenderness = mechanism["hinge_height_ratio"].values, mechanism["slenderness"].values
    parts, changes = {}, {}
    for name, variable in (("effective mass", "effective_mass_ratio"), ("excitation factor", "excitation_factor")):
        at = mechanism[variable].values
        change = at[-1] / at[0] - 1
        size = np.abs(change)
        parts[name] = bool(((size > limits["none"]) & (size <= limits["slight"])).all())
        changes[name] = f"{percent(change[0])} to {percent(change[-1])}"
    measured = ", ".join(f"{name} {change}" for name, change in changes.items())
    return (
        parts,
        measured,
        (
            f"From h1/h = {plain(r[0])} to {plain(r[-1])} the effective mass at rest changes by"
            f" {changes['effective mass']} and the excitation factor by {changes['excitation factor']} over"
            f" h/t = {plain(slenderness[0])} to {plain(slenderness[-1])}; Eqs (2) and (4), of slender bodies, do not."
        ),
    )


def bilinear_demand(data: Datasets, limits: Limits) -> Judgement:
    """Divide peaks with the bi-linear by those with the tri-linear curve, in pairs."""
    ratio = paired_ratio(data["bilinear"])
    median, middle = ratio.median("record").dropna("velocity_ratio"), number(ratio.median())
    fell = data["bilinear"]["collapsed"].sum(["record", "velocity_ratio"])
    counts = {curve: int(fell.sel(force_curve=curve)) for curve in ("bi-linear", "tri-linear")}
    return (
        {"displacement demand": bool((median > limits["more"]).all())},
        f"median ratio {middle}",
        f"Where the tri-linear wall rocks and not both collapse, the bi-linear curve peaks in the median at {middle}"
        f" times the tri-linear one's displacement. Of {ratio.size} runs {counts['bi-linear']} collapse with it and"
        f' {counts["tri-linear"]} with the tri-linear curve. The paper says "may" and cites others.',
    )


def paired_ratio(pairs: xr.Dataset) -> xr.DataArray:
    """Return the bi-linear over the tri-linear peak; NaN where the latter does not rock or both collapse.

    A collapse is larger than any peak.
    """
    peak = pairs["peak"].where(pairs["collapsed"] == 0, np.inf)
    bilinear, trilinear = (peak.sel(force_curve=curve, drop=True) for curve in ("bi-linear", "tri-linear"))
    first_branch = float(pairs["yield_displacement_ratio"].sel(force_curve="tri-linear"))
    both = np.isinf(bilinear) & np.isinf(trilinear)
    return (bilinear / trilinear.where(~both & (trilinear > first_branch))).drop_vars("force_curve", errors="ignore")


def ean_slender(data: Datasets, limits: Limits) -> Judgement:
    """Compare e of Eq. (7) at each slenderness with that at the next."""
    mechanism = data["mechanism"].sortby(["slenderness", "hinge_height_ratio"])
    slenderness, r = mechanism["slenderness"].values, mechanism["hinge_height_ratio"].values
    e = mechanism["restitution_rigid"].transpose("hinge_height_ratio", "slenderness").values
    low, high = (number(end) for end in e[0, [0, -1]])
    consistent = mechanism["restitution_impulsive"].transpose("hinge_height_ratio", "slenderness").values[0, [0, -1]]
    return (
        {"e": bool((np.diff(e) > 0).all())},
        f"e {low} to {high}",
        f"With the hinge at {plain(r[0])} h, Eq. (7) gives e = {low} at h/t = {plain(slenderness[0])} and {high} at"
        f" h/t = {plain(slenderness[-1])}; with the impulse of every support it is {number(consistent[0])} and"
        f" {number(consistent[1])}.",
    )


def e_measured(data: Datasets, limits: Limits) -> Judgement:
    """Divide the measured restitution that the paper quotes by the analytical value of the tested wall."""
    analytical, impulsive = (float(data["mechanism"][f"tested_restitution_{rule}"]) for rule in ("rigid", "impulsive"))
    low, mean, high = (e / analytical for e in limits["measured"])
    return (
        {"mean of the tests": bool(abs(mean / limits["share"] - 1) <= limits["same"])},
        f"mean {number(mean)}",
        f"The tests' mean is {number(mean)} of Eq. (7), {number(analytical)} for this wall, and all lie from"
        f" {number(low)} to {number(high)} of it; of the value with the impulse of every support the mean is"
        f" {number(limits['measured'][1] / impulsive)}.",
    )


# --- loops -----------------------------------------------------------------------------------------------------------


def areas(histories: xr.Dataset, model: str, response_length: float, inner: float = 1.0) -> Array:
    """Return the work of the damping force in each half cycle that ends within `response_length`, over K0 u_ins^2.

    Only of displacements up to `inner` times the peak that the half cycle starts from.
    """
    u, v, force = (
        histories[name].sel(damping_model=model).values for name in ("displacement", "velocity", "damping_force")
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
    """Compare the areas of the models' loops, half cycle by half cycle: over a whole decay they are equal by energy."""
    length = float(data["match/amplitude"]["response_length"])
    loops = [areas(data["damping_force"], model, length) for model in PAPER_MODELS]
    totals = np.array([loop.sum() for loop in loops])
    count = min(loop.size for loop in loops)
    loop_areas = np.stack([loop[:count] for loop in loops])
    apart = np.abs(loop_areas / loop_areas.mean(axis=0) - 1)
    largest, least = percent(apart.max()), percent(apart.max(axis=0).min())
    return (
        {"each loop": bool((apart <= limits["same"]).all())},
        f"up to {largest} from their mean",
        f"The areas differ from their mean by {largest} in one half cycle, by {least} where they differ least,"
        f" and by {percent(np.abs(totals / totals.mean() - 1).max())} in total over the matched length.",
    )


def fig3_impact(data: Datasets, limits: Limits) -> Judgement:
    """Compute the share of the matched decay's dissipation near zero displacement."""
    length, share, ranges = float(data["match/amplitude"]["response_length"]), {}, {}
    for model in PAPER_MODELS:
        whole = areas(data["damping_force"], model, length)
        inner = areas(data["damping_force"], model, length, limits["inner"])
        share[model] = inner.sum() / whole.sum()
        ranges[model] = extremes(inner / whole)
    concentrated = {model: bool(part > limits["concentrated"]) for model, part in share.items()}
    return (
        {"CDR": concentrated["CDR"], "SDR": concentrated["SDR"], "CDC does not": not concentrated["CDC"]},
        ", ".join(f"{model} {percent(part)}" for model, part in share.items()),
        f"Within the inner {percent(limits['inner'])} of the amplitude CDR dissipates {percent(share['CDR'])} of the"
        f" decay's energy, SDR {percent(share['SDR'])} and CDC {percent(share['CDC'])}; from half cycle to half cycle"
        f" {ranges['CDR']}, {ranges['SDR']} and {ranges['CDC']}.",
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
    slender, exact = (percent(value) for value in apart.values())
    return (
        {"decay": max(apart["slender"], peaks_apart["slender"]) <= limits["same"]},
        f"{slender} of the release",
        f"The history differs from that of two bodies with small rotations, as Eq. (1) has them, by {slender} of the"
        f" release (root mean square), its first {limits['peaks']} peaks by up to {percent(peaks_apart['slender'])}."
        f" With exact rotations it is {exact} and {percent(peaks_apart['large rotation'])}.",
    )


def first_peaks(displacement: Array, count: int) -> Array:
    """Return the first peaks of |u| after the release."""
    return np.abs(displacement)[turning_samples(np.gradient(displacement))[1 : count + 1]]


def fig4_smooth(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR with CR over the matched length: velocity step by step, and the histories."""
    histories, length = data["damping_force"], float(data["match/amplitude"]["response_length"])
    matched = histories.isel(tau=histories["tau"].values <= length)
    cr, cdr = (matched.sel(damping_model=model) for model in ("CR", "CDR"))
    step_cr, step_cdr = (float(np.abs(np.diff(one["velocity"].values)).max()) for one in (cr, cdr))
    u, v = (
        rms(cdr[name].values - cr[name].values) / float(np.abs(cr[name]).max()) for name in ("displacement", "velocity")
    )
    jump = step_cdr / step_cr
    return (
        {"smooth": jump <= limits["jump"], "follows CR": u <= limits["same"] and v <= limits["same_velocity"]},
        f"step {percent(jump)} of CR's, displacement {percent(u)}",
        f"The largest change of velocity in a step is {percent(jump)} of CR's; in the root mean square the displacement"
        f" differs by {percent(u)} and the velocity by {percent(v)} of their largest values.",
    )


def fig8_sdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare decrement and peaks of the models after the largest peak of the test."""
    validation = data["validation"].sel(damping_model=["CR", *PAPER_MODELS])
    decrement, misfit = validation["log_decrement"], validation["decay_peak_misfit"]
    sdr, others = decrement.sel(damping_model="SDR"), decrement.drop_sel(damping_model="SDR")
    more = float(sdr / others.mean(skipna=False)) - 1
    nearer = misfit.sel(damping_model="SDR") < misfit.drop_sel(damping_model="SDR")
    millimetres = phrase_models(1000 * misfit, lambda value: f"{number(value, 2)} mm")
    return (
        {
            "SDR damps most": bool((sdr > others).all()),
            "slightly": 0 < more <= limits["slight"],
            "SDR follows the peaks best": bool(nearer.all()),
        },
        f"logarithmic decrement {list_models(decrement, number)}",
        f"The laboratory's record is not public. On the record of the config the decrement of SDR exceeds the mean of"
        f" the others' by {percent(more)}, and the decay's peaks are off by {millimetres}.",
    )
