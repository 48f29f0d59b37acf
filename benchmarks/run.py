"""Measure speed and memory on a quiet machine, and write README.md beside this file.

`make benchmark` runs it. Loops are timed in turn in one process, by its processor time. The
pipeline runs in a folder of its own.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import opensees_wall
from c_loop import FLAGS, c_peaks, compile_scheme
from jax_loop import jax_peaks
from walls import MODELS, STEPS, Walls

ROOT = Path(__file__).resolve().parents[1]
COUNT = 4096  # walls of a kernel's row
ROUNDS = 7  # of calls of each loop, of which the best counts
CORES = os.cpu_count() or 1
SAME = 1e-9  # largest difference between the peaks of two loops [u/u_ins]
PAGE = """# How fast it is

{claim}

{table}

Kernel rows: processor time of one step of one wall, peaks alone, {count} random walls under one
record, one thread, best of {rounds}. C has the same scheme, compiled by gcc with `{flags}`; JAX has
it as `lax.scan`. All three loops return the same peaks to {same:g}. A call of BAND first solves for
the strength of each wall. OpenSeesPy runs one wall at a time; rockdamp's number is its share of
{count}. Pipeline rows: a rebuild in an environment that is set up, on {cores} cores. Memory: the
largest process.

Not compared: free decay, where rockdamp stops a wall once its peak is sure, and full histories.

{machine}

`make benchmark` writes this page.
"""


def best_times(functions: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the best processor time of each of several functions, called in turn [s]."""
    for function in functions.values():  # compiles, and fills the caches
        function()
    best = dict.fromkeys(functions, float("inf"))
    for _ in range(ROUNDS):
        for name, function in functions.items():
            start = time.process_time()
            function()
            best[name] = min(best[name], time.process_time() - start)
    return best


def kernel_times() -> dict[str, dict[str, float]]:
    """Return the seconds of a step of one wall, by damper and loop."""
    library = compile_scheme()
    times = {}
    for model in MODELS:
        walls = Walls.draw(model, COUNT)
        loops = {"C": c_peaks(library, walls), "JAX": jax_peaks(walls)}
        result = walls.peaks()
        for name, run in loops.items():
            difference = abs(run() - result.peak)[~result.collapsed].max()
            assert difference < SAME, f"{model}: the peaks of {name} differ by {difference:g}"
        best = best_times({"rockdamp": walls.peaks, **loops})
        times[model] = {name: seconds / STEPS / COUNT for name, seconds in best.items()}
        print(model, times[model], flush=True)
    return times


# A process of its own runs a command, as the children of this one count together.
MEASURE = """
import resource, subprocess, sys, time

start = time.perf_counter()
subprocess.run(sys.argv[1:], check=True, capture_output=True)
seconds = time.perf_counter() - start
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
"""


class Usage(NamedTuple):
    """Duration and processor time of a command [s], and memory of its largest process [MiB]."""

    seconds: float
    processor: float
    memory: float


def measure(*arguments: str) -> Usage:
    """Run Python with some arguments, and return its usage."""
    command = [sys.executable, "-c", MEASURE, sys.executable, *arguments]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return Usage(*map(float, run.stdout.split()))


def program_rows() -> list[list[str]]:
    """Return the rows of the pipeline, the command line and memory."""
    rows = []
    build = ["-m", "snakemake", "--cores", str(CORES), "--forceall"]
    build += ["--config", "results=build/benchmarks", "--"]
    for target in ("paper", "all"):
        used = measure(*build, target)
        rows.append(
            [
                f"`snakemake {target}`, rebuilt [s]",
                f"{used.seconds:.0f} ({used.processor:.0f} of processor time,"
                f" {used.memory:.0f} MiB)",
            ]
        )
    equivalent = ["equivalent", "--restitution", "0.85", "--a1", "0.04", "--b1", "0.85"]
    used = measure("-m", "rockdamp", *equivalent)
    rows.append(["`rockdamp equivalent`, processor time [s]", f"{used.processor:.1f}"])
    code = (
        "import sys; sys.path.insert(0, 'benchmarks'); "
        "from walls import Walls; Walls.draw('BAND', 1_000_000).peaks()"
    )
    used = measure("-c", code)
    rows.append(
        [
            f"peaks of a million BAND walls, {STEPS} steps, one thread [s]",
            f"{used.processor:.0f} ({used.memory:.0f} MiB)",
        ]
    )
    return [[*row, "", "", ""] for row in rows]


def machine() -> str:
    """Describe the machine and the versions."""
    names = ("numpy", "numba", "scipy", "snakemake", "openseespy", "jax")
    processor_info = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    processor = processor_info.partition("model name")[2].partition(":")[2].splitlines()[0].strip()
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    python = platform.python_version()
    return f"Machine: {processor}, {CORES} cores, Python {python}, {versions}."


def main() -> None:
    """Measure and write."""
    times = kernel_times()
    columns = ["", "rockdamp", "C", "JAX", "OpenSeesPy"]
    rows = []
    for model in MODELS:
        nanoseconds = [f"{1e9 * times[model][name]:.2f}" for name in columns[1:4]]
        rows.append([f"{model}, a step [ns]", *nanoseconds, ""])
    opensees = opensees_wall.rows(times["CDC"]["rockdamp"])
    ranges = {}
    for peer in ("C", "JAX"):
        ratios = [times[model]["rockdamp"] / times[model][peer] for model in MODELS]
        ranges[peer] = f"{min(ratios):.2f} to {max(ratios):.2f}"
    claim = (
        f"A step of rockdamp takes {ranges['C']} times as long as in C, and {ranges['JAX']} times as"
        " long as in JAX."
    )
    lines = [columns, ["---"] + ["---:"] * 4, *rows, *opensees, *program_rows()]
    page = PAGE.format(
        claim=claim,
        table="\n".join(f"| {' | '.join(line)} |" for line in lines),
        count=f"{COUNT:,}",
        flags=" ".join(FLAGS),
        same=SAME,
        rounds=ROUNDS,
        cores=CORES,
        machine=machine(),
    )
    Path(__file__).with_name("README.md").write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
