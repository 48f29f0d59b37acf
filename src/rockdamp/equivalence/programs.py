"""What to type into a program that has viscous damping alone: which damper, its ratio, and dashpots.

Commands, report and documents take from here which damper is for which program.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import TypedDict

import numpy as np

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import damper_classes
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.plausibility import as_meant
from rockdamp.vocabulary import RECOMMENDED, VISCOUS_MODELS

BRANCHES = 3  # of the curve
REFERS_TO = {
    "CDC": "w1",
    "CDR": "secant frequency",
    "SDR": "w1, with secant stiffness",
    "ECD": "V(u)",
    RECOMMENDED: "u, v and w1",
}
# By model what a program must take; the first that it can take errs least.
OFFERS = {RECOMMENDED: "a formula in u and v", "CDR": "a coefficient at the secant", "CDC": "a constant"}


class ProgramInput(TypedDict):
    """One viscous damper as a program takes it.

    `damping_ratio` has the least Err, Eq. (17), or is by the closed form where no ratio has; `false_safe_rate` is its
    share of the collapses under restitution that it misses, `false_safe_restitution` the e of that study. [-]
    `damping_coefficient` is C of the whole wall, None where C varies with displacement or velocity. [N s m-1]
    """

    damping_model: str
    damping_ratio: float
    rms_error: float | None
    damping_ratio_energy: float
    refers_to: str
    damping_coefficient: float | None
    false_safe_rate: float


def frequencies(wall: Wall | Parapet | OneSidedWall, curve: TrilinearCurve) -> tuple[float, float]:
    """Return the angular frequency w1 of the curve's first branch [rad s-1], and its period T1 [s]."""
    w1 = float(wall.frequency_parameter * curve.initial_frequency)
    return w1, 2 * np.pi / w1


def dashpot(wall: Wall | Parapet, curve: TrilinearCurve, damping_model: str, damping_ratio: float) -> float | None:
    """Return C = 2 xi m_eff w1 of a damper whose coefficient is constant on the whole curve, else None. [N s m-1]"""
    if damper_classes()[damping_model].linear_branches != BRANCHES:
        return None
    return float(2 * damping_ratio * wall.effective_mass * frequencies(wall, curve)[0])


def program_inputs(wall: Wall | Parapet, curve: TrilinearCurve, restitution: float) -> list[ProgramInput]:
    """Return each viscous damper that stands for a coefficient of restitution, as a program takes it.

    The wall is released from half of a3.
    """
    a3 = float(curve.ultimate_displacement_ratio)
    x0 = 0.5 * a3
    a1, b1 = float(curve.yield_displacement_ratio), float(curve.strength_ratio)
    matched: dict[str, tuple[float, float | None]] = {}
    with as_meant():  # what is unlikely of e and the curve was said where they were stated
        energies = {model: float(damping_ratio_energy(curve, model, restitution, x0)) for model in VISCOUS_MODELS}
    try:
        with as_meant():
            matched_rows = equivalent(restitution, a1, b1, a3, curve.softening, release_amplitude=x0)
        matched = {row["damping_model"]: (row["damping_ratio"], row["rms_error"]) for row in matched_rows}
    except InputError:  # for some curves no damping ratio within reach errs least
        pass
    rows: list[ProgramInput] = []
    for model, energy in energies.items():
        xi, error = matched.get(model, (energy, None))
        rows.append(
            {
                "damping_model": model,
                "damping_ratio": xi,
                "rms_error": error,
                "damping_ratio_energy": energy,
                "refers_to": refers_to(model),
                "damping_coefficient": dashpot(wall, curve, model, xi),
                "false_safe_rate": false_safe(restitution)[1][model],
            }
        )
    return rows


def refers_to(model: str) -> str:
    """Say to which frequency a damper's ratio refers."""
    return REFERS_TO[model]


def advice(restitution: float) -> str:
    """Say which damper to take for which program, and which share of the collapses under restitution each misses."""
    e, missed = false_safe(restitution)
    rows = [f"{model} ({100 * missed[model]:.2g} % missed) if it takes {offer}" for model, offer in OFFERS.items()]
    return (
        f"Use the first that your program can take: {'; '.join(rows)}. Missed: collapses under restitution that do not "
        f"happen with the damper, on the walls of config/default.yaml under the records of FEMA P695 at e = {e:g}."
    )


def false_safe(restitution: float) -> tuple[float, dict[str, float]]:
    """Return the studied e nearest to `restitution`, and by model the share of collapses that it misses there. [-]"""
    shipped = _shipped()
    e = min(shipped, key=lambda studied: abs(studied - restitution))
    return e, shipped[e]


@cache
def _shipped() -> dict[float, dict[str, float]]:
    """Return the shares that the package ships, by e and model; `tools/measured_tables.py` writes them."""
    table: dict[float, dict[str, float]] = {}
    text = Path(__file__).with_name("false_safe.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(text.splitlines()):
        table.setdefault(float(row["restitution"]), {})[row["damping_model"]] = float(row["false_safe_rate"])
    return table
