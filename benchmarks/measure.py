"""What the sections share: interleaved timing, tables, and targets that are met or not."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

LEAST = 0.02  # s that one measurement lasts, at least


class Timing(NamedTuple):
    """Of one call. [s]"""

    best: float
    median: float


def of_children() -> float:
    """Processor time of the processes that were started and have ended, with all of theirs. [s]"""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def interleaved(
    functions: Mapping[str, Callable[[], Any]],
    repetitions: int,
    least: float = LEAST,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, Timing]:
    """Time functions in turn, so that what else the machine does meets all of them alike."""
    calls = {}
    for name, function in functions.items():
        function()  # warm
        start = clock()
        function()
        calls[name] = max(1, int(np.ceil(least / max(clock() - start, 1e-9))))
    found: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(repetitions):
        for name, function in functions.items():
            start = clock()
            for _ in range(calls[name]):
                function()
            found[name].append((clock() - start) / calls[name])
    return {name: Timing(min(one), float(np.median(one))) for name, one in found.items()}


@dataclass
class Table:
    """A table of text."""

    caption: str
    header: list[str]
    rows: list[list[str]] = field(default_factory=list)

    def markdown(self) -> str:
        """Return the caption and the table."""
        lines = [self.header, ["---"] + ["---:"] * (len(self.header) - 1), *self.rows]
        return f"{self.caption}\n\n" + "\n".join(f"| {' | '.join(line)} |" for line in lines)


@dataclass
class Section:
    """What a part of the suite found."""

    title: str
    tables: list[Table] = field(default_factory=list)
    targets: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    series: dict[str, Any] = field(default_factory=dict)  # for the plots

    def target(
        self, what: str, measured: float, limit: float, unit: str = "", least: bool = False, reason: str = ""
    ) -> None:
        """Judge a number that must be at most `limit`, or at least; the reason is told once where it is not."""
        met = bool(measured >= limit if least else measured <= limit)
        wanted = f"{'at least' if least else 'at most'} {number(limit)}{unit}"
        self.targets.append({"what": what, "target": wanted, "measured": f"{number(measured)}{unit}", "met": met})
        if reason and not met and reason not in self.notes:
            self.notes.append(reason)

    def data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Section:
        """Return the section that `data` made."""
        return cls(**{**data, "tables": [Table(**table) for table in data["tables"]]})


def second_process(run: Callable[[], Any], repetitions: int) -> float:
    """Return how many times as fast two processes together are as one alone, each with the same work."""
    run()  # loads the kernel, before the processes are made
    alone, together = (min(_slowest(run, processes, repetitions)) for processes in (1, 2))
    return 2 * alone / together


def _slowest(run: Callable[[], Any], processes: int, repetitions: int) -> list[float]:
    """Return the seconds of the slowest of some processes that begin at once, for each repetition."""
    context = get_context("fork")
    barrier, spent = context.Barrier(processes), context.SimpleQueue()

    def work() -> None:
        for _ in range(repetitions):
            barrier.wait()
            start = time.perf_counter()
            run()
            spent.put(time.perf_counter() - start)
            barrier.wait()  # all are done before one begins again

    workers = [context.Process(target=work) for _ in range(processes)]
    for worker in workers:
        worker.start()
    seconds = [spent.get() for _ in range(processes * repetitions)]
    for worker in workers:
        worker.join()
    return [max(seconds[i : i + processes]) for i in range(0, len(seconds), processes)]


def number(value: float) -> str:
    """Three digits, without exponents where they read badly."""
    if value == 0 or not np.isfinite(value):
        return f"{value:g}"
    decimals = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return f"{value:,.{min(decimals, 9)}f}" if 1e-4 < abs(value) < 1e7 else f"{value:.2e}"


def crossing(cost: Any, error: Any, wanted: float) -> float:
    """Cost at which the error falls to `wanted`: between the two runs around it, straight in logarithms.

    Runs from coarse to fine. Where the coarsest is good enough already, its cost; where none is, not a number.
    """
    cost = np.maximum.accumulate(np.asarray(cost, dtype=float))
    # From the finest run back: an error that happens to be small in a coarse run does not count.
    error = np.maximum.accumulate(np.asarray(error, dtype=float)[::-1])[::-1]
    if error[-1] > wanted:
        return float("nan")
    return float(np.exp(np.interp(-np.log(wanted), -np.log(error), np.log(cost))))


def slope(x: Any, y: Any) -> float:
    """Slope of the straight line through logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
