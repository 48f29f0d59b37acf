"""Tables of the study of walls that rock to one side, for the documents."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr
from table_text import interval, percent, table

from rockdamp.mechanics.one_sided import CONTACT_STIFFNESS

LOW = 0.25  # u/u_ins, up to which a peak is low


def one_sided(data: dict[str, xr.Dataset]) -> str:
    """The damper at the stop, and other e, beside restitution."""
    study = data["one_sided"]
    low = study["band_end"].values <= LOW
    rows = []
    for e in study["restitution"].values:
        for name in study["alternative"].values:
            one = study.sel(restitution=e, alternative=name)
            medians = one["median_ratio"].values
            ranges = [medians[low], medians[~low], one["median_intensity_ratio"].values]
            below, above, collapse = map(_range, ranges)
            rates = [percent(one[f"false_{of}_rate"]) for of in ("safe", "collapse")]
            rows.append([f"{e:g}", str(name), below, above, *rates, collapse])
    head = ["e", "in place of it", f"peaks below {LOW:g}", "peaks above", "missed", "added", "median of collapse"]
    return table(head, rows)


def shipped(study: xr.Dataset) -> str:
    """Return the errors by e and alternative as the package ships them, for `rockdamp.equivalence.programs`."""
    one = study[["false_safe_rate", "false_collapse_rate"]].round(6)
    for name, of, over in (("peak", "median_ratio", "band"), ("median", "median_intensity_ratio", "wall")):
        one[f"least_{name}"], one[f"largest_{name}"] = study[of].min(over).round(3), study[of].max(over).round(3)
    rows: pd.DataFrame = one.to_dataframe(dim_order=["restitution", "alternative"]).reset_index()
    return str(rows.to_csv(index=False, lineterminator="\n"))


def _range(values: np.ndarray) -> str:
    known = values[np.isfinite(values)]
    return f"{known.min():.2f} to {known.max():.2f}" if known.size else "–"


def one_sided_steps(data: dict[str, xr.Dataset]) -> str:
    """How well single impacts on the stop take e, by step."""
    study = data["one_sided"]
    rows = []
    for step in study["contact_step"].values:
        at = study.sel(contact_step=step)
        pairs = zip(at["impact_error"].values, at["impact_scatter"].values, strict=True)
        rows.append([f"{step:g}", *(f"{error:+.3f} ± {scatter:.3f}" for error, scatter in pairs)])
    return table(["step", *(f"e = {e:g}" for e in study["restitution"].values)], rows)


def one_sided_collapse(data: dict[str, xr.Dataset]) -> str:
    """The median of collapse with the damper at the stop that the commands take, over that under restitution."""
    at = data["one_sided"].sel(alternative=f"stop, {CONTACT_STIFFNESS:g} k1")
    return _by_facade(at, "restitution", "e =", "median_intensity_ratio")


def two_sided(data: dict[str, xr.Dataset]) -> str:
    """The median of collapse of the two-sided wall over that of the one-sided one."""
    study = data["one_sided"]
    at = study.isel(restitution=(study.sizes["restitution"] - 1) // 2)
    return _by_facade(at, "two_sided_restitution", "two-sided e =", "two_sided_intensity_ratio")


def _by_facade(at: xr.Dataset, e: str, head: str, name: str) -> str:
    """Return a ratio with its interval, by facade and e."""
    values = at[e].values
    rows = [
        [str(wall), *(interval(at.sel({"wall": wall, e: value}), name) for value in values)]
        for wall in at["wall"].values
    ]
    return table(["facade", *(f"{head} {value:g}" for value in values)], rows)
