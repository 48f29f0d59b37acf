"""What each assumption costs, as the documents have it: the table of docs/assumptions.md."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from table_text import interval, number, table

from rockdamp.studies.supports import ANALYTICAL, FIXED, IMPULSIVE, MASS, VERTICAL

FLOORS = (0.1, 0.3, 0.6, 1.0)  # periods that are shown [s]
HEAD = ("assumed", "in place of it", "median intensity of collapse", "single walls", "the assumption is", "computed in")
RATIO = "median_intensity_ratio"
RULE = "e by `measured`"


def assumed(data: dict[str, xr.Dataset]) -> str:
    """What each assumption costs: collapse over that under the assumption, and on which side it is."""
    return table(HEAD, [*_of_supports(data["supports"]), *_of_loss(data["loss_law"])])


def _of_supports(study: xr.Dataset) -> Iterator[list[str]]:
    floors = study.where(np.isfinite(study["diaphragm_period"]), drop=True)
    for period in FLOORS:
        nearest = int(np.abs(floors["diaphragm_period"].values - period).argmin())
        floor = floors.isel(assumption=nearest)
        yield _row("a rigid floor at the top", f"a floor of {float(floor['diaphragm_period']):g} s", floor, "supports")
    eccentricity, factor = float(study["eccentricity_ratio"]), float(study["vertical_factor"])
    keeps = f"it keeps its side, {eccentricity:g} t from the middle"
    for case, what, instead in (
        (MASS, "the overburden has no mass", "all of it is a mass, the same e"),
        (IMPULSIVE, RULE, "e by `impulsive`"),
        (ANALYTICAL, RULE, "e of Eq. (7)"),
        (VERTICAL, "no vertical shaking", f"the other component times {factor:.2g}"),
        (FIXED, "the worse of both signs of the eccentricity", keeps),
    ):
        yield _row(what, instead, study.sel(assumption=case), "supports")


def _of_loss(study: xr.Dataset) -> Iterator[list[str]]:
    middle = study.isel(loss_exponent=study.sizes["loss_exponent"] // 2)
    for at in middle["reference_amplitude"].values.tolist():
        law = f"the loss falls, and e is that of {at:g} u_ins"
        yield _row("one e at all amplitudes", law, middle.sel(reference_amplitude=at), "loss_law")


def _row(what: str, instead: str, case: xr.Dataset, dataset: str) -> list[str]:
    whole, walls = case.sel(wall="all"), case[RATIO].drop_sel(wall="all")
    low, high = whole[f"{RATIO}_interval"].values.tolist()
    side = "unsafe" if high < 1 else "safe" if low > 1 else "neither"
    ends = f"{number(walls.min())} to {number(walls.max())}"
    return [what, instead, interval(whole, RATIO), ends, side, f"`results/{dataset}.nc`"]
