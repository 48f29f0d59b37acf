"""Curves, dampers and loads that tests of both solvers share."""

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
VALUES = {"CR": 0.85, "CDC": 0.05, "CDR": 0.06, "SDR": 0.07, "ECD": 0.05, "BAND": 0.05, "CQD": 0.05}
DAMPERS = {model: Damping(model, VALUES.get(model, 0.05)) for model in (*MODELS, "CQD")}
DAMPERS |= {
    "CR, law": Damping("CR", 0.85, loss_exponent=0.2),
    "ECD16": Damping("ECD", 0.05, order=16),
    "ECD, law": Damping("ECD", 0.05, order=4, loss_exponent=0.2),
}


def smooth_load(seed: int, samples: int, size: float = 0.08) -> np.ndarray:
    """Return noise that a Hann window of 21 samples has smoothed."""
    noise = np.random.default_rng(seed).normal(size=samples + 20)
    return size * np.convolve(noise, np.hanning(21), "valid")[:samples]


def cr_peaks(curve, restitution, release_amplitude, count):
    """Return the first `count` peaks of a CR decay after a release from rest.

    V(x_n) = e^(2n) V(x0).
    """
    losses = restitution ** (2 * np.arange(1, count + 1))
    return curve.amplitude(losses * curve.energy(release_amplitude))


def random_curve(rng, case, smallest=1e-3):
    """Return a curve of either softening, by turns; a1/a2 is at least `smallest`."""
    b1 = rng.uniform(0.2, 0.95)
    if case % 2 == 0:
        softening = "steeper"
        a3 = rng.uniform(1.02 * (1 - b1), 1.0)
        a2 = 1 - b1
    else:
        softening = "translated"
        a3 = rng.uniform(b1 + 0.01, 1.0)
        a2 = a3 - b1
    a1 = a2 * np.exp(rng.uniform(np.log(smallest), np.log(0.95)))
    return TrilinearCurve(a1, b1, a3, softening)
