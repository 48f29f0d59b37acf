"""Local damping beside ECD and ECD16, under pulses and earthquakes: three dampers that are exact in free decay.

Each has the parameter that loses in every half cycle what an impact takes; nothing is fitted. So what they differ by
is when, within the half cycle, they take it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.histories.forcing import Forcing
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED
from rockdamp.statistics.against_restitution import BOUND, HISTORIES, bootstrapped, in_bands, of_pairs
from rockdamp.statistics.fragility import resample
from rockdamp.studies.pulses import CELLS, PULSES, Run, pulse
from rockdamp.vocabulary import LOCAL, RECOMMENDED, REFERENCE

DAMPERS = ("ECD", RECOMMENDED, LOCAL)
KEPT = ("median_ratio", "log_error", "false_safe_rate", "false_collapse_rate")  # of the statistics under earthquakes


def compare(config: Config) -> xr.Dataset:
    """Run CR and the three dampers under every pulse on the reference curve, and every wall under every record."""
    e = config.damping_force.restitution
    dampings = {REFERENCE: Damping.cr(e)} | {model: Damping.of_restitution(e, model) for model in DAMPERS}
    bands = config.comparison.bands
    parts = [_of_pulses(under_pulses(config, dampings)), _of_records(under_records(config, dampings), config)]
    by_band = xr.concat([_by_band(part, dims, bands) for part, dims in parts], "loading")
    statistics = xr.merge([part.drop_dims([*dims]) for part, dims in parts])
    return (
        statistics.merge(by_band)
        .assign_coords(
            loading=["pulses", "earthquakes"],
            damping_model=list(DAMPERS),
            band=np.arange(1, bands.size),
            band_start=("band", bands[:-1]),
            band_end=("band", bands[1:]),
            bound=list(BOUND),
            restitution=e,
        )
        .assign(local_damping=float(dampings[LOCAL].local_damping))
    )


def _against(peak: xr.DataArray, collapsed: xr.DataArray) -> xr.Dataset:
    """Return the peaks and outcomes of the dampers beside those of CR, and the ratios of peaks where neither falls."""
    reference, fell = (values.sel(damping_model=REFERENCE, drop=True) for values in (peak, collapsed.astype(np.int8)))
    other, other_fell = (values.sel(damping_model=list(DAMPERS)) for values in (peak, collapsed.astype(np.int8)))
    ratio = (other / reference).where((fell == 0) & (other_fell == 0))
    named = {"reference_peak": reference, "reference_collapsed": fell, "peak": other, "collapsed": other_fell}
    return xr.Dataset({**named, "ratio": ratio})


def _by_band(histories: xr.Dataset, dims: tuple[str, ...], bands: np.ndarray) -> xr.Dataset:
    """Return the statistics of the ratios by band of the peak under CR."""
    by_band = of_pairs(in_bands(histories["ratio"], histories["reference_peak"], bands), dims)
    return by_band.rename({name: f"band_{name}" for name in by_band}).transpose("damping_model", "band")


# --- pulses -----------------------------------------------------------------------------------------------------------


def under_pulses(config: Config, dampings: dict[str, Damping]) -> xr.Dataset:
    """Run the reference curve under every pulse."""
    pulses, shape = config.pulses, (config.pulses.frequency.size, config.pulses.load.size)
    ended = np.empty((2, len(dampings), len(PULSES), *shape))
    for i, name in enumerate(PULSES):
        for j, frequency in enumerate(track(pulses.frequency, f"{name} pulses, local damping")):
            load = pulse(name, float(frequency), pulses.step)
            run = Run(config.curve, load, pulses.load, pulses.step, pulses.tail)
            for row, damping in enumerate(dampings.values()):
                response = run(damping.map(lambda parameter: parameter[None]))
                ended[:, row, i, j] = response.peak[:, 0], response.outcome[:, 0] == COLLAPSED
    dims = ("damping_model", *CELLS)
    peak, fell = (xr.DataArray(values, dims=dims, coords={"damping_model": list(dampings)}) for values in ended)
    return _against(peak, fell)


def _of_pulses(histories: xr.Dataset) -> tuple[xr.Dataset, tuple[str, ...]]:
    """Add the statistics over all pulses."""
    pairs = of_pairs(histories["ratio"], CELLS)
    fell, other = histories["reference_collapsed"], histories["collapsed"]
    return histories.assign(
        pulse_median_ratio=pairs["median_ratio"],
        pulse_log_error=pairs["log_error"],
        pulse_false_safe_rate=((fell == 1) & (other == 0)).sum(CELLS) / (fell == 1).sum(CELLS),
        pulse_false_collapse_rate=((fell == 0) & (other == 1)).sum(CELLS) / (fell == 0).sum(CELLS),
    ), CELLS


# --- earthquakes ------------------------------------------------------------------------------------------------------


def under_records(config: Config, dampings: dict[str, Damping]) -> xr.Dataset:
    """Run every wall under every record at every intensity."""
    quakes = config.earthquakes
    entries = catalogue.listing(config.records)
    shape = (len(entries), quakes.velocity_ratio.size, len(quakes.walls))
    ended, stations = np.empty((2, len(dampings), *shape)), []
    for row, entry in enumerate(track(entries, "Local damping, records")):
        motion = catalogue.read(entry)
        pgv = intensity_measures(motion.record).pgv
        stations.append(motion.group)
        for column, named in enumerate(quakes.walls):
            factor = quakes.velocity_ratio * named.wall.velocity_scale / pgv
            forcing = Forcing.of(named.wall, motion.record, factor, rest=quakes.tail)
            substeps = forcing.substeps(quakes.orders.step / named.curve.initial_frequency)
            loads = replace(forcing, load_factor=np.asarray(forcing.load_factor)).newmark(substeps)
            for index, damping in enumerate(dampings.values()):
                response = solve(named.curve, damping, peaks_only=True, **loads)
                ended[:, index, row, :, column] = response.peak, response.outcome == COLLAPSED
    dims = ("damping_model", *HISTORIES)
    coords = {
        "damping_model": list(dampings),
        "velocity_ratio": quakes.velocity_ratio,
        "station": ("record", stations),
    }
    peak, fell = (xr.DataArray(values, dims=dims, coords=coords) for values in ended)
    return _against(peak, fell)


def _of_records(histories: xr.Dataset, config: Config) -> tuple[xr.Dataset, tuple[str, ...]]:
    """Add the statistics over all records, with their intervals over stations."""
    bootstrap = config.comparison.bootstrap
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    compared = bootstrapped(histories.drop_vars("ratio").expand_dims(restitution=1), weights)
    names = [*KEPT, *(f"{name}_interval" for name in KEPT)]
    whole = compared[names].isel(band=0, restitution=0)
    return histories.merge(whole.rename({name: f"record_{name}" for name in names})), HISTORIES
