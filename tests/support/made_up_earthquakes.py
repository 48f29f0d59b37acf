"""A made-up study of earthquakes: lognormal collapses and peaks that differ by known factors, no solver."""

from pathlib import Path

import numpy as np
import xarray as xr
import yaml
from scipy.special import ndtr

from rockdamp.constants import MODELS as ALL_MODELS
from rockdamp.constants import STUDIES
from rockdamp.storage import dataset


def by_model(models, other, **known):
    """A value for each model, in their order; those of models that are not known begin at `other`, and all differ."""
    others = [model for model in models if model not in known]
    return np.array([known[model] if model in known else other + 0.001 * others.index(model) for model in models])


MODELS = list(ALL_MODELS)
SOURCES = ["polynomial", "least error", "closed form"]
VARIATIONS = ["step", "impact", "lower e", "higher e"]
WALLS = ["tested", "veneer", "church", "degraded", "parapet"]
E = np.array([0.8, 0.85, 0.9])
SCALE = np.geomspace(0.2, 5, 8)
EDGES = np.array([0.01, 0.04, 0.1, 0.25, 0.5, 1.0])
FACTOR = by_model(MODELS, 0.97, CR=1.0, CDC=1.08, CDR=0.99, SDR=0.9, ECD=0.96)  # of the peak with each model to CR's
BETA = 0.4  # dispersion of collapse

COORDS = {
    "restitution": E,
    "damping_model": MODELS,
    "damping_ratio_source": SOURCES,
    "wall": WALLS,
    "velocity_ratio": SCALE,
    "variation": VARIATIONS,
}


DIMENSIONS = yaml.safe_load(Path(__file__).with_name("dimensions.yaml").read_text(encoding="utf-8"))


def complete(data, kind):
    """Add zeros for what the glossary has and no figure shows, and check the rest against it."""
    parameter = next((str(dim) for dim in STUDIES.values() if dim in data.dims), None)
    for name, dims in dimensions(kind, parameter if kind in ("decay", "match") else None, optional=False).items():
        if name not in data.variables:
            data[name] = (dims, np.zeros([data.sizes.get(dim, 3) for dim in dims]))
    dataset.check(data, kind)
    return data


def dimensions(kind, parameter=None, optional=True):
    """Dimensions of the variables that a kind of dataset has, of a study with its `parameter`; a scalar has none."""
    grouped = {name: dims.split() for dims, names in DIMENSIONS.get(kind, {}).items() for name in names}
    used = {dim for dims in grouped.values() for dim in dims}
    others = set(STUDIES.values()) if parameter else ()
    entries = {name: one for name, one in dataset.variables(kind).items() if name not in others}
    names = [name for name, entry in entries.items() if optional or not entry.get("optional")]
    found = {name: grouped.get(name, [name] if name in used else []) for name in names}
    found |= {"STUDY": ["STUDY"]} if parameter else {}
    of_study = {"STUDY": parameter}
    return {of_study.get(name, name): [of_study.get(dim, dim) for dim in dims] for name, dims in found.items()}


def earthquakes(records=6):
    """Peaks that grow with scale and collapse beyond 1, and those of the dampers by `FACTOR`."""
    strength = np.exp(BETA * np.linspace(-1.5, 1.5, records))
    wall = 0.8 + 0.1 * np.arange(len(WALLS))
    cr = 0.2 * strength[:, None, None, None] * SCALE[:, None, None] ** 1.2 / wall[:, None] / (1.2 - 0.2 * E)
    peak = cr[..., None, None] * FACTOR[:, None] * np.ones(3)
    collapsed = (peak > 1).astype(np.int8)
    dims = ("record", "velocity_ratio", "wall", "restitution", "damping_model", "damping_ratio_source")
    collapsed[:, :, 3, :, 1:, 0] = -1  # one wall lies beyond the polynomials
    data = xr.Dataset(
        {"peak": (dims, np.where(collapsed < 0, np.nan, peak)), "collapsed": (dims, collapsed)},
        coords={
            **COORDS,
            "record": [f"far-field/{i}/a" for i in range(records)],
            "station": ("record", [f"far-field/{i}" for i in range(records)]),
        },
    )
    return complete(data, "earthquakes")


def comparison():
    """Statistics that are functions of model, e and band, with intervals of a tenth about them."""
    lead, bands = (E.size, len(MODELS), len(SOURCES)), EDGES.size
    e_dims, band = ("restitution", "damping_model", "damping_ratio_source"), np.arange(bands)
    ratio = np.broadcast_to(FACTOR[:, None, None], (*lead, bands)) * np.ones(bands)
    base = by_model(MODELS, 0.15, CR=0.0, CDC=0.25, CDR=0.10, SDR=0.20, ECD=0.11)[:, None, None] * (1 + 0.1 * band)
    error = np.broadcast_to(base, (*lead, bands)) * (1 + 0.02 * np.arange(3)[:, None])
    own = np.array([0.01, 0.02, 0.06, 0.07])[:, None] * (1 + 0.1 * band) * np.ones((E.size, 1, 1))
    median = 0.5 + 0.1 * np.arange(len(WALLS))
    of_wall = (median[:, None, None, None] / FACTOR[:, None]) * np.ones((len(WALLS), *lead))
    collapse = ndtr(np.log(SCALE / of_wall[..., None]) / BETA)
    wall_dims = ("wall", *e_dims)
    data = xr.Dataset(
        {
            **statistic("median_ratio", (*e_dims, "band"), ratio),
            **statistic("log_error", (*e_dims, "band"), error),
            **statistic("varied_median_ratio", ("restitution", "variation", "band"), 1 + 0.1 * own),
            **statistic("varied_log_error", ("restitution", "variation", "band"), own),
            **statistic("median_velocity_ratio", e_dims, np.broadcast_to(1 / FACTOR[:, None], lead)),
            **statistic("median_intensity_ratio", e_dims, np.broadcast_to(1 / FACTOR[:, None], lead)),
            **statistic("missed_collapse_rate", e_dims, np.full(lead, 0.03)),
            **statistic("added_collapse_rate", e_dims, np.full(lead, 0.02)),
            **statistic("wall_median_velocity_ratio", wall_dims, of_wall),
            **statistic("wall_dispersion", wall_dims, np.full(of_wall.shape, BETA)),
            "collapse_fraction": ((*wall_dims, "velocity_ratio"), collapse),
            "pooled": (("wall", "damping_ratio_source"), np.tile([[1], [1], [1], [0], [1]], 3)),
            "records": 100,
            "stations": 50,
            "converged_share": 0.99,
            "relative_uncertainty": ("share", np.array([1e-3, 2e-3, 0.04, 1.0])),
        },
        coords={
            **COORDS,
            "bound": ["lower", "upper"],
            "share": [0.5, 0.9, 0.99, 1.0],
            "band": band,
            "band_start": ("band", np.r_[EDGES[0], EDGES[:-1]]),
            "band_end": ("band", np.r_[EDGES[-1], EDGES[1:]]),
        },
    )
    return complete(with_excess(data), "comparison")


def with_excess(data):
    """The excess over the least error at each e, with intervals of 0.011 to each side."""
    error = data["log_error"].isel(band=0, drop=True).where(data["damping_model"] != MODELS[0])
    excess = error - error.min(("damping_model", "damping_ratio_source"))
    bounds = xr.concat([excess - 0.011, excess + 0.011], "bound").transpose(..., "bound")
    return data.assign(excess=excess, excess_interval=bounds.assign_coords(bound=data["bound"]))


def statistic(name, dims, values):
    bounds = np.stack([0.95 * values, 1.05 * values], axis=-1)
    return {name: (dims, values), f"{name}_interval": ((*dims, "bound"), bounds)}


def walls():
    """The walls of the study, one without a ratio from the polynomials."""
    ratio = np.full((len(WALLS), E.size, len(MODELS), len(SOURCES)), 0.05)
    ratio *= 1 + 0.1 * np.arange(len(WALLS))[:, None, None, None]
    ratio[:, :, 0] = ratio[3, :, :, 0] = np.nan
    data = xr.Dataset(
        {
            "damping_ratio": (("wall", "restitution", "damping_model", "damping_ratio_source"), ratio),
            "parapet": ("wall", np.array([0, 0, 0, 0, 1], dtype=np.int8)),
            **{
                name: ("wall", 0.1 + 0.1 * np.arange(5.0))
                for name in (
                    "thickness",
                    "height",
                    "slenderness",
                    "overburden_ratio",
                    "yield_displacement_ratio",
                    "strength_ratio",
                    "instability_displacement",
                    "frequency_parameter",
                    "initial_period",
                )
            },
        },
        coords={name: COORDS[name] for name in ("wall", "restitution", "damping_model", "damping_ratio_source")},
    )
    return complete(data, "earthquake_walls")
