"""How an elastic spectrum does in place of histories, on the same walls and records.

The simple method replaces the wall by a linear oscillator with the secant stiffness at the capacity, a displacement
such as 0.4 u_ins. Its spectral displacement times the excitation factor lambda is the demand; the wall passes if the
demand is at most the capacity. Here the method is asked at the very intensity at which the wall, by its histories under
restitution, reaches the capacity first. A method without error then finds a demand equal to the capacity; below it
passes a wall that fails.

One oscillator has 5 % of damping, as spectra of codes do, the other the ratio that loses as much in a cycle as the
restitution. Both are run on the ground and on a storey of a building, under its floor's exact motion.
"""

from __future__ import annotations

from warnings import catch_warnings

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import NamedWall
from rockdamp.histories.loads import peaks_and_collapses
from rockdamp.histories.supports import floor_motions
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.solvers.oscillator import spectral_acceleration

SUPPORTS = ("ground", "storey")
METHODS = ("5 %", "equivalent")
CODE_DAMPING = 0.05
TOLERATED = 0.05  # share of walls that may pass and fail, for the factor that attains it
DIMS = ("spectrum_damping", "support", "wall", "capacity", "restitution")


def spectrum_method(config: Config) -> xr.Dataset:
    """Return the demand of each method over the capacity, at the intensity at which each wall reaches the capacity.

    ``demand_ratio`` is NaN where a wall reaches the capacity at no intensity, or at the lowest already. Over the
    records ``bias`` is its median, ``scatter`` the standard deviation of its logarithm, and ``unsafe_share`` the part
    below 1; the same over all walls too.
    """
    quakes = config.earthquakes
    method = config.spectrum_method
    secant = [named.curve.force(method.capacity) / method.capacity for named in quakes.walls]
    p = np.array([float(named.wall.frequency_parameter) for named in quakes.walls])
    period = 2 * np.pi / (p[:, None] * np.sqrt(secant))
    equivalent = Damping.of_restitution(quakes.restitution, "ECD").damping_ratio  # loses as much in half a cycle
    ratio = np.stack([np.full(quakes.restitution.size, CODE_DAMPING), equivalent])
    names, demands = [], []
    for entry in track(catalogue.listing(config.records), "Spectrum method"):
        ground = catalogue.read(entry)
        names.append(ground.name)
        by_wall = [
            [
                _demand(motion.record, named, seconds, ratio, config)
                for motion in (
                    ground,
                    *floor_motions(ground, method.building, isinstance(named.wall, Parapet)),
                )
            ]
            for named, seconds in zip(quakes.walls, period, strict=True)
        ]
        # From (walls, supports, methods, capacities, restitution) to the order of `DIMS`.
        demands.append(np.array(by_wall).transpose(2, 1, 0, 3, 4))
    demand = xr.DataArray(np.stack(demands, axis=-1), dims=(*DIMS, "record"))
    return xr.Dataset(
        {
            "demand_ratio": demand,
            **statistics(demand, ["record"]),
            **{f"overall_{name}": value for name, value in statistics(demand, ["record", "wall"]).items()},
            "secant_period": (("wall", "capacity"), period),
            "damping_ratio": (("spectrum_damping", "restitution"), ratio),
            "building_period": method.building.period,
            "storeys": method.building.storeys,
            "storey": method.building.storey,
        },
        coords={
            "spectrum_damping": list(METHODS),
            "support": list(SUPPORTS),
            "wall": [named.name for named in quakes.walls],
            "capacity": method.capacity,
            "restitution": quakes.restitution,
            "record": names,
        },
    )


def statistics(demand: xr.DataArray, over: list[str]) -> dict[str, xr.DataArray]:
    """Return the statistics of the ratios over some dimensions; NaN where none is known."""
    reached = demand.notnull()
    with catch_warnings(action="ignore", category=RuntimeWarning):  # NumPy's, of the median of nothing
        return {
            "bias": demand.median(over),
            "scatter": xr.apply_ufunc(np.log, demand).std(over),
            "unsafe_share": ((demand < 1) & reached).sum(over) / reached.sum(over),
            "unsafe_factor": 1 / demand.quantile(TOLERATED, over).drop_vars("quantile"),
            "reached": reached.sum(over),
        }


def _demand(record: Record, named: NamedWall, period: Array, ratio: Array, config: Config) -> Array:
    """Return the demand over the capacity where the wall reaches it; shape (methods, capacities, restitution)."""
    quakes = config.earthquakes
    method = config.spectrum_method
    wall, capacity = named.wall, method.capacity
    factor = method.velocity_ratio * float(wall.velocity_scale) / intensity_measures(record).pgv
    damping = Damping.cr(quakes.restitution)
    run = peaks_and_collapses(record, wall, named.curve, [damping], factor, step=method.step, tail=quakes.tail)
    peak = np.where(run[1], np.inf, run[0])[..., 0].T  # (levels, restitution)
    reached = np.stack([first_factor(factor, peak, at) for at in capacity])
    frequency = 2 * np.pi / period
    by_ratio = {xi: spectral_acceleration(record, period, xi) / frequency**2 for xi in np.unique(ratio)}
    displacement = np.array([[by_ratio[xi] for xi in of_method] for of_method in ratio]).transpose(0, 2, 1)
    scale = wall.excitation_factor / (capacity * float(wall.instability_displacement))
    return np.asarray(reached * displacement * scale[:, None])


def first_factor(factor: Array, peak: Array, capacity: float) -> Array:
    """Return the least factor on the record at which the peak passes the capacity; NaN where none does.

    `peak`, shape (factors, ...), is infinite where the wall collapsed. Between two factors log peak is linear in log
    factor; where the wall collapses at the second one, their geometric mean is taken.
    """
    above = peak > capacity
    first = np.argmax(above, axis=0)
    known = above.any(axis=0) & (first > 0)
    after, before = np.take_along_axis(peak, first[None], 0)[0], np.take_along_axis(peak, first[None] - 1, 0)[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where(np.isfinite(after), np.log(capacity / before) / np.log(after / before), 0.5)
    crossing = factor[first - 1] * (factor[first] / factor[first - 1]) ** part
    return np.where(known, crossing, np.nan)
