"""Curves, dampers and loads for the event-driven solver."""

import numpy as np

from rockdamp.constants import MODELS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping

CURVES = (
    TrilinearCurve(0.04, 0.85),
    TrilinearCurve(0.02, 0.6),
    TrilinearCurve.preset("severe"),
    TrilinearCurve(0.06, 0.72, 0.8, "translated"),
    TrilinearCurve(0.1, 0.8, 0.85, "steeper"),
)
KNOWN = (
    Damping("CR", 0.85),
    Damping("CDC", 0.05),
    Damping("CDR", 0.06),
    Damping("SDR", 0.07),
    Damping("ECD", 0.05),
    Damping("BAND", 0.05),
    Damping("CQD", 0.05),
)
DAMPERS = (*KNOWN, *(Damping(model, 0.05) for model in MODELS if model not in {one.model for one in KNOWN}))
NAMES = [damper.model for damper in DAMPERS]


def smooth_load(seed: int, samples: int, size: float = 0.08) -> np.ndarray:
    """Return noise that a Hann window of 21 samples has smoothed."""
    noise = np.random.default_rng(seed).normal(size=samples + 20)
    return size * np.convolve(noise, np.hanning(21), "valid")[:samples]


def cr_peaks(curve, restitution, release_amplitude, count):
    """First `count` peaks |x_n| of a free CR decay after a release from rest: V(x_n) = e^(2n) V(x0)."""
    return curve.amplitude(restitution ** (2 * np.arange(1, count + 1)) * curve.energy(release_amplitude))
