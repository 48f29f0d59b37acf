"""Random walls under one random record: what every loop of the benchmark runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rockdamp import Damping, Load, Peaks, TrilinearCurve, peaks

MODELS = ("CR", "CDC", "CDR", "SDR", "ECD", "BAND")
STEPS = 4000
STEP = 0.005  # in tau
SUBSTEPS = 4
SEED = 2017


def record(samples: int, sampling: float) -> np.ndarray:
    """Return sines of 0.5 p to 4 p with seeded phases that grow and die away, shape (samples,)."""
    tau = sampling * np.arange(samples)
    frequencies = np.geomspace(0.5, 4.0, 24)
    phases = np.random.default_rng(SEED).uniform(0, 2 * np.pi, frequencies.size)
    envelope = np.sin(np.pi * tau / tau[-1]) ** 2
    sines = np.sin(np.outer(tau, frequencies) + phases)
    return 0.25 * envelope * sines.sum(axis=1)


@dataclass(frozen=True)
class Walls:
    """Walls of one damper, at rest, under the same record scaled for each."""

    curve: TrilinearCurve
    damping: Damping
    factor: np.ndarray
    ground: np.ndarray

    @classmethod
    def draw(cls, model: str, count: int) -> Walls:
        """Draw walls with e of 0.75 to 0.95 or damping ratios of 0.02 to 0.08."""
        rng = np.random.default_rng(SEED)
        curve = TrilinearCurve(rng.uniform(0.03, 0.12, count), rng.uniform(0.65, 0.85, count))
        limits = (0.75, 0.95) if model == "CR" else (0.02, 0.08)
        damping = Damping(model, rng.uniform(*limits, count))
        factor = rng.uniform(0.1, 0.9, count)
        ground = record(STEPS // SUBSTEPS + 1, STEP * SUBSTEPS)
        return cls(curve, damping, factor, ground)

    def peaks(self, threads: int = 1) -> Peaks:
        """Return their peaks by rockdamp."""
        load = Load(self.ground, self.factor, STEP * SUBSTEPS, SUBSTEPS)
        return peaks(self.curve, self.damping, load=load, threads=threads)
