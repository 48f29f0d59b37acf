"""How time and memory grow with walls and steps."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
from kernel import batch
from measure import Section, Table, interleaved, number, slope

from rockdamp.solvers.newmark import available_threads

ROOT = Path(__file__).resolve().parents[1]
GROWS = 1.02  # of the peak memory: less is noise

# Not ru_maxrss: a child starts with its parent's.
PEAK = """
status = dict(line.split(":", 1) for line in open("/proc/self/status", encoding="utf-8"))
print(status["VmHWM"].split()[0])
"""

CHILD = """
import sys
import numpy as np
from rockdamp import Damping, TrilinearCurve
from rockdamp.solvers.newmark import Load, simulate
lanes, steps, samples, every = map(int, sys.argv[1:])
ground = 0.1 * np.sin(0.05 * np.arange(samples))
substeps = max(1, steps // max(samples - 1, 1))
run = {"step": 0.0025, "release_amplitude": 0.5}
if samples:
    run = {"load": Load(ground, 1.0, 0.0025 * substeps, substeps)}
damping = Damping("CDR", np.full(lanes, 0.05))
simulate(TrilinearCurve(0.04, 0.85), damping, steps=steps, store_every=every or steps, **run)
"""


def memory(quick: bool) -> Section:
    """Peak memory of new processes against lanes and steps."""
    found = Section("Memory")
    table = Table(
        "Largest resident memory, in MiB, of a new process that calls rockdamp.simulate once.",
        ["histories", "steps", "samples of the record", "histories stored", "peak [MiB]"],
    )
    most = 1000 if quick else 100_000
    runs = [(64, 0, 1000), (4096, 0, 1000), (65536, 0, 100), *(() if quick else ((1_000_000, 0, 100),))]
    for lanes, samples, steps in [(64, 0, 1), *runs]:
        _row(table, lanes, steps, samples, 0)
    # Few walls and many steps: the time stays short, and a history would show at once.
    few = {steps: _row(table, 64, steps, 0, 0) for steps in (most // 100, most // 10, most)}
    record = {steps: _row(table, 64, steps, 101, 0) for steps in (most // 10, most)}
    _row(table, 64, most, 0, 1)
    found.tables.append(table)
    sizes = list(few.values())
    found.target(
        f"Memory of {most} steps over that of {most // 100}, no history asked for",
        sizes[-1] / sizes[0],
        GROWS,
        " times",
    )
    found.target(
        f"Memory of {most} steps over that of {most // 10}, under a record of 101 samples",
        record[most] / record[most // 10],
        GROWS,
        " times",
    )
    return found


def _row(table: Table, lanes: int, steps: int, samples: int, every: int) -> float:
    size = _child(CHILD, *map(str, (lanes, steps, samples, every)))
    table.rows.append([f"{lanes:,}", f"{steps:,}", str(samples or "-"), "yes" if every else "no", number(size)])
    return size


def _child(code: str, *arguments: str) -> float:
    command = [sys.executable, "-c", code + PEAK, *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return int(done.stdout.split()[-1]) / 1024


# --- growth -----------------------------------------------------------------------------------------------------------


def growth(quick: bool) -> Section:
    """Time against walls and steps."""
    found = Section("Growth")
    threads = available_threads()
    walls = 10 ** np.arange(1, 5 if quick else 7)
    steps = 10 ** np.arange(2, 5 if quick else 6)
    lines = {
        "walls": (walls, [_run(int(count), 400, True, threads) for count in walls], 1000),
        "steps": (steps, [_run(512, int(count), False, threads) for count in steps], 1000),
    }
    shown = {
        "walls": "walls, CDR, 400 steps of one record",
        "steps": "steps, CDR, 512 walls, free",
    }
    table = Table(
        f"Seconds on {threads} thread(s), the best of the repetitions, and the slope of the line in logarithms: over"
        " all runs, and over the long ones, in which the start of a call does not count (from 1000 walls or steps on).",
        ["against", "from", "s", "to", "s", "slope", "slope of the long runs"],
    )
    for name, (x, seconds, least) in lines.items():
        long = np.asarray(x) >= least
        slopes = slope(x, seconds), slope(np.asarray(x)[long], np.asarray(seconds)[long])
        table.rows.append(
            [
                shown[name],
                f"{x[0]:,}",
                number(seconds[0]),
                f"{x[-1]:,}",
                number(seconds[-1]),
                f"{slopes[0]:.2f}",
                f"{slopes[1]:.2f}",
            ]
        )
        found.target(f"Growth with {name}: slope of the long runs", slopes[1], 1.1)
    found.tables.append(table)
    return found


def _run(walls: int, steps: int, forced: bool, threads: int) -> float:
    lanes = batch("CDR", forced, walls, steps)
    return interleaved({"run": lambda: lanes.run(threads)}, 3, 0.005)["run"].best
