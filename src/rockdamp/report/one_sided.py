"""What the study of walls that rock to one side found: which stop, which step, how far off, and the two-sided wall."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.figures.one_sided import middle_of
from rockdamp.mechanics.one_sided import CONTACT_STEP, CONTACT_STIFFNESS
from rockdamp.text import DASH, listed, percent, plain, span

COMPRESSION, CHANGED = "stop, ", "CR, "  # how the names of alternatives begin


def finding(study: xr.Dataset) -> dict[str, Any]:
    """Return what the section on walls that rock to one side says, from the dataset ``one_sided``.

    The stop and the step are those of the commands, or the nearest that were studied.
    """
    names = [str(name) for name in study["alternative"].values]
    wanted = f"{COMPRESSION}{CONTACT_STIFFNESS:g} k1"
    taken = wanted if wanted in names else [name for name in names if name.startswith(COMPRESSION)][-1]
    changed = [name for name in names if name.startswith(CHANGED)]
    others = [name for name in names if name not in (taken, *changed)]
    return {
        "stiffness": plain(CONTACT_STIFFNESS),
        "step": plain(CONTACT_STEP),
        "taken": taken,
        "peaks": _range(_peaks(study, taken)),
        "others": [(name, _range(_peaks(study, name)), _off(study, name) <= _off(study, taken)) for name in others],
        "steps": _steps(study),
        "changed": listed(changed),
        "rates": [_rates(study.sel(restitution=e), taken, changed) for e in study["restitution"].values],
        "medians": _range(_finite(study["median_intensity_ratio"].sel(alternative=taken))),
        **_two_sided(study),
    }


def _finite(values: xr.DataArray) -> Array:
    return np.asarray(values.values[np.isfinite(values.values)])


def _peaks(study: xr.Dataset, name: str) -> Array:
    """Return the medians of peaks over those under restitution, of all e and bands that have one."""
    return _finite(study["median_ratio"].sel(alternative=name))


def _range(values: Array) -> str:
    return span(values, lambda value: f"{value:.2f}") if values.size else DASH


def _off(study: xr.Dataset, name: str) -> float:
    """Return how far these medians are from 1 at most, as a logarithm."""
    values: Array = np.abs(np.log(_peaks(study, name)))
    return float(np.max(values, initial=0.0))


def _steps(study: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the step of the commands and the longest one, each with error and scatter of single impacts, at most."""
    steps = study["contact_step"].values
    picked = dict.fromkeys([int(np.argmin(np.abs(steps - CONTACT_STEP))), int(np.argmax(steps))])
    largest = {name: abs(study[f"impact_{name}"]).max("restitution").values for name in ("error", "scatter")}
    return [(plain(steps[at]), f"{largest['error'][at]:.3f}", f"{largest['scatter'][at]:.3f}") for at in picked]


def _rates(at: xr.Dataset, taken: str, changed: list[str]) -> dict[str, str]:
    """Return collapses missed and added at one e: of the stop, and the larger of restitution with a changed e."""
    missed, added = at["false_safe_rate"], at["false_collapse_rate"]
    return {
        "e": plain(at["restitution"]),
        "own": " and ".join(percent(rate.sel(alternative=taken)) for rate in (missed, added)),
        "changed": " and ".join(percent(rate.sel(alternative=changed).max()) for rate in (missed, added)),
    }


def _two_sided(study: xr.Dataset) -> dict[str, str]:
    """Return on which facades, and at which e, the two-sided wall's median intensity of collapse is the higher one."""
    ratio = study["two_sided_intensity_ratio"].sel(restitution=middle_of(study))
    e, higher = ratio["two_sided_restitution"].values, ratio > 1
    unsafe = {str(wall): e[higher.sel(wall=wall).values] for wall in ratio["wall"].values}
    safe = e[(ratio < 1).all("wall").values]
    return {
        "middle": plain(middle_of(study)),
        "unsafe": listed(f"{wall} (e = {listed(map(plain, at))})" for wall, at in unsafe.items() if at.size),
        "safe": listed(map(plain, safe)),
    }
