"""Input of structural programs that have viscous damping alone: damper, ratio and dashpot.

Commands, report and documents read here which damper suits which program.
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

# Frequency that xi is multiplied by, by damper.
REFERENCE_QUANTITY = {
    "CDC": "w1",
    "CDR": "secant frequency",
    "SDR": "w1, times secant over initial stiffness",
    "ECD": "abs(f)/sqrt(2 V), stored energy V(u)",
    "BAND": "none: takes e and w1",
}
# Feature that a program needs for each damper, the damper with the smallest errors first.
REQUIREMENT = {
    "BAND": "a formula in u and v",
    "CDR": "a secant-based coefficient",
    "CDC": "a constant coefficient",
}


def describe_damping(
    wall: Wall | Parapet, curve: TrilinearCurve, restitution: float
) -> dict[str, Any]:
    """Return the input of a program with viscous damping for a coefficient of restitution.

    Parameters
    ----------
    wall : Wall or Parapet
        One wall.
    curve : TrilinearCurve
        Its force-displacement curve.
    restitution : float
        Coefficient of restitution e. [-]

    Returns
    -------
    dict
        ``initial_frequency`` w1 [rad s-1] and ``initial_period`` T1 [s] of the first branch,
        ``damping_restitution`` e, ``damping_coefficient`` C = 2 xi m_eff w1 of CDC [N s m-1],
        ``rayleigh_alpha_m`` = 2 xi w1 of CDC [s-1], and in ``damping`` a row for each viscous
        damper: ``damping_ratio`` of least Err, Eq. (17), for a release from half of a3, with its
        ``rms_error`` in u/u_ins, or by the closed form for BAND, where it is exact, and where no
        ratio has the least error;
        ``damping_coefficient``, None where it varies with u or v; and ``missed_collapse_rate``,
        the share of the collapses under restitution that the damper misses at the nearest e of
        the study of earthquakes.
    """
    w1 = float(wall.frequency_parameter * curve.initial_frequency)
    ratios = _least_error_or_closed_form(curve, restitution)
    (xi,) = (row["damping_ratio"] for row in ratios if row["damping_model"] == "CDC")
    alpha = 2 * xi * w1
    coefficient = float(alpha * wall.effective_mass)
    missed = missed_collapses(restitution)[1]
    rows = []
    for ratio in ratios:
        model = ratio["damping_model"]
        row = {
            "damping_model": model,
            "damping_ratio": ratio["damping_ratio_energy" if model == "BAND" else "damping_ratio"],
            "rms_error": ratio["rms_error"],
            "damping_ratio_energy": ratio["damping_ratio_energy"],
            "refers_to": REFERENCE_QUANTITY[model],
            "damping_coefficient": coefficient if model == "CDC" else None,
            "missed_collapse_rate": missed[model],
        }
        rows.append(row)
    return {
        "initial_frequency": w1,
        "initial_period": 2 * np.pi / w1,
        "damping_restitution": restitution,
        "damping_coefficient": coefficient,
        "rayleigh_alpha_m": alpha,
        "damping": rows,
    }


def _least_error_or_closed_form(curve: TrilinearCurve, restitution: float) -> list[dict[str, Any]]:
    """Return the rows of `equivalent`, or those of the closed form where Err has no minimum."""
    x0 = 0.5 * float(curve.ultimate_displacement_ratio)
    try:
        return equivalent(restitution, curve, release_amplitude=x0)
    except InputError:  # on some curves, Err has no minimum within reach
        rows = []
        for model in VISCOUS_MODELS:
            xi = float(damping_ratio_energy(curve, model, restitution, x0))
            row = {
                "damping_model": model,
                "damping_ratio": xi,
                "rms_error": None,
                "damping_ratio_energy": xi,
            }
            rows.append(row)
        return rows


@cache
def missed_collapses(restitution: float) -> tuple[float, dict[str, float]]:
    """Return the nearest e of the study of earthquakes, and the missed collapses of each model. [-]

    They are shares of the collapses under restitution. `tools/shipped_tables.py` writes the file
    that the package ships.

    Parameters
    ----------
    restitution : float
        Coefficient of restitution e. [-]
    """
    path = Path(__file__).with_name("missed_collapses.csv")
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    restitutions = {float(row["restitution"]) for row in rows}
    nearest = min(restitutions, key=lambda e: abs(e - restitution))
    missed = {
        row["damping_model"]: float(row["missed_collapse_rate"])
        for row in rows
        if float(row["restitution"]) == nearest
    }
    return nearest, missed
