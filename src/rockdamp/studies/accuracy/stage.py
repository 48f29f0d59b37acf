"""Accuracy: errors of the solver and of the damping ratios, where small rotations matter, and the energy audit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import itemgetter

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.progress import track
from rockdamp.solvers import event_driven
from rockdamp.studies.accuracy import energy_audit, matched_ratios
from rockdamp.studies.accuracy.energy_audit import Audited
from rockdamp.studies.accuracy.ensemble import EXCITATIONS, Ensemble, collect, fitted_order, halved
from rockdamp.studies.accuracy.small_rotations import rotations
from rockdamp.studies.damping_force import matched_histories
from rockdamp.vocabulary import MODELS, STUDIES


def accuracy(
    config: Config, loops: xr.Dataset, matches: Sequence[xr.Dataset], decays: Sequence[xr.Dataset]
) -> xr.Dataset:
    """Measure how accurate the published numbers are.

    `matches` and `decays` are those of each study, in the order of `STUDIES`.
    """
    step, scheme, sizes = config.solver.step, config.solver.scheme, config.accuracy
    matched, decaying = (dict(zip(STUDIES, of_each, strict=True)) for of_each in (matches, decays))
    studies = {name: config.study(name) for name in STUDIES}
    ensemble = collect(
        studies,
        matched,
        restitutions=sizes.restitutions,
        seed=sizes.seed,
        length=config.matching.response_length,
        step=step,
        steps=halved(step, sizes.doublings, sizes.halvings),
        scheme=scheme,
    )
    audited = audited_walls(config, loops)
    parts = [
        solver_errors(ensemble, step, refinement=config.matching.refinement),
        matched_ratios.uncertainty(matched),
        matched_ratios.minima(studies, matched, count=sizes.minima, bracket=sizes.bracket, seed=sizes.seed),
        rotations(
            loops,
            config.damping_force.rigid.wall,
            restitution=config.damping_force.rigid.restitution,
            slenderness=sizes.rigid.slenderness,
            hinge_ratio=sizes.rigid.hinge_ratio,
            release_amplitude=sizes.rigid.release_amplitude,
            peaks=sizes.rigid.peaks,
        ),
        energy_audit.residuals(ensemble, step),
        energy_audit.stored(audited["reference"], decaying, studies, step),
        energy_audit.losses(audited, config.release_amplitude, step),
    ]
    return xr.merge(parts, compat="no_conflicts", join="exact")


def audited_walls(config: Config, loops: xr.Dataset) -> dict[str, Audited]:
    """Return the reference wall with its histories in `damping_force.nc`, and that of Fig. 8 with such histories."""
    histories = matched_histories(
        config.validation.curve,
        config.validation.restitution,
        config.release_amplitude,
        config.matching,
        length=config.damping_force.response_length,
        step=config.solver.step,
        scheme=config.solver.scheme,
    )
    return {
        "reference": Audited(config.wall, config.curve, config.damping_force.restitution, loops),
        "Fig. 8": Audited(config.validation.wall, config.validation.curve, config.validation.restitution, histories),
    }


def solver_errors(ensemble: Ensemble, step: float, refinement: int) -> xr.Dataset:
    """Compare the pipeline's solver with the event-driven one, free and forced, against the step.

    The error of a history is the root mean square of u/u_ins less the exact one, over the times of the coarsest step.
    The ensemble's steps include the pipeline's; the published damping ratios have `refinement` steps in place of each.
    """
    steps, own = ensemble.steps, int(np.argmin(np.abs(ensemble.steps - step)))
    error = np.empty((len(EXCITATIONS), len(MODELS), *ensemble.factor.shape, steps.size))
    largest = np.empty(error.shape[:2])
    peak = np.zeros((len(EXCITATIONS), *ensemble.factor.shape))
    cells = [(x, m) for x in range(len(EXCITATIONS)) for m in range(len(MODELS))]
    lanes = ensemble.factor.size
    references = iter(track(_exact(ensemble, cells), "exact histories", len(cells) * lanes))
    for x, m in cells:
        expected = np.stack([next(references) for _ in range(lanes)]).reshape(*ensemble.factor.shape, -1)
        peak[x] = np.maximum(peak[x], np.abs(expected).max(axis=-1))
        for k in range(steps.size):
            displacement, _ = ensemble.histories(MODELS[m], EXCITATIONS[x], float(steps[k]), 2**k)
            error[x, m, ..., k] = np.sqrt(np.mean((displacement - expected) ** 2, axis=-1))
            if k == own:
                largest[x, m] = np.abs(displacement - expected).max()
    dims = ("excitation", "damping_model")
    median = np.median(error, axis=(2, 3))
    return xr.Dataset(
        {
            "solver_error": ((*dims, "case", "restitution", "step"), error),
            "median_solver_error": ((*dims, "step"), median),
            "largest_solver_error": ((*dims, "step"), error.max(axis=(2, 3))),
            "convergence_order": (dims, fitted_order(steps, median)),
            "largest_history_error": (dims, largest),
            "largest_displacement": (("excitation", "case", "restitution"), peak),
        },
        coords={
            "excitation": list(EXCITATIONS),
            "damping_model": list(MODELS),
            "restitution": ensemble.restitution,
            "step": steps,
            "solver_step": step,
            "published_step": step / refinement,
            "release_amplitude": ("case", ensemble.release_amplitude[:, 0]),
            "yield_displacement_ratio": ("case", ensemble.curve.yield_displacement_ratio[:, 0]),
            "strength_ratio": ("case", ensemble.curve.strength_ratio[:, 0]),
        },
    )


def _exact(ensemble: Ensemble, cells: list[tuple[int, int]]) -> Iterator[Array]:
    """Yield the exact displacement of each lane of each cell, at the multiples of the coarsest step."""
    spacing = float(ensemble.steps[0])
    times = spacing * np.arange(round((ensemble.load.shape[-1] - 1) * ensemble.sample / spacing) + 1)
    for x, m in cells:
        forced = EXCITATIONS[x] == "forced"
        damping = ensemble.damping(MODELS[m]).map(lambda parameter: np.broadcast_to(parameter, ensemble.factor.shape))
        for case, e in np.ndindex(*ensemble.factor.shape):
            yield event_driven.history(
                ensemble.curve.map(itemgetter((case, 0))),
                damping.map(itemgetter((case, e))),
                times,
                release_amplitude=0.0 if forced else float(ensemble.release_amplitude[case, 0]),
                load=ensemble.factor[case, e] * ensemble.load[case] if forced else (),
                load_step=ensemble.sample,
            ).displacement
