"""Time histories as labelled datasets: a free decay, or the response to a record, of one wall or of a batch.

Parameters may be numbers, arrays, or arrays with named dimensions (``xarray.DataArray``), and broadcast by name. A
plain array is named after the parameter it is given for; plain arrays of one wall, curve or damper vary together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp import plausibility
from rockdamp.arguments import broadcast, instance, number, quantity, whole
from rockdamp.arrays import Array, Quantity, is_named
from rockdamp.errors import InputError, require
from rockdamp.histories.half_cycles import LEAST, half_cycles
from rockdamp.histories.loads import MOST_STEPS, Forcing, require_affordable, substeps_of
from rockdamp.histories.measured_test import record_attributes
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.questions import of_start
from rockdamp.solvers.newmark import Histories, simulate, stable_step
from rockdamp.storage.dataset import ATTRIBUTES, glossary
from rockdamp.vocabulary import OUTCOMES, REFERENCE

STEP = 0.0025  # in tau, at most: that of the studies
FINEST = 1 / 60  # of the stability limit, for curves stiffer than the studies'
LENGTH = 30.0  # in tau: half a dozen impacts and more
HISTORY = ("displacement", "velocity")
TAKEN = (
    *HISTORY,
    *(f"control_{name}" for name in HISTORY),
    *("peak", "peak_displacement", "impacts", "outcome", "ground_acceleration"),
    *("tau", "peak_tau", "outcome_tau", "elapsed", "peak_elapsed", "outcome_elapsed", "damping_model"),
)


def free_decay(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    wall: Wall | Parapet | None = None,
    release_amplitude: Quantity = 0.5,
    length: float | None = None,
    points: int = 1001,
    step: float | None = None,
) -> xr.Dataset:
    """Compute the free decay after a release at rest.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
    wall : Wall or Parapet, optional
        Gives the result its units: m and s in place of u/u_ins and tau.
    release_amplitude : float, ndarray or DataArray
        u0/u_ins, less than a3. [-]
    length : float, optional
        Of the history: in tau, or with a wall in seconds. By default 30/p, in tau 30. [-] or [s]
    points : int
        Number of times at which the history is returned, both ends included.
    step : float, optional
        Longest step of the solver in tau; by default 0.0025, and a 60th of the stability limit at most. [-]

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``velocity`` over ``tau``, or with a wall ``control_displacement`` [m] and
        ``control_velocity`` over ``elapsed``, with peaks, number of impacts and outcome.

    Raises
    ------
    InputError
        If a value lies outside its range, or parameters have unlike values along a dimension that they share.

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.3, height=4.5)
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> decay = rd.free_decay(curve, rd.Damping("CR", [0.8, 0.9]), wall=wall)
    >>> dict(decay.control_displacement.sizes)
    {'restitution': 2, 'elapsed': 1001}
    >>> decay.control_displacement.attrs["units"]
    'm'
    """
    points = whole("points", points, 2, MOST_STEPS + 1)
    batch = _Batch(wall, curve, damping, {"release_amplitude": release_amplitude})
    plausibility.warn(of_start(batch.values["release_amplitude"], batch.curve.yield_displacement_ratio))
    length = LENGTH / float(batch.frequency.min()) if length is None else number("length", length)
    require(length > 0, "length", length, "greater than 0")
    spacing = length / (points - 1)
    every = batch.steps_within(spacing, step, points - 1)
    response = simulate(
        batch.curve,
        batch.damping,
        release_amplitude=batch.values["release_amplitude"],
        step=batch.frequency * spacing / every,
        steps=every * (points - 1),
        store_every=every,
    )
    return batch.dataset(response, spacing * np.arange(points)).pipe(described)


def respond(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    damping: Damping,
    record: Record | GroundMotion,
    *,
    scale: Quantity = 1.0,
    tail: float = 0.0,
    step: float | None = None,
    histories: bool = True,
) -> xr.Dataset:
    """Compute the response of a wall to a record's motion, starting at rest.

    Parameters
    ----------
    wall : Wall or Parapet
    curve, damping : TrilinearCurve, Damping
    record : Record or GroundMotion
        Of which the acceleration is used, of a `FloorMotion` that of the supports.
    scale : float, ndarray or DataArray
        Factor on the ground acceleration; in the dataset it is ``scale_factor``. [-]
    tail : float
        Rest after the end of the record. [s]
    step : float, optional
        Longest step of the solver in tau; by default 0.0025, and a 60th of the stability limit at most. [-]
    histories : bool
        Whether to return the histories. Without them memory does not grow with the length of the record.

    Returns
    -------
    xarray.Dataset
        ``control_displacement`` [m] and ``control_velocity`` over ``elapsed`` (the samples of the record) and the
        dimensions of the parameters, ``ground_acceleration``, peaks, number of impacts and outcome. After a collapse
        the history is NaN. Without histories the same peaks, impacts and outcomes alone.

    Raises
    ------
    InputError
        If a value lies outside its range, or parameters have unlike values along a dimension that they share.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(200)
    >>> pulse = rd.Record(elapsed, np.where(elapsed < 0.5, 2 * np.sin(2 * np.pi * elapsed / 0.5), 0.0))
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> response = rd.respond(rd.Wall(0.3, 4.5), curve, rd.Damping("CDR", 0.05), pulse, scale=[1, 2], tail=1)
    >>> response.outcome.values.tolist()
    ['completed', 'completed']
    """
    instance("wall", wall, Wall, Parapet)
    taken: Record = instance("record", getattr(record, "record", record), Record)  # of a ground motion its own
    batch = _Batch(wall, curve, damping, {"scale_factor": quantity("scale", scale)})
    forcing = Forcing.from_record(batch.wall or wall, taken, batch.values["scale_factor"], tail=tail)
    motion = forcing.ground_acceleration
    warn_of_motion(motion, batch.values["scale_factor"])
    substeps = batch.steps_within(taken.step, step, forcing.intervals)
    every = substeps if histories else substeps * forcing.intervals
    response = simulate(batch.curve, batch.damping, load=forcing.newmark(substeps), store_every=every)
    _question_rest(batch, response, motion)
    if histories:
        end = response.displacement[..., -1], response.velocity[..., -1]
        plausibility.warn(plausibility.of_end(batch.curve.energy, response.peak, *end))
    history = batch.dataset(response, taken.elapsed[0] + taken.step * np.arange(motion.size), histories)
    if not histories:
        return history.pipe(described)
    scaled = batch.parameters["scale_factor"].variable * xr.Variable("elapsed", motion)
    return history.assign(ground_acceleration=scaled.to_base_variable()).pipe(described)


def warn_of_motion(ground: Array, scale: Array) -> None:
    """Warn where the motion is likely in another unit at every scale: of many, some may be meant to go far."""
    pga = float(np.abs(ground).max())
    doubts = [doubt for factor in np.ravel(scale) for doubt in plausibility.of_motion(pga, scale=float(factor))]
    plausibility.warn(doubts[:1] if len(doubts) == np.size(scale) else [])


def _question_rest(batch: _Batch, response: Histories, ground: Array) -> None:
    """Ask whether a motion that rocks no wall of the batch was meant in g, where that would."""
    a1 = batch.curve.yield_displacement_ratio
    if batch.wall is None or not response.peak.size or not (response.peak < a1).all():
        return
    pga = float(np.abs(ground).max() * np.abs(batch.values["scale_factor"]).max(initial=0.0))
    onset = float(np.min(batch.wall.rocking_onset(batch.curve.strength_ratio)))
    if plausibility.was_g(pga, onset):
        plausibility.warn(plausibility.of_response(response.peak, float(np.min(a1)), pga, onset))


class _Batch:
    """A wall, its curve, its damper and what else varies, broadcast by name to lanes of one shape.

    `parameters` are as they were passed, with named dimensions; `dims` are those of the lanes. All else has an element
    for each lane: `values` are the further parameters, `frequency` is p [rad s-1] and `u_ins` [m], both 1 without a
    wall.
    """

    def __init__(
        self, wall: Wall | Parapet | None, curve: TrilinearCurve, damping: Damping, others: Mapping[str, Quantity]
    ) -> None:
        if wall is not None:
            instance("wall", wall, Wall, Parapet)
            e = damping.value if damping.model == "CR" else 0.0
            plausibility.warn(plausibility.of_sizes(e, wall.restitution_rigid))
        instance("curve", curve, TrilinearCurve)
        instance("damping", damping, Damping)
        plausibility.warn(plausibility.of_dampings([damping]))
        others = {name: quantity(name, value) for name, value in others.items()}
        self.parameters = _names(_parameters(wall)) | _names(_parameters(curve))
        self.parameters |= _names({name: getattr(damping, field) for name, field in _fields(damping).items()})
        for name, value in others.items():
            self.parameters |= _names({name: value})
        try:
            together = xr.broadcast(*xr.align(*self.parameters.values(), join="exact", copy=False))
        except ValueError as error:
            raise InputError(f"parameters have unlike values along a dimension that they share: {error}") from None
        broadcast(**dict(zip(self.parameters, together, strict=True)))
        lanes: dict[str, Any] = {name: array.values for name, array in zip(self.parameters, together, strict=True)}
        self.dims, self.model = together[0].dims, damping.model
        for dim in {*self.dims} & {*TAKEN}:
            raise InputError(f"a dimension is called {dim!r}, as a part of the result; it must have another name")
        with plausibility.as_meant():  # it was warned of when it was made
            self.wall = None if wall is None else replace(wall, **{name: lanes[name] for name in _parameters(wall)})
        self.curve = replace(curve, **{name: lanes[name] for name in _parameters(curve)})
        self.damping = replace(damping, **{field: lanes[name] for name, field in _fields(damping).items()})
        self.values = {name: lanes[name] for name in others}
        self.frequency = np.ones(()) if self.wall is None else np.asarray(self.wall.frequency_parameter)
        self.u_ins = np.ones(()) if self.wall is None else np.asarray(self.wall.instability_displacement)

    def steps_within(self, spacing: float, step: float | None, times: int) -> int:
        """Return the solver's steps between two of so many times, `spacing` apart in s, or without a wall in tau."""
        longest = np.minimum(STEP, FINEST * stable_step(self.curve)) if step is None else number("step", step)
        require(np.greater(longest, 0), "step", longest, "greater than 0")
        between = substeps_of(self.frequency * spacing, longest).max(initial=1.0)
        require_affordable(float(between) * times, f"the length is {spacing * times:g}")
        return int(between)

    def dataset(self, response: Histories, time: NDArray[Any], histories: bool = True) -> xr.Dataset:
        """Name what the solver returned; with a wall in m and s."""
        clock = "tau" if self.wall is None else "elapsed"
        variables: dict[str, Any] = {}
        if histories:
            of = "" if self.wall is None else "control_"  # in metres the hinge's, or the top's of a parapet
            u_ins, speed = self.u_ins[..., None], (self.u_ins * self.frequency)[..., None]
            variables[f"{of}displacement"] = ((*self.dims, clock), u_ins * response.displacement)
            variables[f"{of}velocity"] = ((*self.dims, clock), speed * response.velocity)
        variables |= {
            "peak": (self.dims, response.peak),
            f"peak_{clock}": (self.dims, time[0] + response.peak_tau / self.frequency),
            "impacts": (self.dims, response.impacts),
            "outcome": (self.dims, np.asarray(OUTCOMES)[response.collapsed.astype(int)]),
            f"outcome_{clock}": (self.dims, time[0] + response.end_tau / self.frequency),
        }
        if self.wall is not None:
            variables["peak_displacement"] = (self.dims, self.u_ins * response.peak)
        short = {name: _shortened(name, array) for name, array in self.parameters.items()}
        varied = {name: array for name, array in short.items() if array.ndim}
        fixed = {name: float(array) for name, array in short.items() if not array.ndim}
        coords = {"damping_model": self.model, **varied}
        coords |= {clock: time} if histories else {}
        attrs = {"title": "Time history of a rocking wall", "softening": self.curve.softening, **fixed}
        return xr.Dataset(variables, coords=coords, attrs=attrs)


def _parameters(owner: Wall | Parapet | TrilinearCurve | None) -> dict[str, Quantity]:
    """Return the numbers that make a wall or a curve, by name."""
    values = {field.name: getattr(owner, field.name) for field in fields(owner)} if owner is not None else {}
    return {name: value for name, value in values.items() if not isinstance(value, str)}


def _fields(damping: Damping) -> dict[str, str]:
    """Return the fields of a damper by the names of its parameters in a dataset."""
    names = {"restitution" if damping.model == "CR" else "damping_ratio": "value"}
    names |= {name: name for name in ("order", "width") if name in DAMPERS[damping.model].takes}
    return names | ({"exponent": "loss_exponent", "at": "reference_amplitude"} if damping.loss_exponent.any() else {})


def _names(values: Mapping[str, Quantity]) -> dict[str, xr.DataArray]:
    """Return parameters with named dimensions; plain arrays share one, named after the first of them."""
    plain = {name: np.asarray(value) for name, value in values.items() if np.ndim(value) and not is_named(value)}
    for name, array in plain.items():
        require(
            array.ndim == 1, f"the number of dimensions of {name}", array.ndim, "1, or named in an xarray.DataArray"
        )
    first = next(iter(plain), "")
    along = dict(zip(plain, np.broadcast_arrays(*plain.values()), strict=True))
    coords = {first: along[first]} if plain else {}
    return {
        name: xr.DataArray(along[name], dims=first, coords=coords) if name in plain else xr.DataArray(value)
        for name, value in values.items()
    }


def _shortened(name: str, array: xr.DataArray) -> xr.DataArray:
    """Drop dimensions along which a parameter does not vary, which its owner gave it beside others that do."""
    for dim in (dim for dim in array.dims if dim != name):
        if (array == array.isel({dim: 0})).all():
            array = array.isel({dim: 0}, drop=True)
    return array


def described(dataset: xr.Dataset, texts: Mapping[str, Mapping[str, str]] | None = None) -> xr.Dataset:
    """Add units and meaning to the variables that have an entry of the glossary, or of `texts`."""
    texts = glossary()["names"] if texts is None else texts
    for name in texts.keys() & set(map(str, dataset.variables)):
        dataset[name].attrs = {key: texts[name][key] for key in ATTRIBUTES if key in texts[name]}
    return dataset


# --- several damping models -------------------------------------------------------------------------------------------
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
    sizes = ["thickness", "height", "frequency_parameter", "instability_displacement"]
    sizes += ["hinge_ratio"] if isinstance(wall, Wall) else []
    shape: dict[str, Any] = {name: float(getattr(wall, name)) for name in sizes}
    u_ins, p = shape["instability_displacement"], shape["frequency_parameter"]
    end, speed = (histories[f"control_{name}"].values[..., -1] / u_ins for name in ("displacement", "velocity"))
    plausibility.warn(plausibility.of_end(curve.energy, histories["peak"].values, end, speed / p))
    return histories.assign(
        ground_acceleration=("elapsed", runs[0]["ground_acceleration"].values), scale_factor=float(scale), **shape
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
    parameters: dict[str, Any] = {
        name: (
            "damping_model",
            [
                float(damping.value) if (damping.model == REFERENCE) == (name == "restitution") else np.nan
                for damping in dampings
            ],
        )
        for name in ("restitution", "damping_ratio")
    }
    parameters |= {name: float(getattr(curve, name)) for name in RULES}
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


# --- several records and scales ---------------------------------------------------------------------------------------

OF_ROW = ("peak_displacement", "peak", "peak_elapsed", "outcome", "outcome_elapsed")


def scales_of(record: Record, asked: Mapping[str, Sequence[float]]) -> Array:
    """Return the factors on a record's acceleration.

    `asked` has one key: ``scale``, plain factors [-], or ``pga`` [m s-2] or ``pgv`` [m s-1], to which the record is
    scaled.
    """
    ((kind, values),) = asked.items()
    if kind == "scale":
        return np.asarray(values, dtype=float)
    for value in values:
        require(value > 0, f"--to-{kind}", value, "greater than 0")
    return np.asarray(values, dtype=float) / getattr(intensity_measures(record), kind)


def rows(
    motions: Iterable[GroundMotion],
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    asked: Mapping[str, Sequence[float]],
    tail: float,
) -> Iterator[dict[str, Any]]:
    """Yield the peaks and the outcome of a wall under each record, at each scale and under each damping model.

    ``pga`` [m s-2] and ``pgv`` [m s-1] are those of the scaled record; in a building, of the ground. ``damping_ratio``
    is None for restitution; those of `OF_ROW` are as of `respond`. `asked` is as for `scales_of`; `tail` is the rest
    after each record. [s]
    """
    for motion in motions:
        scale, measures = scales_of(motion.intensity_record, asked), intensity_measures(motion.intensity_record)
        warn_of_motion(motion.record.ground_acceleration, scale)
        with plausibility.as_meant():  # one record of several may be too weak to rock the wall
            runs = [
                respond(wall, curve, each, motion.record, scale=scale, tail=tail, histories=False) for each in dampings
            ]
        for index, factor in enumerate(scale.tolist()):
            for damping, run in zip(dampings, runs, strict=True):
                yield {
                    "record": motion.name,
                    "scale": factor,
                    "pga": abs(factor) * measures.pga,
                    "pgv": abs(factor) * measures.pgv,
                    "damping_model": damping.model,
                    "damping_ratio": None if damping.model == REFERENCE else float(damping.value),
                    **{name: run[name].values[index].item() for name in OF_ROW},
                }
