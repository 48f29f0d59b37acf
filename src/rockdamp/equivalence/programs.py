"""What to type into a program that has viscous damping alone: which damper, its ratio, and dashpots.

Commands, report and documents take from here which damper is for which program.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import Parapet, Wall

REFERENCE_QUANTITY = {  # to which xi refers
    "CDC": "w1",
    "CDR": "secant frequency",
    "SDR": "w1, with secant stiffness",
    "ECD": "V(u)",
    "BAND": "u, v and w1",
}
# By model what a program must take; the first that it can take errs least.
REQUIREMENT = {"BAND": "a formula in u and v", "CDR": "a coefficient at the secant", "CDC": "a constant"}


@dataclass(frozen=True)
class ProgramInput:
    """One viscous damper as a program takes it."""

    damping_model: str
    damping_ratio: float  # of least Err, Eq. (17), or by the closed form where no ratio has it [-]
    rms_error: float | None  # sqrt(Err/k), in u/u_ins [-]
    damping_ratio_energy: float  # by the closed form [-]
    refers_to: str
    damping_coefficient: float | None  # C of the whole wall; None where it varies with u or v [N s m-1]
    missed_collapse_rate: float  # share of the collapses under restitution that it misses, at the nearest studied e [-]


def frequencies(wall: Wall | Parapet | OneSidedWall, curve: TrilinearCurve) -> tuple[float, float]:
    """Return the angular frequency w1 of the curve's first branch [rad s-1], and its period T1 [s]."""
    w1 = float(wall.frequency_parameter * curve.initial_frequency)
    return w1, 2 * np.pi / w1


def dashpot(wall: Wall | Parapet, curve: TrilinearCurve, damping_model: str, damping_ratio: float) -> float | None:
    """Return C = 2 xi m_eff w1 of CDC, whose coefficient is constant, else None. [N s m-1]"""
    w1, _ = frequencies(wall, curve)
    return float(2 * damping_ratio * wall.effective_mass * w1) if damping_model == "CDC" else None


def program_inputs(wall: Wall | Parapet, curve: TrilinearCurve, restitution: float) -> list[ProgramInput]:
    """Return each viscous damper that stands for a coefficient of restitution, as a program takes it.

    The wall is released from half of a3.
    """
    x0 = 0.5 * float(curve.ultimate_displacement_ratio)
    try:
        rows = equivalent(restitution, curve, release_amplitude=x0)
    except InputError:  # for some curves no damping ratio within reach errs least
        energy = {model: float(damping_ratio_energy(curve, model, restitution, x0)) for model in VISCOUS_MODELS}
        names = "damping_model", "damping_ratio", "rms_error", "damping_ratio_energy"
        rows = [dict(zip(names, (model, xi, None, xi), strict=True)) for model, xi in energy.items()]
    missed, found = missed_collapses(restitution)[1], []
    for row in rows:
        model, xi = row["damping_model"], row["damping_ratio"]
        energy, coefficient = row["damping_ratio_energy"], dashpot(wall, curve, model, xi)
        quantity = REFERENCE_QUANTITY[model]
        found.append(ProgramInput(model, xi, row["rms_error"], energy, quantity, coefficient, missed[model]))
    return found


@cache
def missed_collapses(restitution: float) -> tuple[float, dict[str, float]]:
    """Return the studied e nearest to `restitution`, and by model the share of collapses that it misses there. [-]

    `tools/shipped_tables.py` writes the shares that the package ships.
    """
    with Path(__file__).with_name("missed_collapses.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    e = min({float(row["restitution"]) for row in rows}, key=lambda studied: abs(studied - restitution))
    here = [row for row in rows if float(row["restitution"]) == e]
    return e, {row["damping_model"]: float(row["missed_collapse_rate"]) for row in here}
