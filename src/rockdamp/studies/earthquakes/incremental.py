"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same intensities of each wall, `scale` = lambda PGV/(p u_ins): the velocity that the
motion gives the wall over the one that carries a rigid wall to its instability, so that one set of scales takes every
wall from rest to collapse. Everything else is dimensionless as in the kernels.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. The
finest is published; what the halvings change bounds its error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import EXCITATION_FACTOR, Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import IntensityMeasures, intensity_measures, spectral_acceleration
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Comparison, Histories, Options, Reference, Response
from rockdamp.studies.earthquakes.settings import EarthquakeRecordSettings, EarthquakeWallSettings
from rockdamp.studies.matches import match_decays
from rockdamp.studies.settings import NamedWall
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

SOURCES = ("fit", "error", "closed form")  # of the damping ratio: polynomials, Eq. (17) at that wall, energy
HALVINGS = 2
VARIATIONS = ("step", "impact", "lower e", "higher e")
MEASURES = ("pga", "pgv", "pgd", "arias", "strong_duration")

HISTORY = ("record", "scale", "wall", "restitution")
BY_DAMPER = (*HISTORY, "damping_model", "damping_ratio_source")


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    Parameters
    ----------
    config : dict
        Has the keys of `EarthquakeWallSettings`.
    equivalence : xarray.Dataset
        With ``coefficient`` (damping_model, cracked_stiffness_ratio, degree) of the polynomials xi(e).

    Returns
    -------
    xarray.Dataset
        ``damping_ratio`` (wall, restitution, damping_model, damping_ratio_source), NaN for CR and beyond the range
        of the polynomials, and what describes each wall.
    """
    given = EarthquakeWallSettings.of(config)
    ratio = np.full((len(given.walls), given.restitution.size, len(MODELS), len(SOURCES)), np.nan)
    ratio[:, :, 1:] = _damping_ratios(given, Polynomials.of(equivalence))
    made = [(named.wall, named.curve) for named in given.walls]
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
        for name in ("cracked_stiffness_ratio", "plateau_ratio")
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
            "wall": [named.name for named in given.walls],
            "restitution": given.restitution,
            "damping_model": list(MODELS),
            "damping_ratio_source": list(SOURCES),
        },
    )


def _damping_ratios(given: EarthquakeWallSettings, polynomials: Polynomials) -> Array:
    """Damping ratios, shape (walls, e, viscous models, sources)."""
    count, e = len(given.walls), given.restitution
    a1, b1, a3 = (
        np.array([float(getattr(named.curve, name)) for named in given.walls])
        for name in ("cracked_stiffness_ratio", "plateau_ratio", "ultimate_ratio")
    )
    curves, each_e = TrilinearCurve(a1, b1, a3).map(lambda parameter: np.repeat(parameter, e.size)), np.tile(e, count)
    amplitude = np.full(each_e.size, given.release_amplitude)
    step, scheme, label = given.solver.step, given.solver.scheme, "Damping ratios of the walls"
    matched = match_decays(
        curves, amplitude, each_e, VISCOUS_MODELS, given.matching, step=step, scheme=scheme, description=label
    )
    ratio = np.empty((count, e.size, len(VISCOUS_MODELS), len(SOURCES)))
    for column, model in enumerate(VISCOUS_MODELS):
        by_source = {
            "fit": np.stack([polynomials(model, e, own) for own in a1]),
            "error": matched[model].damping_ratio,
            "closed form": damping_ratio_energy(curves, model, each_e, amplitude),
        }
        for place, source in enumerate(SOURCES):
            ratio[:, :, column, place] = by_source[source].reshape(count, e.size)
    return ratio


# --- the ground motions -----------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's share of the records.

    Parameters
    ----------
    number : str
        Of the job, from 0.
    config : dict
        Has the keys of `EarthquakeRecordSettings`.
    walls : xarray.Dataset
        Of `walls`.

    Returns
    -------
    xarray.Dataset
        ``peak_displacement``, ``collapsed``, ``settled``, ``peak_displacement_uncertainty`` and ``decay_misfit``
        (record, scale, wall, restitution, damping_model, damping_ratio_source); ``varied_peak`` and
        ``varied_collapsed`` (record, scale, wall, restitution, variation) of CR; intensity measures (record).
    """
    given = EarthquakeRecordSettings.of(config)
    size = given.records_per_job
    mine = catalogue.listing(given.records)[int(number) * size : (int(number) + 1) * size]
    study = _Study(given, walls["restitution"].values, walls["damping_ratio"].values)
    shares = [study.run(catalogue.read(entry)) for entry in track(mine, f"Records {int(number) + 1}")]
    return xr.concat(shares, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")


def gather(config: Config, walls: xr.Dataset, *shares: xr.Dataset) -> xr.Dataset:
    """Join the walls and the jobs' shares of the records, in the order of the records."""
    joined = xr.concat(shares, "record", data_vars="minimal", coords="minimal", compat="override", join="exact")
    return joined.merge(walls, join="exact", combine_attrs="drop")


@dataclass(frozen=True)
class _Study:
    """What the records of a job share."""

    given: EarthquakeRecordSettings
    restitution: Array
    damping_ratio: Array  # (wall, e, model, source)

    def run(self, motion: catalogue.GroundMotion) -> xr.Dataset:
        """Run one record, for every wall, scale, e and damper."""
        intensity = intensity_measures(motion.record)
        per_wall = [
            self._of_wall(named, ratio, motion.record, intensity)
            for named, ratio in zip(self.given.walls, self.damping_ratio, strict=True)
        ]
        dims = {
            **dict.fromkeys(
                ("peak_displacement", "peak_displacement_uncertainty", "collapsed", "settled", "decay_misfit"),
                BY_DAMPER[1:],
            ),
            **dict.fromkeys(("varied_peak", "varied_collapsed"), (*HISTORY[1:], "variation")),
            "scale_factor": ("scale", "wall"),
            "load_ratio": ("scale", "wall"),
            "spectral_acceleration": ("wall",),
        }
        data: dict[str, Any] = {
            name: (of, np.stack([values[name] for values in per_wall], axis=of.index("wall")))
            for name, of in dims.items()
        }
        data |= {name: ((), float(getattr(intensity, name))) for name in MEASURES}
        data |= {"pulse_period": ((), float(motion.pulse_period)), "sampling_step": ((), motion.record.step)}
        coords = {
            "scale": self.given.scale,
            "wall": [named.name for named in self.given.walls],
            "restitution": self.restitution,
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

    def _of_wall(
        self, named: NamedWall, damping_ratio: Array, record: Record, intensity: IntensityMeasures
    ) -> dict[str, Array]:
        """All histories of one wall under one record; arrays without the dimensions record and wall."""
        wall, curve, given = named.wall, named.curve, self.given
        p, u_ins = float(wall.frequency_parameter), float(wall.instability_displacement)
        unit = p * u_ins / EXCITATION_FACTOR
        factor = given.scale * unit / intensity.pgv
        case = _Case.of(wall, curve, record, factor, strong_end=intensity.strong_end, step=given.step, tail=given.tail)
        return {
            **case.by_damper(self.restitution, damping_ratio),
            **case.varied(self.restitution, given.restitution_change),
            "scale_factor": factor,
            "load_ratio": factor * intensity.pga / (float(curve.plateau_ratio) * p * unit),
            "spectral_acceleration": spectral_acceleration(record, 2 * np.pi / (p * float(curve.initial_frequency))),
        }


# --- one wall under one record ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Case:
    """One wall under one record, at every scale.

    Attributes
    ----------
    curve : TrilinearCurve
    load_factor : ndarray, shape (scales,)
        What times the record's acceleration is the dimensionless load. [s2 m-1]
    ground : ndarray
        The record, and rest after it. [m s-2]
    sampling : float
        Of the record, in tau. [-]
    substeps : int
        Of the coarsest run, between two samples.
    decay : int
        The sample at which the strong motion has ended.
    """

    curve: TrilinearCurve
    load_factor: Array
    ground: Array
    sampling: float
    substeps: int
    decay: int

    @classmethod
    def of(
        cls,
        wall: Wall | Parapet,
        curve: TrilinearCurve,
        record: Record,
        factor: Array,
        *,
        strong_end: float,
        step: float,
        tail: float,
    ) -> _Case:
        """Scale the record by each of `factor`; its strong motion ends at `strong_end`, the `step` is the finest's."""
        sampling = float(wall.frequency_parameter) * record.step
        coarsest = 2**HALVINGS * step / float(curve.initial_frequency)
        return cls(
            curve,
            float(wall.load_factor) * factor,
            followed_by_rest(record.ground_acceleration, record.step, tail),
            sampling,
            int(np.ceil(sampling / coarsest)),
            int(np.ceil((strong_end - record.elapsed[0]) / record.step)),
        )

    def __call__(self, damping: Damping, halving: int, scheme: str = "newmark") -> Response:
        """Run dampers of shape (e, ...) at every scale: a batch of shape (scales, e, ...)."""
        return solve(self.curve, damping, **self._forced(damping, halving, scheme))

    def histories(self, damping: Damping) -> Histories:
        """Run dampers at the coarsest step and keep their histories."""
        return solve(self.curve, damping, store_every=1, **self._forced(damping, 0))

    def compared(self, damping: Damping, reference: Reference) -> Comparison:
        """Run dampers at the coarsest step and compare their histories with the reference."""
        return solve(self.curve, damping, reference=reference, **self._forced(damping, 0))

    def _forced(self, damping: Damping, halving: int, scheme: str = "newmark") -> Options:
        substeps = self.substeps * 2**halving
        load_factor = self.load_factor.reshape(-1, *(1 for _ in damping.shape))
        return {
            "step": self.sampling / substeps,
            "steps": substeps * (self.ground.size - 1),
            "load_factor": load_factor,
            "ground_acceleration": self.ground,
            "substeps": substeps,
            "scheme": scheme,
        }

    def by_damper(self, e: Array, damping_ratio: Array) -> dict[str, Array]:
        """Peaks, collapses and misfits over the decay; shape (scales, e, models, sources)."""
        shape = (self.load_factor.size, e.size, len(MODELS), len(SOURCES))
        names = ("peak_displacement", "peak_displacement_uncertainty", "decay_misfit")
        outcome = {name: np.full(shape, np.nan) for name in names}
        outcome |= {name: np.zeros(shape, dtype=np.int8) for name in ("collapsed", "settled")}
        histories = self.histories(Damping.cr(e))
        reference = self._reference(histories)
        for name, values in self._judge([histories, *self._refined(Damping.cr(e))]).items():
            outcome[name][:, :, 0] = values[..., None]  # the same whatever the source
        stands, peak = outcome["collapsed"][:, :, 0, 0] == 0, outcome["peak_displacement"][:, :, 0, 0]
        for row, model in enumerate(VISCOUS_MODELS, start=1):
            defined = np.isfinite(damping_ratio[:, row]).all(axis=0)
            damping = Damping(model, damping_ratio[:, row, defined])
            compared = self.compared(damping, reference)
            for name, values in self._judge([compared, *self._refined(damping)]).items():
                outcome[name][:, :, row, defined] = values
            outcome["decay_misfit"][:, :, row, defined] = self._decay_misfit(compared, peak, stands)
            outcome["collapsed"][:, :, row, ~defined] = -1
            outcome["settled"][:, :, row, ~defined] = -1
        return outcome

    def varied(self, e: Array, change: float) -> dict[str, Array]:
        """CR with a coarser step, the printed treatment of impacts, and e a little lower and higher; (scales, e, 4)."""
        finest = HALVINGS
        nearby = self(Damping.cr(e[:, None] + change * np.array([-1.0, 1.0])), finest)
        coarse, printed = self(Damping.cr(e), 0), self(Damping.cr(e), finest, "paper")
        peak = [coarse.peak, printed.peak, *np.moveaxis(nearby.peak, -1, 0)]
        outcome = [coarse.outcome, printed.outcome, *np.moveaxis(nearby.outcome, -1, 0)]
        return {
            "varied_peak": np.stack(peak, axis=-1),
            "varied_collapsed": (np.stack(outcome, axis=-1) == COLLAPSED).astype(np.int8),
        }

    def _refined(self, damping: Damping) -> list[Response]:
        """Run at each halving of the coarsest step."""
        return [self(damping, halving) for halving in range(1, HALVINGS + 1)]

    def _judge(self, responses: list[Response]) -> dict[str, Array]:
        """Peaks and outcomes of the finest step, and what the halvings say of their error."""
        finest, collapsed = responses[-1], np.stack([response.outcome == COLLAPSED for response in responses])
        settled = (collapsed == collapsed[-1]).all(axis=0)
        changes = np.abs(np.diff([response.peak for response in responses], axis=0)).max(axis=0)
        bound = np.where(settled & ~collapsed[-1], changes + self.roughness * finest.peak, np.nan)
        return {
            "peak_displacement": finest.peak,
            "peak_displacement_uncertainty": bound,
            "collapsed": collapsed[-1].astype(np.int8),
            "settled": settled.astype(np.int8),
        }

    @property
    def roughness(self) -> float:
        """(w1 h)^2/3 at the finest step: what a halving may hide by chance, as a fraction of the peak.

        Three times the median error of 8000 histories, whose changes, plus this, bounded 99.97 % of their errors.
        """
        step = self.sampling / (self.substeps * 2**HALVINGS)
        return (step * float(self.curve.initial_frequency)) ** 2 / 3

    def _reference(self, coarsest: Histories) -> Reference:
        """What Eq. (17) compares with: CR's histories at the coarsest step, summed up to the decay and to the end."""
        displacement = np.nan_to_num(coarsest.displacement.reshape(-1, coarsest.displacement.shape[-1]))
        case = np.arange(displacement.shape[0]).reshape(*coarsest.displacement.shape[:-1], 1)
        steps = self.substeps * (self.ground.size - 1)
        checkpoints = [min(max(self.decay * self.substeps, 1), steps - 1), steps]
        return Reference(displacement, case, checkpoints)

    def _decay_misfit(self, coarsest: Comparison, reference_peak: Array, stands: ArrayLike) -> Array:
        """Root mean square of the difference in |u| after the strong motion, over CR's peak; NaN after a collapse."""
        steps = self.substeps * (self.ground.size - 1 - self.decay)
        both = np.asarray(stands)[..., None] & (coarsest.outcome != COLLAPSED)
        error = np.where(both, coarsest.error, 0.0)
        root = np.sqrt(np.maximum(error[1] - error[0], 0.0) / max(steps, 1))
        return np.where(both, root / reference_peak[..., None], np.nan)
