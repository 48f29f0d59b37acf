"""See that the posterior is right about itself: identify records made with parameters that are drawn from its prior.

`.venv/bin/python tools/check_posterior.py --records 100 --seed 7`. A record takes some seconds. If prior, likelihood
and sampler are what they say, the rank of a true value among draws of its posterior is uniform (Talts et al.,
arXiv:1804.06788), and an interval of any level holds it as often as its level says. The standard errors of least
squares are judged by the same records. The program tells how often the intervals held the truth, with the standard
error that so many records leave, and ends with status 1 where this is off by more than three of those.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.motions.experimental_style import WALL, table_pulse
from rockdamp.motions.records import Record
from rockdamp.studies.candidates import Candidate
from rockdamp.studies.identification.importance import explore
from rockdamp.studies.identification.noise import correlated
from rockdamp.studies.identification.posterior import Sampler, draw
from rockdamp.studies.identification.prior import Interval, Prior
from rockdamp.studies.identification.problem import INSTRUMENTS, Problem
from rockdamp.studies.least_squares import LOST, Fit
from rockdamp.vocabulary import CANDIDATES, REFERENCE

# Of the records: an instrumented test at a coarser sampling than the shipped one's, for speed.
DURATION, SAMPLING, PULSE_AT = 4.0, 128.0, 1.0  # [s], [Hz], [s]
PULSE_PEAK = (6.0, 15.0)  # [m s-2]
MOTION_NOISE = 0.02  # [m s-2]
PRIOR = replace(
    Prior(),
    sensor_deviation=Interval("loguniform", 5e-5, 5e-4),
    sensor_correlation=Interval("uniform", 0.0, 0.9),
)
STEP = 0.01  # in tau
SAMPLER = Sampler(ensembles=4, walkers=64, burn_in=80, steps=60, rounds=6, effective=200)
RANKED = 99  # draws of each posterior, among which the true value has one of 100 ranks
LEVELS = {0.5: 0.6745, 0.9: 1.6449}  # of intervals, and the standard errors that least squares take for them
MOST = 3.0  # standard errors of a share


@dataclass(frozen=True)
class Judged:
    """One record: ranks of the true values, and errors of least squares over standard errors; NaN if refused."""

    ranks: Array
    scores: Array


def fit_of(record: Record, candidate: Candidate) -> Fit:
    return Fit.of(record, WALL, candidate, ultimate_ratio=1.0, softening="steeper", step=STEP)


def trial(candidate: Candidate, random: np.random.RandomState) -> tuple[Record, Array]:
    """Draw parameters and a pulse until the wall rocks and stands; return the record, and what made it."""
    names = (*candidate.parameters, *INSTRUMENTS[:-1])
    low, high = PRIOR.bounds(names)
    elapsed = np.arange(round(DURATION * SAMPLING) + 1) / SAMPLING
    while True:
        values = PRIOR.values(names, random.uniform(low, high)[None])
        pulse = table_pulse(elapsed - PULSE_AT, random.uniform(*PULSE_PEAK))
        moved = fit_of(Record(elapsed, pulse, np.zeros_like(elapsed)), candidate)
        if values[0, 0] >= 0.99 * moved.physical(np.array([1.0, values[0, 1], 0.0]))[0]:
            continue
        displacement = moved.computed(values[:, :-2])[0]
        if values[0, 0] * moved.u_ins < np.abs(displacement).max() < LOST * moved.u_ins:
            break
    zero, drift = random.standard_normal(2) * [PRIOR.sensor_zero, PRIOR.sensor_drift]
    noise = correlated(float(values[0, -2]), float(values[0, -1]), random.standard_normal(elapsed.size))
    measured = pulse + MOTION_NOISE * random.standard_normal(elapsed.size)
    return Record(elapsed, measured, displacement + zero + drift * elapsed + noise), values[0]


def judged(candidate: Candidate, random: np.random.RandomState, sampler: Sampler = SAMPLER) -> Judged:
    """Make a record, identify it, and compare with what made it."""
    record, truth = trial(candidate, random)
    ranks, scores = np.full(truth.size, np.nan), np.full(3, np.nan)
    try:
        problem = Problem.of(fit_of(record, candidate), PRIOR)
        found = problem.fit.solution()
        covariance = found.covariance_by_sensor[0] + found.covariance_by_motion
        scores = (found.estimate - truth[:3]) / np.sqrt(np.diag(covariance))
        draws = draw(problem, explore(problem, random), replace(sampler, seed=random.randint(2**31 - 100)))
    except InputError:
        return Judged(ranks, scores)
    if draws.good:
        values = problem.values(draws.flat)[:, : truth.size]
        ranks = (values[random.permutation(len(values))[:RANKED]] < truth).sum(axis=0).astype(float)
    return Judged(ranks, scores)


def held_by_ranks(ranks: Array, level: float) -> Array:
    """Say which true values lie in the interval of a level, by their ranks from 0 to RANKED."""
    outside = (RANKED + 1) * (1 - level) / 2
    return (ranks >= outside) & (ranks < RANKED + 1 - outside)


def told(name: str, held: Array, level: float) -> bool:
    """Print how often an interval held the truth; say whether that is within what so many records leave."""
    share, error = float(np.mean(held)), float(np.sqrt(level * (1 - level) / held.size))
    print(f"  {level:.0%} interval of {name}: {share:.1%} of {held.size} ± {error:.1%}")
    return abs(share - level) <= MOST * error


def report(names: Sequence[str], records: Sequence[Judged]) -> bool:
    """Print the coverage of each parameter, by the posterior and by least squares; say whether the former holds."""
    ranks = np.array([record.ranks for record in records if not np.isnan(record.ranks).any()])
    scores = np.array([record.scores for record in records if not np.isnan(record.scores).any()])
    print(f"{len(ranks)} of {len(records)} records identified, the others refused; by the posterior:")
    if not len(ranks):
        return False
    holds = [
        told(name, held_by_ranks(ranks[:, column], level), level)
        for column, name in enumerate(names)
        for level in LEVELS
    ]
    print(f"by least squares, of {len(scores)} records:")
    for column, name in enumerate(names[:3]):
        for level, reach in LEVELS.items():
            told(name, np.abs(scores[:, column]) <= reach, level)
    return all(holds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--damping-model", choices=CANDIDATES, default=REFERENCE)
    given = parser.parse_args()
    candidate = Candidate.of(given.damping_model)
    records = []
    for number in range(given.records):
        records.append(judged(candidate, np.random.RandomState([given.seed, number])))
        print(f"\r{number + 1} of {given.records}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return 0 if report((*candidate.parameters, *INSTRUMENTS[:-1]), records) else 1


if __name__ == "__main__":
    sys.exit(main())
