"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same velocity ratios of each wall, lambda PGV/(p u_ins): the velocity that the motion gives
the wall over the one that carries a rigid wall to its instability. One set of them takes every wall from rest to
collapse. `wall_under_record` runs the histories and bounds the error of their peaks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import NamedWall
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.mechanics.curve import TEXTS, TrilinearCurve
from rockdamp.mechanics.wall import Parapet
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import IntensityMeasures, intensity_measures
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.solvers.oscillator import spectral_acceleration
from rockdamp.studies.earthquakes.wall_under_record import SOURCES, VARIATIONS, Case, by_damper
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

MEASURES = ("pga", "pgv", "pgd", "arias", "strong_duration")

HISTORY = ("record", "velocity_ratio", "wall", "restitution")
BY_DAMPER = (*HISTORY, "damping_model", "damping_ratio_source")


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    The ratio is NaN for CR and beyond the range of the polynomials.
    """
    quakes = config.earthquakes
    ratio = np.full((len(quakes.walls), quakes.restitution.size, len(MODELS), len(SOURCES)), np.nan)
    ratio[:, :, 1:] = _damping_ratios(config, Polynomials.of(equivalence))
    made = [(named.wall, named.curve) for named in quakes.walls]
    of_wall: dict[str, Any] = {
        name: ("wall", [float(getattr(wall, name)) for wall, _ in made])
        for name in (
            "thickness",
            "height",
            "slenderness",
            "overburden_ratio",
            "instability_displacement",
            "frequency_parameter",
        )
    }
    of_wall |= {
        name: ("wall", [float(getattr(curve, name)) for _, curve in made])
        for name in ("yield_displacement_ratio", "strength_ratio")
    }
    w1 = np.array([float(wall.frequency_parameter * curve.initial_frequency) for wall, curve in made])
    return xr.Dataset(
        {
            "damping_ratio": (("wall", "restitution", "damping_model", "damping_ratio_source"), ratio),
            "parapet": ("wall", np.array([isinstance(wall, Parapet) for wall, _ in made], dtype=np.int8)),
            "initial_period": ("wall", 2 * np.pi / w1),
            **of_wall,
        },
        coords={
            "wall": [named.name for named in quakes.walls],
            "restitution": quakes.restitution,
            "damping_model": list(MODELS),
            "damping_ratio_source": list(SOURCES),
        },
    )


def _damping_ratios(config: Config, polynomials: Polynomials) -> Array:
    """Return damping ratios, shape (walls, e, viscous models, sources)."""
    quakes = config.earthquakes
    count, e = len(quakes.walls), quakes.restitution
    a1, b1, a3 = (np.array([float(getattr(named.curve, name)) for named in quakes.walls]) for name in TEXTS)
    curves, each_e = TrilinearCurve(a1, b1, a3).map(lambda parameter: np.repeat(parameter, e.size)), np.tile(e, count)
    amplitude = np.full(each_e.size, config.release_amplitude)
    step, scheme, label = config.solver.step, config.solver.scheme, "Damping ratios of the walls"
    matched = match_decays(
        curves, amplitude, each_e, VISCOUS_MODELS, config.matching, step=step, scheme=scheme, description=label
    )
    ratio = np.empty((count, e.size, len(VISCOUS_MODELS), len(SOURCES)))
    for column, model in enumerate(VISCOUS_MODELS):
        by_source = {
            "polynomial": np.stack([polynomials(model, e, own) for own in a1]),
            "least error": matched[model].damping_ratio,
            "closed form": damping_ratio_energy(curves, model, each_e, amplitude),
        }
        for place, source in enumerate(SOURCES):
            ratio[:, :, column, place] = by_source[source].reshape(count, e.size)
    return ratio


# --- the ground motions -----------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's share of the records; jobs are numbered from 0."""
    size = config.earthquakes.chunk
    mine = catalogue.listing(config.records)[int(number) * size : (int(number) + 1) * size]
    e, ratio = walls["restitution"].values, walls["damping_ratio"].values
    shares = [run(config, e, ratio, catalogue.read(entry)) for entry in track(mine, f"Records {int(number) + 1}")]
    return xr.concat(shares, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")


def gather(config: Config, walls: xr.Dataset, shares: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the walls and the jobs' shares of the records, in the order of the records."""
    joined = xr.concat(shares, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")
    return joined.merge(walls, join="exact", combine_attrs="drop")


def run(config: Config, restitution: Array, damping_ratio: Array, motion: catalogue.GroundMotion) -> xr.Dataset:
    """Run one record, for every wall, scale, e and damper; ratios have the shape (walls, e, models, sources)."""
    quakes = config.earthquakes
    intensity = intensity_measures(motion.record)
    factors = [quakes.velocity_ratio * float(named.wall.velocity_scale) / intensity.pgv for named in quakes.walls]
    cases = [
        Case.of(
            named.wall,
            named.curve,
            motion.record,
            factor,
            strong_end=intensity.strong_end,
            step=quakes.step,
            tail=quakes.tail,
        )
        for named, factor in zip(quakes.walls, factors, strict=True)
    ]
    by_wall = zip(quakes.walls, factors, cases, by_damper(cases, restitution, damping_ratio), strict=True)
    change = quakes.restitution_change
    per_wall = [
        peaks | case.varied(restitution, change) | _load(named, factor, motion.record, intensity)
        for named, factor, case, peaks in by_wall
    ]
    dims = {
        **dict.fromkeys(
            ("peak", "peak_uncertainty", "collapsed", "settled", "decay_misfit"),
            BY_DAMPER[1:],
        ),
        **dict.fromkeys(("varied_peak", "varied_collapsed"), (*HISTORY[1:], "variation")),
        "scale_factor": ("velocity_ratio", "wall"),
        "load_ratio": ("velocity_ratio", "wall"),
        "spectral_acceleration": ("wall",),
    }
    data: dict[str, Any] = {
        name: (of, np.stack([values[name] for values in per_wall], axis=of.index("wall"))) for name, of in dims.items()
    }
    data |= {name: ((), float(getattr(intensity, name))) for name in MEASURES}
    data |= {"pulse_period": ((), float(motion.pulse_period)), "sampling_step": ((), motion.record.step)}
    coords = {
        "velocity_ratio": quakes.velocity_ratio,
        "wall": [named.name for named in quakes.walls],
        "restitution": restitution,
        "damping_model": list(MODELS),
        "damping_ratio_source": list(SOURCES),
        "variation": list(VARIATIONS),
        "record": motion.name,
        "record_set": motion.record_set,
        "station": motion.group,
    }
    return (
        xr.Dataset(data, coords=coords)
        .expand_dims("record")
        .assign_coords({name: ("record", [coords[name]]) for name in ("record_set", "station")})
    )


def _load(named: NamedWall, factor: Array, record: Record, intensity: IntensityMeasures) -> dict[str, Array]:
    """Return the strength of a record for a wall; arrays over the scales, and one for the wall."""
    p = float(named.wall.frequency_parameter)
    yields = float(named.curve.strength_ratio) * p * float(named.wall.velocity_scale)
    w1 = p * float(named.curve.initial_frequency)
    return {
        "scale_factor": factor,
        "load_ratio": factor * intensity.pga / yields,
        "spectral_acceleration": spectral_acceleration(record, 2 * np.pi / w1),
    }
