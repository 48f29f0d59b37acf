"""A code's displacement check beside histories: Circolare 21.1.2019 n. 7 (Italy), C8.7.1.2.1, for local mechanisms.

The formulas are after a transcription that has not been compared with the official gazette. The code takes the rigid
wall's capacity curve, alpha = alpha0 (1 - d/d0) over the spectral displacement d = u/lambda, and the acceleration
a = alpha g/(e* FC), with e* the part of the mass that takes part and FC the confidence factor. At a limit state, a
share of d0, the secant gives a period, at which an elastic spectrum gives the demand; the wall passes if the demand is
at most that share of d0.

As in `spectrum_method`, the check is asked at the very intensity at which the wall, by its histories under restitution,
reaches the capacity first: a check without error finds a demand equal to the capacity there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config
from rockdamp.config.earthquakes import CodeChecks, NamedWall
from rockdamp.histories.loads import peaks_and_collapses
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.solvers.oscillator import spectral_acceleration
from rockdamp.statistics.against_restitution import BOUND
from rockdamp.statistics.fragility import interval, resample, weighted_quantile
from rockdamp.studies.spectrum_method import first_factor


class LimitState(NamedTuple):
    """A limit state of the code: its displacement over d0, the factor on pi of its period, its damping ratio. [-]"""

    capacity: float
    period_factor: float
    damping_ratio: float


LIMIT_STATES = {"SLV": LimitState(0.4, 1.68, 0.08), "SLC": LimitState(0.6, 1.56, 0.10)}
MASS_SHARE = 0.75  # e* of a mechanism of triangular shape
# ASSUME: the transcription asks for the largest S_d from T0 on and does not say which period T0 is. The first branch's,
# of the wall before it rocks, is taken, where it is the shorter one; beside it the demand at the secant's period alone.
FROM_FIRST, ALONE = "from the first branch on", "at the secant alone"
RANGES = (FROM_FIRST, ALONE)
PERIODS = 30  # at which a spectrum is taken between the shortest and the longest, in geometric sequence
RULES = ("measured", "one for all")
EVERY_WALL = "all"
DIMS = ("limit_state", "confidence_factor", "period_range", "restitution_rule", "wall")


def code_checks(config: Config) -> xr.Dataset:
    """Return the demand of the code's check over the capacity where walls reach it: medians over records by wall.

    ``median_demand_ratio`` has a bootstrap interval over stations; ``unsafe_share`` is the part of the records below 1.
    Records under which a wall reaches the capacity at no intensity, or at the lowest already, are left out.
    """
    quakes, settings = config.earthquakes, config.code_checks
    motions = [catalogue.read(entry) for entry in catalogue.listing(config.records)]
    ratio = np.stack(
        [
            demand_ratios(motion.record, quakes.walls, settings, quakes.tail)
            for motion in track(motions, "A code's check")
        ],
        axis=-1,
    )
    bootstrap = config.comparison.bootstrap
    weights = resample([motion.group for motion in motions], bootstrap.replicates, bootstrap.seed)
    names = [named.name for named in quakes.walls]
    period = np.stack([_periods(quakes.walls, state, settings) for state in LIMIT_STATES.values()])
    return xr.Dataset(
        {
            **medians(ratio, weights),
            "code_period": (("limit_state", "confidence_factor", "wall"), _beside_all(period.swapaxes(1, 2))),
            "restitution": (("restitution_rule", "wall"), _beside_all(restitutions(quakes.walls, settings).T)),
            "capacity": ("limit_state", [state.capacity for state in LIMIT_STATES.values()]),
            "damping_ratio": ("limit_state", [state.damping_ratio for state in LIMIT_STATES.values()]),
        },
        coords={
            "limit_state": list(LIMIT_STATES),
            "confidence_factor": settings.confidence_factor,
            "period_range": list(RANGES),
            "restitution_rule": list(RULES),
            "wall": [EVERY_WALL, *names],
            "bound": list(BOUND),
        },
    )


def code_period(wall: Wall | Parapet, state: LimitState, confidence_factor: Quantity) -> Array:
    """Return the code's period of a wall at a limit state. [s]"""
    d0 = wall.instability_displacement / wall.excitation_factor
    acceleration = wall.rocking_onset() * (1 - state.capacity) / (MASS_SHARE * np.asarray(confidence_factor))
    return np.asarray(state.period_factor * np.pi * np.sqrt(state.capacity * d0 / acceleration))


def _periods(walls: Sequence[NamedWall], state: LimitState, settings: CodeChecks) -> Array:
    """Return the code's periods, shape (walls, confidence factors). [s]"""
    return np.stack([code_period(named.wall, state, settings.confidence_factor) for named in walls])


def restitutions(walls: Sequence[NamedWall], settings: CodeChecks) -> Array:
    """Return e of each wall by each of `RULES`, shape (walls, rules)."""
    return np.array([[float(named.wall.restitution_measured), settings.restitution] for named in walls])


def demand_ratios(record: Record, walls: Sequence[NamedWall], settings: CodeChecks, tail: float) -> Array:
    """Return the demand over the capacity at the intensity at which each wall reaches it, in the order of `DIMS`.

    NaN where a wall reaches the capacity at no intensity, or at the lowest already.
    """
    first = [2 * np.pi / float(named.wall.frequency_parameter * named.curve.initial_frequency) for named in walls]
    ends = {name: _periods(walls, state, settings) for name, state in LIMIT_STATES.items()}
    longest = max(period.max() for period in ends.values())
    grid = np.geomspace(min(*first, longest), longest, PERIODS)
    reached = _factors_at_capacity(record, walls, settings, tail)
    found = np.empty((len(LIMIT_STATES), settings.confidence_factor.size, len(RANGES), len(RULES), len(walls)))
    for row, (name, state) in enumerate(LIMIT_STATES.items()):
        between, at_end = (_displacement(record, period, state.damping_ratio) for period in (grid, ends[name]))
        for column, named in enumerate(walls):
            d0 = float(named.wall.instability_displacement / named.wall.excitation_factor)
            for place, (period, alone) in enumerate(zip(ends[name][column], at_end[column], strict=True)):
                within = between[(grid >= first[column]) & (grid <= period)]
                demand = np.array([within.max(initial=alone), alone])[:, None] * reached[row, :, column]
                found[row, place, :, :, column] = demand / (state.capacity * d0)
    return found


def medians(ratio: Array, weights: Array) -> dict[str, tuple[tuple[str, ...], Array]]:
    """Return statistics over the records, the last dimension of `ratio`; of all walls together and wall by wall."""
    shape = (*ratio.shape[:-2], 1 + ratio.shape[-2])
    median, bounds, unsafe = np.empty(shape), np.empty((*shape, 2)), np.empty(shape)
    for at in np.ndindex(shape):
        values = ratio[at[:-1]] if at[-1] == 0 else ratio[at[:-1]][at[-1] - 1, None]
        record = np.broadcast_to(np.arange(values.shape[-1]), values.shape)
        known = np.isfinite(values)
        drawn = weighted_quantile(values[known], record[known], weights, 0.5)
        median[at], bounds[at] = np.median(values[known]) if known.any() else np.nan, interval(drawn)
        unsafe[at] = np.mean(values[known] < 1) if known.any() else np.nan
    return {
        "median_demand_ratio": (DIMS, median),
        "median_demand_ratio_interval": ((*DIMS, "bound"), bounds),
        "unsafe_share": (DIMS, unsafe),
    }


def _factors_at_capacity(record: Record, walls: Sequence[NamedWall], settings: CodeChecks, tail: float) -> Array:
    """Return the least factor at which walls reach each capacity, shape (limit states, rules, walls)."""
    pgv = intensity_measures(record).pgv
    found = np.empty((len(LIMIT_STATES), len(RULES), len(walls)))
    for column, (named, e) in enumerate(zip(walls, restitutions(walls, settings), strict=True)):
        factor = settings.velocity_ratio * float(named.wall.velocity_scale) / pgv
        run = peaks_and_collapses(
            record, named.wall, named.curve, [Damping.cr(e)], factor, step=settings.step, tail=tail
        )
        peak = np.where(run[1], np.inf, run[0])[..., 0].T  # (levels, rules)
        for row, state in enumerate(LIMIT_STATES.values()):
            found[row, :, column] = first_factor(factor, peak, state.capacity)
    return found


def _displacement(record: Record, period: Array, damping_ratio: float) -> Array:
    """Return the spectral displacement. [m]"""
    return spectral_acceleration(record, period, damping_ratio) * (period / (2 * np.pi)) ** 2


def _beside_all(of_walls: Array) -> Array:
    """Return values with NaN before those of the walls, the last dimension: all walls together have none."""
    return np.concatenate([np.full((*of_walls.shape[:-1], 1), np.nan), of_walls], axis=-1)
