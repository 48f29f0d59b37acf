"""Time histories of one wall as labelled datasets: free decay and response to a ground motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.constants import REFERENCE
from rockdamp.errors import InputError, check, check_list, check_number, check_type
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
    """Compute the free decay of one wall after a release from rest.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve of one wall.
    damping : Damping, or list of Damping
        Restitution or viscous damper. A list is returned along the dimension ``damping_model``;
        several values of one damper along ``restitution`` (CR) or ``damping_ratio``.
    wall : Wall or Parapet, optional
        One wall; it adds results in metres and seconds.
    release_amplitude : float
        Displacement u0/u_ins of the release, less than a3. [-]
    length : float
        Length of the history in tau = p t. [-]
    step : float, optional
        Longest step of the solver in tau. The default is 0.0025, or 1/60 of the stability limit if
        this is less. [-]

    Returns
    -------
    xarray.Dataset
        ``displacement`` (u/u_ins) and ``velocity`` at each step ``tau``; ``peak``, ``peak_tau``,
        ``impacts``, ``collapsed`` and ``end_tau`` of each history. With a wall also
        ``control_displacement`` [m], that of the hinge or of the top of a parapet,
        ``control_velocity`` [m s-1], ``elapsed`` [s],
        ``peak_displacement`` [m], ``peak_elapsed`` and ``end_elapsed`` [s]. Every variable states
        its unit and meaning.

    Raises
    ------
    InputError
        If a number lies outside its range, or the list of dampers is empty.

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
    longest = default_step(curve) if step is None else step
    steps = int(count_steps(length, longest))
    solver_options: dict[str, Any] = {
        "step": length / steps,
        "steps": steps,
        "release_amplitude": release_amplitude,
    }
    runs = [simulate(curve, damper, **solver_options) for damper in dampings]
    tau = length / steps * np.arange(steps + 1)
    decay = _name_results(runs, damping).assign_coords(tau=tau)
    decay = _add_curve(decay, curve)
    if wall is not None:
        decay = _add_dimensions(decay, wall)
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
    """Compute the response of one wall to a ground motion, from rest.

    Parameters
    ----------
    wall : Wall or Parapet
        One wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    damping : Damping, or list of Damping
        Restitution or viscous damper. A list is returned along the dimension ``damping_model``;
        several values of one damper along ``restitution`` (CR) or ``damping_ratio``.
    record : Record or GroundMotion
        Acceleration of the supports. A motion from `floor_motions` moves each support with its
        floor.
    scale : float or ndarray, shape (scales,)
        Factor on the acceleration; several factors are returned along the dimension
        ``scale_factor``. [-]
    tail : float
        Time at rest after the record, at most 1000. [s]
    step : float, optional
        Longest step of the solver in tau = p t. The default is 0.0025, or 1/60 of the stability
        limit if this is less. [-]

    Returns
    -------
    xarray.Dataset
        ``displacement`` (u/u_ins), ``velocity``, ``control_displacement`` [m],
        ``control_velocity`` [m s-1] and ``ground_acceleration`` [m s-2] at each sample ``elapsed``
        of the record; ``peak``, ``peak_displacement`` [m], ``peak_elapsed`` [s], ``impacts``,
        ``collapsed`` and ``end_elapsed`` [s] of each history. After a collapse the history is NaN.

    Raises
    ------
    InputError
        If a number lies outside its range, the list of dampers is empty, the wall is one-sided, or
        a parapet is given the motion of two supports.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(200)
    >>> pulse = np.where(elapsed < 0.5, 2 * np.sin(4 * np.pi * elapsed), 0.0)
    >>> record = rd.Record(elapsed, pulse)
    >>> wall, curve = rd.Wall(0.3, 4.5), rd.TrilinearCurve(0.04, 0.85)
    >>> response = rd.respond(wall, curve, rd.Damping("CDR", 0.05), record, scale=[1, 2], tail=1)
    >>> response.collapsed.values.tolist()
    [0, 0]
    """
    check_type("wall", wall, Wall, Parapet)
    check_type("curve", curve, TrilinearCurve)
    dampings = check_list("damping", damping, Damping)
    check_type("record", record, Record, GroundMotion)
    motion: Record = record.record if isinstance(record, GroundMotion) else record
    scale = _check_scale(scale)
    longest = default_step(curve) if step is None else step
    substeps = int(count_steps(wall.frequency_parameter * motion.step, longest))
    # Scales come before the values of a damper.
    factor = scale.reshape(scale.shape + (1,) * len(dampings[0].shape))
    load = make_load(wall, motion, factor, substeps=substeps, tail=tail)
    runs = [simulate(curve, damper, load=load, store_every=substeps) for damper in dampings]
    ground = append_rest(motion.ground_acceleration, motion.step, tail)
    samples = np.arange(ground.size)
    start = motion.elapsed[0]
    scale_factor = xr.Variable(("scale_factor",) * scale.ndim, scale)
    history = _name_results(runs, damping, scale_factor.dims).assign_coords(
        tau=float(wall.frequency_parameter) * motion.step * samples, scale_factor=scale_factor
    )
    history = _add_dimensions(_add_curve(history, curve), wall, start)
    elapsed = xr.Variable("tau", start + motion.step * samples)
    history = history.assign_coords(elapsed=elapsed).swap_dims(tau="elapsed")
    history["ground_acceleration"] = scale_factor * xr.Variable("elapsed", ground)
    attributes = record_attributes(motion.header)
    return describe(history.assign_attrs(attributes), "response")


def _check_scale(scale: ArrayLike) -> Array:
    """Return scales as a number or an array of at least one. [-]"""
    factors = check("scale", scale, np.isfinite, "a finite number")
    if factors.ndim > 1:
        raise InputError(f"scale has the shape {factors.shape}; it must be a number or a list")
    return factors


# --- names ----------------------------------------------------------------------------------------


def damper_coordinates(
    dampings: Sequence[Damping], dimension: str = "damping_model"
) -> dict[str, Any]:
    """Return the coordinates of dampers along a dimension: label, family and parameter.

    Parameters
    ----------
    dampings : sequence of Damping
        Dampers in the order of the dimension.
    dimension : str
        Name of the dimension, which holds the labels, such as ECD16.
    """
    return {
        dimension: [damping.label for damping in dampings],
        "damper_family": (dimension, [damping.model for damping in dampings]),
        "damper_parameter": (dimension, [damping.family_parameter for damping in dampings]),
    }


def _name_results(
    runs: Sequence[Histories],
    damping: Damping | Sequence[Damping],
    scale_dims: tuple[Any, ...] = (),
) -> xr.Dataset:
    """Return the solver's results under their names, over the dampers, the scales and tau."""
    coords: dict[str, Any]
    if isinstance(damping, Damping):
        value_name = "restitution" if damping.model == REFERENCE else "damping_ratio"
        value_dims = (value_name,) * damping.value.ndim
        coords = {
            "damping_model": damping.label,
            "damper_family": damping.model,
            "damper_parameter": damping.family_parameter,
            value_name: (value_dims, damping.value),
        }
        dims = (*scale_dims, *value_dims)
        results = dict(vars(runs[0]))
    else:
        is_cr = np.array([damper.model == REFERENCE for damper in damping])
        values = np.array([float(damper.value) for damper in damping])
        coords = damper_coordinates(damping)
        coords["restitution"] = ("damping_model", np.where(is_cr, values, np.nan))
        coords["damping_ratio"] = ("damping_model", np.where(is_cr, np.nan, values))
        dims = ("damping_model", *scale_dims)
        results = {
            name: np.stack([getattr(histories, name) for histories in runs])
            for name in vars(runs[0])
        }
    results["collapsed"] = results["collapsed"].astype(np.int8)
    variables = {
        name: ((*dims, "tau") if name in ("displacement", "velocity") else dims, values)
        for name, values in results.items()
    }
    return xr.Dataset(variables, coords)


def _add_curve(history: xr.Dataset, curve: TrilinearCurve) -> xr.Dataset:
    """Add the ratios of a curve to its history."""
    names = ("yield_displacement_ratio", "strength_ratio", "ultimate_displacement_ratio")
    ratios = {name: float(getattr(curve, name)) for name in names}
    return history.assign(ratios).assign_attrs(softening=curve.softening)


def _add_dimensions(history: xr.Dataset, wall: Wall | Parapet, start: float = 0.0) -> xr.Dataset:
    """Add the wall's sizes and the results in metres and seconds; `start` is the first time. [s]"""
    names = ("thickness", "height", "frequency_parameter", "instability_displacement")
    sizes = {name: float(getattr(wall, name)) for name in names}
    if isinstance(wall, Wall):
        sizes["hinge_ratio"] = float(wall.hinge_ratio)
    history = history.assign(sizes)
    p = history["frequency_parameter"]
    u_ins = history["instability_displacement"]
    return history.assign(
        control_displacement=u_ins * history["displacement"],
        control_velocity=u_ins * p * history["velocity"],
        peak_displacement=u_ins * history["peak"],
        peak_elapsed=start + history["peak_tau"] / p,
        end_elapsed=start + history["end_tau"] / p,
    ).assign_coords(elapsed=start + history["tau"] / p)


def record_attributes(header: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes that a dataset, and each figure of it, must state of its record.

    Parameters
    ----------
    header : mapping of str
        Header of the record.
    """
    attributes = {
        f"record_{key}": header.get(key, "not stated") for key in ("specimen", "source", "licence")
    }
    return {**attributes, "record_synthetic": header.get("synthetic", "no")}


# --- several records and scales -------------------------------------------------------------------


def scale_factors(record: Record, target: Mapping[str, Sequence[float]]) -> Array:
    """Return the factors on a record's acceleration. [-]

    Parameters
    ----------
    record : Record
        Motion whose intensity counts.
    target : mapping
        One key: ``scale`` with plain factors [-], or ``pga`` [m s-2] or ``pgv`` [m s-1] with the
        intensities to which the record is scaled.
    """
    ((name, values),) = target.items()
    if name == "scale":
        return np.asarray(values, dtype=float)
    levels = check(name, values, lambda level: level > 0, "greater than 0")
    return levels / getattr(intensity_measures(record), name)


def tabulate(
    motions: Iterable[GroundMotion],
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    target: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield the peak and the outcome of a wall under each record, at each scale, with each damper.

    Parameters
    ----------
    motions : iterable of GroundMotion
        Motions of the ground, or of floors.
    wall : Wall or Parapet
        One wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    dampings : sequence of Damping
        Dampers of one value each.
    target : mapping
        Scales, or intensities to which the records are scaled, as in `scale_factors`.
    tail : float
        Rest after each record, at most 1000. [s]

    Yields
    ------
    dict
        ``record``, ``scale``, ``pga`` [m s-2] and ``pgv`` [m s-1] of the scaled record (in a
        building of the ground), and the values of `summarise`.
    """
    for motion in motions:
        measures = intensity_measures(motion.intensity_record)
        scales = scale_factors(motion.intensity_record, target)
        response = respond(wall, curve, dampings, motion, scale=scales, tail=tail)
        outcomes = response.drop_dims("elapsed")
        for index, scale in enumerate(scales.tolist()):
            for damper in range(len(dampings)):
                yield {
                    "record": motion.name,
                    "scale": scale,
                    "pga": abs(scale) * measures.pga,
                    "pgv": abs(scale) * measures.pgv,
                    **summarise(outcomes.isel(damping_model=damper, scale_factor=index)),
                }


def summarise(history: xr.Dataset) -> dict[str, Any]:
    """Return the damper, the peak and the outcome of one history.

    Parameters
    ----------
    history : xarray.Dataset
        One history from `respond`; ``damping_ratio`` is None for restitution.
    """
    xi = history["damping_ratio"].item()
    peaks = ("peak_displacement", "peak", "peak_elapsed")
    return {
        "damping_model": history["damping_model"].item(),
        "damping_ratio": None if np.isnan(xi) else xi,
        **{name: history[name].item() for name in peaks},
        "outcome": "collapsed" if history["collapsed"] else "survived",
        "outcome_elapsed": history["end_elapsed"].item(),
    }
