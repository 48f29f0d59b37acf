"""A test series of experimental-style records: one wall under pulses of one shape, from small to near collapse.

Four walls go through it. One loses energy at impacts, two by viscous dampers, and one at impacts while its curve
degrades: parameters that fit the records of one need not fit another's. All are labelled synthetic in their headers.

``.venv/bin/python tools/experimental_series.py FOLDER`` makes the records that ``test_series.yaml`` there describes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from experimental_style import OVERSAMPLING, SAMPLING, WALL, instrumented

from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.histories.loads import Forcing
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import wavelet
from rockdamp.motions.records import Record, write_record
from rockdamp.solvers import event_driven
from rockdamp.storage import yaml_file
from rockdamp.vocabulary import STANDARD_GRAVITY

DURATION = 2.5  # [s]
LEG = 0.2  # of a degrading wall is solved at once [s]
SETTINGS = "test_series.yaml"


@dataclass(frozen=True)
class Maker:
    """The wall that makes a record: its curve at the start, its damper, and how it degrades.

    The damper loses as much in a free decay as `restitution`. With each half cycle beyond u1 a1 grows by `growth` and
    b1 falls by `loss`, as fractions of themselves.
    """

    curve: TrilinearCurve
    damping_model: str
    restitution: float
    growth: float = 0.0
    loss: float = 0.0

    @property
    def damping(self) -> Damping:
        return Damping.of_restitution(self.restitution, model=self.damping_model)

    def displacement(self, times: Array, frequency: float, cycles: float, centre: float, amplitude: float) -> Array:
        """Return u/u_ins at `times` [s] under a wavelet that peaks at `centre` [s]; NaN after a collapse."""
        p = float(WALL.frequency_parameter)
        step = 1 / (SAMPLING * OVERSAMPLING)

        def leg(until: Array) -> event_driven.ExactHistory:  # from `start` on, to the last of some tau after it
            later = start + step * np.arange(np.ceil((times[-1] - start) / step) + 1)
            motion = wavelet(later - centre, frequency, cycles, amplitude)
            forcing = Forcing(motion, p * step, float(WALL.load_factor))
            return event_driven.history(curve, self.damping, until, release_velocity=velocity, **forcing.event_driven())

        displacement, curve, start, velocity = np.full(times.shape, np.nan), self.curve, 0.0, 0.0
        while True:
            for stop in (start + LEG, times[-1]):  # the next impact that counts is near, or there is none
                within = (times >= start) & (times <= stop)
                history = leg(p * (times[within] - start))
                impact = self._damaging_impact(history, curve) if self.growth or self.loss else None
                if impact is not None:
                    break
            displacement[within] = history.displacement
            if impact is None:
                return displacement
            # With u = 0 the wall holds no energy in its curve: what it hands on is the velocity after the impact.
            velocity = float(leg(np.array([impact, impact + p * step])).velocity[0])
            start += impact / p
            a1, b1 = float(curve.yield_displacement_ratio), float(curve.strength_ratio)
            curve = TrilinearCurve(a1 * (1 + self.growth), b1 * (1 - self.loss))

    @staticmethod
    def _damaging_impact(leg: event_driven.ExactHistory, curve: TrilinearCurve) -> float | None:
        """Return tau of the first impact that ends a half cycle beyond u1; None where there is none."""
        beyond = leg.turning_tau[np.abs(leg.turning_displacement) > float(curve.yield_displacement_ratio)]
        later = leg.impacts[leg.impacts > beyond[0]] if beyond.size else beyond
        return float(later[0]) if later.size else None


def records(settings: dict[str, Any]) -> Iterator[tuple[str, Record]]:
    """Yield the name and the record of each wall on each level; `settings` are those of test_series.yaml."""
    names = [(wall, level) for wall in settings["walls"] for level in settings["levels"]]
    for seed, (wall, level) in enumerate(names, start=settings["seed"]):
        yield f"{wall}-{level}", record(settings, wall, level, seed)


def record(settings: dict[str, Any], wall: str, level: str, seed: int) -> Record:
    """Make one record of the test series: the response of a wall to the pulse of a level, through the instruments."""
    curve = settings["curve"]
    maker = Maker(TrilinearCurve(**curve), restitution=settings["restitution"], **settings["walls"][wall])
    pulse, peak = settings["pulse"], settings["levels"][level] * STANDARD_GRAVITY
    elapsed = np.arange(int(DURATION * SAMPLING) + 1) / SAMPLING
    response = maker.displacement(elapsed, amplitude=peak, **pulse)
    require(not np.isnan(response).any(), f"levels: {level}", settings["levels"][level], f"so that {wall} survives [g]")
    u_ins = float(WALL.instability_displacement)
    motion = wavelet(elapsed - pulse["centre"], pulse["frequency"], pulse["cycles"], peak)
    made_by = {
        "source": "event-driven solution under a pulse of a few cycles, with noise and drift",
        "generator_level": level,
        "generator_damping_model": maker.damping_model,
        "generator_yield_displacement_ratio": f"{curve['yield_displacement_ratio']:g}",
        "generator_strength_ratio": f"{curve['strength_ratio']:g}",
        "generator_restitution": f"{maker.restitution:g}",
        "generator_cracked_stiffness_growth": f"{maker.growth:g}",
        "generator_plateau_loss": f"{maker.loss:g}",
        "generator_pulse_peak_m_s2": f"{peak:.6g}",
        "generator_pulse_frequency_hz": f"{pulse['frequency']:g}",
        "generator_pulse_cycles": f"{pulse['cycles']:g}",
    }
    return instrumented(elapsed, motion, u_ins * response, seed, made_by)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python tools/experimental_series.py FOLDER")
    folder = Path(sys.argv[1])
    for name, made in records(yaml_file.load((folder / SETTINGS).read_text(encoding="utf-8"))):
        write_record(folder / f"{name}.csv", made)
