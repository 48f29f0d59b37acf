"""Time to answer: the damping ratio that is equivalent to a coefficient of restitution, to a thousandth."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np
from measure import Section, Table, interleaved, number
from peers import NO_OPENSEES, opensees, opensees_history, scipy_history
from scipy.optimize import minimize_scalar

from rockdamp import Damping, TrilinearCurve
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH
from rockdamp.equivalence import matching
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.equivalent import STEP
from rockdamp.equivalence.matching import Cases, global_minima
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import available_threads

RELEASE = 0.5
STEPS = round(DEFAULT_RESPONSE_LENGTH / STEP)
AT_ONCE = 250  # walls whose decays are held at the same time
PRECISE = 1e-3  # of xi
WALLS = 1000
SEED = 2017
SUBSTEPS = (1, 2, 4, 8)  # of STEP, tried in turn until OpenSees is precise enough
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
TIMES = STEP * np.arange(STEPS + 1)


def section(quick: bool) -> Section:
    """Measure."""
    found = Section("Time to answer")
    walls = 20 if quick else WALLS
    rng = np.random.default_rng(SEED)
    a1, b1, e = rng.uniform(0.03, 0.12, walls), rng.uniform(0.65, 0.85, walls), rng.uniform(0.75, 0.95, walls)
    a1[0], b1[0], e[0] = 0.04, 0.85, 0.85
    one = TrilinearCurve(0.04, 0.85)
    truth = exact_history(one, Damping("CR", 0.85), TIMES, release_amplitude=RELEASE).displacement
    best = minimise(one, 0.85, truth, lambda xi: _exact(one, xi))
    ours = {
        (name, many): lambda last=last, many=many: rockdamp(a1[:many], b1[:many], e[:many], last)
        for name, last in (("rockdamp", True), ("rockdamp, the studies' step", False))
        for many in (1, walls)
    }
    timed = interleaved(ours, 1 if quick else 3, 0.0)
    seconds_one, seconds_all = timed["rockdamp", 1].best, timed["rockdamp", walls].best
    table = Table(
        f"xi of CDC for e = 0.85, a1 = 0.04, b1 = 0.85 by Eq. (17) over tau = {DEFAULT_RESPONSE_LENGTH:g}, and for"
        f" {walls} walls that differ in a1, b1 and e, on {available_threads()} thread(s). rockdamp runs its own decay"
        " under restitution, scans 200 damping ratios for all minima, and refines them: in the end at"
        f" 1/{matching.REFINEMENT} of the studies' step, as `rockdamp equivalent` does, or at the studies' step"
        " alone. The others are given the decay and minimise Err once (minimize_scalar, from the closed form), at the"
        f" coarsest step or tolerance that is good to 0.1 %; their time for {walls} walls is {walls} times one wall's.",
        ["solver", "one wall [s]", "off by", f"{walls} walls [s]", "times rockdamp, one", f"times rockdamp, {walls}"],
    )
    for name in dict.fromkeys(name for name, _ in ours):
        deviation = abs(ours[name, 1]()[0] / best - 1)
        one_wall, all_walls = timed[name, 1].best, timed[name, walls].best
        table.rows.append(
            [
                name,
                number(one_wall),
                f"{deviation:.1e}",
                number(all_walls),
                number(one_wall / seconds_one),
                number(all_walls / seconds_all),
            ]
        )
        assert deviation < PRECISE, name
    for name, histories in _peers(one).items():
        seconds, off = _first_precise(one, truth, best, histories, 1 if quick else 3)
        table.rows.append(
            [
                name,
                number(seconds),
                f"{off:.1e}",
                f"{number(seconds * walls)} (extrapolated)",
                number(seconds / seconds_one),
                number(seconds * walls / seconds_all),
            ]
        )
    if NO_OPENSEES:
        found.notes.append(NO_OPENSEES + ".")
    found.tables.append(table)
    return found


def rockdamp(a1: np.ndarray, b1: np.ndarray, e: np.ndarray, last: bool) -> np.ndarray:
    """Damping ratios of CDC, found as `rockdamp.equivalent` finds them, or without its last minimisation."""
    edges = [slice(at, at + AT_ONCE) for at in range(0, a1.size, AT_ONCE)]
    return np.concatenate([_rockdamp(a1[some], b1[some], e[some], last) for some in edges])


def _rockdamp(a1: np.ndarray, b1: np.ndarray, e: np.ndarray, last: bool) -> np.ndarray:
    curve, amplitude = TrilinearCurve(a1, b1).map(lambda p: np.broadcast_to(p, e.shape)), np.full(e.size, RELEASE)
    cases = Cases.release(curve, amplitude, e, step=STEP, steps=STEPS)
    if last:
        return matching.match_dampers(cases, ["CDC"], STEPS)["CDC"].damping_ratio
    return global_minima(cases, "CDC", [STEPS]).damping_ratio[0]


def minimise(
    curve: TrilinearCurve, e: float, truth: np.ndarray, history: Callable[[float], np.ndarray], precise: float = 1e-4
) -> float:
    """Return xi with the least Err near the closed form."""
    guess = damping_ratio_energy(curve, "CDC", e, RELEASE).item()

    def err(xi: float) -> float:
        return float(np.sum((np.abs(truth) - np.abs(history(xi)))[1:] ** 2))

    # The closed form leads into the right basin from some side; a third each way holds it.
    bounds = (guess / 1.5, guess * 1.5)
    return float(minimize_scalar(err, bounds=bounds, method="bounded", options={"xatol": precise * guess}).x)


def _exact(curve: TrilinearCurve, xi: float) -> np.ndarray:
    return exact_history(curve, Damping("CDC", xi), TIMES, release_amplitude=RELEASE).displacement


def _peers(curve: TrilinearCurve) -> dict[str, list[Callable[[float], np.ndarray]]]:
    """Histories over xi of each program, from coarse to fine."""

    def opensees_of(substeps: int) -> Callable[[float], np.ndarray]:
        def history(xi: float) -> np.ndarray:
            opensees(curve, xi, RELEASE)
            return opensees_history(STEPS, substeps, STEP)

        return history

    def scipy_of(rtol: float) -> Callable[[float], np.ndarray]:
        return lambda xi: scipy_history(curve, xi, RELEASE, TIMES[-1], rtol, times=TIMES).y[0]

    found = {} if NO_OPENSEES else {"OpenSeesPy": [opensees_of(substeps) for substeps in SUBSTEPS]}
    return {**found, "SciPy DOP853": [scipy_of(rtol) for rtol in TOLERANCES]}


def _first_precise(
    curve: TrilinearCurve,
    truth: np.ndarray,
    best: float,
    histories: list[Callable[[float], np.ndarray]],
    repetitions: int,
) -> tuple[float, float]:
    """Best seconds of the first minimisation that is precise enough, and by how much its xi is off."""
    for history in histories:
        seconds = []
        for _ in range(repetitions):
            start = perf_counter()
            xi = minimise(curve, 0.85, truth, history, PRECISE / 4)
            seconds.append(perf_counter() - start)
        off = abs(xi / best - 1)
        if off < PRECISE:
            return min(seconds), off
    return float("nan"), off
