"""The equivalence for one curve and one coefficient of restitution, or several of them."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import RESTITUTION_RULE, damping_ratio_energy
from rockdamp.equivalence.matching import Cases, Matched, match_dampers
from rockdamp.equivalence.polynomials import shipped_polynomials
from rockdamp.errors import check, check_number, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.solvers.newmark import default_step


def equivalent(
    restitution: ArrayLike,
    curve: TrilinearCurve,
    *,
    release_amplitude: float = 0.5,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
) -> list[dict[str, Any]]:
    """Return the damping ratio of each viscous model that is equivalent to an e.

    Parameters
    ----------
    restitution : float or sequence of float
        Coefficient of restitution e, greater than 0 and at most 1, as measured in releases from 0.3
        to 0.5 u_ins. [-]
    curve : TrilinearCurve
        One force-displacement curve.
    release_amplitude : float
        Amplitude u0/u_ins of the decay that is matched, between 0 and a3. [-]
    response_length : float
        Length of the response over which Eq. (17) is summed, in tau. It must be longer than the
        time to the first impact. [-]

    Returns
    -------
    list of dict
        A row for each e, in ascending order, and each model: ``restitution``, ``damping_model``,
        ``damping_ratio`` (global minimum of Eq. (17)), ``rms_error`` (sqrt(Err/k) in u/u_ins),
        ``damping_ratio_energy`` (closed form; exact for ECD and BAND) and ``damping_ratio_fit``
        (the shipped polynomials of the reference curve with b1 = 0.85 and u0 = 0.5 u_ins, linear
        in a1 between them; None outside their range of e and a1).

    Raises
    ------
    InputError
        If a number lies outside its range, Err has no minimum within reach, or the response ends
        before the first impact.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> for row in rd.equivalent(0.85, curve):
    ...     print(row["damping_model"], round(row["damping_ratio"], 4))
    CDC 0.0288
    CDR 0.0447
    SDR 0.0616
    ECD 0.0524
    BAND 0.0517
    """
    e = np.atleast_1d(check("restitution", restitution, *RESTITUTION_RULE))
    check_type("curve", curve, TrilinearCurve)
    x0 = check_number("release_amplitude", release_amplitude, np.isfinite, "a finite number")
    above_0 = "greater than 0, in tau"
    check_number("response_length", response_length, lambda length: length > 0, above_0)
    amplitudes = np.full(e.size, x0)
    curves = curve.map(lambda parameter: np.full(e.size, parameter))
    a1 = float(curve.yield_displacement_ratio)
    polynomials = shipped_polynomials()
    energy = {model: damping_ratio_energy(curve, model, e, amplitudes) for model in VISCOUS_MODELS}
    rows = []
    for model, result in least_error(curves, e, amplitudes, response_length).items():
        fits = polynomials(model, e, a1)
        for index in range(e.size):
            fit = float(fits[index])
            row = {
                "restitution": float(e[index]),
                "damping_model": model,
                "damping_ratio": float(result.damping_ratio[index]),
                "rms_error": float(result.rms_error[index]),
                "damping_ratio_energy": float(energy[model][index]),
                "damping_ratio_fit": None if np.isnan(fit) else fit,
            }
            rows.append(row)
    return sorted(rows, key=itemgetter("restitution"))


def equivalent_restitution(
    damping_ratio: float, curve: TrilinearCurve, *, release_amplitude: float = 0.5
) -> list[dict[str, Any]]:
    """Return the restitution that is equivalent to a damping ratio of each viscous model.

    Parameters
    ----------
    damping_ratio : float
        Damping ratio xi of least error, the ``damping_ratio`` of `equivalent`. [-]
    curve : TrilinearCurve
        One force-displacement curve.
    release_amplitude : float
        Amplitude u0/u_ins of the decay that is matched, between 0 and a3. [-]

    Returns
    -------
    list of dict
        A row for each model: ``damping_model``, ``damping_ratio`` and ``restitution``, which is
        None outside 0.60 to 0.99.

    Examples
    --------
    >>> import rockdamp as rd
    >>> from rockdamp.equivalence.equivalent import equivalent_restitution
    >>> cdc, *_ = equivalent_restitution(0.05, rd.TrilinearCurve(0.04, 0.85))
    >>> cdc["damping_model"], f"{cdc['restitution']:.3f}"
    ('CDC', '0.776')
    """
    xi = check_number("damping_ratio", damping_ratio, lambda xi: xi > 0, "greater than 0")
    # Beyond the e of the studies, 0.70 to 0.98, on both sides. Linear interpolation of xi between
    # these e moves the result by 1.3e-4 at most.
    grid = np.arange(0.60, 0.995, 0.01)
    ratios: dict[str, list[float]] = {model: [] for model in VISCOUS_MODELS}
    for row in equivalent(grid, curve, release_amplitude=release_amplitude):
        ratios[row["damping_model"]].append(row["damping_ratio"])
    rows = []
    for model, falling in ratios.items():
        e = float(np.interp(xi, falling[::-1], grid[::-1], left=np.nan, right=np.nan))
        row = {
            "damping_model": model,
            "damping_ratio": damping_ratio,
            "restitution": None if np.isnan(e) else e,
        }
        rows.append(row)
    return rows


def least_error(
    curve: TrilinearCurve,
    restitution: Array,
    release_amplitude: Array,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
    damping_models: Sequence[str] = VISCOUS_MODELS,
) -> dict[str, Matched]:
    """Return the damping ratios of least Err, Eq. (17), by model.

    The result of a wall does not depend on the walls beside it.

    Parameters
    ----------
    curve : TrilinearCurve
        Curves of one or more walls for which `default_step` is the same, with parameters of shape
        (walls,).
    restitution : ndarray, shape (walls,)
        Coefficient of restitution e, greater than 0 and at most 1. [-]
    release_amplitude : ndarray, shape (walls,)
        Amplitude u0/u_ins, between 0 and a3. [-]
    response_length : float
        Length of the response over which Err is summed, in tau. [-]
    damping_models : sequence of str
        Viscous models.

    Raises
    ------
    InputError
        If Err has no minimum within reach, or the response ends before the first impact.
    """
    steps = int(np.ceil(response_length / float(default_step(curve).min())))
    step = response_length / steps
    cases = Cases.release(curve, release_amplitude, restitution, step=step, steps=steps)
    return match_dampers(cases, damping_models, steps)
