"""Compare every viscous damper with CR under pulses: does what is equivalent in free decay hold there?

A pulse of angular frequency w is the load l b1 s(w t): s has the peak 1, so that l = 1 is what the plateau just
stands when it is applied slowly. Everything is dimensionless: w over p, time as tau = p t.

`demand` is the displacement demand with the bi-linear curve (section 3), in pairs with the tri-linear one. The same
wall with the same e is put under the same pulses and earthquake records. The nearly rigid curve of Fig. 4a stands for
the bi-linear law.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.study import RigidWall
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.histories.loads import CELLS, pulse_load, under_pulses, under_records
from rockdamp.mechanics.curve import TEXTS, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
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


CURVES = ("tri-linear", "bi-linear")


def demand(config: Config) -> xr.Dataset:
    """Run the reference wall with both curves under restitution, under every pulse and every record.

    The loads are over the tri-linear plateau for both.
    """
    rigid: RigidWall = config.damping_force.rigid
    pair = (config.curve, rigid.curve)
    a1, b1, a3 = (np.array([float(getattr(curve, name)) for curve in pair]) for name in TEXTS)
    curves = TrilinearCurve(a1, b1, a3, config.curve.softening)
    e, asked = config.damping_force.restitution, config.bilinear
    dampings, plateau = {"CR": Damping.cr(np.full(len(pair), e))}, float(config.curve.strength_ratio)
    by_pulse = under_pulses(
        curves,
        dampings,
        config.pulses.frequency,
        config.pulses.load,
        step=config.pulses.step,
        tail=config.pulses.tail,
        plateau=plateau,
        dims=["force_curve"],
    )
    entries = track(catalogue.listing(asked.records), "Bi-linear and tri-linear curve")
    walls = {name: (config.wall, curve) for name, curve in zip(CURVES, pair, strict=True)}
    by_record = under_records(
        map(catalogue.read, entries),
        walls,
        {"CR": Damping.cr(e)},
        asked.velocity_ratio,
        step=asked.step,
        tail=asked.tail,
    ).rename(wall="force_curve")
    both = [
        ended.sel(damping_model="CR", drop=True)
        .transpose("force_curve", ...)
        .rename(peak=f"peak_under_{load}", collapsed=f"{load}_collapsed")
        for load, ended in (("pulse", by_pulse), ("record", by_record.drop_vars(["record_set", "station"])))
    ]
    return xr.merge([both[0].assign_coords(force_curve=list(CURVES)), both[1]], join="exact").assign(
        yield_displacement_ratio=("force_curve", a1), strength_ratio=("force_curve", b1), restitution=e
    )
