"""The section ``identification`` of the config, parsed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rockdamp.arrays import Array
from rockdamp.config.parsing import Settings
from rockdamp.config.walls import Strip
from rockdamp.studies.identification.prior import Interval, Prior


@dataclass(frozen=True)
class Simulated:
    """Records that are made with parameters drawn from the prior, and then identified.

    Parameters
    ----------
    draws, seed : int
        Number of the records; of their random numbers.
    damping_model : str
        That makes them, and by which they are identified.
    duration, sampling, pulse_at : float
        Of a record [s], of its samples [Hz], and where the table's pulse peaks. [s]
    pulse_peak : Interval
        [m s-2]
    motion_noise : float
        Standard deviation of the accelerometer's noise. [m s-2]
    sensor_deviation, sensor_correlation : Interval
        In place of the prior's.
    """

    draws: int
    seed: int
    damping_model: str
    duration: float
    sampling: float
    pulse_at: float
    pulse_peak: Interval
    motion_noise: float
    sensor_deviation: Interval
    sensor_correlation: Interval


@dataclass(frozen=True)
class IdentificationSettings(Settings):
    """The wall of the tests, the prior, and what is simulated: new records, and the ladder's with more noise."""

    wall: Annotated[Strip, "validation.wall"]
    ultimate_ratio: Annotated[float, "validation.curve.ultimate_ratio"]
    softening: Annotated[str, "validation.curve.softening"]
    prior: Annotated[Prior, "identification.prior", Prior.of]
    step: Annotated[float, "identification.step"]
    simulated: Annotated[Simulated, "identification.simulated"]
    damping_models: Annotated[tuple[str, ...], "identification.damping_models"]
    noise: Annotated[Array, "identification.noise"]
