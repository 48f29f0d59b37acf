"""Samplers of the posterior, each with the same batched likelihood: one command, run by hand.

    .venv/bin/python -m pip install ultranest dynesty
    .venv/bin/python benchmarks/samplers.py

Writes samplers.md beside this file. Each sampler meets the cube that is stretched about the mode, as `rockdamp` does.
Times are of the processor.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from experimental_style import WALL

from rockdamp.laboratory import sampler
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.problem import Problem
from rockdamp.laboratory.sampler import Draws, Neighbourhood, sample
from rockdamp.motions.records import read_record
from rockdamp.progress import without_bars

DATA = Path(__file__).resolve().parents[1] / "data"
CASES = [
    ("sin-03-00-synthetic", "CR"),
    ("test_series/cr-half", "CR"),
    ("test_series/ecd-half", "CR"),
    ("test_series/ecd16-half", "ECD16"),
]
SEED, EFFECTIVE = 1, 1000.0
DYNESTY = 50  # live points: it asks for one likelihood at a time, and takes long
SLOW = (CASES[0],)  # cases of five parameters that dynesty draws too
GRID, REACH = 41, 6.0  # points of an axis, and how many standard deviations it reaches either way
Density = Callable[[np.ndarray], np.ndarray]


class Counted:
    """A density that counts what it is asked for."""

    def __init__(self, density: Density) -> None:
        self.density, self.points, self.batches = density, 0, 0

    def __call__(self, points: np.ndarray) -> np.ndarray:
        self.points, self.batches = self.points + len(points), self.batches + 1
        return self.density(points)


def by_nautilus(density: Density, about: Neighbourhood) -> Draws:
    return sample(density, about, EFFECTIVE, SEED)


def by_ultranest(density: Density, about: Neighbourhood) -> Draws:
    from ultranest import ReactiveNestedSampler

    logging.getLogger("ultranest").setLevel(logging.ERROR)
    np.random.seed(SEED)  # noqa: NPY002
    names = [f"x{i}" for i in range(about.centre.size)]
    made = ReactiveNestedSampler(names, _stretched(density, about), lambda cube: cube, vectorized=True, ndraw_min=256)
    found = made.run(show_status=False, viz_callback=False, min_num_live_points=200, frac_remain=0.01, min_ess=400)
    weighted = found["weighted_samples"]
    return _draws(about, weighted["points"], np.array(weighted["weights"]), found["logz"])


def by_dynesty(density: Density, about: Neighbourhood) -> Draws:
    """It takes no batches: each likelihood is asked for by itself."""
    import dynesty

    stretched = _stretched(density, about)
    made = dynesty.NestedSampler(
        lambda cube: float(stretched(cube[None])[0]),
        lambda cube: cube,
        about.centre.size,
        nlive=DYNESTY,
        rstate=np.random.default_rng(SEED),
        sample="rwalk",
    )
    made.run_nested(print_progress=False, dlogz=0.1)
    found = made.results
    return _draws(about, found.samples, np.exp(found.logwt - found.logwt.max()), found.logz[-1])


SAMPLERS = {"nautilus": by_nautilus, "ultranest": by_ultranest, "dynesty": by_dynesty}


def _stretched(density: Density, about: Neighbourhood) -> Density:
    def stretched(cube: np.ndarray) -> np.ndarray:
        points, stretch = about.points(cube)
        return np.maximum(density(points) - stretch, sampler.ZERO)

    return stretched


def _draws(about: Neighbourhood, cube: np.ndarray, weights: np.ndarray, log_evidence: float) -> Draws:
    points, stretch = about.points(np.asarray(cube))
    return Draws(points, weights / weights.sum(), stretch, float(log_evidence))


def row(problem: Problem, name: str, density: Density, about: Neighbourhood) -> str:
    """Draw by a sampler and return a row of the table."""
    counted = Counted(density)
    start = time.process_time()
    draws = SAMPLERS[name](counted, about)
    seconds = time.process_time() - start
    return _row(
        f"{name} | {seconds:.1f} | {counted.points} | {counted.batches}",
        problem,
        draws.points,
        draws.weights,
        f"{draws.log_evidence:.2f} ± {draws.error:.2f}",
    )


def _row(start: str, problem: Problem, points: np.ndarray, weights: np.ndarray, evidence: str) -> str:
    whole = np.tile(problem.mode, (len(points), 1))
    whole[:, : points.shape[1]] = points
    values = problem.values(whole)[:, :3]
    mean = weights @ values
    deviation = np.sqrt(weights @ (values - mean) ** 2)
    shown = [f"{a:.5f} ± {b:.5f}" for a, b in zip(mean, deviation, strict=True)]
    return f"| {start} | {' | '.join(shown)} | {evidence} |"


def by_grid(problem: Problem, density: Density, about: Neighbourhood) -> str:
    """Integrate over a grid of three parameters."""
    axis = np.linspace(-REACH, REACH, GRID)
    standard = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    points = about.centre + standard @ about.lower.T
    start = time.process_time()
    log_density = np.concatenate([density(some) for some in np.array_split(points, 128)])
    seconds = time.process_time() - start
    weights = np.exp(log_density - log_density.max())
    cell = (axis[1] - axis[0]) ** 3 * np.abs(np.diag(about.lower)).prod()
    evidence = log_density.max() + np.log(weights.sum() * cell)
    return _row(
        f"grid | {seconds:.1f} | {len(points)} | 128", problem, points, weights / weights.sum(), f"{evidence:.2f}"
    )


HEAD = [
    "| sampler | time [s] | likelihoods | batches | a1 | b1 | e | logarithm of the evidence |",
    "| --- | ---: | ---: | ---: | --- | --- | --- | --- |",
]


def main() -> None:
    """Measure, print and write."""
    lines = [
        "# Samplers of the posterior",
        "",
        "`.venv/bin/python benchmarks/samplers.py` writes this page. Times are of one processor, for the draws alone:"
        " the least squares and the search for the mode come before, and are the same for all."
        f" {EFFECTIVE:g} draws of nautilus are effective, of ultranest 400; dynesty has {DYNESTY} live points.",
    ]
    for name, model in CASES:
        record = read_record(DATA / f"{name}.csv")
        with without_bars():
            fit = RecordFit.from_record(
                record,
                WALL,
                Candidate.from_name(model),
                ultimate_displacement_ratio=1.0,
                softening="steeper",
                step=0.01,
            )
            problem = Problem.from_fit(fit, Prior())
        about = problem._neighbourhood()
        lines += ["", f"## {name} by {model}, five parameters", "", *HEAD]
        lines += [
            row(problem, kind, problem.log_density, about)
            for kind in SAMPLERS
            if kind != "dynesty" or (name, model) in SLOW
        ]
        if (name, model) == CASES[1]:
            lines += ["", "The same with the sensor's noise fixed, three parameters:", "", *HEAD]
            mode = problem.mode

            def three(points: np.ndarray, problem: Problem = problem, mode: np.ndarray = mode) -> np.ndarray:
                return problem.log_density(np.concatenate([points, np.tile(mode[3:], (len(points), 1))], axis=1))

            near = Neighbourhood(about.centre[:3], about.lower[:3, :3])
            lines += [by_grid(problem, three, near), *(row(problem, kind, three, near) for kind in SAMPLERS)]
        print("\n".join(lines[-12:]), flush=True)
        text = "\n".join([*lines, "", *NOTES, ""])
        Path(__file__).with_name("samplers.md").write_text(text, encoding="utf-8")


NOTES = [
    "Before, draws came from a mixture of t distributions that was fitted to the posterior from its modes on, and from"
    " emcee's walkers in lock step. On the shipped record the mixture took 0.6 s for 5120 likelihoods (evidence 9405.95"
    " ± 0.01), the walkers 6.8 s for 62208 likelihoods; on cr-half 0.25 s (4690.93 ± 0.01) and 4.8 s; together 700"
    " lines. Without the stretch about the mode nautilus took 82 s and 40 s there (291328 and 192512 likelihoods), with"
    " the same evidence, 9405.95 and 4690.93.",
    "",
    "Nautilus is taken: the same results, within ten times of the time of the mixture, and it takes batches.",
]


if __name__ == "__main__":
    main()
