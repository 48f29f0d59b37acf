"""Compile every loop before jobs start that need them; no result depends on this module."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import process_time

DAMPERS = [
    ("CR", 0.0),
    ("CDC", 0.0),
    ("CDR", 0.0),
    ("SDR", 0.0),
    ("ECD", 0.0),
    ("BAND", 0.0),
    ("ECD", 8.0),
]
RUNS = [
    ("exact", "CR", 0.0),
    *((march, *damper) for march in ("peaks", "full") for damper in DAMPERS),
]


def compile_all(processes: int = 1) -> None:
    """Compile what most stages run, into Numba's cache; what one stage alone runs is compiled there.

    Numba compiles one function at a time in a process: from the first loop on that is not in the cache, further
    processes help.
    """
    for count, one in enumerate(RUNS, 1):
        start = process_time()
        run(*one)
        if (
            processes > 1 and process_time() - start > 0.5
        ):  # to read a loop from the cache and run it takes less [s]
            with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
                list(pool.map(run, *zip(*RUNS[count:], strict=True)))
            break


def run(march: str, model: str, order: float) -> None:
    """Take one step of one damper."""
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.solvers.exact import exact_history
    from rockdamp.solvers.newmark import peaks, simulate

    curve, damping = TrilinearCurve(0.04, 0.85), Damping(model, 0.5, order=order)
    if march == "exact":
        exact_history(curve, damping, [0.01], release_amplitude=0.5)
    else:
        (peaks if march == "peaks" else simulate)(
            curve, damping, release_amplitude=0.5, step=0.01, steps=1
        )
