"""Whether the posterior is right about itself: records made with parameters drawn from the prior are identified.

If prior, likelihood and sampler are what they say, the rank of a true value among draws of its posterior is uniform
(Talts et al., arXiv:1804.06788), and an interval of any level holds it as often as its level says. The standard errors
of least squares are judged by the same records.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.experimental_style import table_pulse
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.studies.candidates import ANY_ORDER, CANDIDATES, Candidate
from rockdamp.studies.identification.noise import correlated
from rockdamp.studies.identification.posterior import INSTRUMENTS, Problem, draw
from rockdamp.studies.identification.prior import Prior
from rockdamp.studies.identification.settings import Simulated, SimulatedSettings
from rockdamp.studies.least_squares import LOST, Fit

DRAWN = INSTRUMENTS[:-1]  # of the instruments: the gain stands for noise of the motion, which has no single value
RANKED = 99  # draws of each posterior among which the true value is ranked: 100 ranks
LEVELS = np.array([0.5, 0.9])
START_ORDER = 4.0  # of the damper of any order, while the others are searched
PARAMETERS = (
    "cracked_stiffness_ratio",
    "plateau_ratio",
    "restitution",
    "damping_ratio",
    "order",
    *DRAWN,
)
IDENTIFIED, REFUSED = 1, 0


@dataclass(frozen=True)
class Trial:
    """A record, and the values that made it, in the order of the names of its problem."""

    record: Record
    values: Array


@dataclass(frozen=True)
class Maker:
    """What makes records by a candidate."""

    wall: Wall
    ultimate_ratio: float
    softening: str
    prior: Prior
    given: Simulated
    candidate: Candidate

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that are drawn."""
        return (*self.candidate.parameters, *DRAWN)

    def fit(self, record: Record) -> Fit:
        """Prepare the fit of a record."""
        return Fit.of(
            record,
            self.wall,
            self.candidate,
            ultimate_ratio=self.ultimate_ratio,
            softening=self.softening,
            step=self.given.step,
        )

    def trial(self, random: np.random.RandomState) -> Trial:
        """Draw parameters and a pulse until the wall rocks and stands, and make the record of it."""
        given, low, high = self.given, *self.prior.bounds(self.names)
        elapsed = np.arange(round(given.duration * given.sampling) + 1) / given.sampling
        while True:
            values = self.prior.values(self.names, random.uniform(low, high)[None])
            pulse = table_pulse(elapsed - given.pulse_at, _drawn(given, random))
            moved = self.fit(Record(elapsed, pulse, np.zeros_like(elapsed)))
            if values[0, 0] >= 0.99 * moved.physical(np.array([1.0, values[0, 1], 0.0]))[0]:
                continue
            displacement = moved.computed(values[:, : -len(DRAWN)])[0]
            if values[0, 0] * moved.u_ins < np.abs(displacement).max() < LOST * moved.u_ins:
                break
        zero, drift = random.standard_normal(2) * [self.prior.sensor_zero, self.prior.sensor_drift]
        noise = correlated(*values[0, -2:], random.standard_normal(elapsed.size))
        measured = pulse + given.motion_noise * random.standard_normal(elapsed.size)
        return Trial(Record(elapsed, measured, displacement + zero + drift * elapsed + noise), values[0])


def simulated(config: Config) -> xr.Dataset:
    """Identify records made with parameters drawn from the prior, and rank what made them.

    Parameters
    ----------
    config : dict
        Has the keys of `SimulatedSettings`.

    Returns
    -------
    xarray.Dataset
        For each record of each model ``identified``; of each parameter, NaN where the model has none or the record was
        refused, ``true_value``, ``rank``, ``posterior_mean``, ``posterior_deviation``, ``standard_score`` of least
        squares; and ``covered`` and ``covered_by_least_squares`` (level): the share of intervals that hold the truth.
    """
    settings = SimulatedSettings.of(config)
    given = settings.simulated
    prior = replace(
        settings.prior, sensor_deviation=given.sensor_deviation, sensor_correlation=given.sensor_correlation
    )
    for name in given.damping_models:
        if name not in CANDIDATES:
            raise InputError(f"identification.simulated.damping_models: {name!r} is none of {', '.join(CANDIDATES)}")
    rows = []
    for name in given.damping_models:
        candidate = Candidate(name, START_ORDER if name == ANY_ORDER else None)
        maker = Maker(settings.wall, settings.ultimate_ratio, settings.softening, prior, given, candidate)
        numbers = track(range(given.draws), f"records made by {name}")
        rows.append([judged(maker, np.random.RandomState([given.seed, number])) for number in numbers])
    return _gathered(given.damping_models, rows)


def judged(maker: Maker, random: np.random.RandomState) -> dict[str, Array]:
    """Make a record, identify it, and compare with what made it."""
    trial = maker.trial(random)
    columns = [PARAMETERS.index(name) for name in maker.names]
    found = {name: np.full(len(PARAMETERS), np.nan) for name in (*SINGLE, "standard_score")}
    found |= {"covered": np.full((len(PARAMETERS), LEVELS.size), np.nan), "identified": np.array(REFUSED)}
    found["true_value"][columns] = trial.values
    try:
        problem = Problem.of(maker.fit(trial.record), maker.prior)
        found["standard_score"][columns[:3]] = _standard_score(problem, trial.values[:3])
        draws = draw(problem, replace(maker.given.sampler, seed=random.randint(2**31 - 100)))
    except InputError:
        return found
    if not draws.good:
        return found
    values = problem.values(draws.flat)[:, :-1]
    ranked = values[random.permutation(len(values))[:RANKED]]
    found["rank"][columns] = (ranked < trial.values).sum(axis=0)
    found["posterior_mean"][columns], found["posterior_deviation"][columns] = values.mean(axis=0), values.std(axis=0)
    low, high = (np.quantile(values, 0.5 + side * LEVELS / 2, axis=0).T for side in (-1, 1))
    truth = trial.values[:, None]
    found["covered"][columns] = (low <= truth) & (truth <= high)
    found["identified"] = np.array(IDENTIFIED)
    return found


SINGLE = ("true_value", "rank", "posterior_mean", "posterior_deviation")


def _standard_score(problem: Problem, truth: Array) -> Array:
    """Error of the least squares over its standard error, NaN where the record does not determine it."""
    try:
        covariance = problem.solution.covariance_by_sensor[0] + problem.solution.covariance_by_motion
    except InputError:
        return np.full(3, np.nan)
    return (problem.solution.estimate - truth) / np.sqrt(np.diag(covariance))


def _drawn(given: Simulated, random: np.random.RandomState) -> float:
    return float(given.pulse_peak.value(random.uniform(*given.pulse_peak.bounds)))


def _gathered(models: Sequence[str], rows: list[list[dict[str, Array]]]) -> xr.Dataset:
    """Put the records of each model into one dataset."""
    dims = dict.fromkeys((*SINGLE, "standard_score"), ("parameter",))
    dims |= {"covered": ("parameter", "level"), "identified": ()}
    stacked = {name: np.array([[row[name] for row in of_model] for of_model in rows]) for name in dims}
    variables = {name: (("damping_model", "draw", *dims[name]), values) for name, values in stacked.items()}
    return xr.Dataset(
        variables,
        coords={
            "damping_model": list(models),
            "draw": np.arange(1, len(rows[0]) + 1),
            "parameter": list(PARAMETERS),
            "level": LEVELS,
        },
    )
