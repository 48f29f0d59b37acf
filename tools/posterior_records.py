"""Records made with parameters drawn from the prior, and identified again: is the posterior right about itself?

If prior, likelihood and computation are what they say, the share of the posterior below a true value, its rank, is
uniform (Talts et al., arXiv:1804.06788), and an interval of any level holds it as often as its level says. The standard
errors of least squares are judged by the same records.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtr
from scipy.stats import kstest

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import LOST, RecordFit
from rockdamp.laboratory.noise import correlated
from rockdamp.laboratory.problem import INSTRUMENTS, Problem
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.pulse_shapes import table_pulse
from rockdamp.motions.records import Record
from rockdamp.statistics.distribution import Distribution

LEVELS = (0.5, 0.9)
EFFECTIVE = 300.0  # draws, at least: a rank is then known to 0.03
# The tested wall of the paper, and what is drawn for its records beside the parameters of the prior.
WALL = Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57, overburden_ratio=6.2)
DURATION, SAMPLING, PULSE_AT = 4.0, 128.0, 1.0  # [s], [Hz], where the table's pulse peaks [s]
PULSE_PEAK = Distribution("uniform", 6.0, 15.0)  # [m s-2]
MOTION_NOISE = 0.02  # standard deviation of the accelerometer's noise [m s-2]
STEP = 0.01  # of the solver, in tau, at most
PRIOR = Prior(
    sensor_deviation=Distribution("loguniform", 5e-5, 5e-4),  # [m]
    sensor_correlation=Distribution("uniform", 0.0, 0.9),
)


def names_of(candidate: Candidate) -> tuple[str, ...]:
    """Return the parameters that are drawn."""
    return (*candidate.parameters, *INSTRUMENTS)


def fit_of(record: Record, candidate: Candidate) -> RecordFit:
    """Prepare the fit of a candidate to a record of the wall."""
    return RecordFit.from_record(
        record, WALL, candidate, ultimate_displacement_ratio=1.0, softening="steeper", step=STEP
    )


def made(candidate: Candidate, random: np.random.RandomState) -> tuple[Record, Array]:
    """Draw parameters and a pulse until the wall rocks and survives; return the record, and what made it."""
    elapsed, names = np.arange(round(DURATION * SAMPLING) + 1) / SAMPLING, names_of(candidate)
    while True:
        values = PRIOR.values(names, random.uniform(size=(1, len(names))))
        pulse = table_pulse(elapsed - PULSE_AT, float(PULSE_PEAK.quantile(random.uniform())))
        moved = fit_of(Record(elapsed, pulse, np.zeros_like(elapsed)), candidate)
        if values[0, 0] >= 0.99 * moved.physical(np.array([1.0, values[0, 1], 0.0]))[0]:
            continue
        displacement = moved.computed(values[:, : -len(INSTRUMENTS)])[0]
        if values[0, 0] * moved.u_ins < np.abs(displacement).max() < LOST * moved.u_ins:
            break
    zero, drift = random.standard_normal(2) * [PRIOR.sensor_zero, PRIOR.sensor_drift]
    noise = correlated(float(values[0, -2]), float(values[0, -1]), random.standard_normal(elapsed.size))
    measured = pulse + MOTION_NOISE * random.standard_normal(elapsed.size)
    return Record(elapsed, measured, displacement + zero + drift * elapsed + noise), values[0]


def judged(candidate: Candidate, seed: int, number: int) -> list[dict[str, Any]]:
    """Make the record of a number, identify it, and return a row for each parameter: `row_of`."""
    record, truth = made(candidate, np.random.RandomState([seed, number]))
    mean, deviation, rank, below = (np.full(truth.size, np.nan) for _ in range(4))
    try:
        solution = fit_of(record, candidate).solution()
        covariance = solution.covariance_by_sensor[0] + solution.covariance_by_motion
        below[:3] = ndtr((truth[:3] - solution.estimate) / np.sqrt(np.diag(covariance)))
        problem, draws = Problem.about(solution, PRIOR).drawn(EFFECTIVE, seed)
        values, weights = problem.values(draws.points), draws.weights
        found = weights @ values
        if problem.doubts(float(found[-2])):
            raise InputError("the model that made the record does not explain it")
        mean, deviation = found, np.sqrt(weights @ (values - found) ** 2)
        rank = weights @ (values < truth)
    except InputError:
        pass
    each = zip(names_of(candidate), truth, mean, deviation, rank, below, strict=True)
    return [row_of(number, *one) for one in each]


def row_of(
    number: int, parameter: str, truth: float, mean: float, deviation: float, rank: float, below: float
) -> dict[str, Any]:
    """Return a row of the check: true value, the posterior's mean and standard deviation, and ranks of the true value.

    The rank by least squares is that in a normal distribution by estimate and standard error. NaN where the record was
    refused.
    """
    numbers = {"truth": truth, "mean": mean, "deviation": deviation, "rank": rank, "rank_by_least_squares": below}
    return {"number": number, "parameter": parameter, **{key: float(f"{x:.6g}") for key, x in numbers.items()}}


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Return for each parameter how often intervals hold the truth, the deviation of z, and whether ranks are uniform.

    z is the true value less the posterior's mean, over its standard deviation.
    """
    found = {}
    for name, of in rows.groupby("parameter", sort=False):
        known, by_least_squares = of.dropna(subset="rank"), of["rank_by_least_squares"].dropna()
        z = (known["truth"] - known["mean"]) / known["deviation"]
        found[name] = {
            "records": len(of),
            "identified": len(known),
            **{f"held_{level}": (abs(2 * known["rank"] - 1) <= level).mean() for level in LEVELS},
            **{f"held_{level}_by_least_squares": (abs(2 * by_least_squares - 1) <= level).mean() for level in LEVELS},
            "deviation_of_z": z.std(ddof=0),
            "p": kstest(known["rank"], "uniform").pvalue if len(known) else np.nan,
        }
    return pd.DataFrame.from_dict(found, orient="index")
