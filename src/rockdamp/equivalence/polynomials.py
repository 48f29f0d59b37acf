"""Damping ratios by the polynomials xi(e) of each viscous model, linear in a1 between the fits.

`studies.polynomial_fits` makes the polynomials. This module evaluates them: those that the package
ships, and those of a built dataset.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Polynomials:
    """Fits xi(e) = c0 + c1 e + c2 e^2 of each model at several a1.

    Parameters
    ----------
    coefficient : dict of ndarray
        Coefficients of each model, shape (a1, degree), the constant first. [-]
    yield_displacement_ratio : ndarray
        Values a1 of the fits, ascending. [-]
    restitution : tuple of float
        Smallest and largest e of the fits. [-]
    """

    coefficient: dict[str, Array]
    yield_displacement_ratio: Array
    restitution: tuple[float, float]

    @classmethod
    def from_dataset(cls, equivalence: xr.Dataset) -> Polynomials:
        """Take the polynomials of a built dataset: its ``coefficient`` and ``restitution``."""
        fits = equivalence["coefficient"].sortby("yield_displacement_ratio")
        fits = fits.transpose("damping_model", "yield_displacement_ratio", "degree")
        models = fits["damping_model"].values.tolist()
        e = equivalence["restitution"].values
        return cls(
            coefficient=dict(zip(models, fits.values, strict=True)),
            yield_displacement_ratio=fits["yield_displacement_ratio"].values,
            restitution=(float(e.min()), float(e.max())),
        )

    def __call__(
        self, damping_model: str, restitution: ArrayLike, yield_displacement_ratio: float
    ) -> Array:
        """Evaluate xi(e). [-]

        Parameters
        ----------
        damping_model : str
            Viscous model. One without fits has NaN.
        restitution : float or ndarray
            Coefficient of restitution e. Outside the range of the fits the result is NaN. [-]
        yield_displacement_ratio : float
            Displacement a1. Outside the range of the fits the result is NaN. [-]
        """
        e = np.asarray(restitution, dtype=float)
        if damping_model not in self.coefficient:
            return np.full(e.shape, np.nan)
        a1 = self.yield_displacement_ratio
        columns = self.coefficient[damping_model].T
        coefficients = np.array(
            [np.interp(yield_displacement_ratio, a1, column) for column in columns]
        )
        xi = (coefficients * e[..., None] ** np.arange(coefficients.size)).sum(axis=-1)
        has_fit = _is_within(e, *self.restitution)
        has_fit &= _is_within(yield_displacement_ratio, a1[0], a1[-1])
        return np.where(has_fit, xi, np.nan)


def _is_within(value: ArrayLike, low: float, high: float) -> NDArray[np.bool_]:
    rounding = 1e-12  # of values on a grid
    value = np.asarray(value, dtype=float)
    return np.asarray((low - rounding <= value) & (value <= high + rounding))


@cache
def shipped_polynomials() -> Polynomials:
    """Return the polynomials that the package ships, for b1 = 0.85 and releases from 0.5 u_ins.

    A test keeps the file equal to the results of the pipeline.
    """
    path = Path(__file__).with_name("coefficients.csv")
    table = np.genfromtxt(
        path, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars=""
    )
    coefficient = np.stack([table[name] for name in ("c0", "c1", "c2")], axis=1)
    models = dict.fromkeys(table["damping_model"].tolist())
    smallest = float(table["smallest_restitution"].max())
    largest = float(table["largest_restitution"].min())
    return Polynomials(
        coefficient={model: coefficient[table["damping_model"] == model] for model in models},
        yield_displacement_ratio=np.unique(table["yield_displacement_ratio"]),
        restitution=(smallest, largest),
    )
