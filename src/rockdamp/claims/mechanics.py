"""Judge the claims on the wall, its curve, damping forces, histories and the measured test: sections 2 to 5 and 7."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.claims.verdicts import (
    Limits,
    Part,
    between,
    brief,
    by_id,
    judged,
    measured,
    number,
    per_model,
    percent,
)
from rockdamp.constants import PAPER_MODELS
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.storage.dataset import Datasets


def ean_slender(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the restitution at each slenderness with that at the next."""
    mechanism, parts = data["mechanism"], {}
    values = {"printed": ("restitution_rigid", "Eq. (7)"), "impulsive": ("restitution_impulsive", "every impulse")}
    for name, (variable, words) in values.items():
        e = mechanism[variable].sortby("slenderness")
        rises = e.diff("slenderness") > limits["rise"]
        ends = e.isel(slenderness=[0, -1])
        low, high = ends["slenderness"].values
        ranges = [
            f"{number(first)} to {number(last)} at h1/h {number(hinge)}"
            for hinge, (first, last) in zip(
                e["hinge_height_ratio"].values, ends.transpose(..., "slenderness").values, strict=True
            )
        ]
        rise = measured(f"{words} from h/t {number(low)} to {number(high)}", *ranges)
        first, last = ends.isel(hinge_height_ratio=0).values
        finding = {f"{name}_low": number(first), f"{name}_high": number(last)}
        finding |= {"hinge": number(e["hinge_height_ratio"][0]), "low": number(low), "high": number(high)}
        parts[name] = judged(rises.all("slenderness"), rise, "h1/h", finding=finding)
    return parts


def hinge_mass(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare effective mass and excitation factor at rest between the heights of the hinge."""
    mechanism = data["mechanism"].sortby(["slenderness", "hinge_height_ratio"])
    r, h_t = mechanism["hinge_height_ratio"].values, mechanism["slenderness"].values
    words = {"low": number(r[0]), "high": number(r[-1]), "squat": number(h_t[0]), "slender": number(h_t[-1])}
    parts = {}
    for name, variable in (("mass", "effective_mass_ratio"), ("factor", "excitation_factor")):
        low, high = (mechanism[variable].isel(hinge_height_ratio=end) for end in (0, -1))
        change = high.drop_vars("hinge_height_ratio") / low.drop_vars("hinge_height_ratio") - 1
        held = (np.abs(change) > limits["none"]) & (np.abs(change) <= limits["slight"])
        ends = f"{percent(change[0])} at h/t {words['squat']} to {percent(change[-1])} at h/t {words['slender']}"
        changes = measured(f"{variable.replace('_', ' ')} changes by {ends}")
        finding = {**words, name: f"{brief(change[0])} to {brief(change[-1])}"}
        parts[name] = judged(held, changes, "h/t", limits["enough"], finding)
    return parts


def e_measured(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Divide the measured restitution that the paper quotes by the analytical values of the tested wall."""
    analytical, impulsive = (data["mechanism"][f"tested_restitution_{name}"] for name in ("rigid", "impulsive"))
    low, mean, high = limits["measured"]
    ratio = {"mean": mean / analytical, "lowest": low / analytical, "highest": high / analytical}
    ratio["impulsive"] = mean / impulsive
    near = {name: bool(abs(value / limits["share"] - 1) <= limits["same"]) for name, value in ratio.items()}
    words = {**{name: number(value) for name, value in ratio.items()}, "analytical": number(analytical)}
    every = measured(f"mean {words['impulsive']} of {number(impulsive)}, every impulse")
    ends = measured(f"from {words['lowest']} to {words['highest']} of it")
    return {
        "mean": Part(near["mean"], measured(f"mean {words['mean']} of {words['analytical']}"), words),
        "range": Part(near["lowest"] and near["highest"], ends),
        "impulsive": Part(near["impulsive"], every),
    }


def bilinear_demand(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Divide peaks with the bi-linear by those with the tri-linear curve, in pairs."""
    pairs = data["bilinear"]
    ratio = paired_ratio(pairs)
    median = ratio.median("record").dropna("velocity_ratio")
    middle = number(ratio.median())
    demand = measured(f"median ratio {middle}, {between(median, times)} from intensity to intensity")
    collapses = {curve: int(pairs["collapsed"].sel(force_curve=curve).sum()) for curve in ("bi-linear", "tri-linear")}
    counts = {f"{curve.replace('-', '')}_collapses": f"{count} of {ratio.size}" for curve, count in collapses.items()}
    collapsed = [
        measured(f"{count} of {ratio.size} collapse with the {curve} curve") for curve, count in collapses.items()
    ]
    return {
        "records": judged(median > limits["more"], demand, "intensity", limits["enough"], {"record_ratio": middle}),
        "collapses": Part(collapses["bi-linear"] > collapses["tri-linear"], sum(collapsed, ()), counts),
    }


def times(ratio: float) -> str:
    """Return a ratio of peaks in words."""
    return "a collapse alone" if np.isinf(ratio) else number(ratio)


def paired_ratio(pairs: xr.Dataset) -> xr.DataArray:
    """Return the bi-linear over the tri-linear peak; NaN where the latter does not rock or both collapse."""
    peak = pairs["peak"].where(pairs["collapsed"] == 0, np.inf)
    bilinear, trilinear = (peak.sel(force_curve=curve, drop=True) for curve in ("bi-linear", "tri-linear"))
    first_branch = float(pairs["yield_displacement_ratio"].sel(force_curve="tri-linear"))
    both = np.isinf(bilinear) & np.isinf(trilinear)
    return (bilinear / trilinear.where(~both & (trilinear > first_branch))).drop_vars("force_curve", errors="ignore")


# --- loops ---------------------------------------------------------------------------------------------------------


def areas(histories: xr.Dataset, model: str, response_length: float, inner: float = 1.0) -> Array:
    """Return the work of the damping force in each half cycle that ends within `response_length`, over K0 u_ins^2.

    Only of displacements up to `inner` times the peak that the half cycle starts from.
    """
    u, v, force = (
        histories[name].sel(damping_model=model).values for name in ("displacement", "velocity", "damping_force")
    )
    peaks = _turning_samples(v[histories["tau"].values <= response_length])
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(u)
    middle = np.abs(0.5 * (u[1:] + u[:-1]))
    halves = pairwise(peaks)
    return np.array([work[i:j][middle[i:j] <= inner * abs(u[i])].sum() for i, j in halves])


def _turning_samples(velocity: Array) -> NDArray[np.intp]:
    """Return the samples of a decay's peaks: the release at rest, and the last sample before each change of sign.

    An impact is no peak: it scales the velocity and keeps its sign.
    """
    return np.concatenate([[0], 1 + np.flatnonzero(passes_zero(velocity[1:]))])


def impact_losses(histories: xr.Dataset, response_length: float) -> Array:
    """Return the energy over K0 u_ins^2 that CR loses at each impact within those half cycles."""
    history = histories.sel(damping_model="CR")
    u, v = history["displacement"].values, history["velocity"].values
    last = _turning_samples(v[histories["tau"].values <= response_length])[-1]
    before = np.flatnonzero(passes_zero(u[: last + 1]))
    return 0.5 * v[before] ** 2 * (1 - float(histories["restitution"]) ** 2)


def fig3_energy(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the areas of the loops in total, over two lengths, and half cycle by half cycle."""
    histories, response_length = data["damping_force"], float(data["match/amplitude"]["response_length"])
    parts = {}
    for name, length in (("total", response_length), ("long", float(histories["tau"].values[-1]))):
        totals = np.array([areas(histories, model, length).sum() for model in PAPER_MODELS])
        apart = totals / totals.mean() - 1
        each = ", ".join(f"{model} {percent(part)}" for model, part in zip(PAPER_MODELS, apart, strict=True))
        totals_apart = measured(f"in total against their mean, up to tau {number(length)}", each)
        finding = {} if name == "long" else {"in_total": brief(np.abs(apart).max())}
        parts[name] = Part(bool((np.abs(apart) <= limits["same"]).all()), totals_apart, finding)
    losses = impact_losses(histories, response_length)
    loop_areas = [areas(histories, model, response_length) for model in PAPER_MODELS]
    of_loss = np.array([values.sum() for values in loop_areas]) / losses.sum()
    each = ", ".join(f"{model} {percent(part)}" for model, part in zip(PAPER_MODELS, of_loss, strict=True))
    parts["decay"] = Part(
        bool((np.abs(of_loss - 1) <= limits["same"]).all()),
        measured(f"in total over CR's loss, up to tau {number(response_length)}", each),
        finding={"of_loss": between(of_loss, percent)},
    )
    count = min(losses.size, *(values.size for values in loop_areas))
    table, losses = np.stack([values[:count] for values in loop_areas]), losses[:count]
    for name, reference, of in (("models", table.mean(axis=0), "their mean"), ("impact", losses, "CR's loss")):
        relative = table / reference - 1
        ranges = [f"{percent(column.min())} to {percent(column.max())}" for column in relative.T]
        held = np.abs(relative).max(axis=0) <= limits["same"]
        finding = {f"from_{name}": brief(np.abs(relative).max()) if relative.size else "none"}
        against = measured(f"against {of}", *ranges, by="half cycle")
        parts[name] = judged(by_half_cycle(held), against, "half cycle", limits["enough"], finding)
    return parts


def by_half_cycle(held: NDArray[np.bool_]) -> xr.DataArray:
    """Give the half cycles their numbers, from 1."""
    return xr.DataArray(held, coords={"half_cycle": np.arange(1, held.size + 1)})


def fig3_impact(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compute the share of each loop's area near zero displacement."""
    histories, response_length = data["damping_force"], float(data["match/amplitude"]["response_length"])
    parts = {}
    for model in PAPER_MODELS:
        share = areas(histories, model, response_length, limits["inner"]) / areas(histories, model, response_length)
        concentrated = share > limits["concentrated"]
        held = by_half_cycle(~concentrated if model == "CDC" else concentrated)
        ends = (percent(share.min()), percent(share.max())) if share.size else ("none",) * 2
        inner = measured(f"{model} {ends[0]} to {ends[1]} of the area")
        name = model.lower()
        parts[name] = judged(held, inner, "half cycle", limits["enough"], {name: between(share)})
    return {name: parts[name] for name in ("cdr", "sdr", "cdc")}


# --- histories -----------------------------------------------------------------------------------------------------


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def fig4_rigid(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the nearly rigid tri-linear model with two references."""
    rocking = data["damping_force"]["rocking_displacement"]
    model, release = rocking.sel(rocking_model="tri-linear").values, abs(float(rocking[0, 0]))
    parts = {}
    for name, reference in (("slender", "slender"), ("exact", "large rotation")):
        rigid = rocking.sel(rocking_model=reference).values
        apart = rms(model - rigid) / release
        ours, theirs = (peaks(history, int(limits["peaks"])) for history in (model, rigid))
        count = min(ours.size, theirs.size)
        largest = float(np.abs(ours - theirs)[:count].max()) / release if count else np.nan
        for part, value, words in (("history", apart, "history"), ("peaks", largest, f"first {count} peaks")):
            difference = measured(reference, f"{words} {percent(value)} of the release")
            parts[f"{name}-{part}"] = Part(
                value <= limits["same"], difference, finding={f"{name}_{part}": brief(value)}
            )
    return {name: parts[name] for name in ("slender-history", "slender-peaks", "exact-history", "exact-peaks")}


def peaks(displacement: Array, count: int) -> Array:
    """Return the first `count` peaks of |u| after the release."""
    return np.abs(displacement)[_turning_samples(np.gradient(displacement))[1 : count + 1]]


def fig4_smooth(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare CDR with CR: velocity step by step, and differences of the histories."""
    histories = data["damping_force"]
    matched = histories["tau"].values <= float(data["match/amplitude"]["response_length"])
    u, v = (
        {model: histories[name].sel(damping_model=model).values for model in ("CR", "CDR")}
        for name in ("displacement", "velocity")
    )
    changes = {model: float(np.abs(np.diff(v[model][matched])).max()) for model in v}
    jump = changes["CDR"] / changes["CR"]
    apart, apart_velocity = (rms((of["CDR"] - of["CR"])[matched]) / float(np.abs(of["CR"]).max()) for of in (u, v))
    beyond = rms(u["CDR"] - u["CR"]) / float(np.abs(u["CR"]).max())
    length = number(histories["tau"].values[-1])
    steps = f"largest step of velocity {number(changes['CDR'])} under CDR, {number(changes['CR'])} under CR (p u_ins)"
    parts = {"smooth": Part(jump <= limits["jump"], measured(steps), {"step": brief(jump)})}
    for name, value, limit, words in (
        ("displacement", apart, "same", "displacement differs by {} (rms)"),
        ("velocity", apart_velocity, "same_velocity", "velocity by {} (rms)"),
    ):
        parts[name] = Part(value <= limits[limit], measured(words.format(percent(value))), {name: brief(value)})
    far = measured(f"displacement by {percent(beyond)} (rms) up to tau {length}")
    return parts | {"beyond": Part(beyond <= limits["same"], far)}


# --- the measured test ---------------------------------------------------------------------------------------------


def fig8_sdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare decrement and peaks of the models after the largest peak of the test."""
    validation, little = data["validation"].sel(damping_model=["CR", *PAPER_MODELS]), limits["slight"]
    decrement, misfit = validation["log_decrement"], validation["decay_peak_misfit"]
    sdr, others = decrement.sel(damping_model="SDR"), decrement.drop_sel(damping_model="SDR")
    more = float(sdr / others.mean(skipna=False)) - 1
    side = "above" if more > 0 else "below"
    of_test = number(validation["measured_log_decrement"])
    told = f"SDR's decrement of the decay is {brief(abs(more))} {side} the mean of CR's, CDC's and CDR's"
    return {
        "more": Part(
            bool((sdr > others).all()),
            measured(f"logarithmic decrement {per_model(decrement)}") + measured(f"measured {of_test}"),
        ),
        "slightly": Part(
            0 < more <= little,
            measured(f"SDR {percent(abs(more))} {side} the others' mean"),
            finding={"decay": told},
        ),
        "peaks": Part(
            bool((misfit.sel(damping_model="SDR") < misfit.drop_sel(damping_model="SDR")).all()),
            measured(f"misfit of the decay's peaks {per_model(1000 * misfit)} mm"),
        ),
    }


JUDGES = by_id(hinge_mass, bilinear_demand, ean_slender, e_measured)
JUDGES |= by_id(fig3_energy, fig3_impact, fig4_rigid, fig4_smooth, fig8_sdr)
