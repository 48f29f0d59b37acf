"""Compile the loops that most stages run before their jobs start; no result depends on this."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import process_time

# Model and order. ECD of order 8 has the loop of all orders that are powers of 2.
COMPILED_DAMPERS = [
    ("CR", 0.0),
    ("CDC", 0.0),
    ("CDR", 0.0),
    ("SDR", 0.0),
    ("ECD", 0.0),
    ("BAND", 0.0),
    ("ECD", 8.0),
]
COMPILED_RUNS = [
    ("exact_history", "CR", 0.0),
    *(("peaks", model, order) for model, order in COMPILED_DAMPERS),
    *(("simulate", model, order) for model, order in COMPILED_DAMPERS),
]


def compile_all(processes: int = 1) -> None:
    """Compile the loops of most stages into Numba's cache; others are compiled in their stage.

    Numba compiles one function at a time in a process. From the first loop on that is not in the
    cache, further processes help.

    Parameters
    ----------
    processes : int
        Processes that compile side by side.
    """
    for count, arguments in enumerate(COMPILED_RUNS, 1):
        start = process_time()
        run(*arguments)
        is_compiled = process_time() - start > 0.5  # reading a loop and running it takes less [s]
        if processes > 1 and is_compiled:
            remaining = COMPILED_RUNS[count:]
            with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
                list(pool.map(run, *zip(*remaining, strict=True)))
            break


def run(solver: str, model: str, order: float) -> None:
    """Take one step with one damper.

    Parameters
    ----------
    solver : {"exact_history", "peaks", "simulate"}
        Public function to call.
    model, order : str and float
        Damping model, and the order of ECD.
    """
    import rockdamp as rd  # here, as Numba is slow to import

    curve = rd.TrilinearCurve(0.04, 0.85)
    damping = rd.Damping(model, 0.5, order=order)
    if solver == "exact_history":
        rd.exact_history(curve, damping, [0.01], release_amplitude=0.5)
    else:
        solve = getattr(rd, solver)
        solve(curve, damping, release_amplitude=0.5, step=0.01, steps=1)
