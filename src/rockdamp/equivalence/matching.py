"""The protocol behind every damping ratio of least Err that is published: one, whatever asks for it.

The global minimum of Err, Eq. (17), is found against decays at the solver's step. What is published is the minimum next
to it of the integral that Err tends to, followed to finer steps in the reference and in the model. The uncertainty is
twice the largest difference from what the coarser of the last three steps give, and from what the inner half of the
damping ratios tried gives at each of them. It is never less than the resolution of the minimiser.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import Scan
from rockdamp.equivalence.minima import RESOLUTION, SCAN, Cases, error_at, global_minima, integral_minima
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers import newmark
from rockdamp.solvers.newmark import available_threads

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)

REFINEMENT = 8  # steps of the last minimisation in place of each of the solver's
COARSER = (2.0, 1.6, 1.0)  # steps of the last three minimisations, over the finest; not multiples, lest ripples agree
# Around the ratio of least squares: a coarse grid that holds the minimum, then a fine one between its neighbours.
WIDEST, COARSE, FINE = 1.8, 41, 101


@dataclass(frozen=True)
class Matched:
    """Damping ratios of least Err; every array has the shape (cases,)."""

    damping_ratio: Array  # xi of the least integral of (|u_CR| - |u|)^2 [-]
    uncertainty: Array  # bound of its error [-]
    error: Array  # Err, Eq. (17), over the `steps` at xi [-]
    local_minima: NDArray[np.int64]  # of Err over the damping ratios tried
    step: float  # the finest one, at which xi is the minimum, in tau
    steps: int  # k, over which Err sums

    @property
    def rms_error(self) -> Array:
        """sqrt(Err/k), in u/u_ins. [-]"""
        return np.sqrt(self.error / self.steps)


def solve(
    cases: Cases,
    damping_models: Sequence[str],
    steps: int,
    *,
    scan: Scan = SCAN,
    refinement: int = REFINEMENT,
    scheme: str = "newmark",
    description: str = "",
) -> dict[str, Matched]:
    """Match viscous models to decays under restitution over `steps` of the solver; returned by model, in their order.

    Cases that are equal are matched once. The last minimisation takes `refinement` steps in place of each of the
    solver's. Without a `description` no progress is shown. It raises `InputError` where a minimum lies at the edge of
    the scan, or the response ends before the first impact.
    """
    first, which = cases.unlike()
    unlike = cases.take(first)
    finer = [unlike.refined(steps, refinement / factor, scheme) for factor in COARSER]
    finest, last = finer[-1], steps * refinement

    def of_model(model: str) -> Matched:
        best = global_minima(unlike, model, [steps], scan, scheme)
        ratio = integral_minima(unlike, model, steps, best.damping_ratio[0], scheme)[0]
        minima = []
        for each in finer:
            minima.append(integral_minima(each, model, each.steps, ratio, scheme))
            ratio = minima[-1][0]
        uncertainty = np.maximum(2 * np.abs(np.concatenate(minima) - ratio).max(axis=0), RESOLUTION * ratio)
        error = error_at(finest, model, last, ratio, scheme)
        return Matched(ratio[which], uncertainty[which], error[which], best.local_minima[0][which], finest.step, last)

    return of_each(of_model, damping_models, description)


def of_each(function: Callable[[K], T], items: Sequence[K], description: str = "") -> dict[K, T]:
    """Call a function for each item, side by side: the few lanes of one alone fill no processor."""
    with ThreadPoolExecutor(available_threads()) as pool:
        # Each in a copy of the context: the caller says what becomes of floating-point errors.
        running = [pool.submit(copy_context().run, function, item) for item in items]
        done = track(running, description) if description else running
        return {item: run.result() for item, run in zip(items, done, strict=True)}


def least_absolute(cases: Cases, damping_model: str, least_squares: Array, steps: int, scheme: str) -> Array:
    """Return the damping ratio that minimises the sum of ``||u_CR| - |u_DAF||`` over a response, for each case.

    It is looked for within a factor `WIDEST` of the ratio of least squares; the fine grid is spaced by 0.06 %.
    """
    found = np.empty_like(least_squares)
    for case, middle in enumerate(least_squares.tolist()):
        ratios = middle * np.geomspace(1 / WIDEST, WIDEST, COARSE)
        best = ratios[_sums(cases, case, damping_model, ratios, steps, scheme).argmin()]
        spacing = ratios[1] / ratios[0]
        ratios = best * np.geomspace(1 / spacing, spacing, FINE)
        found[case] = ratios[_sums(cases, case, damping_model, ratios, steps, scheme).argmin()]
    return found


def _sums(cases: Cases, case: int, damping_model: str, ratios: Array, steps: int, scheme: str) -> Array:
    """Return the sum of the absolute differences for each of some damping ratios. [-]"""
    history = newmark.solve(
        cases.curve_of(case),
        Damping(damping_model, ratios),
        step=cases.step,
        steps=steps,
        release_amplitude=float(cases.release_amplitude[case]),
        scheme=scheme,
        store_every=1,
    )
    apart = np.abs(np.abs(history.displacement) - np.abs(cases.displacement[case, : steps + 1]))
    total: Array = apart.sum(axis=-1)
    return total
