"""Compare every viscous damper with CR under pulses: does what is equivalent in free decay hold there?

A pulse of angular frequency w is the load l b1 s(w t): s has the peak 1, so that l = 1 is what the plateau just
stands when it is applied slowly. Everything is dimensionless: w over p, time as tau = p t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.histories.forcing import Forcing
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import ricker
from rockdamp.motions.records import followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Histories, Options, Peaks
from rockdamp.statistics.against_restitution import in_bands, of_outcomes, of_pairs
from rockdamp.studies.decays import step_count
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import VISCOUS_MODELS

PULSES = ("Ricker", "sine")
CELLS = ("pulse", "pulse_frequency", "load_ratio")
SOURCES = ("closed form", "least error")
RICKER_HALF_LENGTH = 1.5  # periods before and after the peak, where the wavelet is 1e-8 of it


def pulse(name: str, frequency: float, step: float) -> Array:
    """Return a pulse of peak 1 and angular frequency w/p, sampled every `step` in tau; it ends at zero."""
    period = 2 * np.pi / frequency
    if name == "Ricker":
        half = step_count(RICKER_HALF_LENGTH * period, step)
        return ricker(step * np.arange(-half, half + 1), 1 / period, 1.0)
    tau = step * np.arange(int(np.ceil(period / step)) + 1)
    return np.where(tau < period, np.sin(frequency * tau), 0.0)


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
    shape = (len(PULSES), frequency.size, load.size, e.size)
    reference = np.empty((3, *shape))
    by_damper = np.empty((2, *xi.shape[:2], *shape))
    for i, name in enumerate(PULSES):
        for j, w in enumerate(track(frequency, f"{name} pulses")):
            step = config.pulses.step
            run = Run(config.curve, pulse(name, float(w), step), load, step, config.pulses.tail)
            histories = run.histories(Damping.cr(e))
            reference[0, i, j], reference[1, i, j] = histories.peak, histories.outcome == COLLAPSED
            reference[2, i, j] = _impacts_before_peak(histories, step)
            for row, model in enumerate(VISCOUS_MODELS):
                response = run(Damping(model, xi[:, row, None, :]))
                by_damper[0, :, row, i, j], by_damper[1, :, row, i, j] = response.peak, response.outcome == COLLAPSED
    dims = (*CELLS, "restitution")
    by_model = ("damping_ratio_source", "damping_model")
    dataset = xr.Dataset(
        {
            "damping_ratio": ((*by_model, "restitution"), xi),
            "reference_peak": (dims, reference[0]),
            "reference_collapsed": (dims, reference[1].astype(np.int8)),
            "impacts_before_peak": (dims, reference[2].astype(np.int32)),
            "peak": ((*by_model, *dims), by_damper[0]),
            "collapsed": ((*by_model, *dims), by_damper[1].astype(np.int8)),
        },
        coords={
            "damping_ratio_source": list(SOURCES),
            "damping_model": list(VISCOUS_MODELS),
            "pulse": list(PULSES),
            "pulse_frequency": frequency,
            "load_ratio": load,
            "restitution": e,
        },
    )
    return dataset.merge(statistics(dataset, config.pulses.bands)).assign_coords(
        release_amplitude=config.release_amplitude
    )


@dataclass(frozen=True)
class Run:
    """A pulse of one frequency at every load, for the dampers that are asked for."""

    curve: TrilinearCurve
    pulse: Array
    load: Array
    step: float
    tail: float

    def __call__(self, damping: Damping) -> Peaks:
        """Dampers of shape (..., e) give a batch (..., load, e)."""
        return solve(self.curve, damping, peaks_only=True, **self._forced())

    def histories(self, damping: Damping) -> Histories:
        return solve(self.curve, damping, store_every=1, **self._forced())

    def _forced(self) -> Options:
        pulse = followed_by_rest(self.pulse, self.step, self.tail)
        return Forcing(pulse, self.step, float(self.curve.strength_ratio) * self.load[:, None]).newmark()


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
