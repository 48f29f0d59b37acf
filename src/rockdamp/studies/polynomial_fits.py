"""Second-order polynomials xi(e) for each viscous model and a1: Fig. 7."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import giannini_masiani

DEGREE = 2
ROUNDING = 1e-9  # of e
RANGES = (0.90, 0.96, 1.00)  # of e: ends of those whose largest relative error is told


def fit(config: Config, matched: xr.Dataset) -> xr.Dataset:
    """Fit xi(e) = c0 + c1 e + c2 e^2 by least squares, for each model and each a1 of the reference plateau.

    Beside the paper's polynomial, which does not vanish at e = 1, stands one that does: xi = delta (d0 + d1 delta +
    d2 delta^2), delta = -ln(e), of the least squares of xi/delta. Both hold over the range of the matched e.
    """
    same = np.isclose(matched["strength_ratio"].values, config.curve.strength_ratio)
    matched = matched.isel(yield_displacement_ratio=np.flatnonzero(same)).drop_vars(
        ["strength_ratio", "step", "steps"], errors="ignore"
    )
    e = matched["restitution"].values
    ratio = matched["damping_ratio"].transpose("damping_model", "yield_displacement_ratio", "restitution")
    rows = ratio.values.reshape(-1, e.size)
    coefficient, fitted = _least_squares(e, rows, np.ones(e.size))
    in_delta, delta_fitted = _least_squares(delta(e), rows, delta(e))
    residual = rows - fitted
    total = ((rows - rows.mean(axis=1, keepdims=True)) ** 2).sum(axis=1)
    lead = ("damping_model", "yield_displacement_ratio")

    def shape_fits(values: Array, *dims: str) -> tuple[tuple[str, ...], Array]:
        return (*lead, *dims), values.reshape(*ratio.shape[:2], *values.shape[1:])

    return xr.Dataset(
        {
            "coefficient": shape_fits(coefficient, "degree"),
            "delta_coefficient": shape_fits(in_delta, "degree"),
            "damping_ratio": ratio,
            "damping_ratio_uncertainty": matched["damping_ratio_uncertainty"].transpose(*ratio.dims),
            "damping_ratio_fit": shape_fits(fitted, "restitution"),
            "damping_ratio_delta_fit": shape_fits(delta_fitted, "restitution"),
            "damping_ratio_energy": matched["damping_ratio_energy"].transpose(*ratio.dims),
            "giannini_masiani": ("restitution", giannini_masiani(e)),
            "r_squared": shape_fits(1 - (residual**2).sum(axis=1) / total),
            "largest_residual": shape_fits(np.abs(residual).max(axis=1)),
            "largest_relative_error": shape_fits(_largest_relative(e, rows, fitted), "restitution_range"),
            "delta_largest_relative_error": shape_fits(_largest_relative(e, rows, delta_fitted), "restitution_range"),
        },
        coords={
            **ratio.coords,
            "degree": np.arange(DEGREE + 1),
            "restitution_range": list(RANGES),
            "strength_ratio": config.curve.strength_ratio,
            "ultimate_displacement_ratio": config.curve.ultimate_displacement_ratio,
            "release_amplitude": config.release_amplitude,
        },
    ).drop_vars("frequency_parameter")


def delta(restitution: Array) -> Array:
    """Return -ln(e), without the sign of zero. [-]"""
    return 0.0 - np.log(restitution)


def _least_squares(x: Array, rows: Array, factor: Array) -> tuple[Array, Array]:
    """Polynomials p in x for which factor p(x) is near each row, by the squares of row/factor - p(x); and factor p(x).

    Where the factor vanishes, so do row and fit: that value decides nothing.
    """
    powers, some = np.vander(x, DEGREE + 1, increasing=True), factor > 0
    coefficient, _, _, _ = np.linalg.lstsq(powers[some], (rows[:, some] / factor[some]).T, rcond=None)
    return np.asarray(coefficient.T, dtype=float), factor * (powers @ coefficient).T


def _largest_relative(e: Array, rows: Array, fitted: Array) -> Array:
    """Largest |fitted/row - 1| from each range of e, beginning beyond the one before; NaN of a range without values."""
    largest = np.full((len(rows), len(RANGES)), np.nan)
    for column, (low, high) in enumerate(pairwise((0.0, *RANGES))):
        own = (e > low + ROUNDING) & (e <= high + ROUNDING) & (e < 1)
        if own.any():
            largest[:, column] = np.abs(fitted[:, own] / rows[:, own] - 1).max(axis=1)
    return largest


def table(equivalence: xr.Dataset) -> pd.DataFrame:
    """Return the polynomials as a table, a row for each model and a1, with their errors and range of validity.

    xi = c0 + c1 e + c2 e^2, or delta (d0 + d1 delta + d2 delta^2) with delta = -ln(e).
    """
    rows = []
    for model in equivalence["damping_model"].values:
        for a1 in equivalence["yield_displacement_ratio"].values:
            fitted = equivalence.sel(damping_model=model, yield_displacement_ratio=a1)
            rows.append(
                {
                    "damping_model": str(model),
                    "yield_displacement_ratio": float(a1),
                    **{f"c{k}": float(value) for k, value in enumerate(fitted["coefficient"].values)},
                    **{f"d{k}": float(value) for k, value in enumerate(fitted["delta_coefficient"].values)},
                    "r_squared": float(fitted["r_squared"]),
                    "largest_residual": float(fitted["largest_residual"]),
                    **{
                        f"{name}_to_{float(end):.2f}": float(fitted[name].sel(restitution_range=end))
                        for name in ("largest_relative_error", "delta_largest_relative_error")
                        for end in equivalence["restitution_range"].values
                    },
                    "smallest_restitution": float(equivalence["restitution"].min()),
                    "largest_restitution": float(equivalence["restitution"].max()),
                }
            )
    return pd.DataFrame(rows)
