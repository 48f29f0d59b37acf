"""Judge the claims on the wall and its curve: sections 2, 3 and 4.1."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.claims.verdicts import Limits, Part, between, brief, by_id, judged, measured, number, percent
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
    pairs, parts = data["bilinear"], {}
    collapses = dict.fromkeys(("bi-linear", "tri-linear"), 0)
    runs = 0
    for name, case, noun in (("pulse", "pulse_frequency", "w/p"), ("record", "velocity_ratio", "intensity")):
        ratio = paired_ratio(pairs, name)
        others = [dim for dim in ratio.dims if dim != case]
        median = ratio.median(others).dropna(case)
        middle = number(ratio.median())
        demand = measured(f"{name}s", f"median ratio {middle}, {between(median, times)} from {noun} to {noun}")
        parts[f"{name}s"] = judged(median > limits["more"], demand, noun, limits["enough"], {f"{name}_ratio": middle})
        for curve in collapses:
            collapses[curve] += int(pairs[f"{name}_collapsed"].sel(force_curve=curve).sum())
        runs += ratio.size
    counts = {f"{curve.replace('-', '')}_collapses": f"{count} of {runs}" for curve, count in collapses.items()}
    overturned = (measured(f"{count} of {runs} collapse with the {curve} curve") for curve, count in collapses.items())
    parts["collapses"] = Part(collapses["bi-linear"] > collapses["tri-linear"], sum(overturned, ()), counts)
    return parts


def times(ratio: float) -> str:
    """Return a ratio of peaks in words."""
    return "a collapse alone" if np.isinf(ratio) else number(ratio)


def paired_ratio(pairs: xr.Dataset, name: str) -> xr.DataArray:
    """Return the bi-linear over the tri-linear peak; NaN where the latter does not rock or both collapse."""
    peak = pairs[f"peak_under_{name}"].where(pairs[f"{name}_collapsed"] == 0, np.inf)
    bilinear, trilinear = (peak.sel(force_curve=curve, drop=True) for curve in ("bi-linear", "tri-linear"))
    first_branch = float(pairs["yield_displacement_ratio"].sel(force_curve="tri-linear"))
    both = np.isinf(bilinear) & np.isinf(trilinear)
    return (bilinear / trilinear.where(~both & (trilinear > first_branch))).drop_vars("force_curve", errors="ignore")


JUDGES = by_id(hinge_mass, bilinear_demand, ean_slender, e_measured)
