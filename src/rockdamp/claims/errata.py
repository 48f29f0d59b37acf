"""Evidence for what data/errata.yaml lists: numbers from the wall's and the curve's formulas, and from the datasets."""

from __future__ import annotations

import os
import string
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.optimize import brentq

from rockdamp.claims.ratios import MODELS, ratios
from rockdamp.claims.verdicts import by_id, number, percent, spans, steady
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.two_bodies import TwoBodies
from rockdamp.mechanics.wall import Wall
from rockdamp.storage.dataset import Datasets

COLUMNS = ("id", "where", "printed", "used", "evidence")
FIG4 = {"thickness": 0.4, "height": 4.0}  # m
FIG4_RESTITUTION = 0.955
FIG5 = {"thickness": 0.3, "height": 15 * 0.3, "hinge_ratio": 0.7}  # m, m, -
FIG8 = {"thickness": 0.102, "height": 27 * 0.102}  # m
Evidence = Callable[[Datasets], dict[str, str]]


def read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the data file of errata; its head says what the keys mean."""
    errata: list[dict[str, Any]] = yaml.safe_load(Path(path).read_text(encoding="utf-8"))["errata"]
    return errata


def table(errata: Sequence[Mapping[str, str]], datasets: Datasets) -> pd.DataFrame:
    """Return the errata with their evidence, one row each, with the columns `COLUMNS`.

    An erratum without evidence here, evidence without an erratum, or gaps that nothing fills raise `InputError`.
    """
    ids = [entry["id"] for entry in errata]
    for names, known, text in ((ids, EVIDENCE, "has no evidence"), (EVIDENCE, ids, "is not in the data file")):
        for name in (name for name in names if name not in known):
            raise InputError(f"erratum {name} {text}")
    rows = []
    for entry in errata:
        values = EVIDENCE[entry["id"]](datasets)
        gaps = {name for _, name, _, _ in string.Formatter().parse(entry["evidence"]) if name is not None}
        if gaps != set(values):
            raise InputError(
                f"erratum {entry['id']}: evidence has the gaps {', '.join(sorted(gaps)) or 'none'};"
                f" they must be {', '.join(sorted(values))}"
            )
        rows.append({**entry, "evidence": entry["evidence"].format_map(values)})
    return pd.DataFrame(rows, columns=list(COLUMNS))


# --- formulas ------------------------------------------------------------------------------------------------------


def printed_force(wall: Wall, u: float) -> float:
    """Eq. (3) to the letter. [N]"""
    t, ecc, load = float(wall.thickness), float(wall.eccentricity), float(wall.overburden)
    h, h1, h2 = float(wall.height), float(wall.lower_height), float(wall.upper_height)
    return float(
        2 / h1 * wall.weight * (t - u) + h / (h1 * h2) * load * (t + 2 * ecc - u) + 2 / h1 * load * (t - 2 * ecc)
    )


def bilinear_force(wall: Wall, u: float) -> float:
    """The law used, F0 - K0 u for 0 < u < u_ins. [N]"""
    return float(wall.rigid_strength - wall.rigid_stiffness * u)


def eq_3(_: Datasets) -> dict[str, str]:
    """Compare value, slope and zero of the printed law with those of the law used."""
    wall, bare = Wall(**FIG5, overburden_ratio=1.0), Wall(**FIG5)
    f0, u_ins = float(wall.rigid_strength), float(wall.instability_displacement)

    def described(law: Callable[[float], float]) -> tuple[str, str, str]:
        value = law(0.0)
        slope = (value - law(u_ins / 2)) / (u_ins / 2)
        return number(value / f0), number(slope / float(wall.rigid_stiffness)), number(value / slope / u_ins)

    value, slope, zero = described(lambda u: printed_force(wall, u))
    used_value, used_slope, used_zero = described(lambda u: bilinear_force(wall, u))
    at = np.linspace(0.001, 0.999, 5) * float(bare.instability_displacement)
    apart = max(abs(printed_force(bare, u) - bilinear_force(bare, u)) for u in at) / float(bare.rigid_strength)
    return {
        "value": value,
        "slope": slope,
        "zero": zero,
        "used_value": used_value,
        "used_slope": used_slope,
        "used_zero": used_zero,
        "apart": number(round(apart, 12)),
    }


def eq_7(_: Datasets) -> dict[str, str]:
    """Compare both coefficients of restitution."""
    middle, high = (Wall(**FIG4, hinge_ratio=ratio) for ratio in (0.5, 0.7))
    return {
        "printed_middle": number(middle.restitution_rigid),
        "printed_high": number(high.restitution_rigid),
        "impulsive_middle": number(middle.restitution_impulsive),
        "impulsive_high": number(high.restitution_impulsive),
    }


def restitution_of_fig_4(_: Datasets) -> dict[str, str]:
    """Eq. (7) at both ends of the hinge's range, and the height of the hinge that gives Fig. 4's e."""

    def excess(ratio: float) -> float:
        return float(Wall(**FIG4, hinge_ratio=ratio).restitution_rigid) - FIG4_RESTITUTION

    low, high = (number(Wall(**FIG4, hinge_ratio=ratio).restitution_rigid) for ratio in (0.5, 0.7))
    return {"low": low, "high": high, "needed": number(brentq(excess, 0.5, 0.99))}


def energy_of_eq_13_and_14(_: Datasets) -> dict[str, str]:
    """Generalised over mechanical: inertia, and work of the restoring force."""

    wall = Wall(**FIG5)
    bodies = TwoBodies(wall)
    return {
        "force": number(wall.rigid_strength / bodies.potential_slope(0.0)),
        "inertia": number(wall.effective_mass / bodies.inertia(float(wall.thickness))),
        "at_rest": number(wall.effective_mass / bodies.inertia(0.0)),
    }


def hinge_ratio_of_fig_6(_: Datasets) -> dict[str, str]:
    """Put the hinge of a wall at its base."""
    try:
        Wall(**{**FIG5, "hinge_ratio": 0.0})
    except InputError as error:
        refusal = str(error)
    low = Wall(**{**FIG5, "hinge_ratio": 0.07})
    lower = 1e-9 * FIG5["height"]
    product, square = lower * (lower + FIG5["height"]), 3 * FIG5["thickness"] ** 2  # of Eq. (7)
    return {
        "refusal": refusal,
        "limit": number((product - square) / (product + square)),
        "growth": number(low.rigid_strength / Wall(**FIG5).rigid_strength),
    }


def lambda_of_captions(_: Datasets) -> dict[str, str]:
    """Eq. (4), and the height of Fig. 8's wall."""
    return {"factor": number(Wall(**FIG5).excitation_factor), "height": number(Wall(**FIG8).height)}


def a1_of_section_7(_: Datasets) -> dict[str, str]:
    """Ends of the plateaus."""
    ends = (float(TrilinearCurve(0.02, b1).plateau_end) for b1 in (0.85, 0.80))
    return dict(zip(("end", "end_wall"), map(number, ends), strict=True))


# --- datasets ------------------------------------------------------------------------------------------------------


def eq_17(data: Datasets) -> dict[str, str]:
    """Damping ratios by the words of Eq. (17) over those by its formula, less one."""
    match = data["match/amplitude"].sortby("restitution")
    release = float(data["damping_force"]["release_amplitude"])
    squares = match["damping_ratio"].sel(release_amplitude=release, method="nearest")
    change = (match["damping_ratio_absolute"] / squares - 1).sel(damping_model=MODELS)
    ends = {model: (float(of.min()), float(of.max())) for model, of in zip(MODELS, change, strict=True)}
    return {
        "release": number(release),
        "low": number(match["restitution"][0]),
        "high": number(match["restitution"][-1]),
        **{model.lower(): f"{percent(least)} to {percent(most)}" for model, (least, most) in ends.items()},
    }


def sdr_and_a1(data: Datasets) -> dict[str, str]:
    """Direction of the change of SDR's damping ratio with a1."""
    dim = "yield_displacement_ratio"
    xi = ratios(data["match/cracked_stiffness"]).sel(damping_model="SDR").sortby(dim)
    mean = xi.mean("restitution").values
    return {
        "low": number(xi[dim][0]),
        "high": number(xi[dim][-1]),
        "xi_low": number(mean[0]),
        "xi_high": number(mean[-1]),
        "more": str(int(steady(xi, dim, -1).sum())),
        "less": str(int(steady(xi, dim, 1).sum())),
        "count": str(xi.sizes["restitution"]),
    }


def err_range_and_err_e(data: Datasets) -> dict[str, str]:
    """Lengths of the response at which each of the two sentences holds."""
    response_lengths = data["response_lengths"]
    in_range = response_lengths["cdr_lowest_in_paper_range"].astype(bool)
    rises = response_lengths["error_rises_as_restitution_falls"].astype(bool)
    models = {model: rises.sel(damping_model=model).drop_vars("damping_model") for model in MODELS}
    together = models["CDC"] & models["CDR"] & models["SDR"]
    least = response_lengths["error"].sel(damping_model=MODELS).idxmin("damping_model") == "CDR"
    of_rising = least.sum("restitution").where(models["SDR"], 0)
    error = (
        response_lengths["rms_error"]
        .sel(response_length=float(response_lengths["inferred_response_length"]), method="nearest")
        .sortby("restitution")
    )
    sdr, cdr = (error.sel(damping_model=model) for model in ("SDR", "CDR"))
    return {
        "range": spans(in_range, "tau"),
        "all_rise": spans(together, "tau"),
        "both": spans(in_range & together, "tau"),
        **{model.lower(): spans(held, "tau") for model, held in models.items()},
        "response_length": number(error["response_length"]),
        "top": number(sdr.idxmax("restitution")),
        "lowest": number(sdr["restitution"][0]),
        "share": percent(sdr[0] / sdr.max()),
        "share_cdr": percent(cdr[0] / cdr.max()),
        "most": str(int(of_rising.max())),
        "count": str(response_lengths.sizes["restitution"]),
    }


EVIDENCE: dict[str, Evidence] = by_id(
    *(eq_3, eq_7, restitution_of_fig_4, energy_of_eq_13_and_14, eq_17, hinge_ratio_of_fig_6, lambda_of_captions),
    *(a1_of_section_7, sdr_and_a1, err_range_and_err_e),
)
