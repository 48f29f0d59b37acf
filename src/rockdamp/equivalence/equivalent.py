"""The equivalence for one wall and one coefficient of restitution, or for as many as are given."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import instance, number
from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import check_restitution, damping_ratio_energy
from rockdamp.equivalence.matching import REFINEMENT, Matched, solve
from rockdamp.equivalence.minima import Cases
from rockdamp.equivalence.polynomials import shipped
from rockdamp.errors import InputError, require
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.plausibility import of_restitution, per_cent, warn
from rockdamp.questions import of_start
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS

STEP = 0.0025  # in tau, at most: that of the studies
FINEST = 1 / 60  # of the stability limit, for curves stiffer than the studies'
MOST_STEPS = 20_000_000  # of the last minimisation's decays together: 160 MB


class Equivalent(TypedDict):
    """A row of `equivalent`: the damping ratio of one viscous model that replaces one coefficient of restitution.

    Attributes
    ----------
    restitution : float
        e. [-]
    damping_model : str
    damping_ratio : float
        Global minimum of Err, Eq. (17). [-]
    rms_error : float
        sqrt(Err/k), in u/u_ins. [-]
    damping_ratio_energy : float
        Closed form; for ECD and BAND exact. [-]
    damping_ratio_fit : float or None
        By the shipped polynomials; None outside their range of e and a1. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> cdc: rd.Equivalent = rd.equivalent(0.85, yield_displacement_ratio=0.04, strength_ratio=0.85)[0]
    >>> list(cdc)
    ['restitution', 'damping_model', 'damping_ratio', 'rms_error', 'damping_ratio_energy', 'damping_ratio_fit']
    """

    restitution: float
    damping_model: str
    damping_ratio: float
    rms_error: float
    damping_ratio_energy: float
    damping_ratio_fit: float | None


def equivalent(
    restitution: ArrayLike,
    yield_displacement_ratio: float,
    strength_ratio: float,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    release_amplitude: float = 0.5,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
) -> list[Equivalent]:
    """Return the damping ratio of each viscous model that is equivalent to a coefficient of restitution.

    Parameters
    ----------
    restitution : float or sequence of float
        e of releases from 0.3 to 0.5 u_ins, in (0, 1]. [-]
    yield_displacement_ratio, strength_ratio, ultimate_displacement_ratio : float
        a1, b1, a3 of the curve. [-]
    softening : {"steeper", "translated"}
        Variant of the curve for a3 < 1.
    release_amplitude : float
        u0/u_ins of the decay that is matched, in (0, a3). [-]
    response_length : float
        Length of the response over which Eq. (17) is summed, in tau. [-]

    Returns
    -------
    list of Equivalent
        A dict for each e and model: ``restitution``, ``damping_model``, ``damping_ratio`` (global minimum of Eq. 17),
        ``rms_error`` (sqrt(Err/k), in u/u_ins), ``damping_ratio_energy`` (closed form; for ECD and BAND exact) and
        ``damping_ratio_fit`` (the shipped polynomials of the reference curve, b1 = 0.85 and u0 = 0.5 u_ins, linear in
        a1 between them; None outside their range of e and a1).

    Raises
    ------
    InputError
        If a value lies outside its range, or the response length ends before the first impact.

    Examples
    --------
    >>> import rockdamp as rd
    >>> rows = rd.equivalent(0.85, yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> {row["damping_model"]: f"{row['damping_ratio']:.4f}" for row in rows}["BAND"]
    '0.0517'
    """
    e = np.atleast_1d(check_restitution(restitution))
    require(e.ndim == 1 and e.size > 0, "the shape of restitution", str(e.shape), "one number or some in a row")
    ratios = (yield_displacement_ratio, strength_ratio, ultimate_displacement_ratio)
    a1, b1, a3 = map(number, RULES, ratios)
    curve = TrilinearCurve(a1, b1, a3, softening)
    response_length = number("response_length", response_length)
    release_amplitude = number("release_amplitude", release_amplitude)
    allowed = f"greater than 0 and less than a3{per_cent(release_amplitude, lambda x0: x0 < a3)}"
    require(0 < release_amplitude < a3, "release_amplitude", release_amplitude, allowed)
    warn([*of_restitution(e), *of_start(release_amplitude, a1)])
    require(response_length > 0, "response_length", response_length, "greater than 0 (in tau)")
    batch = curve.map(lambda parameter: np.full(e.size, parameter))
    amplitude = np.full(e.size, release_amplitude)
    rows: list[Equivalent] = []
    for model, matched in least_error(batch, e, amplitude, response_length).items():
        energy = damping_ratio_energy(batch, model, e, amplitude)
        fit = shipped()(model, e, float(curve.yield_displacement_ratio))
        rows += [
            {
                "restitution": float(e[i]),
                "damping_model": model,
                "damping_ratio": float(matched.damping_ratio[i]),
                "rms_error": float(matched.rms_error[i]),
                "damping_ratio_energy": float(energy[i]),
                "damping_ratio_fit": None if np.isnan(fit[i]) else float(fit[i]),
            }
            for i in range(e.size)
        ]
    return sorted(rows, key=itemgetter("restitution"))


def least_error(
    curve: TrilinearCurve,
    restitution: Array,
    release_amplitude: Array,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
    damping_models: Sequence[str] = VISCOUS_MODELS,
) -> dict[str, Matched]:
    """Return the ratios of least Err, Eq. (17), by model, of walls that `longest_step` gives one step.

    Every array and every parameter of the curve has the shape (walls,). A wall has the same ratios whatever walls stand
    beside it. It raises `InputError` where Err has no minimum within reach, or the response ends before the first
    impact.
    """
    step = float(longest_step(curve).min())
    _require_affordable(response_length, step, restitution.size, float(np.min(curve.yield_displacement_ratio)))
    steps = int(np.ceil(response_length / step))
    cases = Cases.released(curve, release_amplitude, restitution, step=response_length / steps, steps=steps)
    return solve(cases, damping_models, steps)


def longest_step(curve: TrilinearCurve) -> Array:
    """Return the longest step at which Err of a curve is searched: that of the studies, or less if it is stiffer."""
    return np.minimum(STEP, FINEST * 2 / curve.initial_frequency)


def _require_affordable(response_length: float, step: float, count: int, a1: float) -> None:
    steps = count * REFINEMENT * response_length / step
    if steps > MOST_STEPS:
        raise InputError(
            f"response_length is {response_length:g}, which takes {steps:.3g} steps with {count} values of e and"
            f" a1 = {a1:g}; they must be at most {MOST_STEPS:.3g} together"
        )


def equivalent_dampings(
    restitution: float,
    curve: TrilinearCurve,
    release_amplitude: float = 0.5,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
) -> list[Damping]:
    """Return CR, and each viscous model at the damping ratio that is equivalent to it by Eq. (17).

    Parameters
    ----------
    restitution : float
        e, in (0, 1]. [-]
    curve : TrilinearCurve
        Of one wall.
    release_amplitude, response_length : float
        As for `equivalent`. [-]

    Returns
    -------
    list of Damping

    Raises
    ------
    InputError
        As `equivalent`.

    Examples
    --------
    >>> import rockdamp as rd
    >>> dampings = rd.equivalent_dampings(0.85, rd.TrilinearCurve.preset("moderate"))
    >>> [damping.model for damping in dampings[:4]]
    ['CR', 'CDC', 'CDR', 'SDR']
    """
    e, shape = number("restitution (e)", restitution), instance("curve", curve, TrilinearCurve).shape
    require(shape == (), "the shape of the curve", str(shape), "(), one curve")
    a1, b1, a3 = (float(getattr(curve, name)) for name in RULES)
    rows = equivalent(e, a1, b1, a3, curve.softening, release_amplitude, response_length)
    return [Damping.cr(restitution), *(Damping(row["damping_model"], row["damping_ratio"]) for row in rows)]
