"""Time histories of one wall as labelled datasets: its free decay, or its response to a ground motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.errors import check, check_list, check_number, check_type
from rockdamp.histories.loads import count_steps, make_load
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers.newmark import Histories, default_step, simulate
from rockdamp.storage.dataset import describe


def free_decay(
    curve: TrilinearCurve,
    damping: Damping | Sequence[Damping],
    *,
    wall: Wall | Parapet | None = None,
    release_amplitude: float = 0.5,
    length: float = 20.0,
    step: float | None = None,
) -> xr.Dataset:
    """Compute the free decay of one wall after a release at rest.

    Parameters
    ----------
    curve : TrilinearCurve
        Of one wall.
    damping : Damping, or list of Damping
        A list is compared along ``damping_model``. A damper of several values has them along ``restitution`` (CR) or
        ``damping_ratio``.
    wall : Wall or Parapet, optional
        Adds what is in metres and seconds.
    release_amplitude : float
        u0/u_ins, less than a3. [-]
    length : float
        Of the history in tau = p t. [-]
    step : float, optional
        Longest step of the solver in tau; by default 0.0025, and a 60th of the stability limit at most. [-]

    Returns
    -------
    xarray.Dataset
        ``displacement`` (u/u_ins) and ``velocity`` at each step ``tau``, ``peak``, ``peak_tau``, ``impacts``,
        ``collapsed`` and ``end_tau``. With a wall also ``control_displacement`` [m], ``control_velocity`` [m s-1],
        ``elapsed`` [s], ``peak_displacement`` [m], ``peak_elapsed`` and ``end_elapsed`` [s].

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.3, height=4.5)
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> decay = rd.free_decay(curve, rd.Damping("CR", [0.8, 0.9]), wall=wall)
    >>> dict(decay.control_displacement.sizes), decay.control_displacement.attrs["units"]
    ({'restitution': 2, 'tau': 8001}, 'm')
    """
    check_type("curve", curve, TrilinearCurve)
    dampings = check_list("damping", damping, Damping)
    if wall is not None:
        check_type("wall", wall, Wall, Parapet)
    length = check_number("length", length, lambda tau: tau > 0, "greater than 0")
    steps = int(count_steps(length, default_step(curve) if step is None else step))
    runs = [
        simulate(curve, each, step=length / steps, steps=steps, release_amplitude=release_amplitude)
        for each in dampings
    ]
    tau = length / steps * np.arange(steps + 1)
    decay = _assemble(runs, damping, curve, wall, tau)
    return describe(decay.assign(release_amplitude=float(release_amplitude)), "free_decay")


def respond(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    damping: Damping | Sequence[Damping],
    record: Record | GroundMotion,
    *,
    scale: ArrayLike = 1.0,
    tail: float = 0.0,
    step: float | None = None,
) -> xr.Dataset:
    """Compute the response of one wall to a record's motion, starting at rest.

    Parameters
    ----------
    wall : Wall or Parapet
    curve : TrilinearCurve
    damping : Damping, or list of Damping
        As for `free_decay`.
    record : Record or GroundMotion
        Of a `FloorMotion` the acceleration of the supports is taken.
    scale : float or ndarray, shape (scales,)
        Factor on the acceleration; several are along ``scale_factor``. [-]
    tail : float
        Rest after the record. [s]
    step : float, optional
        As for `free_decay`. [-]

    Returns
    -------
    xarray.Dataset
        As of `free_decay` with a wall, over ``elapsed``, the samples of the record, with ``ground_acceleration``.
        After a collapse the history is NaN.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(200)
    >>> pulse = rd.Record(
    ...     elapsed, np.where(elapsed < 0.5, 2 * np.sin(2 * np.pi * elapsed / 0.5), 0.0)
    ... )
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> response = rd.respond(
    ...     rd.Wall(0.3, 4.5), curve, rd.Damping("CDR", 0.05), pulse, scale=[1, 2], tail=1
    ... )
    >>> response.collapsed.values.tolist()
    [0, 0]
    """
    check_type("wall", wall, Wall, Parapet)
    check_type("curve", curve, TrilinearCurve)
    dampings = check_list("damping", damping, Damping)
    check_type("record", record, Record, GroundMotion)
    motion: Record = record.record if isinstance(record, GroundMotion) else record
    scale = check("scale", scale, np.isfinite, "a finite number")
    longest = default_step(curve) if step is None else step
    substeps = int(count_steps(wall.frequency_parameter * motion.step, longest))
    factor = np.reshape(scale, (*scale.shape, *(1 for _ in dampings[0].shape)))
    load = make_load(wall, motion, factor, substeps=substeps, tail=tail)
    runs = [simulate(curve, each, load=load, store_every=substeps) for each in dampings]
    ground = append_rest(motion.ground_acceleration, motion.step, tail)
    samples, start = np.arange(ground.size), motion.elapsed[0]
    scales = xr.Variable(("scale_factor",) * scale.ndim, scale)
    tau = float(wall.frequency_parameter) * motion.step * samples
    history = _assemble(runs, damping, curve, wall, tau, scales.dims, start)
    history = history.assign_coords(
        scale_factor=scales, elapsed=("tau", start + motion.step * samples)
    )
    history["ground_acceleration"] = scales * xr.Variable("tau", ground)
    return describe(
        history.swap_dims(tau="elapsed").assign_attrs(record_attributes(motion.header)), "response"
    )


# --- names ------------------------------------------------------------------------------------------------------------


def _assemble(
    runs: Sequence[Histories],
    damping: Damping | Sequence[Damping],
    curve: TrilinearCurve,
    wall: Wall | Parapet | None,
    tau: NDArray[Any],
    dims: tuple[Any, ...] = (),
    start: float = 0.0,
) -> xr.Dataset:
    """Name what the solver returned over `dims`, the damper's dimension and tau; with a wall in m and s too.

    `start` is the time of the first sample. [s]
    """
    coords: dict[str, Any]
    if isinstance(damping, Damping):
        name = "restitution" if damping.model == "CR" else "damping_ratio"
        own = (name,) * damping.value.ndim
        coords = {"damping_model": damping.label, name: (own, damping.value)}
        dims, results = (*dims, *own), dict(vars(runs[0]))
    else:
        dims = ("damping_model", *dims)
        is_cr, value = (
            [each.model == "CR" for each in damping],
            [float(each.value) for each in damping],
        )
        coords = {
            "damping_model": [each.label for each in damping],
            "restitution": ("damping_model", np.where(is_cr, value, np.nan)),
            "damping_ratio": ("damping_model", np.where(is_cr, np.nan, value)),
        }
        results = {name: np.stack([getattr(run, name) for run in runs]) for name in vars(runs[0])}
    results["collapsed"] = results["collapsed"].astype(np.int8)
    over_tau = ("displacement", "velocity")
    data = {
        name: ((*dims, "tau") if name in over_tau else dims, values)
        for name, values in results.items()
    }
    ratios = ("yield_displacement_ratio", "strength_ratio", "ultimate_displacement_ratio")
    constants = {name: float(getattr(curve, name)) for name in ratios}
    dataset = xr.Dataset(data | constants, {**coords, "tau": tau}, {"softening": curve.softening})
    if wall is None:
        return dataset
    sizes = ("thickness", "height", "frequency_parameter", "instability_displacement")
    dataset = dataset.assign({name: float(getattr(wall, name)) for name in sizes})
    if isinstance(wall, Wall):
        dataset["hinge_ratio"] = float(wall.hinge_ratio)
    p, u_ins = dataset["frequency_parameter"], dataset["instability_displacement"]
    return dataset.assign(
        control_displacement=u_ins * dataset["displacement"],
        control_velocity=u_ins * p * dataset["velocity"],
        peak_displacement=u_ins * dataset["peak"],
        peak_elapsed=start + dataset["peak_tau"] / p,
        end_elapsed=start + dataset["end_tau"] / p,
    ).assign_coords(elapsed=start + dataset["tau"] / p)


def record_attributes(header: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes that a dataset, and with it each figure, must state of its record."""
    attributes = {
        f"record_{key}": header.get(key, "not stated") for key in ("specimen", "source", "licence")
    }
    return {**attributes, "record_synthetic": header.get("synthetic", "no")}


# --- several records and scales ---------------------------------------------------------------------------------------


def scale_factors(record: Record, target: Mapping[str, Sequence[float]]) -> Array:
    """Return the factors on a record's acceleration. [-]

    `target` has one key: ``scale``, plain factors [-], or ``pga`` [m s-2] or ``pgv`` [m s-1], to which the record is
    scaled.
    """
    ((name, values),) = target.items()
    if name == "scale":
        return np.asarray(values, dtype=float)
    levels = check(f"--to-{name}", values, lambda level: level > 0, "greater than 0")
    return levels / getattr(intensity_measures(record), name)


def tabulate(
    motions: Iterable[GroundMotion],
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    target: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield a row for each record, scale and damper: the strength of the motion, the peak and how the history ends.

    ``pga`` [m s-2] and ``pgv`` [m s-1] are those of the scaled record; in a building, of the ground. ``damping_ratio``
    is None for restitution. `target` is as for `scale_factors`; `tail` is the rest after each record. [s]
    """
    for motion in motions:
        scales, measures = (
            scale_factors(motion.intensity_record, target),
            intensity_measures(motion.intensity_record),
        )
        ends = respond(wall, curve, dampings, motion, scale=scales, tail=tail).drop_dims("elapsed")
        for index, scale in enumerate(scales.tolist()):
            for damper in range(len(dampings)):
                yield {
                    "record": motion.name,
                    "scale": scale,
                    "pga": abs(scale) * measures.pga,
                    "pgv": abs(scale) * measures.pgv,
                    **summarise(ends.isel(damping_model=damper, scale_factor=index)),
                }


def summarise(history: xr.Dataset) -> dict[str, Any]:
    """Return the damper, the peak and the outcome of one history; ``damping_ratio`` is None for restitution."""
    xi = history["damping_ratio"].item()
    return {
        "damping_model": history["damping_model"].item(),
        "damping_ratio": None if np.isnan(xi) else xi,
        **{name: history[name].item() for name in ("peak_displacement", "peak", "peak_elapsed")},
        "outcome": "collapsed" if history["collapsed"] else "completed",
        "outcome_elapsed": history["end_elapsed"].item(),
    }
