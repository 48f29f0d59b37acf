"""Local damping beside ECD and ECD16, under pulses and earthquakes: three dampers that are exact in free decay.

Each has the parameter that loses in every half cycle what an impact takes; nothing is fitted. So what they differ by
is when, within the half cycle, they take it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.histories.loads import CELLS, under_pulses, under_records
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import BOUND, HISTORIES, bootstrapped, in_bands, of_pairs
from rockdamp.statistics.fragility import resample
from rockdamp.vocabulary import LOCAL, RECOMMENDED, REFERENCE

DAMPERS = ("ECD", RECOMMENDED, LOCAL)
# Names of the peaks and outcomes of the runs.
PULSE_NAMES = {"peak": "peak_under_pulse", "collapsed": "pulse_collapsed"}
RECORD_NAMES = {"peak": "peak_under_record", "collapsed": "record_collapsed"}
KEPT = ("median_ratio", "log_error", "false_safe_rate", "false_collapse_rate")  # of the statistics under earthquakes


def run(config: Config) -> xr.Dataset:
    """Run CR and the three dampers under every pulse on the reference curve, and every wall under every record."""
    e = config.damping_force.restitution
    dampings = {REFERENCE: Damping.cr(e)} | {model: Damping.of_restitution(e, model) for model in DAMPERS}
    pulses, quakes = config.pulses, config.earthquakes
    of_pulses = under_pulses(
        config.curve,
        dampings,
        pulses.frequency,
        pulses.load,
        step=pulses.step,
        tail=pulses.tail,
        description=", local damping",
    )
    of_records = under_records(
        map(catalogue.read, track(catalogue.listing(config.records), "Local damping, records")),
        {named.name: (named.wall, named.curve) for named in quakes.walls},
        dampings,
        quakes.velocity_ratio,
        step=quakes.orders.step,
        tail=quakes.tail,
    )
    return (
        of_pulses.rename(PULSE_NAMES)
        .merge(of_records.drop_vars("record_set").rename(RECORD_NAMES))
        .assign_coords(restitution=e)
    )


def compare(config: Config, runs: xr.Dataset) -> xr.Dataset:
    """Compare the three dampers with CR under every pulse and under every record, by what `run` returned."""
    e = float(runs["restitution"])
    bands = config.comparison.bands
    parts = [_of_pulses(_against(runs, PULSE_NAMES)), _of_records(_against(runs, RECORD_NAMES), config)]
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
        .assign(local_damping=float(Damping.of_restitution(e, LOCAL).local_damping))
    )


def _against(runs: xr.Dataset, names: Mapping[str, str]) -> xr.Dataset:
    """Return the peaks and outcomes of the dampers beside those of CR, and the ratio of peaks without a collapse."""
    ended = runs[list(names.values())].rename({new: old for old, new in names.items()})
    ended = ended.drop_vars([*CELLS, "record", "wall", "restitution"], errors="ignore")
    reference = ended.sel(damping_model=REFERENCE, drop=True).rename(
        peak="reference_peak", collapsed="reference_collapsed"
    )
    both = ended.sel(damping_model=list(DAMPERS)).merge(reference)
    stand = (both["reference_collapsed"] == 0) & (both["collapsed"] == 0)
    return both.assign(ratio=(both["peak"] / both["reference_peak"]).where(stand))


def _by_band(histories: xr.Dataset, dims: tuple[str, ...], bands: np.ndarray) -> xr.Dataset:
    """Return the statistics of the ratios by band of the peak under CR."""
    by_band = of_pairs(in_bands(histories["ratio"], histories["reference_peak"], bands), dims)
    return by_band.rename({name: f"band_{name}" for name in by_band}).transpose("damping_model", "band")


# --- pulses -----------------------------------------------------------------------------------------------------------


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


def _of_records(histories: xr.Dataset, config: Config) -> tuple[xr.Dataset, tuple[str, ...]]:
    """Add the statistics over all records, with their intervals over stations; of the peaks that every study counts."""
    bootstrap, bands = config.comparison.bootstrap, config.comparison.bands
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    alternatives = histories.drop_vars("ratio").expand_dims(restitution=1)
    compared = bootstrapped(alternatives, weights, [(bands[0], bands[-1])])
    names = [*KEPT, *(f"{name}_interval" for name in KEPT)]
    whole = compared[names].isel(band=0, restitution=0)
    return histories.merge(whole.rename({name: f"record_{name}" for name in names})), HISTORIES
