"""How good the damper at the stop is: facades that rock to one side under records, against restitution by events.

Beside it stand restitution with an e that is off by a little, and the two-sided wall that is often taken in the
facade's place.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import OneSided
from rockdamp.histories.loads import peaks_and_collapses as of_two_sides
from rockdamp.histories.one_sided import SIGNS, peaks_and_collapses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.one_sided import OneSidedForce, Stop
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.progress import track
from rockdamp.solvers import one_sided_march
from rockdamp.statistics.against_restitution import bootstrapped, fragilities
from rockdamp.statistics.fragility import resample

KEPT = ("median_ratio", "log_error", "pairs")  # of the statistics, by band; and the rates of outcomes
RATES = ("false_safe_rate", "false_collapse_rate")
BOUND = ("lower", "upper")
REFERENCE_CURVE = (0.04, 0.85)  # a1 and b1, of single impacts
RELEASES = (0.1, 0.6, 64)  # u0/u_ins of them: from, to and how many


def one_sided(config: Config, histories: xr.Dataset) -> xr.Dataset:
    """Compare each alternative with restitution, and measure the restitution of single impacts on the stop.

    Parameters
    ----------
    config : Config
    histories : xarray.Dataset
        What `histories` returned.

    Returns
    -------
    xarray.Dataset
        By ``restitution`` and ``alternative``: the median and the scatter of the ratio of peaks by ``band``, rates of
        collapses missed and added, and by ``wall`` the ratio of the median intensities of collapse, with intervals
        over stations; the same of the two-sided wall by ``two_sided_restitution``.
    """
    settings, bootstrap, edges = config.one_sided, config.comparison.bootstrap, config.comparison.bands
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    bands = list(zip(edges[:-1], edges[1:], strict=True))
    by_band = bootstrapped(histories, weights, bands, "One-sided walls")
    names = [*KEPT, *RATES, *(f"{name}_interval" for name in ("median_ratio", "log_error", *RATES))]
    answer = by_band[names].assign(_medians(histories, weights)).assign(_single_impacts(settings))
    return answer.assign_coords(
        restitution=histories["restitution"],
        alternative=histories["alternative"],
        wall=histories["wall"],
        two_sided_restitution=histories["two_sided_restitution"],
        contact_step=settings.contact_step,
        band=np.arange(1, edges.size),
        band_start=("band", edges[:-1]),
        band_end=("band", edges[1:]),
        bound=list(BOUND),
    )


def _single_impacts(settings: OneSided) -> dict[str, Any]:
    """Return the mean and the scatter of the restitution of single impacts, by step of the stepper.

    The wall falls from many heights on the stiffest stop, and its energy after the impact is that of the next peak.
    """
    curve = TrilinearCurve(*REFERENCE_CURVE)
    force, release = OneSidedForce(curve), np.linspace(*RELEASES)
    e, steps = settings.restitution, settings.contact_step
    kc = float(settings.contact_stiffness[-1] * curve.initial_stiffness)
    duration = 1.05 * float(np.max(curve.period(release))) / 2
    found = np.empty((2, steps.size, e.size))
    for row, contact in enumerate(steps.tolist()):
        step = contact / np.sqrt(kc)
        run = {"step": step, "steps": int(duration / step), "release_amplitude": release, "store_every": 1}
        for column, each in enumerate(e.tolist()):
            x = one_sided_march.solve(force, Stop(kc, each), **run).displacement  # type: ignore[attr-defined]
            peak = [history[at:].max() for history, at in zip(x, np.argmax(x < 0, axis=1), strict=True)]
            taken = np.sqrt(curve.energy(peak) / curve.energy(release))
            found[:, row, column] = taken.mean() - each, taken.std()
    dims = ("contact_step", "restitution")
    return {"impact_error": (dims, found[0]), "impact_scatter": (dims, found[1])}


def histories(config: Config) -> xr.Dataset:
    """Return peaks and collapses of every facade by record and sign, intensity and e, of restitution and the rest.

    ``record`` has two entries for each record, which acts both ways; ``station`` is its group.
    """
    settings = config.one_sided
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
        stations += [motion.group] * len(SIGNS["both"])
        pgv = intensity_measures(motion.record).pgv
        for column, facade in enumerate(settings.facades):
            signed = np.outer(SIGNS["both"], scale * float(facade.wall.velocity_scale) / pgv)[..., None]
            run = partial(peaks_and_collapses, motion.record, facade.wall, facade.curve, tail=settings.tail)
            reference[:, row, ..., column, :] = run(e, signed)
            for index, (change, how) in enumerate(others.values()):
                other[:, row, ..., column, :, index] = run(e + change, signed, **how)
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
    dims = ("record", "velocity_ratio", "wall")
    ended = {
        "reference_": (reference, ["restitution"]),
        "": (other, ["restitution", "alternative"]),
        "two_sided_": (mirrored, ["two_sided_restitution"]),
    }
    parts: dict[str, Any] = {}
    for prefix, (array, more) in ended.items():
        peak, fell = array.reshape(2, len(stations), *array.shape[3:])
        parts |= {f"{prefix}peak": ((*dims, *more), peak)}
        parts |= {f"{prefix}collapsed": ((*dims, *more), fell.astype(np.int8))}
    return xr.Dataset(
        parts,
        coords={
            "record": [f"{entry.name} {sign}" for entry in entries for sign in ("+", "-")],
            "station": ("record", stations),
            "restitution": e,
            "two_sided_restitution": settings.two_sided_restitution,
            "wall": names,
            "alternative": list(others),
            "velocity_ratio": scale,
        },
    )


def alternatives(settings: OneSided) -> dict[str, tuple[float, dict[str, Any]]]:
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
    order = ("record", "wall", "restitution")
    fell = histories["reference_collapsed"].transpose(*order, "velocity_ratio").values[..., None, :]
    other = histories["collapsed"].transpose(*order, "alternative", "velocity_ratio").values
    one = np.concatenate([fell, other], axis=-2)
    found = fragilities(scale, one, 1, weights, (..., slice(0, 1)))
    two = histories["two_sided_collapsed"].transpose("record", "wall", "two_sided_restitution", "velocity_ratio")
    beside = np.concatenate(
        [fell, np.broadcast_to(two.values[:, :, None], (*fell.shape[:3], two.shape[2], scale.size))], axis=-2
    )
    stood = fragilities(scale, beside, 1, weights, (..., slice(0, 1)))
    of_one, of_two = ("wall", "restitution", "alternative"), ("wall", "restitution", "two_sided_restitution")
    interval = "median_intensity_ratio_interval"
    return {
        "collapse_median": (of_one[:2], found["median"][..., 0]),
        "median_intensity_ratio": (of_one, found["median_intensity_ratio"][..., 1:]),
        interval: ((*of_one, "bound"), found[interval][..., 1:, :]),
        "two_sided_intensity_ratio": (of_two, stood["median_intensity_ratio"][..., 1:]),
        "two_sided_intensity_ratio_interval": ((*of_two, "bound"), stood[interval][..., 1:, :]),
    }
