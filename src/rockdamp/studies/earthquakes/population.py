"""A population of walls under earthquakes: fragility with restitution and with every damper, and what it depends on.

The walls are a Latin hypercube over the distributions of the config. Each is run under every record, scaled to the
same peak ground velocities. Jobs take shares of the walls; what they store is counted up without being held at once.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy import stats
from scipy.stats import qmc

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.at_intensities import ends
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.progress import track
from rockdamp.statistics.fragility import fit_resampled, interval, resample
from rockdamp.studies.earthquakes.settings import (
    PARAMETERS,
    Distribution,
    PopulationSettings,
    PopulationShareSettings,
    PopulationWallSettings,
)
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

HARMONICS = 10  # of RBD-FAST, the usual number
FEWEST = 100  # walls: of fewer the indices are noise


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config) -> xr.Dataset:
    """Sample the walls.

    Parameters
    ----------
    config : dict
        Has the keys of `PopulationWallSettings`.

    Returns
    -------
    xarray.Dataset
        The parameters (wall), what they make of the wall, and ``damping_ratio`` (wall, damping_model) of the closed
        form; NaN for CR.
    """
    given = PopulationWallSettings.of(config)
    values = sample(given)
    wall, curve = mechanics(values)
    ratio = np.full((wall.thickness.size, len(MODELS)), np.nan)
    for column, model in enumerate(VISCOUS_MODELS, start=1):
        ratio[:, column] = damping_ratio_energy(curve, model, values["restitution"], given.release_amplitude)
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
        coords={"wall": np.arange(wall.thickness.size), "damping_model": list(MODELS)},
    )


def sample(given: PopulationWallSettings) -> dict[str, Array]:
    """Draw a Latin hypercube of the distributions, each correlated with the others as the settings say.

    The ranks are correlated by a Gaussian copula: the hypercube's normal scores times the factor of the correlations.
    Each parameter keeps its distribution; without correlations each of its strata holds exactly one wall.

    Raises
    ------
    InputError
        If the correlations contradict each other.
    """
    drawn = qmc.LatinHypercube(len(PARAMETERS), rng=np.random.default_rng(given.seed)).random(given.count)
    correlation = np.eye(len(PARAMETERS))
    for pair, value in given.correlations.items():
        row, column = (PARAMETERS.index(name) for name in pair)
        correlation[row, column] = correlation[column, row] = value
    try:
        factor = np.linalg.cholesky(correlation)
    except np.linalg.LinAlgError:
        stated = ", ".join(f"{value:g} of {name} with {other}" for (name, other), value in given.correlations.items())
        raise InputError(f"population.correlations are {stated}; no parameters can have all of them at once") from None
    scores = stats.norm.ppf(drawn) @ factor.T
    uniform = np.where(np.all(factor == np.eye(len(PARAMETERS)), axis=1), drawn, stats.norm.cdf(scores))
    return {name: _quantile(given.parameters[name], uniform[:, column]) for column, name in enumerate(PARAMETERS)}


def _quantile(of: Distribution, probability: Array) -> Array:
    """Return quantiles of a distribution between ``low`` and ``high``."""
    if of.distribution == "uniform":
        return of.low + (of.high - of.low) * probability
    if of.distribution == "loguniform":
        return np.asarray(of.low * (of.high / of.low) ** probability)
    mean, deviation = of.mean, of.standard_deviation
    if mean is None or deviation is None:
        raise InputError(
            f"a distribution of population.parameters is {of.distribution}; it must state its mean and"
            " standard_deviation"
        )
    a, b = (of.low - mean) / deviation, (of.high - mean) / deviation
    return np.asarray(stats.truncnorm.ppf(probability, a, b, loc=mean, scale=deviation))


def mechanics(values: dict[str, Array]) -> tuple[Wall, TrilinearCurve]:
    wall = Wall(
        thickness=values["thickness"],
        height=values["thickness"] * values["slenderness"],
        hinge_ratio=values["hinge_ratio"],
        overburden_ratio=values["overburden_ratio"],
    )
    return wall, TrilinearCurve(values["cracked_stiffness_ratio"], values["plateau_ratio"])


# --- a share of the walls ---------------------------------------------------------------------------------------------


def share(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run one job's share of the walls under every record.

    Parameters
    ----------
    number : str
        Of the job, from 0.
    config : dict
        Has the keys of `PopulationShareSettings`.
    walls : xarray.Dataset
        Of `walls`.

    Returns
    -------
    xarray.Dataset
        ``peak_ratio`` and ``collapsed`` (wall, record, intensity, damping_model), and their counts:
        ``collapses`` (record, intensity, damping_model) and ``vulnerability`` (wall, damping_model).
    """
    given = PopulationShareSettings.of(config)
    size = given.walls_per_job
    mine = walls.isel(wall=slice(int(number) * size, (int(number) + 1) * size))
    motions = catalogue.load_records(given.records)
    runs = [
        run(motion, mine, given.intensity, step=given.step, tail=given.tail)
        for motion in track(motions, f"Walls {int(number) + 1}")
    ]
    peak, collapsed = (np.stack(arrays, axis=1) for arrays in zip(*runs, strict=True))
    dims = ("wall", "record", "intensity", "damping_model")
    return xr.Dataset(
        {
            "peak_ratio": (dims, peak),
            "collapsed": (dims, collapsed.astype(np.int8)),
            "collapses": (dims[1:], collapsed.sum(axis=0)),
            "vulnerability": (("wall", "damping_model"), collapsed.mean(axis=(1, 2))),
        },
        coords={
            "wall": mine["wall"].values,
            "intensity": given.intensity,
            "damping_model": list(MODELS),
            "record": [motion.name for motion in motions],
            "station": ("record", [motion.group for motion in motions]),
        },
    )


def run(
    motion: catalogue.GroundMotion, walls: xr.Dataset, intensity: Array, *, step: float, tail: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Run walls under one record at every intensity; peaks and collapses, shape (walls, intensities, models).

    Parameters
    ----------
    motion : GroundMotion
    walls : xarray.Dataset
        Of `walls`.
    intensity : ndarray, shape (intensities,)
        Peak ground velocities. [m s-1]
    step : float
        The longest, times the angular frequency of the first branch. [-]
    tail : float
        Rest after the record. [s]
    """
    values = {name: walls[name].values for name in PARAMETERS}
    wall, curve = mechanics(values)
    factor = intensity / intensity_measures(motion.record).pgv
    dampings = [
        Damping.of(model, restitution=values["restitution"], damping_ratio=walls["damping_ratio"].values[:, column])
        for column, model in enumerate(MODELS)
    ]
    return ends(motion.record, wall, curve, dampings, factor, step=step, tail=tail)


# --- all of them ------------------------------------------------------------------------------------------------------


def gather(config: Config, walls: xr.Dataset, *shares: xr.Dataset) -> xr.Dataset:
    """Count up the shares: fragility of the population, and the sensitivity of collapse to each parameter.

    Parameters
    ----------
    config : dict
        Has the keys of `PopulationSettings`.
    walls, *shares : xarray.Dataset
        Of `walls` and `share`; of the shares the counts alone are read.

    Returns
    -------
    xarray.Dataset
        ``collapse_fraction`` (intensity, damping_model), ``median_intensity``, ``dispersion`` and the ratio of the
        medians to CR's (damping_model) with intervals over the stations; ``vulnerability`` (wall, damping_model), the
        share of records and intensities that collapse the wall, and its first-order ``sensitivity`` (parameter,
        damping_model), NaN of fewer than `FEWEST` walls.
    """
    bootstrap = PopulationSettings.of(config).bootstrap
    collapses = sum_of(share["collapses"] for share in shares)
    vulnerability = np.concatenate([share["vulnerability"].values for share in shares])
    first = shares[0]
    count, intensity = walls.sizes["wall"], first["intensity"].values
    by_model = collapses.transpose("record", "damping_model", "intensity").values.astype(float)
    weights = resample(first["station"].values, bootstrap.replicates, bootstrap.seed)
    whole, drawn = fit_resampled(intensity, by_model, count, weights)
    sensitivity, confidence = _sensitivity(walls, vulnerability, bootstrap.seed)
    fraction = collapses.sum("record").transpose("intensity", "damping_model") / (count * len(by_model))
    model = ("damping_model",)
    return xr.Dataset(
        {
            "collapse_fraction": (("intensity", *model), fraction.values),
            "median_intensity": (model, whole.median),
            "median_intensity_interval": ((*model, "bound"), interval(drawn.median)),
            "dispersion": (model, whole.dispersion),
            "dispersion_interval": ((*model, "bound"), interval(drawn.dispersion)),
            "median_intensity_ratio": (model, whole.median / whole.median[0]),
            "median_intensity_ratio_interval": ((*model, "bound"), interval(drawn.median / drawn.median[..., :1])),
            "vulnerability": (("wall", *model), vulnerability),
            "sensitivity": (("parameter", *model), sensitivity),
            "sensitivity_confidence": (("parameter", *model), confidence),
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
    """First-order indices, the part of the variance that a parameter explains on its own, and their confidence.

    RBD-FAST (Tarantola et al. 2006, doi:10.1016/j.ress.2005.06.003; Plischke 2010) takes any sample, so the walls that
    were run serve. Of correlated parameters each has what it shares with the others.
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
