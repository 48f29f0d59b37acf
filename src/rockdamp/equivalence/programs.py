"""What to type into a program that has viscous damping alone: which damper, its ratio, and dashpots.

Commands, report and documents take from here which damper is for which program.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall

REFERENCE_QUANTITY = {  # to which xi refers
    "CDC": "w1",
    "CDR": "secant frequency",
    "SDR": "w1, with secant stiffness",
    "ECD": "V(u)",
    "BAND": "u, v and w1",
}
# By model what a program must take; the first that it can take errs least.
REQUIREMENT = {
    "BAND": "a formula in u and v",
    "CDR": "a coefficient at the secant",
    "CDC": "a constant",
}


def describe_damping(
    wall: Wall | Parapet, curve: TrilinearCurve, restitution: float
) -> dict[str, Any]:
    """Return what a program with viscous damping needs for a coefficient of restitution; the release is half of a3.

    ``initial_frequency`` w1 [rad s-1] and ``initial_period`` T1 [s] of the first branch, ``damping_restitution``,
    ``damping_coefficient`` C = 2 xi m_eff w1 of CDC [N s m-1], ``rayleigh_alpha_m`` = 2 xi w1 of CDC [s-1], and in
    ``damping`` a row for each viscous damper: its ratio of least Err, Eq. (17), with the ``rms_error`` sqrt(Err/k) in
    u/u_ins, or by the closed form where no ratio has the least; C, None where it varies with u or v; and the share of
    the collapses under restitution that it misses, at the nearest studied e.
    """
    x0, w1 = (
        0.5 * float(curve.ultimate_displacement_ratio),
        float(wall.frequency_parameter * curve.initial_frequency),
    )
    try:
        matched = equivalent(restitution, curve, release_amplitude=x0)
    except InputError:  # for some curves no damping ratio within reach errs least
        energy = {
            model: float(damping_ratio_energy(curve, model, restitution, x0))
            for model in VISCOUS_MODELS
        }
        names = ("damping_model", "damping_ratio", "rms_error", "damping_ratio_energy")
        matched = [
            dict(zip(names, (model, xi, None, xi), strict=True)) for model, xi in energy.items()
        ]
    missed = missed_collapses(restitution)[1]
    alpha = {row["damping_model"]: 2 * row["damping_ratio"] * w1 for row in matched}["CDC"]
    coefficient = float(alpha * wall.effective_mass)
    rows = [
        {
            **{
                name: row[name]
                for name in ("damping_model", "damping_ratio", "rms_error", "damping_ratio_energy")
            },
            "refers_to": REFERENCE_QUANTITY[row["damping_model"]],
            "damping_coefficient": coefficient if row["damping_model"] == "CDC" else None,
            "missed_collapse_rate": missed[row["damping_model"]],
        }
        for row in matched
    ]
    return {
        "initial_frequency": w1,
        "initial_period": 2 * np.pi / w1,
        "damping_restitution": restitution,
        "damping_coefficient": coefficient,
        "rayleigh_alpha_m": alpha,
        "damping": rows,
    }


@cache
def missed_collapses(restitution: float) -> tuple[float, dict[str, float]]:
    """Return the studied e nearest to `restitution`, and by model the share of collapses that it misses there. [-]

    `tools/shipped_tables.py` writes the shares that the package ships.
    """
    with Path(__file__).with_name("missed_collapses.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    e = min(
        {float(row["restitution"]) for row in rows}, key=lambda studied: abs(studied - restitution)
    )
    here = [row for row in rows if float(row["restitution"]) == e]
    return e, {row["damping_model"]: float(row["missed_collapse_rate"]) for row in here}
