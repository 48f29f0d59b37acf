"""Simulate measured tests whose curve and e are known, and check the standard errors of `calibrate` by them.

``.venv/bin/python tools/calibration_check.py coverage`` writes the table of docs/measured.md, in about half an hour.
Tests like that of Fig. 8 are simulated under each damper by the event-driven solver, with the noise and the drift of
its instruments, from the first rocking to near collapse. They are fitted with the same damper, from the
truth on: the search of `calibrate` ends within 0.15 standard errors of this fit.

``.venv/bin/python tools/calibration_check.py examples`` writes the free-rocking tests of the examples.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from doc_tables import table
from experimental_style import (
    RESTITUTION,
    STRENGTH_RATIO,
    WALL,
    YIELD_DISPLACEMENT_RATIO,
    synthetic_record,
)

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.laboratory.calibration import estimate_covariance
from rockdamp.laboratory.record_fit import RecordFit
from rockdamp.laboratory.uncertainty import NORMAL_QUANTILE
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.progress import track
from rockdamp.solvers.exact import exact_history

ROOT = Path(__file__).resolve().parents[1]
MODELS, TESTS = ("CR", "CDC", "BAND"), 400
HEAD = (
    "damper",
    "tests",
    "sd of z, a1",
    "sd of z, b1",
    "sd of z, e",
    "mean of z, e",
    "e within its 90 % interval",
)

# --- shaking-table tests ----------------------------------------------------------------------------------------------


def coverage_row(model: str, first_seed: int) -> tuple[str, ...]:
    """Return a row of the table; z is the error of an estimate over its standard error."""
    truth = np.array([YIELD_DISPLACEMENT_RATIO, STRENGTH_RATIO, RESTITUTION])
    start = np.array([YIELD_DISPLACEMENT_RATIO / (1 - STRENGTH_RATIO), STRENGTH_RATIO, RESTITUTION])
    peaks = STANDARD_GRAVITY * np.random.RandomState(first_seed).uniform(1.25, 1.40, TESTS)
    errors = []
    for number, peak in enumerate(track(peaks, model)):
        record = synthetic_record(first_seed + number, damping_model=model, pulse_peak=float(peak))
        fit = RecordFit(record, WALL, model)
        found = fit.descend(start)
        error = np.sqrt(np.diag(estimate_covariance(fit, found)))
        errors.append((fit.parameters(found.x) - truth) / error)
    z = np.array(errors)
    spread = z.std(axis=0, ddof=1)
    spreads = [f"{one:.2f} ± {one / np.sqrt(2 * (TESTS - 1)):.2f}" for one in spread]
    mean = f"{z[:, 2].mean():.2f} ± {spread[2] / np.sqrt(TESTS):.2f}"
    inside = f"{100 * np.mean(np.abs(z[:, 2]) < NORMAL_QUANTILE):.0f} %"
    return model, f"{TESTS}", *spreads, mean, inside


def write_coverage() -> None:
    """Write the table of docs/measured.md; the tests of each damper have noise of their own."""
    text = table(
        HEAD, [coverage_row(model, 1000 * number) for number, model in enumerate(MODELS, 1)]
    )
    page = ROOT / "docs/measured.md"
    block = re.compile(
        r"(?<=<!-- tools/calibration_check.py coverage -->\n).*?(?=<!-- end -->)", re.DOTALL
    )
    page.write_text(block.sub(text + "\n", page.read_text(encoding="utf-8")), encoding="utf-8")


# --- free-rocking tests -----------------------------------------------------------------------------------------------


def free_rocking(
    wall: Wall,
    curve: TrilinearCurve,
    e: float,
    scatter: float,
    release: float,
    elapsed: np.ndarray,
    least: float,
    random,
) -> np.ndarray:
    """Return the displacement after a release, from impact to impact by the event-driven solver. [m]

    ln e has the standard deviation `scatter` from impact to impact. The motion ends at an impact: the last before the
    end of `elapsed` [s], or the first after which the amplitude is below `least` [m]. `release` is over u_ins.
    """
    u_ins, tau = float(wall.instability_displacement), float(wall.frequency_parameter) * elapsed
    amplitude, velocity, end, energy = (
        release,
        0.0,
        float(curve.period(release)) / 4,
        float(curve.energy(release)),
    )
    parts, start = [], 0.0
    while end <= tau[-1]:
        inside = tau[(tau >= start) & (tau < end)] - start
        free = exact_history(
            curve,
            Damping("CR", 1.0),
            inside,
            release_amplitude=amplitude,
            release_velocity=velocity,
        )
        parts.append(free.displacement)
        energy *= np.exp(2 * min(np.log(e) + scatter * random.standard_normal(), 0.0))
        side = -np.sign(velocity or amplitude)
        amplitude, velocity = 0.0, side * np.sqrt(2 * energy)
        if u_ins * abs(velocity) / float(curve.initial_frequency) <= least:
            break
        start, end = end, end + float(curve.period(curve.amplitude(energy))) / 2
    return u_ins * np.concatenate(parts)


def sensor(moved, step, held, noise, drift, random) -> np.ndarray:
    """Return what a sensor shows of a release that is held before, for `held` seconds, and at rest after, for 1 s. [m]

    Its zero, a linear drift [m/s], a random walk, white noise and the logger's steps of 0.01 mm are added.
    """
    shown = np.concatenate([np.full(int(held / step), moved[0]), moved, np.zeros(int(1.0 / step))])
    walk = 0.1 * noise * np.cumsum(random.standard_normal(shown.size)) * np.sqrt(step)
    zero = 10 * noise * random.standard_normal()
    shown = (
        shown
        + zero
        + drift * step * np.arange(shown.size)
        + walk
        + noise * random.standard_normal(shown.size)
    )
    return np.round(shown, 5)


def examples() -> dict[str, str]:
    """Return the text of each example by the name of its file: a wall without overburden, released twice."""
    texts, wall, step = {}, Wall(0.25, 3.0, hinge_ratio=0.6), 0.002
    true = {"yield_displacement_ratio": 0.05, "strength_ratio": 0.82, "restitution": 0.875}
    curve = TrilinearCurve(true["yield_displacement_ratio"], true["strength_ratio"])
    for number, (release, held) in enumerate([(0.5, 0.8), (0.25, 0.5)], 1):
        random = np.random.RandomState(2026 + number)
        elapsed = step * np.arange(int(8.0 / step) + 1)
        moved = free_rocking(
            wall, curve, true["restitution"], 0.015, release, elapsed, 2e-4, random
        )
        shown = sensor(moved, step, held, 2e-4, 1.5e-4, random)
        lines = [
            f"# specimen: wall 0.25 m thick and 3 m high, hinge at 0.6 of its height, release {number}, computed",
            "# source: computed by tools/calibration_check.py from impact to impact, then noise and drift",
            *("# licence: CC0-1.0", "# synthetic: yes", "# units: s, m"),
            *(f"# generator_{name}: {value:g}" for name, value in true.items()),
            "elapsed_s,displacement_m",
            *(f"{step * index:.3f},{u:.5f}" for index, u in enumerate(shown)),
        ]
        texts[f"my-free-rocking-{number}.csv"] = "\n".join(lines) + "\n"
    return texts


if __name__ == "__main__":
    if sys.argv[1:] == ["coverage"]:
        write_coverage()
    elif sys.argv[1:] == ["examples"]:
        for name, text in examples().items():
            (ROOT / "examples" / name).write_text(text, encoding="utf-8")
    else:
        sys.exit("usage: python tools/calibration_check.py coverage|examples")
