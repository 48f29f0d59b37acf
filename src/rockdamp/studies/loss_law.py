"""What a constant e costs, if the loss of an impact falls with the amplitude: the law beside it, under earthquakes.

The law has e at one amplitude and an exponent g (docs/theory.md, section 8). Each pair of both stands beside the
constant e in the same histories, with every wall under every record: in place of the dampers of the other studies.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.histories.loads import run_records
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, HISTORIES, compare_fragilities, compare_pairs

EVERY_WALL = "all"
LAW = ("loss_exponent", "reference_amplitude")
OF_PEAKS = ("median_ratio", "log_error")
OF_OUTCOMES = ("false_safe_rate", "false_collapse_rate")


def histories(config: Config) -> xr.Dataset:
    """Run every wall under every record with the constant e, and with each law."""
    quakes, section = config.earthquakes, config.loss_law
    g, at = (part.ravel() for part in np.meshgrid(section.exponent, section.amplitude, indexing="ij"))
    # The constant e is the first lane of the same batch: its exponent is 0.
    damping = Damping(
        "CR", section.restitution, loss_exponent=np.append(0.0, g), reference_amplitude=np.append(at[:1], at)
    )
    ended = run_records(
        map(catalogue.load_record, track(catalogue.record_names(config.records), "Laws of loss, records")),
        {named.name: (named.wall, named.curve) for named in quakes.walls},
        damping,
        quakes.velocity_ratio.values(),
        step=config.loss_law.step,
        tail=quakes.tail,
        dim="law",
    ).drop_vars("record_set")
    grid = {"loss_exponent": section.exponent, "reference_amplitude": section.amplitude}
    pairs = xr.Coordinates.from_pandas_multiindex(
        pd.MultiIndex.from_product(list(grid.values()), names=list(grid)), "law"
    )
    laws = ended.isel(law=slice(1, None)).assign_coords(pairs).unstack("law").transpose(*HISTORIES, *LAW)  # noqa: PD010, it is xarray's
    constant = {f"reference_{name}": values for name, values in ended.isel(law=0).data_vars.items()}
    return laws.assign(constant).assign_coords(restitution=section.restitution)


def compare(config: Config, histories: xr.Dataset) -> xr.Dataset:
    """Compare each law with the constant e, over all walls together and wall by wall, with intervals over stations.

    ``median_intensity_ratio`` is the median intensity of collapse under the law over that under the constant e.
    ``false_safe_rate`` is the part of the collapses under the law's *reference*, the constant e, that do not happen
    under the law, and ``false_collapse_rate`` the part of its survivals that do: those that the constant e misses.
    """
    bands, bootstrap = config.comparison.bands, config.comparison.bootstrap
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    walls = [*map(str, histories["wall"].values)]
    chosen = [histories, *(histories.sel(wall=[wall]) for wall in walls)]
    edges = list(pairwise(bands))
    parts = [_of_walls(some, weights, edges) for some in track(chosen, "Laws of loss, walls")]
    return (
        xr.concat(parts, "wall", join="exact")
        .assign_coords(
            wall=[EVERY_WALL, *walls],
            loss_exponent=histories["loss_exponent"].values,
            reference_amplitude=histories["reference_amplitude"].values,
            restitution=float(histories["restitution"]),
            band=np.arange(1, len(bands)),
            band_start=("band", bands[:-1]),
            band_end=("band", bands[1:]),
            bound=list(BOUND),
        )
        .assign(records=histories.sizes["record"], stations=np.unique(histories["station"].values).size)
    )


def _of_walls(histories: xr.Dataset, weights: Array, bands: list[tuple[float, float]]) -> xr.Dataset:
    """Return the statistics over some walls together."""
    compared = compare_pairs(histories.drop_vars("restitution").expand_dims(restitution=1), weights, bands)
    kept = [name for statistic in (*OF_PEAKS, *OF_OUTCOMES) for name in (statistic, f"{statistic}_interval")]
    compared = compared[[*kept, "pairs"]].isel(restitution=0)
    order = ("record", *LAW, "velocity_ratio")
    laws = histories["collapsed"].sum("wall").transpose(*order).values
    constant = histories["reference_collapsed"].sum("wall").values[:, None]
    collapses = np.concatenate([constant, laws.reshape(len(laws), -1, laws.shape[-1])], axis=1)
    curves = compare_fragilities(
        histories["velocity_ratio"].values, collapses, histories.sizes["wall"], weights, (..., slice(0, 1))
    )
    shape = laws.shape[1:3]
    return compared.assign(
        median_intensity_ratio=(LAW, curves["median_intensity_ratio"][1:].reshape(shape)),
        median_intensity_ratio_interval=(
            (*LAW, "bound"),
            curves["median_intensity_ratio_interval"][1:].reshape(*shape, len(BOUND)),
        ),
    )
