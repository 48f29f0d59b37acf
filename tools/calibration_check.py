"""Check the standard errors of `calibrate` on simulated tests of known curve and e.

``.venv/bin/python tools/calibration_check.py coverage`` writes the table of docs/measured.md, in
about half an hour. It simulates tests like that of Fig. 8 under each damper by the event-driven
solver, with the noise and the drift of its instruments, from the first rocking to near collapse.
Each test is fitted with the damper that made it, by a descent from the true values: the search of
`calibrate` ends within 0.15 standard errors of this fit.

``.venv/bin/python tools/calibration_check.py examples`` writes the free-rocking tests of the
examples.
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
MODELS = ("CR", "CDC", "BAND")
TESTS = 400  # for each damper: a standard deviation is known to 1 / sqrt(2 TESTS), 4 %

# --- shaking-table tests --------------------------------------------------------------------------


def coverage_row(model: str, first_seed: int) -> list[str]:
    """Return a row of the table; z is the error of an estimate over its standard error."""
    truth = np.array([YIELD_DISPLACEMENT_RATIO, STRENGTH_RATIO, RESTITUTION])
    start = np.array([YIELD_DISPLACEMENT_RATIO / (1 - STRENGTH_RATIO), STRENGTH_RATIO, RESTITUTION])
    random = np.random.RandomState(first_seed)
    pulse_peaks = STANDARD_GRAVITY * random.uniform(1.25, 1.40, TESTS)
    z = np.empty((TESTS, truth.size))
    for number, pulse_peak in enumerate(track(pulse_peaks, model)):
        seed = first_seed + number
        record = synthetic_record(seed, damping_model=model, pulse_peak=float(pulse_peak))
        fit = RecordFit(record, WALL, model)
        solution = fit.descend(start)
        standard_errors = np.sqrt(np.diag(estimate_covariance(solution)))
        z[number] = (solution.parameters - truth) / standard_errors
    deviations = z.std(axis=0, ddof=1)
    deviation_error = 1 / np.sqrt(2 * (TESTS - 1))  # relative to the deviation
    cells = [f"{value:.2f} ± {value * deviation_error:.2f}" for value in deviations]
    z_restitution = z[:, 2]
    mean_error = deviations[2] / np.sqrt(TESTS)
    share_inside = np.mean(np.abs(z_restitution) < NORMAL_QUANTILE)
    mean = f"{z_restitution.mean():.2f} ± {mean_error:.2f}"
    return [model, f"{TESTS}", *cells, mean, f"{100 * share_inside:.0f} %"]


def write_coverage() -> None:
    """Write the table of docs/measured.md; the noise differs from damper to damper."""
    head = ["damper", "tests", "sd of z, a1", "sd of z, b1", "sd of z, e"]
    head += ["mean of z, e", "e within its 90 % interval"]
    rows = [coverage_row(model, 1000 * number) for number, model in enumerate(MODELS, 1)]
    page = ROOT / "docs/measured.md"
    opening = "<!-- tools/calibration_check.py coverage -->\n"
    block = re.compile(rf"(?<={opening}).*?(?=<!-- end -->)", re.DOTALL)
    text = block.sub(table(head, rows) + "\n", page.read_text(encoding="utf-8"))
    page.write_text(text, encoding="utf-8")


# --- free-rocking tests ---------------------------------------------------------------------------


def simulate_free_rocking(
    wall: Wall,
    curve: TrilinearCurve,
    restitution: float,
    scatter: float,
    release: float,
    elapsed: np.ndarray,
    smallest_amplitude: float,
    random: np.random.RandomState,
) -> np.ndarray:
    """Return the displacement after a release, by the event-driven solver [m].

    ln e has the standard deviation `scatter` from impact to impact. The motion ends at an impact:
    the last before the end of `elapsed` [s], or the first after which the amplitude is at most
    `smallest_amplitude` [m]. `release` is the displacement at the release over u_ins.
    """
    u_ins = float(wall.instability_displacement)
    tau = float(wall.frequency_parameter) * elapsed
    displacement = release
    velocity = 0.0
    energy = float(curve.energy(release))
    start = 0.0
    end = float(curve.period(release)) / 4
    parts = []
    while end <= tau[-1]:
        times = tau[(tau >= start) & (tau < end)] - start
        state = {"release_amplitude": displacement, "release_velocity": velocity}
        motion = exact_history(curve, Damping("CR", 1.0), times, **state)
        parts.append(motion.displacement)
        log_restitution = np.log(restitution) + scatter * random.standard_normal()
        energy *= np.exp(2 * min(log_restitution, 0.0))
        direction = -np.sign(velocity or displacement)
        displacement = 0.0
        velocity = direction * np.sqrt(2 * energy)
        # The amplitude that this velocity has on the first branch.
        if u_ins * abs(velocity) / float(curve.initial_frequency) <= smallest_amplitude:
            break
        start = end
        end += float(curve.period(curve.amplitude(energy))) / 2
    return u_ins * np.concatenate(parts)


def measure(
    displacement: np.ndarray,
    step: float,
    held_seconds: float,
    noise: float,
    drift: float,
    random: np.random.RandomState,
) -> np.ndarray:
    """Return a sensor's measurement of a release and of the rests beside it [m].

    The wall is held for `held_seconds` before the release and at rest for 1 s after the motion. The
    sensor has a wrong zero, a linear drift [m/s], a random walk, white noise, and steps of 0.01 mm.
    """
    before = np.full(int(held_seconds / step), displacement[0])
    after = np.zeros(int(1.0 / step))
    true = np.concatenate([before, displacement, after])
    walk = 0.1 * noise * np.cumsum(random.standard_normal(true.size)) * np.sqrt(step)
    zero = 10 * noise * random.standard_normal()
    linear_drift = drift * step * np.arange(true.size)
    white_noise = noise * random.standard_normal(true.size)
    return np.round(true + zero + linear_drift + walk + white_noise, 5)


def make_examples() -> dict[str, str]:
    """Return the text of each example by the name of its file.

    A wall without overburden is released twice.
    """
    wall = Wall(0.25, 3.0, hinge_ratio=0.6)
    curve = TrilinearCurve(0.05, 0.82)
    restitution = 0.875
    step = 0.002
    elapsed = step * np.arange(int(8.0 / step) + 1)
    texts = {}
    for number, (release, held_seconds) in enumerate([(0.5, 0.8), (0.25, 0.5)], 1):
        random = np.random.RandomState(2026 + number)
        displacement = simulate_free_rocking(
            wall, curve, restitution, 0.015, release, elapsed, 2e-4, random
        )
        measured = measure(displacement, step, held_seconds, 2e-4, 1.5e-4, random)
        specimen = "wall 0.25 m thick and 3 m high, hinge at 0.6 of its height"
        origin = "computed by tools/calibration_check.py from impact to impact"
        lines = [
            f"# specimen: {specimen}, release {number}, computed",
            f"# source: {origin}, then noise and drift",
            "# licence: CC0-1.0",
            "# synthetic: yes",
            "# units: s, m",
            f"# generator_yield_displacement_ratio: {curve.yield_displacement_ratio:g}",
            f"# generator_strength_ratio: {curve.strength_ratio:g}",
            f"# generator_restitution: {restitution:g}",
            "elapsed_s,displacement_m",
        ]
        lines += [f"{step * index:.3f},{u:.5f}" for index, u in enumerate(measured)]
        texts[f"my-free-rocking-{number}.csv"] = "\n".join(lines) + "\n"
    return texts


if __name__ == "__main__":
    if sys.argv[1:] == ["coverage"]:
        write_coverage()
    elif sys.argv[1:] == ["examples"]:
        for name, text in make_examples().items():
            (ROOT / "examples" / name).write_text(text, encoding="utf-8")
    else:
        sys.exit("usage: python tools/calibration_check.py coverage|examples")
