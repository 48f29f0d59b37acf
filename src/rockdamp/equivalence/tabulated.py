"""Look up the damping ratio of least Err of CDC, CDR and SDR in a table that the package ships, for many walls.

In tau and u/u_ins xi follows from e, a1, b1, a3 and the release alone: slenderness, overburden and size drop out. With
translated softening a3 drops out too, as such a curve is one of a3 = 1 with displacements, forces and squares of
times over a3. The table holds ln(xi/xi_E), where xi_E = delta/sqrt(pi^2 + delta^2) is ECD's ratio: a smooth function,
which a cubic in each of the five variables follows. Divided by the closed form instead, it is no smoother.

The table is of `PAPER_MODELS`, for the default length of the response. `tools/tabulate_ratios.py` makes it by
`matching.solve`, looks between its nodes, and says where it must not be used: where Err has two minima, so that xi may
jump from one to the other, and where xi turns too sharply for the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import NdBSpline, make_interp_spline

from rockdamp.arguments import broadcast, instance, numbers, one_of
from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import check_restitution, exact_ratio
from rockdamp.errors import InputError, require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.vocabulary import PAPER_MODELS, VISCOUS_MODELS

FILE = Path(__file__).with_name("ratios.npz")
LARGEST_ERROR = 0.01  # of xi, stated; tools/tabulate_ratios.py checks it
NODES = {  # of e, a1, b1, a3 and the release; under CDC xi ripples the most
    "CDC": (21, 9, 16, 6, 21),
    "CDR": (12, 9, 12, 4, 15),
    "SDR": (12, 9, 12, 4, 15),
}
RESTITUTION, STRENGTH_RATIO, ULTIMATE_RATIO = (0.70, 0.99), (0.4, 0.9), (0.7, 1.0)
LEAST_A1 = 0.02
ROOM = 2.5  # 1/a1 is at least 1/a2 and this
LEAST_RELEASE, BEYOND_A1, LARGEST_RELEASE = 0.1, 1.5, 0.8  # u0 from 0.1 + 1.5 a1 to 0.8 a3
UNIT = 5e-5  # of ln(xi/xi_E) in the file, which holds whole numbers
CUBIC = 3
ROUNDING = 1e-9  # beyond the range, over its width, that still counts as within it
SCALED = ", for the table; with translated softening displacements and forces count over a3"
REFUSALS = (  # what is refused, and what it must be
    ("restitution (e)", f"between {RESTITUTION[0]:g} and {RESTITUTION[1]:g}, for the table"),
    ("strength_ratio (b1)", f"between {STRENGTH_RATIO[0]:g} and {STRENGTH_RATIO[1]:g}{SCALED}"),
    ("ultimate_displacement_ratio (a3)", f"between {ULTIMATE_RATIO[0]:g} and {ULTIMATE_RATIO[1]:g}, for the table"),
    ("yield_displacement_ratio (a1)", f"between {LEAST_A1:g} and 1/(1/a2 + {ROOM:g}){SCALED}"),
    (
        "release_amplitude",
        f"between {LEAST_RELEASE:g} + {BEYOND_A1:g} a1 and {LARGEST_RELEASE:g} a3{SCALED}",
    ),
    ("this wall", "matched (`equivalent`): Err has a second minimum near here, or xi turns too sharply for the table"),
)
AXES = (0, 2, 3, 1, 4)  # of the unit box, in the order of `REFUSALS`
AT_ONCE = 2**18  # walls that are looked up together


@dataclass(frozen=True)
class Table:
    """The table of one model."""

    log_ratio: Array  # ln(xi/xi_E) at the nodes, shape NODES[model] [-]
    refused: NDArray[np.bool_]  # which cells between nodes must not be used, shape NODES[model] - 1

    @cached_property
    def _spline(self) -> NdBSpline:
        """The cubic spline through all nodes: a spline along each axis, of the coefficients along the one before."""
        knots, coefficients = [], self.log_ratio
        for axis, count in enumerate(self.log_ratio.shape):
            along = make_interp_spline(np.linspace(0.0, 1.0, count), coefficients, CUBIC, axis=axis)
            knots.append(along.t)
            coefficients = np.moveaxis(along.c, 0, axis)
        return NdBSpline(tuple(knots), np.ascontiguousarray(coefficients), CUBIC)

    def read(self, at: Array) -> Array:
        """Return ln(xi/xi_E) at points in the unit box, shape (5, points). [-]"""
        return np.asarray(self._spline(at.T))

    def refuses(self, at: Array) -> NDArray[np.bool_]:
        """Tell which points of the unit box lie in a cell that must not be used."""
        cells = self.refused
        cell = [np.minimum((part * n).astype(int), n - 1) for part, n in zip(at, cells.shape, strict=True)]
        within: NDArray[np.bool_] = cells[tuple(cell)]
        return within


@cache
def shipped(model: str) -> Table:
    """Return the table of a model that the package ships."""
    with np.load(FILE) as file:
        return Table(file[f"{model}_log_ratio"] * UNIT, file[f"{model}_refused"])


def unit_of(e: Array, a1: Array, b1: Array, a3: Array, x0: Array) -> Array:
    """Return where walls lie in the unit box of e, ln a1, b1, a3 and release; beyond it where they lie outside."""
    least = LEAST_RELEASE + BEYOND_A1 * a1
    parts = (
        _part(e, RESTITUTION),
        np.log(a1 / LEAST_A1) / np.log(largest_a1(b1) / LEAST_A1),
        _part(b1, STRENGTH_RATIO),
        _part(a3, ULTIMATE_RATIO),
        (x0 - least) / (LARGEST_RELEASE * a3 - least),
    )
    return np.stack(np.broadcast_arrays(*parts))


def _part(value: Array, ends: tuple[float, float]) -> Array:
    return (value - ends[0]) / (ends[1] - ends[0])


def largest_a1(b1: Array) -> Array:
    return 1 / (1 / (1 - b1) + ROOM)


def damping_ratio_table(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike = 0.5
) -> Array:
    """Return damping ratios without matching, for any number of walls: of least Err by a table, or exact by the peaks.

    Of CDC, CDR and SDR it is the ratio of least Err, which `equivalent` finds over the default length of the response,
    within 1 %, read from a table that the package ships. Of ECD and ECD16 it is the exact ratio, which has every peak
    of the decay right; that of least Err is another, for ECD by some per cent (docs/theory.md, section 5).

    Parameters
    ----------
    curve : TrilinearCurve
        Broadcasts.
    damping_model : str
        A viscous model.
    restitution : float or ndarray
        e, in (0, 1], broadcasts. [-]
    release_amplitude : float or ndarray
        u0/u_ins of the decay that is matched, in (0, a3), broadcasts. [-]

    Returns
    -------
    ndarray, of the shape that the arguments broadcast to
        xi; NaN where the table does not answer, for the reason that `table_refusal` gives. [-]

    Raises
    ------
    InputError
        If a value lies outside its range, the model is not viscous, or there is one wall alone and the table does not
        answer.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=[0.04, 0.06, 0.3], strength_ratio=[0.85, 0.72, 0.6])
    >>> rd.damping_ratio_table(curve, "CDR", 0.85).round(3)
    array([0.045, 0.046,   nan])
    """
    model, shape, coordinates = _checked(curve, damping_model, restitution, release_amplitude)
    if model not in PAPER_MODELS:
        return np.broadcast_to(Damping.of_restitution(coordinates[0], model).damping_ratio, shape).copy()
    xi, refused = _looked_up(model, shape, coordinates)
    if shape == () and refused.item():
        name, allowed = REFUSALS[refused.item() - 1]
        values = dict(zip((name for name, _ in REFUSALS), (coordinates[axis] for axis in AXES), strict=False))
        told = f" is {values[name].item():g};" if name in values else f", under {model}:"
        raise InputError(f"{name}{told} it must be {allowed}")
    return xi


def table_refusal(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike = 0.5
) -> NDArray[np.object_]:
    """Return why `damping_ratio_table` does not answer for each wall, and an empty text where it does.

    Parameters
    ----------
    curve : TrilinearCurve
    damping_model : str
    restitution, release_amplitude : float or ndarray
        As of `damping_ratio_table`.

    Returns
    -------
    ndarray of str, of the shape that the arguments broadcast to

    Raises
    ------
    InputError
        If a value lies outside its range, or the model is not viscous.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.table_refusal(curve, "CDR", [0.85, 0.6]).tolist()
    ['', 'restitution (e) must be between 0.7 and 0.99, for the table']
    """
    model, shape, coordinates = _checked(curve, damping_model, restitution, release_amplitude)
    told = np.array(["", *(f"{name} must be {allowed}" for name, allowed in REFUSALS)], dtype=object)
    refused = _looked_up(model, shape, coordinates)[1] if model in PAPER_MODELS else np.zeros(shape, dtype=np.int8)
    return np.asarray(told[refused])


def _checked(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike
) -> tuple[str, tuple[int, ...], tuple[Array, ...]]:
    """Return the model, the shape, and e, a1, b1, a3 and the release, those of a curve of steeper softening."""
    of = instance("curve", curve, TrilinearCurve)
    model = one_of("damping_model", damping_model, VISCOUS_MODELS)
    e, x0 = check_restitution(restitution), numbers("release_amplitude", release_amplitude)
    shape = broadcast(restitution=e, release_amplitude=x0, curve=of)
    require(
        (x0 > 0) & (x0 < of.ultimate_displacement_ratio), "release_amplitude", x0, "greater than 0 and less than a3"
    )
    lengths = (of.yield_displacement_ratio, of.strength_ratio, of.ultimate_displacement_ratio, x0)
    scale = np.asarray(1.0 if of.softening == "steeper" else of.ultimate_displacement_ratio)
    return model, shape, (e, *(np.asarray(length) / scale for length in lengths))


def _looked_up(model: str, shape: tuple[int, ...], coordinates: tuple[Array, ...]) -> tuple[Array, NDArray[np.int8]]:
    """Return xi, and of which of `REFUSALS` it is NaN, counted from 1; 0 of none."""
    walls = [np.broadcast_to(value, shape).reshape(-1) for value in coordinates]
    xi, refused = np.empty(walls[0].size), np.zeros(walls[0].size, dtype=np.int8)
    for start in range(0, xi.size, AT_ONCE):
        here = slice(start, start + AT_ONCE)
        of_these = [value[here] for value in walls]
        with np.errstate(all="ignore"):  # far outside the range, where nothing is read
            unit = unit_of(*of_these)
        outside = ~((unit >= -ROUNDING) & (unit <= 1 + ROUNDING))[list(AXES)]
        unit = np.clip(np.where(outside.any(axis=0), 0.5, unit), 0.0, 1.0)
        outside = np.concatenate([outside, shipped(model).refuses(unit)[None]])
        refused[here] = np.where(outside.any(axis=0), outside.argmax(axis=0) + 1, 0)
        xi[here] = exact_ratio(of_these[0]) * np.exp(shipped(model).read(unit))
    xi[refused > 0] = np.nan
    return xi.reshape(shape), refused.reshape(shape)
