"""Write into docs/measured.md how honest the standard errors of `calibrate` are.

``.venv/bin/python tools/calibration_coverage.py`` takes about an hour. Tests like that of Fig. 8 are simulated by each
damper, with the noise and the drift of its instruments, at levels from just beyond the first rocking to near collapse,
and fitted with the same damper. z is the error of an estimate over its standard error.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from doc_tables import table
from experimental_style import RESTITUTION, STRENGTH_RATIO, WALL, YIELD_DISPLACEMENT_RATIO, synthetic_record

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.laboratory.calibration import NORMAL, calibrate
from rockdamp.progress import track

PAGE = Path(__file__).resolve().parents[1] / "docs/measured.md"
BLOCK = re.compile(r"(?<=<!-- tools/calibration_coverage.py -->\n).*?(?=<!-- end -->)", re.DOTALL)
MODELS, TESTS, SEED = ("CR", "CDC", "BAND"), 100, 57
LEVELS = 1.25, 1.40  # peak of the pulse, of g
TRUTH = np.array([YIELD_DISPLACEMENT_RATIO, STRENGTH_RATIO, RESTITUTION])
HEAD = ("damper", "tests", "refused", "sd of z: a1", "b1", "e", "mean of z of e", "e within its 90 % interval")


def errors(model: str) -> list[np.ndarray]:
    """Return z of a1, b1 and e of each simulated test that is not refused."""
    found, level = [], np.random.RandomState(SEED).uniform(*LEVELS, TESTS)
    for number in track(range(TESTS), model):
        peak = level[number] * STANDARD_GRAVITY
        record = synthetic_record(SEED * TESTS + number, damping_model=model, pulse_peak=peak)
        try:
            fitted = calibrate(record, WALL, damping_model=model)
        except InputError as error:
            print(f"{model}, {level[number]:.3f} g: {error}", flush=True)
            continue
        found.append((fitted["estimate"].values - TRUTH) / fitted["standard_error"].values)
    return found


def row(model: str, z: np.ndarray) -> tuple[str, ...]:
    """Return a row of the table; a standard deviation has the standard error 1/sqrt(2 (n - 1)) of it."""
    spread = z.std(axis=0, ddof=1)
    own = spread / np.sqrt(2 * (len(z) - 1))
    spreads = [f"{one:.2f} ± {error:.2f}" for one, error in zip(spread, own, strict=True)]
    inside = f"{100 * np.mean(np.abs(z[:, 2]) < NORMAL):.0f} %"
    mean = f"{z[:, 2].mean():.2f} ± {spread[2] / np.sqrt(len(z)):.2f}"
    return model, f"{TESTS}", f"{TESTS - len(z)}", *spreads, mean, inside


if __name__ == "__main__":
    text = table(HEAD, [row(model, np.array(errors(model))) for model in MODELS])
    print(text)
    PAGE.write_text(BLOCK.sub(text + "\n", PAGE.read_text(encoding="utf-8")), encoding="utf-8")
