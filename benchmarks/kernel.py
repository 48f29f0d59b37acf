"""The kernel: cost of a step of one history, beside other loops and other programs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter, process_time
from typing import Any

import numpy as np
from jax_loop import NO_JAX, jax_peaks
from measure import Section, Table, crossing, interleaved, number, second_process
from peers import (
    NO_OPENSEES,
    NORMALISATION,
    ORDER_16,
    SOURCE,
    CLoop,
    compile_c,
    opensees,
    opensees_history,
    opensees_run,
    scalar_peaks,
    scipy_history,
)

from rockdamp import Damping, TrilinearCurve
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Histories, Load, Peaks, available_threads, peaks, simulate

MODELS = ("CR", "CDC", "CDR", "SDR", "ECD", ORDER_16, "BAND")
LANES = (1, 2, 4, 8, 64, 512, 4096)
FEW = (1, 2, 4, 8)  # of which a call's own cost is told from that of its steps
MOST = LANES[-1]
STEPS = 4000
STEP = 0.005  # in tau
SUBSTEPS = 4
SEED = 2017
SAME = 1e-9  # of the peaks, u/u_ins
WANTED = 1e-4  # error at equal accuracy, u/u_ins

# The wall at equal accuracy.
ONE = TrilinearCurve(0.06, 0.75, 0.95)
XI, RELEASE = 0.03, 0.6
SAMPLE, SAMPLES = 0.05, 400  # of the record, in tau


@dataclass(frozen=True)
class Batch:
    """Walls that differ, free after a release or under a record from rest."""

    model: str
    curve: TrilinearCurve
    parameter: np.ndarray
    release: np.ndarray
    load_factor: np.ndarray
    ground: np.ndarray
    steps: int
    step: float | np.ndarray = STEP
    substeps: int = SUBSTEPS

    @property
    def lanes(self) -> int:
        """Number of walls."""
        return self.parameter.size

    @cached_property
    def damping(self) -> Damping:
        """Their damper."""
        if self.model == ORDER_16:
            return Damping("ECD", self.parameter, order=16)
        return Damping(self.model, self.parameter)

    def run(self, threads: int = 1) -> Histories:
        """Run them by rockdamp, storing the first and the last state."""
        return simulate(self.curve, self.damping, threads=threads, store_every=self.steps, **self._start)

    def peaks(self) -> Peaks:
        """Run them by rockdamp for peaks alone."""
        return peaks(self.curve, self.damping, threads=1, **self._start)

    @property
    def _start(self) -> dict[str, Any]:
        if not self.ground.size:
            return {"release_amplitude": self.release, "step": self.step, "steps": self.steps}
        return {"load": Load(self.ground, self.load_factor, self.step * self.substeps, self.substeps)}


def batch(model: str, forced: bool, lanes: int, steps: int) -> Batch:
    """Draw walls."""
    rng = np.random.default_rng(SEED)
    curve = TrilinearCurve(rng.uniform(0.03, 0.12, lanes), rng.uniform(0.65, 0.85, lanes))
    parameter = rng.uniform(0.75, 0.95, lanes) if model == "CR" else rng.uniform(0.02, 0.08, lanes)
    share = rng.uniform(0.1, 0.9, lanes)
    none = np.zeros(lanes)
    ground = motion(steps // SUBSTEPS + 1, STEP * SUBSTEPS) if forced else np.empty(0)
    return Batch(model, curve, parameter, none if forced else share, share if forced else none, ground, steps)


def motion(samples: int, sample: float) -> np.ndarray:
    """A record: sines from half to four times p, with seeded phases, that grow from nothing and die away."""
    rng, t = np.random.default_rng(SEED), sample * np.arange(samples)
    w = np.geomspace(0.5, 4.0, 24)
    phase = rng.uniform(0, 2 * np.pi, w.size)
    return np.sin(np.pi * t / t[-1]) ** 2 * (np.sin(np.outer(t, w) + phase)).sum(axis=1) * 0.25


def section(quick: bool) -> Section:
    """Measure."""
    found = Section("Kernel")
    library = compile_c()
    if library is None:
        found.notes.append("No C compiler is here: the comparison with C is left out.")
    if NO_OPENSEES:
        found.notes.append(NO_OPENSEES + ".")
    _peaks_alone(found, quick)
    speeds = _loops(found, library, quick)
    _accuracy(found, speeds, quick)
    return found


# --- peaks alone ------------------------------------------------------------------------------------------------------

LONG_STEP = 0.05  # in tau: too long for a lane to leave, see solvers.kernel.FINE


def _peaks_alone(found: Section, quick: bool) -> None:
    """Compare the march of peaks alone with the same in C and in JAX, and the full march with the full C loop."""
    steps, repetitions, lanes = (400, 2, 512) if quick else (STEPS, 7, MOST)
    columns = {"peaks": "rockdamp", "jax": "JAX", "c": "C", "full": "rockdamp, full", "c full": "C, full"}
    table = Table(
        f"Peaks alone of {lanes} histories: nanoseconds of processor time per step and history, one thread, best of"
        f" {repetitions} interleaved repetitions of {steps} steps. Full: with collapse time, peak time and crossings."
        " rockdamp ends a history once its peak is sure, in free decay soon after the first half cycle; in the rows"
        f" 'free, all steps' the step, {LONG_STEP:g} in tau, is too long for that, and every loop takes every step.",
        ["damper", "load", *columns.values(), "rockdamp / JAX", "rockdamp / C", "full / C, full"],
    )
    libraries = {"c": compile_c(SOURCE, "-DPEAKS_ALONE"), "c full": compile_c()}
    if NO_JAX:
        found.notes.append(NO_JAX + ".")
    worst: dict[tuple[str, str], float] = {}
    for model in MODELS:
        for load in ("free", "free, all steps", "record"):
            walls = batch(model, load == "record", lanes, steps)
            walls = replace(walls, step=LONG_STEP) if load == "free, all steps" else walls
            functions: dict[str, Any] = {"peaks": walls.peaks, "full": walls.run}
            functions |= {name: CLoop(library, walls).run for name, library in libraries.items() if library}
            if not NO_JAX:
                functions["jax"] = jax_peaks(walls, NORMALISATION)
                ended = walls.peaks()
                apart = np.abs(functions["jax"]() - ended.peak)[~ended.collapsed].max()
                assert apart < SAME, f"{model}, {load}: JAX's peaks differ by {apart:g}"
            timed = interleaved(functions, repetitions, clock=process_time)
            ns = {name: timed[name].best * 1e9 / steps / lanes if name in timed else np.nan for name in columns}
            ratios = {"JAX": ns["peaks"] / ns["jax"], "C": ns["peaks"] / ns["c"], "C, full": ns["full"] / ns["c full"]}
            for peer, ratio in ratios.items() if load in ("free", "record") else ():
                worst[model, peer] = np.fmax(worst.get((model, peer), np.nan), ratio)
            cells = [*ns.values(), *ratios.values()]
            table.rows.append([model, load, *("-" if np.isnan(cell) else f"{cell:.2f}" for cell in cells)])
            print("  " + "  ".join(table.rows[-1]), flush=True)
    found.tables.append(table)
    limits = {"JAX": ("Peaks alone", 0.8), "C": ("Peaks alone", 1.15), "C, full": ("Full march", 1.25)}
    for (model, peer), ratio in worst.items():
        if not np.isnan(ratio):
            what, limit = limits[peer]
            named = f"{what}: time over {peer}, {model}, {lanes} histories, worse of free and record"
            found.target(named, float(ratio), limit, " times")


# --- loops ------------------------------------------------------------------------------------------------------------


def _loops(found: Section, library, quick: bool) -> dict[tuple[str, bool, int], float]:
    """Fill the table of loops; return the best ns per step and lane on one core."""
    steps, repetitions = (400, 2) if quick else (STEPS, 7)
    table = Table(
        f"Nanoseconds per step and history: the best (and the median) of interleaved repetitions of {steps} steps. C"
        " and the plain numba loop run on one thread, the numba loop one history after the other.",
        [
            "damper",
            "load",
            "histories",
            "rockdamp, 1 thread",
            "rockdamp, 2 threads",
            "C",
            "plain numba",
            "rockdamp / C",
            "numba / rockdamp",
            "1 / 2 threads",
        ],
    )
    worst: dict[str, list[float]] = {}
    plain: dict[int, list[float]] = {}
    speeds, c_second, c_scalar, apart = {}, [], [], []
    for model in MODELS:
        for forced in (False, True):
            for lanes in LANES:
                walls = batch(model, forced, lanes, steps)
                functions = {"one": walls.run}
                if available_threads() > 1 and lanes > 64:
                    functions["two"] = lambda walls=walls: walls.run(2)
                some = min(lanes, 64)
                functions["scalar"] = lambda walls=walls, some=some: scalar_peaks(walls, some)
                if library is not None:
                    loop = CLoop(library, walls)
                    functions["c"] = loop.run
                    if lanes == MOST and "two" in functions:
                        functions["c two"] = lambda loop=loop: loop.run(2)
                    _check_same(walls, loop)
                else:
                    _check_same(walls, None)
                timed = interleaved(functions, repetitions)
                per = {name: 1e9 / steps / (some if name == "scalar" else lanes) for name in functions}
                cell = {
                    name: f"{time.best * per[name]:.2f} ({time.median * per[name]:.2f})" for name, time in timed.items()
                }
                ns = {name: time.best * per[name] for name, time in timed.items()}
                speeds[model, forced, lanes] = ns["one"]
                ratios = {
                    "c": ns["one"] / ns.get("c", np.nan),
                    "scalar": ns["scalar"] / ns["one"],
                    "two": ns["one"] / ns.get("two", np.nan),
                }
                plain.setdefault(lanes, []).append(ratios["scalar"])
                if lanes == MOST and "two" in functions:
                    apart.append(second_process(walls.run, repetitions))
                if lanes == MOST:
                    for name, value in ratios.items():
                        worst.setdefault(f"{model} {name}", []).append(value)
                    if "c" in ns:
                        c_scalar.append(ns["scalar"] / ns["c"])
                    if "c two" in ns:
                        c_second.append(ns["c"] / ns["c two"])
                table.rows.append(
                    [
                        model,
                        "record" if forced else "free",
                        str(lanes),
                        *(cell.get(name, "-") for name in ("one", "two", "c", "scalar")),
                        *("-" if np.isnan(ratios[name]) else f"{ratios[name]:.2f}" for name in ("c", "scalar", "two")),
                    ]
                )
                print("  " + "  ".join(table.rows[-1]), flush=True)
    found.tables.append(table)
    _few(found, repetitions)
    faster = min(lanes for lanes in LANES if _faster_from(lanes, plain))
    few = f"From {faster} histories of {steps} steps on rockdamp is faster than the plain loop with every damper."
    several = min(min(ratios) for lanes, ratios in plain.items() if lanes > 1)
    for what, speed, least in (("one history", min(plain[1]), 0.9), ("several histories", several, 1)):
        named = f"Speed over the plain numba loop's, {what}, worst of all dampers"
        found.target(named, speed, least, " times", least=True, reason=few)
    if c_scalar:
        found.notes.append(
            f"The C loop, compiled for this processor, is {min(c_scalar):.2f} to {max(c_scalar):.2f} times as fast as"
            f" the plain numba loop ({MOST} histories). That rockdamp be 8 times as fast as the plain loop with every"
            " damper was a target here and is none any more."
        )
    if available_threads() > 1:
        second = [value for model in MODELS for value in worst[f"{model} two"]]
        found.target(
            f"Second core, {MOST} histories, median of all dampers",
            float(np.median(second)),
            1.8,
            " times",
            least=True,
            reason=f"Two processes that share nothing, each with the same histories on one thread, are in the median"
            f" {np.median(apart):.2f} times as fast together as one alone ({min(apart):.2f} to {max(apart):.2f}).",
        )
        if c_second:
            found.notes.append(
                f"At {MOST} histories the second core gives the C loop {min(c_second):.2f} to {max(c_second):.2f} times"
                " the speed."
            )
    found.series["damping_force"] = [row[:7] for row in table.rows]
    return speeds


def _faster_from(lanes: int, plain: dict[int, list[float]]) -> bool:
    """Whether so many histories, and any larger number, are faster than by the plain loop."""
    return all(min(ratios) >= 1 for many, ratios in plain.items() if many >= lanes)


def _few(found: Section, repetitions: int) -> None:
    """Tell what a call of few histories costs by itself from what its steps cost."""
    table = Table(
        f"Few histories, in processor time: a call of {SUBSTEPS} steps, and what each step more takes for all histories"
        f" together, up to {STEPS}.",
        ["damper", "load", "histories", "call [us]", "plain [us]", "step [ns]", "plain [ns]", "plain / rockdamp, step"],
    )
    calls = ("ours", "plain")
    for model in MODELS:
        for forced in (False, True):
            for lanes in FEW:
                long, short = (batch(model, forced, lanes, count) for count in (STEPS, SUBSTEPS))
                functions = {
                    "ours": long.run,
                    "plain": lambda long=long: scalar_peaks(long, long.lanes),
                    "ours, call": short.run,
                    "plain, call": lambda short=short: scalar_peaks(short, short.lanes),
                }
                timed = {
                    name: time.best for name, time in interleaved(functions, repetitions, clock=process_time).items()
                }
                step = {name: (timed[name] - timed[f"{name}, call"]) / (STEPS - SUBSTEPS) for name in calls}
                row = [model, "record" if forced else "free", str(lanes)]
                row += [f"{timed[f'{name}, call'] * 1e6:.0f}" for name in calls]
                row += [f"{step[name] * 1e9:.1f}" for name in calls]
                table.rows.append([*row, f"{step['plain'] / step['ours']:.2f}"])
    found.tables.append(table)


def _check_same(walls: Batch, loop: CLoop | None) -> None:
    """The loops must give the same: peaks and, of C, where the walls are at the end, crossings and collapses."""
    ours = walls.run()
    stands = ~ours.collapsed
    some = min(walls.lanes, 64)
    scalar = scalar_peaks(walls, some)
    assert np.abs(scalar - ours.peak[:some])[stands[:some]].max() < SAME, walls.model
    if loop is not None:
        loop.run()
        assert np.array_equal(loop.row("alive") == 1, stands), walls.model
        assert np.abs(loop.row("peak") - ours.peak)[stands].max() < SAME, walls.model
        assert np.abs(loop.row("x") - ours.displacement[:, -1])[stands].max() < SAME, walls.model
        assert np.array_equal(loop.row("crossings")[stands], ours.impacts[stands]), walls.model


# --- other programs ---------------------------------------------------------------------------------------------------


def _accuracy(found: Section, speeds: dict[tuple[str, bool, int], float], quick: bool) -> None:
    """Compare with OpenSeesPy and SciPy on one CDC wall: per step, and to reach the same error."""
    table = Table(
        f"Cost of one CDC wall over tau = {SAMPLE * SAMPLES:g}, with an error of u/u_ins of at most {WANTED:g} at"
        f" {SAMPLES} samples, against rockdamp.solvers.exact. rockdamp's step is that of one of {MOST} histories"
        " on one core; the others run one history at a time.",
        [
            "load",
            "solver",
            "us per step",
            "steps",
            "us per history",
            "times rockdamp's step",
            "times rockdamp's history",
        ],
    )
    for forced in (False, True):
        _one_wall(found, table, forced, speeds, 2 if quick else 5)
    found.tables.append(table)


def _one_wall(
    found: Section, table: Table, forced: bool, speeds: dict[tuple[str, bool, int], float], repetitions: int
) -> None:
    samples = SAMPLES
    load = 0.8 * motion(samples + 1, SAMPLE) if forced else np.empty(0)
    release, end, name = (0.0 if forced else RELEASE), SAMPLE * samples, "record" if forced else "free"
    times = SAMPLE * np.arange(samples + 1)
    truth = exact_history(
        ONE, Damping("CDC", XI), times, release_amplitude=release, load=load, sampling=SAMPLE if forced else None
    )
    assert not truth.collapsed
    ns = speeds["CDC", forced, MOST]

    def ours(substeps: int) -> np.ndarray:
        free = {"release_amplitude": release, "step": SAMPLE / substeps, "steps": samples * substeps}
        run = {"load": Load(load, 1.0, SAMPLE, substeps)} if forced else free
        return simulate(ONE, Damping("CDC", XI), store_every=substeps, **run).displacement

    def error(history: np.ndarray) -> float:
        return float(np.abs(history - truth.displacement).max())

    substeps = 2 ** np.arange(10)
    steps = crossing(substeps, [error(ours(int(n))) for n in substeps], WANTED) * samples
    cost = steps * ns * 1e-9
    table.rows.append([name, "rockdamp", number(ns * 1e-3), number(steps), number(cost * 1e6), "1", "1"])
    if not NO_OPENSEES:

        def theirs(n: int) -> np.ndarray:
            opensees(ONE, XI, release, load, SAMPLE)
            return opensees_history(samples, n, SAMPLE)

        peer_steps = crossing(substeps, [error(theirs(int(n))) for n in substeps], WANTED) * samples
        per_step = _opensees_step(release, load, samples, repetitions)
        peer_cost = peer_steps * per_step
        table.rows.append(
            [
                name,
                "OpenSeesPy",
                number(per_step * 1e6),
                number(peer_steps),
                number(peer_cost * 1e6),
                number(per_step * 1e9 / ns),
                number(peer_cost / cost),
            ]
        )
        found.target(
            f"Faster than OpenSeesPy per step, CDC, {name}, one core", per_step * 1e9 / ns, 800, " times", least=True
        )
        found.target(
            f"Faster than OpenSeesPy at equal accuracy, CDC, {name}, one core",
            peer_cost / cost,
            1000,
            " times",
            least=True,
        )
    rtol = 10.0 ** -np.arange(1, 12)
    runs = {str(value): lambda value=value: scipy_history(ONE, XI, release, end, value, load, SAMPLE) for value in rtol}
    seconds = [one.best for one in interleaved(runs, 2, 0.0).values()]
    errors = [error(scipy_history(ONE, XI, release, end, value, load, SAMPLE, times).y[0]) for value in rtol]
    scipy_cost = crossing(seconds, errors, WANTED)
    table.rows.append([name, "SciPy DOP853", "-", "-", number(scipy_cost * 1e6), "-", number(scipy_cost / cost)])


def _opensees_step(release: float, load: np.ndarray, samples: int, repetitions: int) -> float:
    """Seconds of one step, in one call for all of them and without output."""
    substeps, found = 8, []
    for _ in range(repetitions + 1):
        opensees(ONE, XI, release, load, SAMPLE)
        start = perf_counter()
        opensees_run(samples * substeps, SAMPLE / substeps)
        found.append((perf_counter() - start) / (samples * substeps))
    return min(found)
