"""The damping ratio by the polynomials xi(e) of each viscous model, linear in a1 between their fits.

`studies.polynomial_fits` makes them; here they are evaluated, those that the package ships as those just built.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.errors import require

if TYPE_CHECKING:
    import xarray as xr

SHIPPED_STRENGTH_RATIO = 0.85  # b1 of the reference curve, to whose decays the shipped polynomials are fitted
ROUNDING = 1e-12  # beyond the range of the fits that still counts as within it


@dataclass(frozen=True)
class Polynomials:
    """Fits xi(e) = c0 + c1 e + c2 e^2 of each model at several a1."""

    coefficient: Mapping[str, Array]  # by model, shape (a1, degree), the constant first [-]
    yield_displacement_ratio: Array  # a1 of the fits, ascending [-]
    restitution: tuple[float, float]  # the smallest and the largest e of the fits [-]

    @classmethod
    def from_dataset(cls, equivalence: xr.Dataset) -> Polynomials:
        """Take the polynomials of a built dataset: its ``coefficient`` and the range of its ``restitution``."""
        fits = equivalence["coefficient"].sortby("yield_displacement_ratio")
        fits = fits.transpose("damping_model", "yield_displacement_ratio", "degree")
        e = equivalence["restitution"].values
        models = map(str, fits["damping_model"].values)
        return cls(
            dict(zip(models, fits.values, strict=True)),
            fits["yield_displacement_ratio"].values,
            (float(e.min()), float(e.max())),
        )

    def covers(self, restitution: ArrayLike, yield_displacement_ratio: ArrayLike) -> NDArray[np.bool_]:
        """Tell where e and a1 lie within the range of the fits."""
        e, a1 = np.asarray(restitution, dtype=float), np.asarray(yield_displacement_ratio, dtype=float)
        return _within(e, self.restitution) & _within(a1, self.yield_displacement_ratio)

    def require_cover(self, restitution: ArrayLike, yield_displacement_ratio: ArrayLike, a1_name: str) -> None:
        """Raise `InputError` unless e and a1, which the message calls `a1_name`, lie within the range of the fits."""
        checked = (
            ("restitution", restitution, self.restitution),
            (a1_name, yield_displacement_ratio, self.yield_displacement_ratio),
        )
        for name, value, fits in checked:
            values = np.asarray(value, dtype=float)
            require(_within(values, fits), name, values, f"within the range of the fits, {fits[0]:g} to {fits[-1]:g}")

    def __call__(self, damping_model: str, restitution: ArrayLike, yield_displacement_ratio: float) -> Array:
        """Evaluate xi(e), the coefficients linear in a1 between the fits. [-]

        NaN outside the range of the fits, and for a model without any.
        """
        e = np.asarray(restitution, dtype=float)
        if damping_model not in self.coefficient:
            return np.full(e.shape, np.nan)
        of_degree = self.coefficient[damping_model].T
        at = [np.interp(yield_displacement_ratio, self.yield_displacement_ratio, values) for values in of_degree]
        terms = np.array(at) * e[..., None] ** np.arange(len(at))
        return np.where(self.covers(e, yield_displacement_ratio), terms.sum(axis=-1), np.nan)


def _within(values: Array, ends: ArrayLike) -> NDArray[np.bool_]:
    low, high = np.min(ends), np.max(ends)
    return (values >= low - ROUNDING) & (values <= high + ROUNDING)


@cache
def shipped_coefficients() -> dict[str, Array]:
    """Return the table that the package ships, coefficients.csv: by column, its rows in the file's order.

    A test holds the file equal to what the pipeline builds.
    """
    lines = Path(__file__).with_name("coefficients.csv").read_text(encoding="utf-8").splitlines()
    table = np.genfromtxt(lines, delimiter=",", names=True, deletechars="", dtype=None, encoding=None)
    return {name: table[name] for name in lines[0].split(",")}


@cache
def shipped() -> Polynomials:
    """Return the polynomials that the package ships: of b1 = `SHIPPED_STRENGTH_RATIO` and releases from 0.5 u_ins."""
    table = shipped_coefficients()
    rows = {str(model): table["damping_model"] == model for model in table["damping_model"]}
    coefficient = np.stack([table[name] for name in ("c0", "c1", "c2")], axis=1)
    return Polynomials(
        {model: coefficient[of_model] for model, of_model in rows.items()},
        np.unique(table["yield_displacement_ratio"]),
        (float(table["smallest_restitution"].max()), float(table["largest_restitution"].min())),
    )
