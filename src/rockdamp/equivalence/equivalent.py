"""The equivalence for one wall and one coefficient of restitution, or for several of them."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import RESTITUTION, damping_ratio_energy
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
    """Return the damping ratio of each viscous model that is equivalent to a coefficient of restitution.

    Parameters
    ----------
    restitution : float or sequence of float
        e of releases from 0.3 to 0.5 u_ins, in (0, 1]. [-]
    curve : TrilinearCurve
        Of one wall.
    release_amplitude : float
        u0/u_ins of the decay that is matched, in (0, a3). [-]
    response_length : float
        Length of the response over which Eq. (17) is summed, in tau; longer than the time to the first impact. [-]

    Returns
    -------
    list of dict
        One for each e, ascending, and model: ``restitution``, ``damping_model``, ``damping_ratio`` (global minimum of
        Eq. 17), ``rms_error`` (sqrt(Err/k), in u/u_ins), ``damping_ratio_energy`` (closed form; for ECD and BAND exact)
        and ``damping_ratio_fit`` (the shipped polynomials of the reference curve, b1 = 0.85 and u0 = 0.5 u_ins, linear
        in a1 between them; None outside their range of e and a1).

    Examples
    --------
    >>> import rockdamp as rd
    >>> rows = rd.equivalent(
    ...     0.85, rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    ... )
    >>> {row["damping_model"]: f"{row['damping_ratio']:.4f}" for row in rows}["BAND"]
    '0.0517'
    """
    e = np.atleast_1d(check("restitution", restitution, *RESTITUTION))
    check_type("curve", curve, TrilinearCurve)
    finite = "a finite number"
    x0 = check_number("release_amplitude", release_amplitude, np.isfinite, finite)
    amplitude = np.full(e.size, x0)
    check_number(
        "response_length", response_length, lambda length: length > 0, "greater than 0, in tau"
    )
    a1, curves = (
        float(curve.yield_displacement_ratio),
        curve.map(lambda parameter: np.full(e.size, parameter)),
    )
    energy = {
        model: damping_ratio_energy(curve, model, e, amplitude).tolist() for model in VISCOUS_MODELS
    }
    rows, fits = [], shipped_polynomials()
    for model, matched in least_error(curves, e, amplitude, response_length).items():
        columns = {
            "restitution": e.tolist(),
            "damping_model": [model] * e.size,
            "damping_ratio": matched.damping_ratio.tolist(),
            "rms_error": matched.rms_error.tolist(),
            "damping_ratio_energy": energy[model],
            "damping_ratio_fit": [
                None if np.isnan(fit) else fit for fit in fits(model, e, a1).tolist()
            ],
        }
        rows += [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ]
    return sorted(rows, key=itemgetter("restitution"))


def equivalent_restitution(
    damping_ratio: float, curve: TrilinearCurve, *, release_amplitude: float = 0.5
) -> list[dict[str, Any]]:
    """Return the coefficient of restitution that a damping ratio of each viscous model is equivalent to.

    Parameters
    ----------
    damping_ratio : float
        xi of least error, as of `equivalent`. [-]
    curve, release_amplitude
        As for `equivalent`.

    Returns
    -------
    list of dict
        One for each model: ``damping_model``, ``damping_ratio`` and ``restitution``, None beyond 0.60 to 0.99.

    Examples
    --------
    >>> import rockdamp as rd
    >>> from rockdamp.equivalence.equivalent import equivalent_restitution
    >>> cdc, *_ = equivalent_restitution(0.05, rd.TrilinearCurve(0.04, 0.85))
    >>> cdc["damping_model"], f"{cdc['restitution']:.3f}"
    ('CDC', '0.776')
    """
    check("damping_ratio", damping_ratio, lambda xi: xi > 0, "greater than 0")
    tried = np.arange(0.60, 0.995, 0.01)  # e, between which it is linear
    by_model: dict[str, list[float]] = {}
    for row in equivalent(tried, curve, release_amplitude=release_amplitude):
        by_model.setdefault(row["damping_model"], []).append(row["damping_ratio"])
    rows = []
    for model, ratios in by_model.items():
        e = np.interp(damping_ratio, ratios[::-1], tried[::-1], left=np.nan, right=np.nan)
        restitution = None if np.isnan(e) else float(e)
        rows.append(
            {"damping_model": model, "damping_ratio": damping_ratio, "restitution": restitution}
        )
    return rows


def least_error(
    curve: TrilinearCurve,
    restitution: Array,
    release_amplitude: Array,
    response_length: float = DEFAULT_RESPONSE_LENGTH,
    damping_models: Sequence[str] = VISCOUS_MODELS,
) -> dict[str, Matched]:
    """Return the ratios of least Err, Eq. (17), by model, of walls that `default_step` gives one step.

    Every array and every parameter of the curve has the shape (walls,). A wall has the same ratios whatever walls stand
    beside it. It raises `InputError` where Err has no minimum within reach, or the response ends before the first
    impact.
    """
    steps = int(np.ceil(response_length / float(default_step(curve).min())))
    cases = Cases.release(
        curve, release_amplitude, restitution, step=response_length / steps, steps=steps
    )
    return match_dampers(cases, damping_models, steps)
