"""The section ``identification`` of the config, parsed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rockdamp.config.parsing import Settings
from rockdamp.studies.identification.posterior import Sampler
from rockdamp.studies.identification.prior import Bounds, Prior
from rockdamp.studies.walls import Strip


@dataclass(frozen=True)
class Simulated:
    """Records made with parameters that are drawn from the prior.

    Parameters
    ----------
    draws, seed : int
    damping_models : tuple of str
        That make the records, and are then identified; each has as many draws.
    duration, sampling, pulse_at : float
        Of a record [s], of its samples [Hz], and where the pulse peaks. [s]
    pulse_peak : Interval
        [m s-2]
    motion_noise : float
        Standard deviation of the accelerometer's noise. [m s-2]
    sensor_deviation, sensor_correlation : Interval
        In place of the prior's.
    step : float
        Of the solver, in tau, at most. [-]
    sampler : Sampler
    """

    draws: int
    seed: int
    damping_models: tuple[str, ...]
    duration: float
    sampling: float
    pulse_at: float
    pulse_peak: Bounds
    motion_noise: float
    sensor_deviation: Bounds
    sensor_correlation: Bounds
    step: float
    sampler: Sampler


@dataclass(frozen=True)
class SimulatedSettings(Settings):
    wall: Annotated[Strip, "validation.wall"]
    ultimate_ratio: Annotated[float, "validation.curve.ultimate_ratio"]
    softening: Annotated[str, "validation.curve.softening"]
    prior: Annotated[Prior, "identification.prior"]
    simulated: Annotated[Simulated, "identification.simulated"]
