"""The seeded experimental-style record that stands in for the shaking-table test of Fig. 8.

The record of the test (SIN-03-00, test #2.4) is not public. This one is labelled synthetic in its
header. Its response comes from the event-driven solver, not from the one under test, and its curve
and e are not those of Fig. 8.

``.venv/bin/python tools/experimental_style.py PATH`` writes it.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError, check
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import write_record
from rockdamp.solvers.exact import exact_history

# The wall of Fig. 8; width and density too, though neither changes the response.
# ASSUME: width 1.438 m and density 1835 kg m-3, from a secondary source that was not verified.
WALL = Wall(
    thickness=0.102,
    height=27 * 0.102,
    width=1.438,
    density=1835.0,
    hinge_ratio=0.57,
    overburden_ratio=6.2,
)

# Near a1 = 0.03, b1 = 0.80, e = 0.835 of Fig. 8, but not equal, as those of a test would not be.
YIELD_DISPLACEMENT_RATIO = 0.031
STRENGTH_RATIO = 0.799
RESTITUTION = 0.84

# The paper's pulse, an ideal Ricker wavelet; a real table follows it only nearly.
# ASSUME: 1.35 g, more than the 0.26 to 1.00 g reported for the sister specimen. This wall carries
# six times its weight: it starts to rock at 1.17 g, its plateau. It peaks at 0.145 u_ins, and
# collapses under 1.45 g.
PULSE_FREQUENCY = 2.0  # [Hz]
PULSE_PEAK = 1.35 * STANDARD_GRAVITY
PULSE_CENTRE = 1.5  # [s]
DURATION = 5.0  # [s]

# ASSUME: an instrumented test, as far as is known of this one.
SAMPLING = 256  # [Hz]
OVERSAMPLING = 4  # samples of the motion that the wall feels, per sample of the record
ACCELEROMETER_NOISE = 0.02  # standard deviation [m s-2]
SENSOR_NOISE = 1.5e-4  # standard deviation of the displacement sensor [m]
SENSOR_ZERO = 1.3e-3  # its reading while the wall is at rest [m]
SENSOR_DRIFT = 6e-5  # steady part of its drift [m s-1]
SENSOR_WANDER = 2e-5  # random part: standard deviation after one second of a random walk [m]
# The logger's steps: 0.001 m s-2 and 0.01 mm.
DECIMALS = {"elapsed": 8, "ground_acceleration": 3, "displacement": 5}

SEED = 2017


def ricker(time: ArrayLike, frequency: float, amplitude: float) -> Array:
    """Return a Ricker wavelet A (1 - 2 s) exp(-s), s = (pi f t)^2, with its peak at t = 0 [m s-2].

    `time` is in s, `frequency` in Hz and `amplitude` in m s-2.
    """
    s = (np.pi * frequency * np.asarray(time, float)) ** 2
    return amplitude * (1 - 2 * s) * np.exp(-s)


def synthetic_record(
    seed: int = SEED,
    *,
    yield_displacement_ratio: float = YIELD_DISPLACEMENT_RATIO,
    strength_ratio: float = STRENGTH_RATIO,
    restitution: float = RESTITUTION,
    damping_model: str = "CR",
    pulse_peak: float = PULSE_PEAK,
    noise: float = 1.0,
) -> Record:
    """Return the experimental-style record: the pulse and the wall's response, as instruments read
    them.

    A viscous damper has the ratio that loses as much energy as e in a half cycle from 0.3 u_ins.
    `pulse_peak` is the peak of the table's acceleration [m s-2]. `noise` is a factor on the noise
    and drift of both instruments; 0 leaves the sensor's zero and the rounding. A pulse that
    collapses the wall is refused.
    """
    check("noise", noise, lambda factor: factor >= 0, "at least 0")
    elapsed = np.arange(int(DURATION * SAMPLING) + 1) / SAMPLING
    fine_steps = np.arange(int(DURATION * SAMPLING) * OVERSAMPLING + 1)
    fine = fine_steps / (SAMPLING * OVERSAMPLING)
    motion = ricker(fine - PULSE_CENTRE, PULSE_FREQUENCY, pulse_peak)
    load = make_load(WALL, Record(fine, motion))
    curve = TrilinearCurve(yield_displacement_ratio, strength_ratio)
    value = restitution
    if damping_model != "CR":
        value = damping_ratio_energy(curve, damping_model, restitution, 0.3)
    damping = Damping(damping_model, value)
    tau = float(WALL.frequency_parameter) * elapsed
    history = exact_history(curve, damping, tau, **sample_load(load))
    if history.collapsed:
        raise InputError(
            f"pulse_peak is {pulse_peak:g}; it must be so small that the wall survives [m s-2]"
        )

    # The shipped files must not change: RandomState's streams are frozen, a Generator's are not.
    random = np.random.RandomState(seed)
    steps = random.standard_normal(elapsed.size) / np.sqrt(SAMPLING)
    drift = SENSOR_DRIFT * elapsed + SENSOR_WANDER * np.cumsum(steps)
    sensor = SENSOR_NOISE * random.standard_normal(elapsed.size)
    accelerometer = ACCELEROMETER_NOISE * random.standard_normal(elapsed.size)
    u_ins = float(WALL.instability_displacement)
    columns = {
        "elapsed": elapsed,
        "ground_acceleration": motion[::OVERSAMPLING] + noise * accelerometer,
        "displacement": u_ins * history.displacement + SENSOR_ZERO + noise * (drift + sensor),
    }
    # Adding 0.0 turns a rounded -0.0 into 0.0.
    rounded = {name: np.round(values, DECIMALS[name]) + 0.0 for name, values in columns.items()}
    header = {
        "specimen": "wall like SIN-03-00 of the paper's Fig. 8; computed, not tested",
        "source": "event-driven solution under a Ricker pulse, with noise and drift",
        "licence": "CC0-1.0",
        "units": "s, m s-2, m",
        "synthetic": "yes",
        "generator_seed": str(seed),
        "generator_yield_displacement_ratio": f"{yield_displacement_ratio:g}",
        "generator_strength_ratio": f"{strength_ratio:g}",
        "generator_restitution": f"{restitution:g}",
        "generator_pulse_peak_m_s2": f"{pulse_peak:.6g}",
        "generator_pulse_frequency_hz": f"{PULSE_FREQUENCY:g}",
        "generator_accelerometer_noise_m_s2": f"{noise * ACCELEROMETER_NOISE:g}",
        "generator_sensor_noise_m": f"{noise * SENSOR_NOISE:g}",
        "generator_sensor_zero_m": f"{SENSOR_ZERO:g}",
        "generator_sensor_drift_m_s1": f"{noise * SENSOR_DRIFT:g}",
        "generator_sensor_wander_m_s05": f"{noise * SENSOR_WANDER:g}",
    }
    return Record(
        rounded["elapsed"], rounded["ground_acceleration"], rounded["displacement"], header
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python tools/experimental_style.py PATH")
    write_record(sys.argv[1], synthetic_record())
