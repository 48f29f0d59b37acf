"""The damping ratio by the polynomials xi(e) of each viscous model, linear in a1 between their fits.

`studies.polynomial_fits` makes them; here they are evaluated, those that the package ships as those just built.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array

if TYPE_CHECKING:
    import xarray as xr

SHIPPED_STRENGTH_RATIO = (
    0.85  # b1 of the reference curve, to whose decays the shipped polynomials are fitted
)


@dataclass(frozen=True)
class Polynomials:
    """Fits xi(e) = c0 + c1 e + c2 e^2 of each model at several a1."""

    coefficient: dict[str, Array]  # by model, shape (a1, degree), the constant first [-]
    yield_displacement_ratio: Array  # a1 of the fits, ascending [-]
    restitution: tuple[float, float]  # the smallest and the largest e of the fits [-]

    @classmethod
    def from_dataset(cls, equivalence: xr.Dataset) -> Polynomials:
        """Take the polynomials of a built dataset: its ``coefficient`` and the range of its ``restitution``."""
        fits = equivalence["coefficient"].sortby("yield_displacement_ratio")
        fits = fits.transpose("damping_model", "yield_displacement_ratio", "degree")
        coefficient = dict(zip(fits["damping_model"].values.tolist(), fits.values, strict=True))
        e = equivalence["restitution"].values
        return cls(
            coefficient, fits["yield_displacement_ratio"].values, (float(e.min()), float(e.max()))
        )

    def __call__(
        self, damping_model: str, restitution: ArrayLike, yield_displacement_ratio: float
    ) -> Array:
        """Evaluate xi(e), the coefficients linear in a1 between the fits. [-]

        NaN outside the range of the fits, and for a model without any.
        """
        e, a1 = np.asarray(restitution, dtype=float), self.yield_displacement_ratio
        rounding = 1e-12
        inside = (self.restitution[0] - rounding <= e) & (e <= self.restitution[1] + rounding)
        inside &= a1[0] - rounding <= yield_displacement_ratio <= a1[-1] + rounding
        if damping_model not in self.coefficient:
            return np.full(e.shape, np.nan)
        terms = [
            np.interp(yield_displacement_ratio, a1, column)
            for column in self.coefficient[damping_model].T
        ]
        return np.where(
            inside, (np.array(terms) * e[..., None] ** np.arange(len(terms))).sum(axis=-1), np.nan
        )


@cache
def shipped_polynomials() -> Polynomials:
    """Return the polynomials that the package ships: of b1 = `SHIPPED_STRENGTH_RATIO` and releases from 0.5 u_ins.

    A test holds the file equal to what the pipeline builds.
    """
    path = Path(__file__).with_name("coefficients.csv")
    table = np.genfromtxt(
        path, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars=""
    )
    coefficient = np.stack([table[name] for name in ("c0", "c1", "c2")], axis=1)
    models = dict.fromkeys(table["damping_model"].tolist())
    return Polynomials(
        {model: coefficient[table["damping_model"] == model] for model in models},
        np.unique(table["yield_displacement_ratio"]),
        (float(table["smallest_restitution"].max()), float(table["largest_restitution"].min())),
    )
