"""How good the damper at the stop is: facades that rock to one side under records, against restitution by events.

Beside it stand restitution with an e that is off by a little, and the two-sided wall that is often taken in the
facade's place.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.histories.loads import peaks_and_collapses as of_two_sides
from rockdamp.histories.one_sided import SIGNS, peaks_and_collapses
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import bootstrapped, fragilities
from rockdamp.statistics.fragility import resample

KEPT = ("median_ratio", "log_error", "pairs")  # of the statistics, by band; and the rates of outcomes
RATES = ("false_safe_rate", "false_collapse_rate")
BOUND = ("lower", "upper")


def one_sided(config: Any) -> xr.Dataset:
    """Run each facade under every record and both signs, and compare each alternative with restitution.

    Returns
    -------
    xarray.Dataset
        By ``restitution`` and ``alternative``: the median and the scatter of the ratio of peaks by ``band``, rates of
        collapses missed and added, and by ``facade`` the ratio of the median intensities of collapse, with intervals
        over stations; the same of the two-sided wall by ``two_sided_restitution``.
    """
    settings = config.one_sided
    histories = under_records(settings)
    weights = resample(histories["station"].values, settings.bootstrap.replicates, settings.bootstrap.seed)
    paired = histories.rename(facade="wall")
    edges = settings.bands
    bands = list(zip(edges[:-1], edges[1:], strict=True))
    by_band = bootstrapped(paired, weights, bands, "One-sided walls")
    names = [*KEPT, *RATES, *(f"{name}_interval" for name in ("median_ratio", "log_error", *RATES))]
    answer = by_band[names].assign(_medians(histories, weights))
    return answer.assign_coords(
        restitution=histories["restitution"],
        alternative=histories["alternative"],
        facade=histories["facade"],
        two_sided_restitution=histories["two_sided_restitution"],
        band=np.arange(1, edges.size),
        band_start=("band", edges[:-1]),
        band_end=("band", edges[1:]),
        bound=list(BOUND),
    )


def under_records(settings: Any) -> xr.Dataset:
    """Return peaks and collapses of every facade by record and sign, intensity and e, of restitution and the rest."""
    e, scale = settings.restitution, settings.velocity_ratio
    others = alternatives(settings)
    entries = catalogue.listing(settings.records)
    names = [facade.name for facade in settings.facades]
    shape = (len(entries), len(SIGNS["both"]), scale.size, len(names))
    reference = np.empty((2, *shape, e.size))
    other = np.empty((2, *shape, e.size, len(others)))
    mirrored = np.empty((2, *shape, settings.two_sided_restitution.size))
    stations = []
    for row, entry in enumerate(track(entries, "One-sided walls, records")):
        motion = catalogue.read(entry)
        stations.append(motion.group)
        pgv = intensity_measures(motion.record).pgv
        for column, facade in enumerate(settings.facades):
            signed = np.outer(SIGNS["both"], scale * float(facade.wall.velocity_scale) / pgv)[..., None]
            run = {"tail": settings.tail}
            reference[:, row, ..., column, :] = peaks_and_collapses(
                motion.record, facade.wall, facade.curve, e, signed, **run
            )
            for index, (change, how) in enumerate(others.values()):
                other[:, row, ..., column, :, index] = peaks_and_collapses(
                    motion.record, facade.wall, facade.curve, e + change, signed, **run, **how
                )
            # The two-sided wall has neither a sign nor a tie.
            both = of_two_sides(
                motion.record,
                facade.wall.mechanism,
                facade.curve,
                [Damping.cr(each) for each in settings.two_sided_restitution],
                signed[0, :, 0],
                step=settings.step,
                tail=settings.tail,
            )
            mirrored[:, row, ..., column, :] = np.stack([values[0] for values in both])[:, None]
    dims = ("record", "sign", "velocity_ratio", "facade")
    values = {
        "reference": (reference, (*dims, "restitution")),
        "": (other, (*dims, "restitution", "alternative")),
        "two_sided": (mirrored, (*dims, "two_sided_restitution")),
    }
    parts: dict[str, Any] = {}
    for name, (array, of) in values.items():
        prefix = f"{name}_" if name else ""
        peak, fell = array
        parts |= {f"{prefix}peak": (of, peak), f"{prefix}collapsed": (of, fell.astype(np.int8))}
    histories = xr.Dataset(
        parts,
        coords={
            "restitution": e,
            "two_sided_restitution": settings.two_sided_restitution,
            "facade": names,
            "alternative": list(others),
            "velocity_ratio": scale,
            "station": ("record", stations),
        },
    )
    stacked = histories.stack(history=("record", "sign")).reset_index("history", drop=True)
    station = np.repeat(stations, len(SIGNS["both"]))
    return (
        stacked.rename(history="record").assign_coords(station=("record", station)).drop_vars("sign", errors="ignore")
    )


def alternatives(settings: Any) -> dict[str, tuple[float, dict[str, Any]]]:
    """Return by name what is compared with restitution: a change of e, and the arguments of the run."""
    change = settings.restitution_change
    named: dict[str, tuple[float, dict[str, Any]]] = {
        f"CR, e - {change:g}": (-change, {}),
        f"CR, e + {change:g}": (change, {}),
    }
    for stiffness in settings.contact_stiffness.tolist():
        named[f"stop, {stiffness:g} k1"] = (0.0, {"contact_stiffness": stiffness})
    stiffest = float(settings.contact_stiffness[-1])
    named[f"pulling stop, {stiffest:g} k1"] = (0.0, {"contact_stiffness": stiffest, "pulls": True})
    return named


def _medians(histories: xr.Dataset, weights: Array) -> dict[str, Any]:
    """Return the ratios of the median intensities of collapse to those of restitution, with intervals."""
    scale = histories["velocity_ratio"].values
    order = ("record", "facade", "restitution")
    fell = histories["reference_collapsed"].transpose(*order, "velocity_ratio").values[..., None, :]
    other = histories["collapsed"].transpose(*order, "alternative", "velocity_ratio").values
    one = np.concatenate([fell, other], axis=-2)
    found = fragilities(scale, one, 1, weights, (..., slice(0, 1)))
    two = histories["two_sided_collapsed"].transpose("record", "facade", "two_sided_restitution", "velocity_ratio")
    beside = np.concatenate(
        [fell, np.broadcast_to(two.values[:, :, None], (*fell.shape[:3], two.shape[2], scale.size))], axis=-2
    )
    stood = fragilities(scale, beside, 1, weights, (..., slice(0, 1)))
    of_one, of_two = ("facade", "restitution", "alternative"), ("facade", "restitution", "two_sided_restitution")
    interval = "median_intensity_ratio_interval"
    return {
        "reference_median": (of_one[:2], found["median"][..., 0]),
        "median_intensity_ratio": (of_one, found["median_intensity_ratio"][..., 1:]),
        interval: ((*of_one, "bound"), found[interval][..., 1:, :]),
        "two_sided_intensity_ratio": (of_two, stood["median_intensity_ratio"][..., 1:]),
        "two_sided_intensity_ratio_interval": ((*of_two, "bound"), stood[interval][..., 1:, :]),
    }
