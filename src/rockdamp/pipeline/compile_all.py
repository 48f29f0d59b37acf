"""Compile every loop before jobs start that need them; no result depends on this module."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rockdamp.mechanics.damping import Damping
    from rockdamp.solvers.response import Options

LOADED = 0.5  # s of processor time, in which a compiled loop is read from the cache and run; compiling takes longer


def compile_all(processes: int = 1) -> None:
    """Compile every loop that the pipeline runs, into Numba's cache, so that later processes find it there.

    A short run of each damper, with all that the solver keeps and of peaks alone, of ECD of a doubled order, and of the
    exact solver. The scheme as printed, other orders, a loss that falls
    with the amplitude and walls of an uneven force, of one stage alone, are compiled by who asks for them. Numba
    compiles one function at a time in a process: from the first loop on that is not in the cache, further processes
    help.
    """
    from concurrent.futures import ProcessPoolExecutor
    from functools import partial
    from multiprocessing import get_context
    from time import process_time

    import rockdamp.solvers.exact  # noqa: F401 - before the clock runs
    from rockdamp.mechanics.damping import Damping
    from rockdamp.vocabulary import MODELS

    models = [Damping(model, 0.5) for model in MODELS]
    dampers = [*models, Damping("ECD", 0.05, order=8)]
    runs = [partial(_run_exactly)]  # the first tells whether anything is to be compiled
    runs += [partial(_run, damping, peaks_only=True) for damping in dampers]
    runs += [partial(_run, damping) for damping in dampers]
    for count, run in enumerate(runs, 1):
        start = process_time()
        run()
        if processes > 1 and process_time() - start > LOADED:
            with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
                for done in [pool.submit(run) for run in runs[count:]]:
                    done.result()
            break


def _run(damping: Damping, *, peaks_only: bool = False) -> None:
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.solvers.newmark import solve

    run: Options = {"release_amplitude": 0.5, "step": 0.01, "steps": 1}
    if peaks_only:
        solve(TrilinearCurve(0.04, 0.85), damping, peaks_only=True, **run)
    else:
        solve(TrilinearCurve(0.04, 0.85), damping, **run)


def _run_exactly() -> None:
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.damping import Damping
    from rockdamp.solvers.exact import exact_history

    exact_history(TrilinearCurve(0.04, 0.85), Damping("CR", 0.9), [0.01], release_amplitude=0.5)
