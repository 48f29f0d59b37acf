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
RANGES = (0.90, 0.96, 1.00)  # of e: the ends of those that have a largest relative error each


def fit(config: Config, matched: xr.Dataset) -> xr.Dataset:
    """Fit xi(e) = c0 + c1 e + c2 e^2 by least squares, for each model and each a1 of the reference plateau.

    Beside the paper's polynomial, which does not vanish at e = 1, stands one that does: xi = delta (d0 + d1 delta +
    d2 delta^2), delta = -ln(e), of the least squares of xi/delta. Both hold over the range of the matched e.
    """
    same = np.isclose(matched["strength_ratio"].values, config.curve.strength_ratio)
    matched = matched.isel(yield_displacement_ratio=np.flatnonzero(same)).drop_vars(
        ["strength_ratio", "step", "steps", "frequency_parameter"]
    )
    dims = ("damping_model", "yield_displacement_ratio")
    matched = matched.transpose(*dims, "restitution")
    e, ratio = matched["restitution"].values, matched["damping_ratio"]
    rows, delta = ratio.values, 0.0 - np.log(e)  # without the sign of zero
    coefficient, fitted = _least_squares(e, rows, np.ones(e.size))
    delta_coefficient, delta_fitted = _least_squares(delta, rows, delta)
    residual = rows - fitted
    total = ((rows - rows.mean(axis=-1, keepdims=True)) ** 2).sum(axis=-1)
    return xr.Dataset(
        {
            "coefficient": ((*dims, "degree"), coefficient),
            "delta_coefficient": ((*dims, "degree"), delta_coefficient),
            "damping_ratio": ratio,
            "damping_ratio_uncertainty": matched["damping_ratio_uncertainty"],
            "damping_ratio_fit": ratio.copy(data=fitted),
            "damping_ratio_delta_fit": ratio.copy(data=delta_fitted),
            "damping_ratio_energy": matched["damping_ratio_energy"],
            "giannini_masiani": ("restitution", giannini_masiani(e)),
            "r_squared": (dims, 1 - (residual**2).sum(axis=-1) / total),
            "largest_residual": (dims, np.abs(residual).max(axis=-1)),
            "largest_relative_error": (
                (*dims, "restitution_range"),
                _largest_relative(e, rows, fitted),
            ),
            "delta_largest_relative_error": (
                (*dims, "restitution_range"),
                _largest_relative(e, rows, delta_fitted),
            ),
        },
        coords={
            "degree": np.arange(DEGREE + 1),
            "restitution_range": list(RANGES),
            "strength_ratio": config.curve.strength_ratio,
            "ultimate_displacement_ratio": config.curve.ultimate_displacement_ratio,
            "release_amplitude": config.release_amplitude,
        },
    )


def _least_squares(x: Array, rows: Array, factor: Array) -> tuple[Array, Array]:
    """Polynomials p in x for which factor p(x) is near each row, by the squares of row/factor - p(x); and factor p(x).

    Where the factor vanishes, so do row and fit: that value decides nothing. Rows have the shape (..., x).
    """
    powers, decides = np.vander(x, DEGREE + 1, increasing=True), factor > 0
    values = (rows[..., decides] / factor[decides]).reshape(-1, decides.sum()).T
    coefficient = np.asarray(np.linalg.lstsq(powers[decides], values, rcond=None)[0], dtype=float)
    fitted: Array = factor * (powers @ coefficient).T
    return coefficient.T.reshape(*rows.shape[:-1], -1), fitted.reshape(rows.shape)


def _largest_relative(e: Array, rows: Array, fitted: Array) -> Array:
    """Largest |fitted/row - 1| of each range of e, which begins beyond the one before; NaN of one without values."""
    largest = np.full((*rows.shape[:-1], len(RANGES)), np.nan)
    for column, (low, high) in enumerate(pairwise((0.0, *RANGES))):
        inside = (e > low + 1e-9) & (e <= high + 1e-9) & (e < 1)
        if inside.any():
            largest[..., column] = np.abs(fitted[..., inside] / rows[..., inside] - 1).max(axis=-1)
    return largest


def table(equivalence: xr.Dataset) -> pd.DataFrame:
    """Return the polynomials as a table, a row for each model and a1, with their errors and range of validity.

    xi = c0 + c1 e + c2 e^2, or delta (d0 + d1 delta + d2 delta^2) with delta = -ln(e).
    """
    columns = {
        f"{letter}{k}": equivalence[name].sel(degree=k, drop=True)
        for letter, name in (("c", "coefficient"), ("d", "delta_coefficient"))
        for k in range(DEGREE + 1)
    }
    columns |= {name: equivalence[name] for name in ("r_squared", "largest_residual")}
    columns |= {
        f"{name}_to_{end:.2f}": equivalence[name].sel(restitution_range=end, drop=True)
        for name in ("largest_relative_error", "delta_largest_relative_error")
        for end in RANGES
    }
    dims, e = ["damping_model", "yield_displacement_ratio"], equivalence["restitution"].values
    rows = xr.Dataset(columns).to_dataframe(dims)[list(columns)].reset_index()
    return rows.assign(smallest_restitution=e.min(), largest_restitution=e.max())
