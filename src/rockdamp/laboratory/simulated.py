"""Check the posterior by records that are made with parameters drawn from the prior, and then identified.

If prior, likelihood and computation are what they say, the share of the posterior below a true value is uniform (Talts
et al., arXiv:1804.06788), and an interval of any level holds it as often as its level says. The standard errors of
least squares are judged by the same records.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.special import ndtr
from scipy.stats import kstest

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import LOST, RecordFit, Solution
from rockdamp.laboratory.noise import correlated
from rockdamp.laboratory.problem import INSTRUMENTS, Problem
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.pulse_shapes import table_pulse
from rockdamp.motions.records import Record
from rockdamp.statistics.distribution import Distribution

LEVELS = np.array([0.5, 0.9])
EFFECTIVE = 300.0  # draws, at least: a rank is then known to 0.03


@dataclass(frozen=True)
class Simulated:
    """Records that are made with parameters drawn from the prior, and then identified by the model that made them."""

    draws: int
    seed: int
    damping_model: str
    duration: float  # [s]
    sampling: float  # [Hz]
    pulse_at: float  # where the table's pulse peaks [s]
    pulse_peak: Distribution  # [m s-2]
    motion_noise: float  # standard deviation of the accelerometer's noise [m s-2]
    sensor_deviation: Distribution  # in place of the prior's [m]
    sensor_correlation: Distribution


@dataclass(frozen=True)
class Judged:
    """One record: its true values, and where they lie in the posterior; NaN where it was refused. Shape (parameters,).

    The rank is the share of the posterior below the true value. That by least squares, shape (3,), is the share below
    it of a normal distribution by estimate and standard error.
    """

    true_value: Array
    rank: Array
    mean: Array
    deviation: Array
    rank_by_least_squares: Array


@dataclass(frozen=True)
class Maker:
    """The wall and the distributions by which records are made, and identified again."""

    wall: Wall
    ultimate_displacement_ratio: float
    softening: str
    step: float
    prior: Prior  # with the sensor's noise as it is simulated
    simulated: Simulated

    @property
    def candidate(self) -> Candidate:
        """The damping model that makes the records."""
        return Candidate.of(self.simulated.damping_model)

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that are drawn."""
        return (*self.candidate.parameters, *INSTRUMENTS)

    def fit(self, record: Record, candidate: Candidate) -> RecordFit:
        """Prepare the fit of a candidate to a record of this wall."""
        a3, softening = self.ultimate_displacement_ratio, self.softening
        return RecordFit.of(
            record, self.wall, candidate, ultimate_displacement_ratio=a3, softening=softening, step=self.step
        )

    def record(self, random: np.random.RandomState) -> tuple[Record, Array]:
        """Draw parameters and a pulse until the wall rocks and stands; return the record, and what made it."""
        simulated = self.simulated
        elapsed = np.arange(round(simulated.duration * simulated.sampling) + 1) / simulated.sampling
        while True:
            values = self.prior.values(self.names, random.uniform(size=(1, len(self.names))))
            peak = simulated.pulse_peak.quantile(random.uniform())
            pulse = table_pulse(elapsed - simulated.pulse_at, float(peak))
            moved = self.fit(Record(elapsed, pulse, np.zeros_like(elapsed)), self.candidate)
            if values[0, 0] >= 0.99 * moved.physical(np.array([1.0, values[0, 1], 0.0]))[0]:
                continue
            displacement = moved.computed(values[:, : -len(INSTRUMENTS)])[0]
            if values[0, 0] * moved.u_ins < np.abs(displacement).max() < LOST * moved.u_ins:
                break
        zero, drift = random.standard_normal(2) * [self.prior.sensor_zero, self.prior.sensor_drift]
        noise = correlated(float(values[0, -2]), float(values[0, -1]), random.standard_normal(elapsed.size))
        measured = pulse + simulated.motion_noise * random.standard_normal(elapsed.size)
        return Record(elapsed, measured, displacement + zero + drift * elapsed + noise), values[0]

    def judged(self, number: int, effective: float = EFFECTIVE) -> Judged:
        """Make the record of a number, identify it by so many effective draws, and compare with what made it."""
        random = np.random.RandomState([self.simulated.seed, number])
        record, truth = self.record(random)
        nothing, by_least_squares = np.full(truth.size, np.nan), np.full(3, np.nan)
        try:
            solution = self.fit(record, self.candidate).solution()
            by_least_squares = _rank_by_least_squares(solution, truth[:3])
            problem, draws = Problem.about(solution, self.prior).drawn(effective, self.simulated.seed)
            values, weights = problem.values(draws.points), draws.weights
            mean = weights @ values
            if problem.doubts(float(mean[-2])):
                raise InputError("the model that made the record does not explain it")
        except InputError:
            return Judged(truth, nothing, nothing, nothing, by_least_squares)
        deviation = np.sqrt(weights @ (values - mean) ** 2)
        return Judged(truth, weights @ (values < truth), mean, deviation, by_least_squares)


def gathered(names: Sequence[str], records: Sequence[Judged]) -> xr.Dataset:
    """Put the records into one dataset, with the share of intervals that hold the truth."""
    rank = np.array([record.rank for record in records])
    identified = int(np.isfinite(rank).all(axis=1).sum())
    by_least_squares = np.full(rank.shape, np.nan)
    by_least_squares[:, :3] = [record.rank_by_least_squares for record in records]
    dims, wall = ("draw", "parameter"), [index for index, name in enumerate(names) if name not in INSTRUMENTS]
    of_wall = ("draw", "wall_parameter")
    return xr.Dataset(
        {
            "true_value": (of_wall, np.array([record.true_value[wall] for record in records])),
            "posterior_mean": (of_wall, np.array([record.mean[wall] for record in records])),
            "posterior_deviation": (of_wall, np.array([record.deviation[wall] for record in records])),
            "rank": (dims, rank),
            "rank_by_least_squares": (dims, by_least_squares),
            "coverage": (("level", "parameter"), _coverage(rank)),
            "coverage_error": ("level", np.sqrt(LEVELS * (1 - LEVELS) / max(identified, 1))),
            "coverage_by_least_squares": (("level", "parameter"), _coverage(by_least_squares)),
            "rank_p_value": ("parameter", np.array([_p_value(column) for column in rank.T])),
            "identified_records": identified,
        },
        coords={
            "draw": np.arange(1, len(records) + 1),
            "parameter": list(names),
            "wall_parameter": [names[index] for index in wall],
            "level": LEVELS,
        },
    )


def _coverage(rank: Array) -> Array:
    """Share of the records that are not refused whose true value lies in the middle of each level; NaN of none."""
    known = np.isfinite(rank)
    held = (np.abs(2 * rank - 1) <= LEVELS[:, None, None]) & known
    count = known.sum(axis=0)
    return np.where(count > 0, held.sum(axis=1) / np.maximum(count, 1), np.nan)


def _p_value(rank: Array) -> float:
    """Of Kolmogorov and Smirnov's test that the ranks are uniform; NaN of none."""
    known = rank[np.isfinite(rank)]
    return float(kstest(known, "uniform").pvalue) if known.size else np.nan


def _rank_by_least_squares(solution: Solution, truth: Array) -> Array:
    covariance = solution.covariance_by_sensor[0] + solution.covariance_by_motion
    return np.asarray(ndtr((truth - solution.estimate) / np.sqrt(np.diag(covariance))))
