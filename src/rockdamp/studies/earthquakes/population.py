"""A population of walls under earthquakes: fragility with restitution and with every damper, and its sensitivity.

The walls are a Latin hypercube over the distributions of the config. Each is run under every record, scaled to the
same peak ground velocities. Jobs take chunks of the walls; their counts are added up without being held at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr, ndtri

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import PARAMETERS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.loads import peaks_and_collapses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.plausibility import as_meant
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import fragilities
from rockdamp.statistics.distribution import Distribution
from rockdamp.statistics.fragility import resample
from rockdamp.vocabulary import MODELS, REFERENCE, VISCOUS_MODELS

HARMONICS = 10  # of RBD-FAST, the usual number
FEWEST = 100  # walls: of fewer the indices are noise


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config) -> xr.Dataset:
    """Sample the walls, with the damping ratios of the closed form."""
    values = sample(config)
    wall, curve = mechanics(values)
    ratio = np.full((wall.thickness.size, len(MODELS)), np.nan)
    for column, model in enumerate(VISCOUS_MODELS, start=1):
        ratio[:, column] = damping_ratio_energy(curve, model, values["restitution"], config.release_amplitude)
    of_wall: dict[str, Array] = {
        **values,
        "instability_displacement": wall.instability_displacement,
        "frequency_parameter": wall.frequency_parameter,
        "initial_period": 2 * np.pi / (wall.frequency_parameter * curve.initial_frequency),
    }
    return xr.Dataset(
        {
            **{name: ("wall", value) for name, value in of_wall.items()},
            "damping_ratio": (("wall", "damping_model"), ratio),
        },
        coords={
            "wall": np.arange(wall.thickness.size),
            "damping_model": list(MODELS),
        },
    )


def sample(config: Config) -> dict[str, Array]:
    """Draw a Latin hypercube of the distributions, with the correlations of the settings.

    The ranks are correlated by a Gaussian copula: the hypercube's normal scores times the factor of the correlations.
    Each parameter keeps its distribution; without correlations each of its strata holds exactly one wall.
    """
    drawn, factor = _hypercube(config), _factor_of_correlations(config)
    scores = ndtri(drawn) @ factor.T
    uniform = np.where(np.all(factor == np.eye(len(PARAMETERS)), axis=1), drawn, ndtr(scores))
    distributions: list[Distribution] = [getattr(config.population.parameters, name) for name in PARAMETERS]
    return {
        name: of.quantile(uniform[:, i]) for i, (name, of) in enumerate(zip(PARAMETERS, distributions, strict=True))
    }


def _hypercube(config: Config) -> Array:
    """Return a Latin hypercube; shape (walls, parameters)."""
    section = config.population
    rng = np.random.default_rng(section.seed)
    from scipy.stats import qmc  # slow to import, and the chunks need none

    return np.asarray(qmc.LatinHypercube(len(PARAMETERS), rng=rng).random(section.walls))


def _factor_of_correlations(config: Config) -> Array:
    """Return the Cholesky factor of the correlations of the normal scores, which must not contradict each other."""
    section = config.population
    correlation = np.eye(len(PARAMETERS))
    for pair, value in section.correlations.items():
        row, column = (PARAMETERS.index(name) for name in pair)
        correlation[row, column] = correlation[column, row] = value
    try:
        return np.asarray(np.linalg.cholesky(correlation), dtype=float)
    except np.linalg.LinAlgError:
        stated = ", ".join(f"{value:g} of {name} with {other}" for (name, other), value in section.correlations.items())
        raise InputError(f"population.correlations are {stated}; no parameters can have all of them at once") from None


@as_meant()  # drawn from distributions that the config checks
def mechanics(values: dict[str, Array]) -> tuple[Wall, TrilinearCurve]:
    """Return the walls and the curves that the parameters describe."""
    wall = Wall(
        thickness=values["thickness"],
        height=values["thickness"] * values["slenderness"],
        hinge_ratio=values["hinge_ratio"],
        overburden_ratio=values["overburden_ratio"],
    )
    return wall, TrilinearCurve(values["yield_displacement_ratio"], values["strength_ratio"])


# --- a chunk of the walls ---------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run one job's chunk of the walls under every record, and count its collapses."""
    section = config.population
    size = section.chunk
    mine = walls.isel(wall=slice(int(number) * size, (int(number) + 1) * size))
    motions = catalogue.load_records(section.records)
    runs = [
        run(motion, mine, section.intensity, step=section.step, tail=section.tail)
        for motion in track(motions, f"Walls {int(number) + 1}")
    ]
    peak, collapsed = (np.stack(arrays, axis=1) for arrays in zip(*runs, strict=True))
    dims = ("wall", "record", "intensity", "damping_model")
    return xr.Dataset(
        {
            "peak": (dims, peak),
            "collapsed": (dims, collapsed.astype(np.int8)),
            "collapses": (dims[1:], collapsed.sum(axis=0)),
            "vulnerability": (("wall", "damping_model"), collapsed.mean(axis=(1, 2))),
        },
        coords={
            "wall": mine["wall"].values,
            "intensity": section.intensity,
            "damping_model": list(MODELS),
            "record": [motion.name for motion in motions],
            "station": ("record", [motion.group for motion in motions]),
        },
    )


def run(
    motion: catalogue.GroundMotion,
    walls: xr.Dataset,
    intensity: Array,
    *,
    step: float,
    tail: float,
    models: Sequence[str] = MODELS,
) -> tuple[Array, NDArray[np.bool_]]:
    """Run walls under one record at every intensity (PGV); peaks and collapses, shape (walls, intensities, models).

    `step` is the longest, times the angular frequency of the first branch; `tail` is the rest after the record. [s]
    """
    values = {name: walls[name].values for name in PARAMETERS}
    wall, curve = mechanics(values)
    factor = intensity / intensity_measures(motion.record).pgv
    dampings = [
        Damping.cr(values["restitution"])
        if model == REFERENCE
        else Damping(model, walls["damping_ratio"].sel(damping_model=model).values)
        for model in models
    ]
    return peaks_and_collapses(motion.record, wall, curve, dampings, factor, step=step, tail=tail)


# --- all of them ------------------------------------------------------------------------------------------------------


def gather(config: Config, walls: xr.Dataset, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Count up the chunks: fragility of the population, and the sensitivity of collapse to each parameter.

    Intervals are bootstrapped over the stations. Sensitivities of fewer than `FEWEST` walls are NaN.
    """
    bootstrap = config.population.bootstrap
    collapses = sum_of(part["collapses"] for part in chunks)
    vulnerability = np.concatenate([part["vulnerability"].values for part in chunks])
    first = chunks[0]
    count, intensity = walls.sizes["wall"], first["intensity"].values
    by_model = collapses.transpose("record", "damping_model", "intensity").values.astype(float)
    weights = resample(first["station"].values, bootstrap.replicates, bootstrap.seed)
    fitted = fragilities(intensity, by_model, count, weights, (..., slice(0, 1)))
    sensitivity, confidence = _sensitivity(walls, vulnerability, bootstrap.seed)
    fraction = collapses.sum("record").transpose("intensity", "damping_model") / (count * len(by_model))
    model = ("damping_model",)
    return xr.Dataset(
        {
            "collapse_fraction": (("intensity", *model), fraction.values),
            "median_intensity": (model, fitted["median"]),
            "median_intensity_interval": ((*model, "bound"), fitted["median_interval"]),
            "dispersion": (model, fitted["dispersion"]),
            "dispersion_interval": ((*model, "bound"), fitted["dispersion_interval"]),
            "median_intensity_ratio": (model, fitted["median_intensity_ratio"]),
            "median_intensity_ratio_interval": ((*model, "bound"), fitted["median_intensity_ratio_interval"]),
            "vulnerability": (("wall", *model), vulnerability),
            "first_order_index": (("parameter", *model), sensitivity),
            "first_order_index_confidence": (("parameter", *model), confidence),
            "records": len(by_model),
            **{name: walls[name] for name in PARAMETERS},
        },
        coords={
            "wall": walls["wall"].values,
            "intensity": intensity,
            "damping_model": list(MODELS),
            "bound": ["lower", "upper"],
            "parameter": list(PARAMETERS),
        },
    )


def sum_of(counts: Iterable[xr.DataArray]) -> xr.DataArray:
    """Add arrays one after the other, so that no more than two are in memory."""
    arrays = iter(counts)
    total = next(arrays).load()
    for count in arrays:
        total = total + count.load()
    return total


def _sensitivity(walls: xr.Dataset, vulnerability: Array, seed: int) -> tuple[Array, Array]:
    """Return first-order indices, the part of the variance that a parameter explains alone, and their confidence.

    RBD-FAST (Tarantola et al. 2006, doi:10.1016/j.ress.2005.06.003; Plischke 2010) takes any sample, so the walls that
    were run serve. The index of a correlated parameter includes what it shares with the others.
    """
    from SALib.analyze import rbd_fast

    names = list(PARAMETERS)
    x = np.column_stack([walls[name].values for name in names])
    bounds = [[float(low), float(high)] for low, high in zip(x.min(axis=0), x.max(axis=0), strict=True)]
    problem = {"num_vars": len(names), "names": names, "bounds": bounds}
    columns: list[tuple[ArrayLike, ArrayLike]] = []
    for y in vulnerability.T:
        if np.ptp(y) == 0 or len(y) < FEWEST:
            columns.append((np.full(len(names), np.nan),) * 2)
            continue
        indices = rbd_fast.analyze(problem, x, y, M=HARMONICS, num_resamples=100, seed=seed)
        columns.append((indices["S1"], indices["S1_conf"]))
    return np.column_stack([index for index, _ in columns]), np.column_stack([bound for _, bound in columns])
