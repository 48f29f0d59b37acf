"""Random tests of walls on a shaking table, made by the event-driven solver, and what the posterior says of each.

What is drawn was chosen before any test was identified: walls, curves and coefficients of restitution by the default
prior, three shapes of pulses, rates, and the errors of both instruments. A real wall is not exactly CR: other `MAKERS`
lose their energy otherwise.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.loads import Forcing, Load
from rockdamp.laboratory.candidates import Prior
from rockdamp.laboratory.noise import correlated
from rockdamp.laboratory.posterior import posterior
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.pulse_shapes import ricker, table_pulse, wavelet
from rockdamp.motions.records import Record
from rockdamp.plausibility import as_meant
from rockdamp.progress import without_bars
from rockdamp.solvers import event_driven

NAMES = ("yield_displacement_ratio", "strength_ratio", "restitution")
OVERSAMPLING = 4  # samples of the motion that the wall feels to one of the record
RATES = (100, 128, 200, 256, 500)  # [Hz]
# A test that a laboratory would keep: the wall rocks well beyond its first branch and does not come near to collapse.
LEAST_OF_BRANCH, LEAST, MOST = 2.0, 0.05, 0.9  # of u1, of u_ins
SENSOR = (5e-5, 5e-4)  # standard deviations of its noise [m]
MAKERS = ("CR", "CR, e scatters", "CDC", "ECD16")
SCATTER = 0.01  # standard deviation of e from impact to impact
RATIOS = (0.01, 0.05)  # xi of CDC, drawn apart from e


@dataclass(frozen=True)
class RandomTest:
    """One test: the wall, what made its record, and the record."""

    wall: Wall
    truth: tuple[float, float, float]  # a1, b1, e
    pulse: str
    pulse_peak: float  # [m s-2]
    rate: int  # [Hz]
    peak: float  # u/u_ins
    motion_noise: float  # [m s-2]
    sensor_deviation: float  # [m]
    record: Record
    fine: Record  # the motion as it was, finer than the record


def drawn(
    seed: int,
    number: int,
    maker: str = "CR",
    least_of_branch: float = LEAST_OF_BRANCH,
    share: tuple[float, float] | None = None,
) -> RandomTest:
    """Draw tests until one rocks and survives as a laboratory would keep it.

    The sensor's noise lies within `SENSOR`, or within a share of the wall's largest displacement.
    """
    random = np.random.RandomState([seed, number])
    prior = Prior()
    while True:
        thickness = random.uniform(0.10, 0.50)
        with as_meant():
            wall = Wall(
                thickness=thickness,
                height=thickness * random.uniform(8, 28),
                hinge_ratio=random.uniform(0.5, 0.75),
                overburden_ratio=random.choice([0.0, random.uniform(0.0, 4.0)]),
            )
        a1, b1, e = prior.values(NAMES, random.uniform(size=(1, 3)))[0]
        if a1 >= 0.99 * (1 - b1):  # the plateau would end before it begins
            continue
        rate = int(random.choice(RATES))
        width, side = random.uniform(0.15, 0.6), random.uniform(0.1, 0.4)  # of the pulse's main lobe [s]
        cycles, peak = random.uniform(1.5, 4), wall.rocking_onset(b1) * random.uniform(1.0, 4.0)
        kind = str(random.choice(["ricker", "table", "wavelet"]))
        before, after = random.uniform(0.3, 1.0), random.uniform(2.0, 6.0)  # of the pulse's centre and after it [s]
        noise = np.exp(random.uniform(np.log(0.003), np.log(0.05)))
        deviation, correlation = np.exp(random.uniform(*np.log(share or SENSOR))), random.uniform(0.0, 0.9)
        zero, drift = random.standard_normal(2) * [prior.sensor_zero, prior.sensor_drift]
        # The zeros of a Ricker wavelet are sqrt(2)/(pi f) apart, those of the longest cycle of a wavelet 1/(2 f).
        frequency = {"ricker": np.sqrt(2) / (np.pi * width), "table": 1 / width, "wavelet": 0.5 / width}[kind]
        centre = before + (cycles / 2 if kind == "wavelet" else 2.0) / frequency
        samples = round((centre + after) * rate)
        fine = np.arange(samples * OVERSAMPLING + 1) / (rate * OVERSAMPLING) - centre
        if kind == "ricker":
            motion = ricker(fine, frequency, peak)
        elif kind == "table":
            motion = table_pulse(fine, peak, width=width, side_lobe=side)
        else:
            motion = wavelet(fine, frequency, cycles, peak)
        elapsed = np.arange(samples + 1) / rate
        times = float(wall.frequency_parameter) * elapsed
        forced = Forcing.from_record(wall, Record(fine - fine[0], motion)).event_driven()
        displacement = _response(TrilinearCurve(a1, b1), maker, float(e), times, forced, random)
        ratio = float(np.abs(displacement).max())  # NaN of a wall that collapses
        if max(LEAST, least_of_branch * a1) < ratio < MOST:
            break
    u_ins = float(wall.instability_displacement)
    deviation = deviation * (ratio * u_ins if share else 1.0)
    shown = u_ins * displacement + zero + drift * elapsed
    shown = shown + correlated(deviation, correlation, random.standard_normal(elapsed.size))
    measured = motion[::OVERSAMPLING] + noise * random.standard_normal(elapsed.size)
    record = Record(elapsed, measured, shown)
    true = Record(fine - fine[0], motion)
    return RandomTest(wall, (a1, b1, e), kind, float(peak), rate, ratio, float(noise), float(deviation), record, true)


def _response(curve: TrilinearCurve, maker: str, e: float, times: Array, forced: Load, random: Any) -> Array:
    """Return u/u_ins at times in tau; NaN after a collapse."""
    if maker == "CDC":
        damping = Damping("CDC", random.uniform(*RATIOS))
    else:
        damping = Damping.of_restitution(e, "ECD16" if maker == "ECD16" else "CR")
    if maker != "CR, e scatters":
        return event_driven.history(curve, damping, times, **forced).displacement
    displacement, start, state = np.empty(times.size), 0, (0.0, 0.0)
    while True:
        e_here = min(e + SCATTER * random.standard_normal(), 1.0)
        part = event_driven.history(
            curve,
            Damping.cr(e_here),
            times[start:] - times[start],
            release_amplitude=state[0],
            release_velocity=state[1],
            load=forced["load"][start * OVERSAMPLING :],
            load_step=forced["load_step"],
        )
        displacement[start:] = part.displacement
        # The next e from the first sample after this impact on.
        after = int(np.searchsorted(part.times, part.impacts[0])) + 1 if part.impacts.size else part.times.size
        if after >= part.times.size or not np.isfinite(part.displacement[-1]):
            return displacement
        state = float(part.displacement[after]), float(part.velocity[after])
        start += after


def judged(seed: int, number: int) -> dict[str, float | str]:
    """Identify a test; return how it ended, and the truth with mean, deviation and rank of its posterior."""
    test = drawn(seed, number)
    ended, words = "answered", ""
    start = time.process_time()
    with without_bars(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            answer = posterior(test.record, test.wall, seed=seed)
        except InputError as error:
            ended, words = "refused", str(error)
        except Exception as error:
            ended, words = "failed", f"{type(error).__name__}: {error}"
    row: dict[str, float | str] = {
        "seed": seed,
        "number": number,
        "peak": float(f"{test.peak:.4g}"),
        "ended": ended,
        "reason": words,
        "seconds": round(time.process_time() - start, 1),
    }
    for name, truth in zip(NAMES, test.truth, strict=True):
        mean = deviation = rank = np.nan
        if ended == "answered":
            of = answer.sel(parameter=name)
            mean, deviation = float(of["mean"]), float(of["standard_deviation"])
            rank = float((of["draws"] < truth).mean())
        values = {"true": truth, "mean": mean, "deviation": deviation, "rank": rank}
        row |= {f"{key}_{name}": float(f"{value:.6g}") for key, value in values.items()}
    return row
