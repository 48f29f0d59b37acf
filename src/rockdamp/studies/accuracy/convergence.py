"""Order of convergence of both schemes for each damper, measured on ensembles, free and forced.

Beside it the walls of the studies as an ensemble, `Ensemble`: what the stage accuracy is measured on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.study import Study
from rockdamp.equivalence.closed_form import exact_ratio
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COMPLETED, Options
from rockdamp.studies.decays import step_count
from rockdamp.vocabulary import MODELS

EXCITATIONS = ("free", "forced")
LOAD_SAMPLE = 0.2  # in tau, about: a tenth of the load's shortest period
LOAD_FREQUENCIES = (0.3, 3.0)  # over p: the load's band
ROUNDING = 1e-9  # a length that is a whole number of samples but for rounding is one
FACTORS = np.geomspace(0.02, 2.0, 40)  # of the load's peak over F0 that are tried


@dataclass(frozen=True)
class Ensemble:
    """Walls that differ in tau, at a few e, with their published damping ratios and a load."""

    curve: TrilinearCurve  # of shape (cases, 1)
    release_amplitude: Array  # of the free decays, shape (cases, 1) [-]
    restitution: Array  # shape (e,)
    ratio: Mapping[str, Array]  # published damping ratio of each viscous model, shape (cases, e) [-]
    load: Array  # of the forced responses, from rest: of unit peak, linear between samples, shape (cases, samples)
    sample: float  # spacing of the samples, in tau [-]
    length: float  # of all histories, in tau [-]
    factor: Array  # of the load, over F0, shape (cases, e) [-]
    steps: Array  # at which errors are measured, in tau, coarsest first; the solver's own is among them [-]
    scheme: str

    def damping(self, model: str, case: int | slice = slice(None)) -> Damping:
        """Return the damping of the lanes of some cases, shape (cases, e) or a shape that broadcasts to it."""
        return Damping(model, self.ratio[model][case]) if model in self.ratio else Damping.cr(self.restitution)

    def histories(self, model: str, excitation: str, step: float, store_every: int) -> tuple[Array, Array]:
        """Run every lane with the pipeline's solver: displacements and velocities, shape (cases, e, stored). [-]"""
        if excitation == "free":
            free = Options(release_amplitude=self.release_amplitude, **self._steps(step))
            responses = [solve(*self._walls(model, slice(None)), store_every=store_every, **free)]
        else:
            responses = [
                solve(
                    *self._walls(model, slice(case, case + 1)),
                    store_every=store_every,
                    **self._forced(case, step, self.factor[case]),
                )
                for case in range(len(self.load))
            ]
        return (
            np.concatenate([response.displacement for response in responses]),
            np.concatenate([response.velocity for response in responses]),
        )

    def forced_peaks(self, model: str, step: float, factor: Array) -> Array:
        """Return the largest |u|/u_ins under `factor` of the loads, shape (..., cases, e); infinite if it collapsed."""
        responses = [
            solve(*self._walls(model, case), **self._forced(case, step, factor[..., case, :]))
            for case in range(len(self.load))
        ]
        return np.stack(
            [np.where(response.outcome == COMPLETED, response.peak, np.inf) for response in responses], axis=-2
        )

    def _walls(self, model: str, case: int | slice) -> tuple[TrilinearCurve, Damping]:
        return self.curve.map(itemgetter(case)), self.damping(model, case)

    def _steps(self, step: float) -> Options:
        substeps = step_count(self.sample, step)
        return {
            "step": step,
            "substeps": substeps,
            "steps": (self.load.shape[-1] - 1) * substeps,
            "scheme": self.scheme,
        }

    def _forced(self, case: int, step: float, factor: Array) -> Options:
        return {**self._steps(step), "load_factor": factor, "ground_acceleration": self.load[case]}

    def load_at(self, step: float) -> Array:
        """Return the load of the forced responses at each step, shape (cases, e, steps + 1). [-]"""
        samples = np.arange(self.load.shape[-1])
        fine = np.arange((samples.size - 1) * step_count(self.sample, step) + 1) * step / self.sample
        return self.factor[..., None] * np.stack([np.interp(fine, samples, load) for load in self.load])[:, None]


def halved(step: float, doublings: int, halvings: int) -> Array:
    """Return the steps at which errors are measured: `step` doubled, itself and halved, coarsest first."""
    return step * 2**doublings / 2.0 ** np.arange(doublings + halvings + 1)


def collect(
    studies: Mapping[str, Study],
    matches: Mapping[str, xr.Dataset],
    *,
    restitutions: int,
    seed: int,
    length: float,
    step: float,
    steps: Array,
    scheme: str,
) -> Ensemble:
    """Draw the ensemble from the studies: each curve and release once, as slenderness and overburden change neither.

    It takes `restitutions` of the studies' e, evenly over them. The loads' factors are found at the pipeline's `step`.
    """
    rows: dict[tuple[float, ...], Array] = {}
    for name, match in matches.items():
        study, e = studies[name], match["restitution"].values
        chosen = np.unique(np.round(np.linspace(0, e.size - 1, restitutions)).astype(int))
        ratio = match["damping_ratio"].transpose(study.parameter, "damping_model", "restitution")
        for i, x0 in enumerate(study.release_amplitude):
            own = study.curve.map(itemgetter(i))
            key = (
                *map(float, (own.yield_displacement_ratio, own.strength_ratio, own.ultimate_displacement_ratio)),
                float(x0),
            )
            rows.setdefault(key, ratio.values[i][:, chosen])
    a1, b1, a3, x0 = (np.array(column)[:, None] for column in zip(*rows, strict=True))
    models = [str(model) for model in match["damping_model"].values]
    coarsest = float(steps[0])
    sample = coarsest * max(1, round(LOAD_SAMPLE / coarsest))
    drawn = Ensemble(
        TrilinearCurve(a1, b1, a3, study.curve.softening),
        x0,
        e[chosen],
        {model: np.stack([row[m] for row in rows.values()]) for m, model in enumerate(models)},
        band_limited(seed, len(rows), int(length / sample + ROUNDING) + 1, sample),
        sample,
        length,
        np.ones((len(rows), chosen.size)),
        steps,
        scheme,
    )
    return replace(drawn, factor=strong_loads(drawn, step))


def band_limited(seed: int, loads: int, samples: int, sample: float) -> Array:
    """Return seeded sums of twelve sinusoids within `LOAD_FREQUENCIES`, of unit peak, shape (loads, samples). [-]"""
    rng = np.random.default_rng(seed)
    frequency, phase = rng.uniform(*LOAD_FREQUENCIES, (loads, 12, 1)), rng.uniform(0, 2 * np.pi, (loads, 12, 1))
    load = np.sin(frequency * sample * np.arange(samples) + phase).sum(axis=1)
    return load / np.abs(load).max(axis=1, keepdims=True)


def strong_loads(ensemble: Ensemble, step: float) -> Array:
    """Return the largest of `FACTORS` under which no model's peak exceeds the release of the free decay. [-]

    So the forced responses are nearly as large as the free ones, and none collapses.
    """
    trial = FACTORS[:, None, None] * np.ones_like(ensemble.factor)
    peak = np.max([ensemble.forced_peaks(model, step, trial) for model in MODELS], axis=0)
    number = np.arange(FACTORS.size)[:, None, None]
    return FACTORS[np.where(peak <= ensemble.release_amplitude, number, 0).max(axis=0)]


def fitted_order(steps: ArrayLike, error: ArrayLike) -> Array:
    """Return the slope of log(error) against log(step), fitted over the last axis. [-]"""
    logs = np.log(np.asarray(error, dtype=float))
    slope = np.polyfit(np.log(np.asarray(steps, dtype=float)), logs.reshape(-1, logs.shape[-1]).T, 1)[0]
    return np.asarray(slope.reshape(logs.shape[:-1]))


SCHEMES = ("newmark", "paper")


@dataclass(frozen=True)
class SeededWalls:
    """Seeded walls and a shared load. A single history's error is erratic: its corners fall anywhere in a step."""

    curve: TrilinearCurve
    release_amplitude: Array
    restitution: Array
    load_factor: Array
    ground: Array


def draw(seed: int, lanes: int, samples: int, sample: float) -> SeededWalls:
    """Draw walls and a band-limited load sampled every `sample` in tau."""
    rng = np.random.default_rng(seed)
    curve = TrilinearCurve(rng.uniform(0.02, 0.12, lanes), rng.uniform(0.5, 0.85, lanes))
    tau = sample * np.arange(samples)
    frequency, phase = rng.uniform(0.3, 3.0, (2, 12))
    ground = np.sin(frequency[:, None] * tau + 2 * np.pi * phase[:, None]).sum(axis=0)
    return SeededWalls(
        curve,
        rng.uniform(0.2, 0.8, lanes),
        rng.uniform(0.75, 0.95, lanes),
        rng.uniform(0.01, 0.05, lanes),
        ground,
    )


def convergence(config: Config) -> xr.Dataset:
    """Measure the error of the displacement against the step, and its order.

    The error of a history is the root mean square over the times of the coarsest step, against the default scheme at a
    sixteenth of the finest step. That of the ensemble is the median, which a wall near collapse does not govern.
    """
    settings = config.convergence
    coarsest, finest = settings.coarsest, 16 * 2**settings.halvings
    steps = coarsest / 2.0 ** np.arange(settings.halvings + 1)
    ensemble = draw(settings.seed, settings.lanes, step_count(settings.length, coarsest) + 1, coarsest)
    shape = (len(SCHEMES), len(EXCITATIONS), len(MODELS), steps.size)
    error = np.empty(shape)
    cells = [(x, m) for x in range(len(EXCITATIONS)) for m in range(len(MODELS))]
    for x, m in track(cells, "orders"):
        exact = _histories(ensemble, MODELS[m], EXCITATIONS[x], "newmark", coarsest, finest)
        for s, scheme in enumerate(SCHEMES):
            for k in range(steps.size):
                displacement = _histories(ensemble, MODELS[m], EXCITATIONS[x], scheme, coarsest, 2**k)
                of_lane = np.sqrt(np.mean((displacement - exact) ** 2, axis=-1))
                error[s, x, m, k] = np.nanmedian(of_lane)
    dims = ("scheme", "excitation", "damping_model")
    return xr.Dataset(
        {
            "solver_error": ((*dims, "step"), error),
            "convergence_order": (dims, fitted_order(steps, error)),
            "finest_convergence_order": (dims, np.log2(error[..., -2] / error[..., -1])),
        },
        coords={
            "scheme": list(SCHEMES),
            "excitation": list(EXCITATIONS),
            "damping_model": list(MODELS),
            "step": steps,
        },
    )


def _histories(ensemble: SeededWalls, model: str, excitation: str, scheme: str, sample: float, substeps: int) -> Array:
    """Displacements at the samples of the load; NaN in lanes that collapse."""
    damping = Damping.from_values(
        model, restitution=ensemble.restitution, damping_ratio=exact_ratio(ensemble.restitution)
    )
    response = solve(
        ensemble.curve,
        damping,
        release_amplitude=ensemble.release_amplitude,
        load_factor=ensemble.load_factor if excitation == "forced" else 0.0,
        ground_acceleration=ensemble.ground if excitation == "forced" else (),
        step=sample / substeps,
        substeps=substeps,
        steps=(ensemble.ground.size - 1) * substeps,
        store_every=substeps,
        scheme=scheme,
    )
    return np.where((response.outcome == COMPLETED)[:, None], response.displacement, np.nan)
