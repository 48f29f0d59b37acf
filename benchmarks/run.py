"""Measure speed and memory on a quiet machine and write README.md beside this file: `make
benchmark`.

Loops are timed in turn in one process, by its processor time, the best of seven.
The pipeline runs in a folder of its own.
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

import opensees_wall
from c_loop import FLAGS, c_peaks, compile_scheme
from jax_loop import jax_peaks
from walls import MODELS, STEPS, Walls

ROOT = Path(__file__).resolve().parents[1]
COUNT = 4096  # walls of a kernel's row
SAME = 1e-9  # largest difference between the peaks of two loops [u/u_ins]
PAGE = """# How fast it is

{claim}

{table}

Kernel rows: processor time of one step of one wall, peaks alone, {count} random walls under one
record, one thread, best of seven. C has the same scheme, compiled by gcc with `{flags}`; JAX has it
as `lax.scan`. All three loops return the same peaks to {same:g}. A call of BAND first solves for
the strength of each wall. OpenSeesPy runs one wall at a time; rockdamp's number is its share of
{count}. Pipeline rows: a rebuild in an environment that is set up, on {cores} cores. Memory: the
largest process.

Not compared: free decay, where rockdamp stops a wall once its peak is sure; full histories; and
other machines.

{machine}

`make benchmark` writes this page.
"""


def best_times(functions: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the best processor time of each of several functions, called in turn [s]."""
    best = dict.fromkeys(functions, float("inf"))
    for _ in range(8):  # the first warms up
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


def usage(*command: str) -> tuple[float, float, float]:
    """Run a command; return its seconds, its processor time [s] and the memory of its largest
    process [MiB].
    """
    code = (
        "import resource, subprocess, sys, time; start = time.perf_counter();"
        "subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL);"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN);"
        "print(time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, *command], cwd=ROOT, capture_output=True, text=True, check=True
    )
    seconds, processor, memory = map(float, run.stdout.split())
    return seconds, processor, memory


def program_rows() -> list[list[str]]:
    """Return the rows of the pipeline, the command line and memory."""
    rows = []
    snakemake = f"{sys.executable} -m snakemake --cores 2 --forceall --config results=build/benchmarks -- ".split()
    for target in ("paper", "all"):
        seconds, processor, memory = usage(*snakemake, target)
        rows.append(
            [
                f"`snakemake {target}`, rebuilt [s]",
                f"{seconds:.0f} ({processor:.0f} of processor time, {memory:.0f} MiB)",
            ]
        )
    _, processor, _ = usage(
        sys.executable,
        "-m",
        "rockdamp",
        *"equivalent --restitution 0.85 --a1 0.04 --b1 0.85".split(),
    )
    rows.append(["`rockdamp equivalent`, processor time [s]", f"{processor:.1f}"])
    code = (
        "import sys; sys.path.insert(0, 'benchmarks'); "
        "from walls import Walls; Walls.draw('BAND', 1_000_000).peaks()"
    )
    seconds, processor, memory = usage(sys.executable, "-c", code)
    rows.append(
        [
            f"peaks of a million BAND walls, {STEPS} steps, one thread [s]",
            f"{processor:.0f} ({memory:.0f} MiB)",
        ]
    )
    return [[*row, "", "", ""] for row in rows]


def machine() -> str:
    """Describe the machine and the versions."""
    names = ("numpy", "numba", "scipy", "snakemake", "openseespy", "jax")
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        processor = next(
            line.partition(":")[2].strip() for line in lines if line.startswith("model name")
        )
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    return f"Machine: {processor}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}."


def main() -> None:
    """Measure and write."""
    times = kernel_times()
    columns = ["", "rockdamp", "C", "JAX", "OpenSeesPy"]
    rows = [
        [f"{model}, a step [ns]", *(f"{times[model][name] * 1e9:.2f}" for name in columns[1:4]), ""]
        for model in MODELS
    ]
    opensees = opensees_wall.rows(times["CDC"]["rockdamp"])
    c, jax = (
        [times[model]["rockdamp"] / times[model][peer] for model in MODELS] for peer in ("C", "JAX")
    )
    claim = (
        f"rockdamp's step takes {min(c):.2f} to {max(c):.2f} times that of C,"
        f" and {min(jax):.2f} to {max(jax):.2f} times that of JAX."
    )
    lines = [columns, ["---"] + ["---:"] * 4, *rows, *opensees, *program_rows()]
    page = PAGE.format(
        claim=claim,
        table="\n".join(f"| {' | '.join(line)} |" for line in lines),
        count=f"{COUNT:,}",
        flags=" ".join(FLAGS),
        same=SAME,
        cores=2,
        machine=machine(),
    )
    Path(__file__).with_name("README.md").write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
