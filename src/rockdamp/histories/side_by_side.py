"""One wall under several damping models: histories side by side in one dataset, as the command line stores them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rockdamp import plausibility
from rockdamp.arguments import number
from rockdamp.errors import InputError, require
from rockdamp.histories.forcing import require_affordable
from rockdamp.histories.half_cycles import LEAST, half_cycles
from rockdamp.histories.labelled import FINEST, STEP, free_decay, respond
from rockdamp.histories.measured_test import record_attributes
from rockdamp.mechanics.curve import TEXTS, TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.solvers.newmark import stable_step

DECAY = ("displacement", "velocity", "impacts", "outcome", "outcome_tau")
RESPONSE = (
    "control_displacement",
    "control_velocity",
    "peak_displacement",
    "peak",
    "peak_elapsed",
    "impacts",
    "outcome",
    "outcome_elapsed",
)


def decays(
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    *,
    release_amplitude: float = 0.5,
    length: float = 20.0,
    wall: Wall | Parapet | None = None,
) -> xr.Dataset:
    """Compute the free decay of one wall under each of several damping models, at each step of the solver.

    `length` is in tau. A wall adds the time in seconds, u_ins and p.
    """
    length, release_amplitude = number("length", length), number("release_amplitude", release_amplitude)
    require(length > 0, "length", length, "greater than 0 (in tau)")
    a3 = float(curve.ultimate_displacement_ratio)
    require(0 < release_amplitude < a3, "release_amplitude", release_amplitude, "greater than 0 and less than a3")
    steps = length / float(np.minimum(STEP, FINEST * stable_step(curve)))
    require_affordable(steps, f"length is {length:g}")
    points = max(int(np.ceil(steps)), 1) + 1
    plausibility.warn(plausibility.of_dampings(dampings))
    with plausibility.as_meant():
        runs = [
            free_decay(curve, damping, release_amplitude=release_amplitude, length=length, points=points)
            for damping in dampings
        ]
    histories = _side_by_side(runs, dampings, DECAY, curve).assign(release_amplitude=float(release_amplitude))
    if wall is None:
        return histories
    p, u_ins = float(wall.frequency_parameter), float(wall.instability_displacement)
    histories = histories.assign(frequency_parameter=p, instability_displacement=u_ins)
    return histories.assign_coords(elapsed=("tau", histories["tau"].values / p))


def responses(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    *,
    scale: float = 1.0,
    tail: float = 0.0,
) -> xr.Dataset:
    """Compute the response of one wall to a record under several damping models, at the samples of the record."""
    scale, tail = number("scale", scale), number("tail", tail)
    plausibility.warn(plausibility.of_dampings(dampings))
    pga = float(np.abs(record.ground_acceleration).max())
    if scale != 1:  # as it is, it was judged when it was read
        plausibility.warn(plausibility.of_motion(pga, scale=scale))
    with plausibility.as_meant():
        runs = [respond(wall, curve, damping, record, scale=scale, tail=tail) for damping in dampings]
    histories = _side_by_side(runs, dampings, RESPONSE, curve)
    a1, onset = float(curve.yield_displacement_ratio), float(wall.rocking_onset(curve.strength_ratio))
    plausibility.warn(plausibility.of_response(histories["peak"].values, a1, abs(scale) * pga, onset))
    shape: dict[str, Any] = {name: float(getattr(wall, name)) for name in ("thickness", "height")}
    if isinstance(wall, Wall):
        shape["hinge_ratio"] = float(wall.hinge_ratio)
    return histories.assign(
        ground_acceleration=("elapsed", runs[0]["ground_acceleration"].values),
        frequency_parameter=float(wall.frequency_parameter),
        instability_displacement=float(wall.instability_displacement),
        scale_factor=float(scale),
        **shape,
    ).assign_attrs(record_attributes(record))


def peaks(decay: xr.Dataset) -> list[dict[str, Any]]:
    """Return the peaks of `decays`: model, impacts before the peak, tau and u/u_ins; with a wall in s and m too.

    The first peak, the release, has no impact before it; the last half cycle, which has not ended, is left out.
    """
    rows = []
    with_wall = "elapsed" in decay.coords
    for model in map(str, decay["damping_model"].values):
        cycles = half_cycles(decay["tau"].values, decay["displacement"].sel(damping_model=model).values, LEAST)
        ended = np.isfinite(cycles.end)
        for impacts, (peak, tau) in enumerate(zip(np.abs(cycles.peak[ended]), cycles.peak_elapsed[ended], strict=True)):
            row = {"damping_model": model, "impacts": impacts, "tau": float(tau), "peak": float(peak)}
            if with_wall:
                row["elapsed"] = float(tau) / float(decay["frequency_parameter"])
                row["peak_displacement"] = float(peak) * float(decay["instability_displacement"])
            rows.append(row)
    return rows


def _side_by_side(
    runs: Sequence[xr.Dataset], dampings: Sequence[Damping], kept: Sequence[str], curve: TrilinearCurve
) -> xr.Dataset:
    """Stack histories of one wall along ``damping_model``."""
    for damping, run in zip(dampings, runs, strict=True):
        _require_numbers(damping.model, run)
    together = xr.concat(
        [run[list(kept)].drop_attrs() for run in runs],
        "damping_model",
        data_vars="all",
        coords="minimal",
        compat="override",
        join="exact",
    )
    names = ["restitution", "damping_ratio"]
    names += ["local_damping"] * any(damping.on_net_force for damping in dampings)
    parameters: dict[str, Any] = {
        name: ("damping_model", [float(damping.parameters.get(name, np.nan)) for damping in dampings]) for name in names
    }
    parameters |= {name: float(getattr(curve, name)) for name in TEXTS}
    return together.assign(parameters).assign_attrs(softening=curve.softening)


def _require_numbers(model: str, run: xr.Dataset) -> None:
    """Raise where a history that did not end in a collapse has NaN, or a peak is infinite: its input was too large."""
    completed = str(run["outcome"].item()) == "completed"
    history = [name for name in run if str(name).endswith(("displacement", "velocity")) and name != "peak_displacement"]
    whole = not completed or all(bool(np.isfinite(run[name]).all()) for name in history)
    if not (whole and np.isfinite(float(run["peak"]))):
        raise InputError(
            f"the response under {model} is beyond what floating point numbers hold; the load or the"
            " damping ratio is too large"
        )
