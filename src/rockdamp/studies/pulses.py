"""Compare every viscous damper with CR under pulses: does what is equivalent in free decay hold there?

A pulse of angular frequency w is the load l b1 s(w t): s has the peak 1, so that l = 1 is what the plateau just
stands when it is applied slowly. Everything is dimensionless: w over p, time as tau = p t.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.histories.loads import CELLS, pulse_load, under_pulses
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import PULSES
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Histories
from rockdamp.statistics.against_restitution import in_bands, of_outcomes, of_pairs
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import VISCOUS_MODELS

SOURCES = ("closed form", "least error")


def damping_ratios(config: Config) -> Array:
    """Damping ratio of each viscous model for each e, by the closed form and by Err; (source, model, e).

    Both at the release amplitude of the settings, since the amplitude that a pulse will cause is not known before.
    """
    e = config.pulses.restitution
    curves = config.curve.map(lambda p: np.full(e.size, p))
    amplitude = np.full(e.size, config.release_amplitude)
    closed_form = [damping_ratio_energy(curves, model, e, amplitude) for model in VISCOUS_MODELS]
    step, scheme = config.solver.step, config.solver.scheme
    matched = match_decays(curves, amplitude, e, VISCOUS_MODELS, config.matching, step=step, scheme=scheme)
    return np.array([closed_form, [of.damping_ratio for of in matched.values()]])


def pulses(config: Config) -> xr.Dataset:
    """Run CR and every viscous model under pulses of every frequency and load."""
    frequency, load, e = config.pulses.frequency, config.pulses.load, config.pulses.restitution
    xi = damping_ratios(config)
    by_source, step, tail = "damping_ratio_source", config.pulses.step, config.pulses.tail
    by_damper = under_pulses(
        config.curve,
        {model: Damping(model, xi[:, row]) for row, model in enumerate(VISCOUS_MODELS)},
        frequency,
        load,
        step=step,
        tail=tail,
        dims=[by_source, "restitution"],
        description=" by damper",
    )
    reference = np.empty((3, len(PULSES), frequency.size, load.size, e.size))
    for i, name in enumerate(PULSES):
        for j, w in enumerate(track(frequency, f"{name} pulses")):
            forcing = pulse_load(name, float(w), float(config.curve.strength_ratio) * load[:, None], step, tail)
            histories = solve(config.curve, Damping.cr(e), store_every=1, **forcing.newmark())
            reference[0, i, j], reference[1, i, j] = histories.peak, histories.outcome == COLLAPSED
            reference[2, i, j] = _impacts_before_peak(histories, step)
    stored = (*CELLS, "restitution")
    dataset = (
        by_damper.transpose(by_source, "damping_model", *stored)
        .assign(
            damping_ratio=((by_source, "damping_model", "restitution"), xi),
            reference_peak=(stored, reference[0]),
            reference_collapsed=(stored, reference[1].astype(np.int8)),
            impacts_before_peak=(stored, reference[2].astype(np.int32)),
        )
        .assign_coords({by_source: list(SOURCES), "restitution": e})
    )
    return dataset.merge(statistics(dataset, config.pulses.bands)).assign_coords(
        release_amplitude=config.release_amplitude
    )


def _impacts_before_peak(response: Histories, step: float) -> NDArray[np.int64]:
    """Impacts before the largest displacement (for a collapse: before its end)."""
    impacts = passes_zero(response.displacement[..., 1:])  # the start is at rest at 0
    before = step * np.arange(2, impacts.shape[-1] + 2) <= response.peak_tau[..., None]
    return (impacts & before).sum(axis=-1)


# --- statistics -------------------------------------------------------------------------------------------------------


def statistics(dataset: xr.Dataset, edges: Array) -> xr.Dataset:
    """Compare the peaks and collapses of each model with CR's, over all pulses and by band of CR's peak.

    ``..._before_impact`` are of CR's peaks in any band that no impact comes before. ``false_safe`` counts where CR
    collapses and the model does not, ``false_collapse`` the reverse.
    """
    fell, reference, peak = dataset["collapsed"] == 1, dataset["reference_collapsed"] == 1, dataset["reference_peak"]
    ratio = (dataset["peak"] / peak).where(~fell & ~reference)
    inside = ratio.where((peak >= edges[0]) & (peak < edges[-1]))
    over_all = of_pairs(inside, CELLS)
    before_impact = of_pairs(inside.where(dataset["impacts_before_peak"] == 0), CELLS)
    compared = (
        of_pairs(in_bands(ratio, peak, edges), CELLS)
        .drop_vars("log_error")
        .merge(of_outcomes(fell, reference, CELLS))
        .assign(
            median_ratio_all=over_all["median_ratio"],
            log_dispersion_all=over_all["log_dispersion"],
            median_ratio_before_impact=before_impact["median_ratio"],
            pairs_before_impact=before_impact["pairs"],
            reference_collapses=reference.sum(CELLS),
            reference_survivals=(~reference).sum(CELLS),
        )
        .assign_coords(band=np.arange(edges.size - 1), band_start=("band", edges[:-1]), band_end=("band", edges[1:]))
    )
    return compared.transpose("damping_ratio_source", "damping_model", "restitution", "band")
