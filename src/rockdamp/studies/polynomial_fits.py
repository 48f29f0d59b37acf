"""Second-order polynomials xi(e) for each viscous model and cracked stiffness: Fig. 7."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from rockdamp.config import Config
from rockdamp.equivalence.closed_form import giannini_masiani
from rockdamp.studies.settings import PolynomialSettings

DEGREE = 2


def fit(config: Config, matched: xr.Dataset) -> xr.Dataset:
    """Fit xi(e) = c0 + c1 e + c2 e^2 by least squares, for each model and each a1 of the reference plateau.

    Parameters
    ----------
    config : dict
        Has the keys of `PolynomialSettings`.
    matched : xarray.Dataset
        Of the cracked-stiffness study.

    Returns
    -------
    xarray.Dataset
        ``coefficient`` and its ``covariance``, the matched, fitted and closed-form damping ratios, Eq. (15), the
        coefficient of determination and the largest residual. The fits hold over the range of `restitution`.
    """
    given = PolynomialSettings.of(config)
    same = np.isclose(matched["plateau_ratio"].values, given.plateau_ratio)
    matched = matched.isel(cracked_stiffness_ratio=np.flatnonzero(same)).drop_vars(
        ["plateau_ratio", "step", "steps"], errors="ignore"
    )
    e = matched["restitution"].values
    ratio = matched["damping_ratio"].transpose("damping_model", "cracked_stiffness_ratio", "restitution")
    powers = np.vander(e, DEGREE + 1, increasing=True)
    rows = ratio.values.reshape(-1, e.size)
    coefficient, _, _, _ = np.linalg.lstsq(powers, rows.T, rcond=None)
    fitted = (powers @ coefficient).T
    residual = rows - fitted
    variance = (residual**2).sum(axis=1) / max(e.size - DEGREE - 1, 1)
    covariance = variance[:, None, None] * np.linalg.inv(powers.T @ powers)
    total = ((rows - rows.mean(axis=1, keepdims=True)) ** 2).sum(axis=1)
    lead = ("damping_model", "cracked_stiffness_ratio")
    shape = ratio.shape[:2]
    degrees = np.arange(DEGREE + 1)
    return xr.Dataset(
        {
            "coefficient": ((*lead, "degree"), coefficient.T.reshape(*shape, -1)),
            "coefficient_covariance": (
                (*lead, "degree", "other_degree"),
                covariance.reshape(*shape, DEGREE + 1, DEGREE + 1),
            ),
            "damping_ratio": ratio,
            "damping_ratio_uncertainty": matched["damping_ratio_uncertainty"].transpose(*ratio.dims),
            "damping_ratio_fit": (ratio.dims, fitted.reshape(ratio.shape)),
            "damping_ratio_energy": matched["damping_ratio_energy"].transpose(*ratio.dims),
            "giannini_masiani": ("restitution", giannini_masiani(e)),
            "r_squared": (lead, (1 - (residual**2).sum(axis=1) / total).reshape(shape)),
            "largest_residual": (lead, np.abs(residual).max(axis=1).reshape(shape)),
        },
        coords={
            **ratio.coords,
            "degree": degrees,
            "other_degree": degrees,
            "plateau_ratio": given.plateau_ratio,
            "ultimate_ratio": given.ultimate_ratio,
            "release_amplitude": given.release_amplitude,
        },
    ).drop_vars("frequency_parameter")


def table(dataset: xr.Dataset) -> pd.DataFrame:
    """Return the polynomials as a table, a row for each model and a1, with their range of validity."""
    rows = []
    for model in dataset["damping_model"].values:
        for a1 in dataset["cracked_stiffness_ratio"].values:
            fitted = dataset.sel(damping_model=model, cracked_stiffness_ratio=a1)
            rows.append(
                {
                    "damping_model": str(model),
                    "cracked_stiffness_ratio": float(a1),
                    **{f"c{k}": float(value) for k, value in enumerate(fitted["coefficient"].values)},
                    "r_squared": float(fitted["r_squared"]),
                    "largest_residual": float(fitted["largest_residual"]),
                    "smallest_restitution": float(dataset["restitution"].min()),
                    "largest_restitution": float(dataset["restitution"].max()),
                }
            )
    return pd.DataFrame(rows)
