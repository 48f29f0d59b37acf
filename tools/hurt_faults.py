"""Faults put into the writer of results, one at each call that can fail; memory, threads and files of a process."""

from __future__ import annotations

import errno
import gc
import os
import secrets
import tempfile
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

import rockdamp as rd
from rockdamp.figures import output
from rockdamp.storage import dataset

Report = Callable[[str, str, str, str, bool], None]
WARM = 50  # calls before what is held is measured
REPEATED = 2000
GROWTH = 20.0  # MB that memory may grow by over so many calls: what allocators keep
TIME = 0.01 * np.arange(200)
CALLS = [(os, name) for name in ("open", "close", "chmod", "fsync", "replace", "lstat")]
CALLS += [(Path, name) for name in ("mkdir", "write_bytes", "write_text", "unlink")]
CALLS += [(secrets, "token_hex"), (xr.Dataset, "to_netcdf"), (pd.DataFrame, "to_csv"), (Figure, "savefig")]
FAULTS: dict[str, Callable[[], BaseException]] = {
    "the disk is full": lambda: OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
    "the disk fails": lambda: OSError(errno.EIO, os.strerror(errno.EIO)),
    "no memory is left": MemoryError,
    "the user interrupts": KeyboardInterrupt,
}


def _dataset(path: Path, number: float) -> None:
    dims = ("scheme", "excitation", "damping_model")
    errors, orders = np.full((1, 1, 1, 500), number), np.full((1, 1, 1), number)
    made = xr.Dataset(
        {
            "solver_error": ((*dims, "step"), errors),
            "order": (dims, orders),
            "finest_convergence_order": (dims, orders),
        },
        {"scheme": ["newmark"], "excitation": ["free"], "damping_model": ["CR"], "step": np.arange(1.0, 501.0)},
    )
    dataset.write(made, path, "convergence", config={}, code_version="0")


def _figure(path: Path, number: float) -> None:
    figure = Figure(figsize=(1, 1))
    figure.subplots().plot([0, number])
    output.save(figure, path.with_suffix(""), ["png"], 50)


def _record(path: Path, number: float) -> None:
    rd.write_record(path, rd.Record(TIME, np.full(TIME.size, number), header={"synthetic": "yes"}))


Writer = Callable[[Path, float], None]
WRITERS: dict[str, Writer] = {"result.nc": _dataset, "result.png": _figure, "result.csv": _record}
REPORTED = (OSError, dataset.DatasetError, rd.InputError, MemoryError, KeyboardInterrupt)


def writer_attacks() -> Iterator[tuple[str, Callable[[Path], str]]]:
    """Yield each writer with each fault at each of its calls, as far as it makes calls."""
    for name, write in WRITERS.items():
        for fault, error in FAULTS.items():
            for owner, call in CALLS:
                at = 1
                while True:
                    hit: list[bool] = []
                    yield f"{name}: {fault} at call {at} of {call}", _run(name, write, error, (owner, call), at, hit)
                    if not hit:
                        break
                    at += 1


def _run(
    name: str, write: Writer, error: Callable[[], BaseException], where: tuple[Any, str], at: int, hit: list[bool]
) -> Callable[[Path], str]:
    def run(folder: Path) -> str:
        path = folder / name
        write(path, 1.0)
        before, raised = path.read_bytes(), False
        try:
            with _failing(*where, at, error, hit):
                write(path, 2.0)
        except REPORTED:
            raised = True
        after = path.read_bytes()
        if after != before:
            write(path, 2.0)
            if after != path.read_bytes():
                return "half a result"
        # A file that cannot be removed stays; nothing reads it.
        stays = [each.name for each in folder.iterdir() if each != path]
        if stays and where[1] != "unlink":
            return f"{stays} left"
        if hit and not raised and after == before:
            return "the fault is hidden, and the old result kept"
        return "refused" if raised else "answer"

    return run


@contextmanager
def _failing(owner: Any, name: str, at: int, error: Callable[[], BaseException], hit: list[bool]) -> Iterator[None]:
    """Let the `at`-th call of a function raise, and note that it did."""
    right, calls = getattr(owner, name), []

    def wrong(*args: Any, **options: Any) -> Any:
        calls.append(None)
        if len(calls) == at:
            hit.append(True)
            raise error()
        return right(*args, **options)

    with mock.patch.object(owner, name, wrong):
        yield


def held() -> dict[str, float]:
    """Return what the process holds: memory in MB, threads, open files."""
    gc.collect()
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    (memory,) = (line.split()[1] for line in status.splitlines() if line.startswith("VmRSS"))
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    return {"memory": int(memory) / 1024, "threads": float(threads), "files": float(files)}


def call_once(folder: Path) -> None:
    """Make a decay on two threads, a response, a record, which is read again, a dataset, and a refusal."""
    curve, damping = rd.TrilinearCurve(0.04, 0.85), rd.Damping("ECD", np.linspace(0.01, 0.1, 80))
    rd.solve(curve, damping, release_amplitude=0.5, step=0.02, steps=50, store_every=5, threads=2)
    record = rd.Record(TIME, np.sin(9 * TIME), header={"synthetic": "yes"})
    rd.respond(rd.Wall(0.3, 4.5), curve, rd.Damping("CDR", 0.05), record)
    rd.write_record(folder / "record.csv", record)
    rd.read_record(folder / "record.csv")
    _dataset(folder / "result.nc", 1.0)
    try:
        rd.Wall(-1.0, 4.5)
    except rd.InputError:
        pass


def writer(report: Report) -> None:
    """Let each call of each writer fail once, by each fault."""
    ended: Counter[str] = Counter()
    for name, run in writer_attacks():
        with tempfile.TemporaryDirectory() as folder:
            found = run(Path(folder))
        ended[found if found in ("answer", "refused") else f"{name}: {found}"] += 1
    others = [what for what in ended if what not in ("answer", "refused")]
    seen = f"{ended['refused']} failures told, {ended['answer']} writes unharmed"
    done = f"{ended.total()} writes, each with a full or failing disk, no memory or an interrupt at one of its calls"
    report("writer", done, "the old result or the new one, whole", "; ".join([seen, *others]), not others)


def resources(report: Report) -> None:
    """Call the package many times over and see what the process holds."""
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(WARM):
            call_once(Path(folder))
        before = held()
        for _ in range(REPEATED):
            call_once(Path(folder))
        after = held()
    grown = {name: after[name] - before[name] for name in before}
    good = grown["memory"] < GROWTH and grown["threads"] == grown["files"] == 0
    seen = f"{grown['memory']:+.1f} MB, {grown['threads']:+.0f} threads, {grown['files']:+.0f} open files"
    report("resources", f"{REPEATED} calls of each function", f"under {GROWTH:g} MB, none more", seen, good)
