"""Compile every loop before jobs start that need them; no result depends on this module."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import process_time

LOADED = 0.5  # s of processor time, in which a compiled loop is read from the cache and run; compiling takes longer
RUNS = [("exact", "CR", 0.0), *((march, model, 0.0) for march in ("peaks", "full") for model in ("CR", "CDC", "CDR"))]
RUNS += [(march, model, 0.0) for march in ("peaks", "full") for model in ("SDR", "ECD", "BAND")]
RUNS += [(march, "ECD", order) for march in ("peaks", "full") for order in (8.0, 16.0)]


def compile_all(processes: int = 1) -> None:
    """Compile what most stages run, into Numba's cache; what one stage alone runs is compiled there.

    Numba compiles one function at a time in a process: from the first loop on that is not in the cache, further
    processes help.
    """
    for count, one in enumerate(RUNS, 1):
        start = process_time()
        run(*one)
        if processes > 1 and process_time() - start > LOADED:
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
        (peaks if march == "peaks" else simulate)(curve, damping, release_amplitude=0.5, step=0.01, steps=1)
