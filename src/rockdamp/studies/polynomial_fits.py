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
# Upper ends of the ranges of e; the largest relative error is stated for each range.
RANGE_ENDS = (0.90, 0.96, 1.00)
POLYNOMIAL_DIMS = ("damping_model", "yield_displacement_ratio")


def fit(config: Config, matched: xr.Dataset) -> xr.Dataset:
    """Fit polynomials by least squares, for each model and each a1 of the reference plateau.

    The paper's polynomial xi(e) = c0 + c1 e + c2 e^2 does not vanish at e = 1. A second one does:
    xi = delta (d0 + d1 delta + d2 delta^2), delta = -ln(e), by the least squares of xi/delta. Both
    hold over the range of the matched e.
    """
    is_reference = np.isclose(matched["strength_ratio"].values, config.curve.strength_ratio)
    matched = (
        matched.isel(yield_displacement_ratio=np.flatnonzero(is_reference))
        .drop_vars(["strength_ratio", "step", "steps", "frequency_parameter"])
        .transpose(*POLYNOMIAL_DIMS, "restitution")
    )
    e = matched["restitution"].values
    ratio = matched["damping_ratio"]
    rows = ratio.values
    delta = 0.0 - np.log(e)  # -np.log(e) would be -0.0 at e = 1
    coefficient, fitted = _least_squares(e, rows, np.ones(e.size))
    delta_coefficient, delta_fitted = _least_squares(delta, rows, delta)
    residual = rows - fitted
    total = ((rows - rows.mean(axis=-1, keepdims=True)) ** 2).sum(axis=-1)
    coefficient_dims = (*POLYNOMIAL_DIMS, "degree")
    range_dims = (*POLYNOMIAL_DIMS, "restitution_range")
    return xr.Dataset(
        {
            "coefficient": (coefficient_dims, coefficient),
            "delta_coefficient": (coefficient_dims, delta_coefficient),
            "damping_ratio": ratio,
            "damping_ratio_uncertainty": matched["damping_ratio_uncertainty"],
            "damping_ratio_fit": ratio.copy(data=fitted),
            "damping_ratio_delta_fit": ratio.copy(data=delta_fitted),
            "damping_ratio_energy": matched["damping_ratio_energy"],
            "giannini_masiani": ("restitution", giannini_masiani(e)),
            "r_squared": (POLYNOMIAL_DIMS, 1 - (residual**2).sum(axis=-1) / total),
            "largest_residual": (POLYNOMIAL_DIMS, np.abs(residual).max(axis=-1)),
            "largest_relative_error": (range_dims, _largest_relative(e, rows, fitted)),
            "delta_largest_relative_error": (
                range_dims,
                _largest_relative(e, rows, delta_fitted),
            ),
        },
        coords={
            "degree": np.arange(DEGREE + 1),
            "restitution_range": list(RANGE_ENDS),
            "strength_ratio": config.curve.strength_ratio,
            "ultimate_displacement_ratio": config.curve.ultimate_displacement_ratio,
            "release_amplitude": config.release_amplitude,
        },
    )


def _least_squares(x: Array, rows: Array, factor: Array) -> tuple[Array, Array]:
    """Return polynomials p for which factor p(x) is near each row, and factor p(x).

    The squares are those of row/factor - p(x). Where the factor vanishes, so do row and fit: that
    value decides nothing. Rows have the shape (..., x).
    """
    powers = np.vander(x, DEGREE + 1, increasing=True)
    is_used = factor > 0
    values = (rows[..., is_used] / factor[is_used]).reshape(-1, is_used.sum()).T
    solution, *_ = np.linalg.lstsq(powers[is_used], values, rcond=None)
    coefficient = np.asarray(solution, dtype=float)
    fitted: Array = factor * (powers @ coefficient).T
    return coefficient.T.reshape(*rows.shape[:-1], -1), fitted.reshape(rows.shape)


def _largest_relative(e: Array, rows: Array, fitted: Array) -> Array:
    """Return the largest |fitted/row - 1| in each range of e; NaN in a range without values."""
    largest = np.full((*rows.shape[:-1], len(RANGE_ENDS)), np.nan)
    for column, (low, high) in enumerate(pairwise((0.0, *RANGE_ENDS))):
        is_inside = (e > low + 1e-9) & (e <= high + 1e-9) & (e < 1)
        if is_inside.any():
            relative = np.abs(fitted[..., is_inside] / rows[..., is_inside] - 1)
            largest[..., column] = relative.max(axis=-1)
    return largest


def table(equivalence: xr.Dataset) -> pd.DataFrame:
    """Return a table of the polynomials, a row for each model and a1.

    The columns are c0 to c2 of xi = c0 + c1 e + c2 e^2, d0 to d2 of xi = delta (d0 + d1 delta +
    d2 delta^2) with delta = -ln(e), and the errors and the range of validity.
    """
    columns = {}
    for letter, name in (("c", "coefficient"), ("d", "delta_coefficient")):
        for degree in range(DEGREE + 1):
            columns[f"{letter}{degree}"] = equivalence[name].sel(degree=degree, drop=True)
    for name in ("r_squared", "largest_residual"):
        columns[name] = equivalence[name]
    for name in ("largest_relative_error", "delta_largest_relative_error"):
        for end in RANGE_ENDS:
            column = equivalence[name].sel(restitution_range=end, drop=True)
            columns[f"{name}_to_{end:.2f}"] = column
    rows = xr.Dataset(columns).to_dataframe(list(POLYNOMIAL_DIMS))[list(columns)].reset_index()
    e = equivalence["restitution"].values
    return rows.assign(smallest_restitution=e.min(), largest_restitution=e.max())
