"""Judge the claims on the decays, their loops and the test: Figs 3, 4 and 8 of the paper."""

from __future__ import annotations

from itertools import pairwise
from typing import SupportsFloat

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.claims.judgement import (
    MODELS,
    Judgement,
    Limits,
    Untestable,
    extremes,
    list_models,
    rms,
)
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.storage.dataset import Datasets
from rockdamp.text import join_words, number, percent

# --- Fig. 3: loops -----------------------------------------------------------------------------


def half_cycle_areas(
    histories: xr.Dataset, model: str, response_length: float, inner: float = 1.0
) -> Array:
    """Return the work of the damping force in each half cycle of a decay, divided by K0 u_ins^2.

    It counts only half cycles that end within `response_length`, and in each only displacements up
    to `inner` times the peak from which the half cycle starts.
    """
    decay = histories.sel(damping_model=model)
    u = decay["displacement"].values
    v = decay["velocity"].values
    force = decay["damping_force"].values
    turns = turning_samples(v[histories["tau"].values <= response_length])
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(u)
    middle = np.abs(0.5 * (u[1:] + u[:-1]))
    areas = []
    for start, end in pairwise(turns):
        is_inner = middle[start:end] <= inner * abs(u[start])
        areas.append(work[start:end][is_inner].sum())
    return np.array(areas)


def turning_samples(velocity: Array) -> NDArray[np.intp]:
    """Return the samples of a decay's peaks: the release, and the last before each turn.

    An impact is no turn: it scales the velocity and keeps its sign.
    """
    turns = 1 + np.flatnonzero(passes_zero(velocity[1:]))
    return np.concatenate([[0], turns])


def fig3_energy(data: Datasets, limits: Limits) -> Judgement:
    """Compare the areas of the models' loops cycle by cycle, and in total."""
    length = float(data["match/amplitude"]["response_length"])
    halves = [half_cycle_areas(data["damping_force"], model, length) for model in MODELS]
    cycles = min(areas.size for areas in halves) // 2
    if cycles == 0:
        raise Untestable("The matched length has no whole cycle.")
    loops = np.stack([areas[: 2 * cycles].reshape(cycles, 2).sum(axis=1) for areas in halves])
    totals = np.array([areas.sum() for areas in halves])
    by_cycle = np.abs(loops / loops.mean(axis=0) - 1).max(axis=0)
    in_total = np.abs(totals / totals.mean() - 1).max()
    later = by_cycle[1:].max(initial=0.0)
    parts = {
        "the first cycle": bool(by_cycle[0] <= limits["same"]),
        "all cycles together": bool(in_total <= limits["same"]),
        "each later cycle": bool(later <= limits["same"]),
    }
    numbers = f"first cycle {percent(by_cycle[0])}, later {percent(later)}"
    finding = (
        "The largest difference of a model's loop from the models' mean. All cycles within the"
        f" matched length together differ by {percent(in_total)}."
    )
    return Judgement(parts, numbers, finding)


def fig3_impact(data: Datasets, limits: Limits) -> Judgement:
    """Compute the share of the matched decay's dissipation near zero displacement."""
    length = float(data["match/amplitude"]["response_length"])
    histories = data["damping_force"]
    shares = {}
    ranges = []
    for model in MODELS:
        total = half_cycle_areas(histories, model, length)
        inner = half_cycle_areas(histories, model, length, limits["inner"])
        shares[model] = inner.sum() / total.sum()
        ranges.append(f"{model} {extremes(inner / total)}")
    concentrated = {model: bool(share > limits["concentrated"]) for model, share in shares.items()}
    parts = {
        "CDR": concentrated["CDR"],
        "SDR": concentrated["SDR"],
        "CDC does not": not concentrated["CDC"],
    }
    numbers = ", ".join(f"{model} {percent(share)}" for model, share in shares.items())
    finding = (
        f"The share of the decay's energy that is lost within {percent(limits['inner'])} of the"
        f" amplitude. By half cycle it is {join_words(ranges)}."
    )
    return Judgement(parts, numbers, finding)


# --- Fig. 4: histories -------------------------------------------------------------------------


def fig4_rigid(data: Datasets, limits: Limits) -> Judgement:
    """Compare the nearly rigid tri-linear model with two bodies of finite and small rotations."""
    rocking = data["damping_force"]["rocking_displacement"]
    model = rocking.sel(rocking_model="tri-linear").values
    release = abs(float(rocking[0, 0]))
    history = {}
    peaks = {}
    for name in ("large rotation", "slender"):
        bodies = rocking.sel(rocking_model=name).values
        history[name] = rms(model - bodies) / release
        peaks[name] = largest_peak_difference(model, bodies, limits["peaks"]) / release
    parts = {
        "peaks": peaks["large rotation"] <= limits["same"],
        "history": history["large rotation"] <= limits["same"],
    }
    numbers = (
        f"history {percent(history['large rotation'])}, peaks {percent(peaks['large rotation'])}"
    )
    finding = (
        "The root mean square difference from two bodies with finite rotations, and the largest"
        f" difference of the first {limits['peaks']} peaks, both divided by the release amplitude."
        " Compared with bodies with small rotations, as in Eq. (1), they are"
        f" {percent(history['slender'])} and {percent(peaks['slender'])}."
    )
    return Judgement(parts, numbers, finding)


def largest_peak_difference(displacement: Array, reference: Array, count: int) -> float:
    """Return the largest difference between the first `count` peaks of |u| in two histories."""
    peaks = first_peaks(displacement, count)
    reference_peaks = first_peaks(reference, count)
    common = min(peaks.size, reference_peaks.size)
    return float(np.abs(peaks[:common] - reference_peaks[:common]).max())


def first_peaks(displacement: Array, count: int) -> Array:
    """Return the first peaks of |u| after the release."""
    turns = turning_samples(np.gradient(displacement))
    return np.abs(displacement)[turns[1 : count + 1]]


def fig4_smooth(data: Datasets, limits: Limits) -> Judgement:
    """Compare CDR with CR over the matched length: velocity steps and the whole histories."""
    histories = data["damping_force"]
    length = float(data["match/amplitude"]["response_length"])
    compared = histories.isel(tau=histories["tau"].values <= length)
    cr = compared.sel(damping_model="CR")
    cdr = compared.sel(damping_model="CDR")
    difference = {}
    for name in ("displacement", "velocity"):
        largest = float(np.abs(cr[name]).max())
        difference[name] = rms(cdr[name].values - cr[name].values) / largest
    step = largest_step(cdr["velocity"].values) / largest_step(cr["velocity"].values)
    follows = (
        difference["displacement"] <= limits["same"]
        and difference["velocity"] <= limits["same_velocity"]
    )
    parts = {"smooth": step <= limits["jump"], "follows CR": follows}
    numbers = f"step {percent(step)} of CR's, displacement {percent(difference['displacement'])}"
    finding = (
        "Largest change of velocity in a step, and the root mean square difference of the"
        f" displacement. The velocity differs by {percent(difference['velocity'])} of CR's"
        " largest."
    )
    return Judgement(parts, numbers, finding)


def largest_step(values: Array) -> float:
    """Return the largest change from one sample to the next."""
    return float(np.abs(np.diff(values)).max())


# --- Fig. 8: the test --------------------------------------------------------------------------


def fig8_sdr(data: Datasets, limits: Limits) -> Judgement:
    """Compare the logarithmic decrement of SDR after the largest peak with the other models'."""
    decrement = data["validation"]["log_decrement"].sel(damping_model=["CR", *MODELS])
    sdr = decrement.sel(damping_model="SDR")
    other_models = decrement.drop_sel(damping_model="SDR")
    excess = float(sdr / other_models.mean(skipna=False)) - 1
    next_excess = float(sdr / other_models.max()) - 1
    parts = {
        "SDR damps most": bool((sdr > other_models).all()),
        "slightly": 0 < excess <= limits["slight"],
    }
    numbers = f"logarithmic decrement {list_models(decrement, number)}"
    finding = (
        f"The decrement of SDR is {percent(excess)} larger than the mean of the others and"
        f" {percent(next_excess)} larger than the next largest. The models are compared with each"
        " other, under the motion of the config's record."
    )
    return Judgement(parts, numbers, finding)


def fig8_peaks(data: Datasets, limits: Limits) -> Judgement:
    """Compare the models' misfit of the peaks after the largest peak of the test."""
    misfit = data["validation"]["decay_peak_misfit"].sel(damping_model=["CR", *MODELS])
    sdr = misfit.sel(damping_model="SDR")
    other_models = misfit.drop_sel(damping_model="SDR")

    def write_millimetres(metres: SupportsFloat) -> str:
        return f"{number(1000 * float(metres), 2)} mm"

    parts = {"SDR": bool((sdr < other_models).all())}
    numbers = list_models(misfit, write_millimetres)
    finding = "The root mean square error of the peaks of the decay, in the config's record."
    return Judgement(parts, numbers, finding)
