"""Made-up datasets of studies: small, and with numbers that tests know."""

import numpy as np
import xarray as xr
from made_up_earthquakes import by_model, complete, statistic

from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.studies.amplitude import DAMPERS
from rockdamp.studies.supports import ANALYTICAL, FIXED, IMPULSIVE, MASS, VERTICAL, name_floor

ALL, VISCOUS = list(MODELS), list(VISCOUS_MODELS)
E = np.linspace(0.7, 0.98, 15)


def equivalence():
    a1 = [0.02, 0.04, 0.10]
    dims = ("damping_model", "yield_displacement_ratio", "restitution")
    matched = np.linspace(0.2, 0.5, len(VISCOUS) * len(a1)).reshape(len(VISCOUS), len(a1), 1) * (1 - E)
    data = xr.Dataset(
        {
            "damping_ratio": (dims, matched),
            "damping_ratio_fit": (dims, 1.001 * matched),
            "giannini_masiani": ("restitution", 2 * (1 - E) / np.pi / (1 + E)),
            "r_squared": (dims[:2], np.full((len(VISCOUS), 3), 0.9987654)),
            **{
                name: (
                    (*dims[:2], "restitution_range"),
                    factor * np.broadcast_to([1.0, 2.0, 9.0], (len(VISCOUS), 3, 3)),
                )
                for name, factor in (("largest_relative_error", 0.01), ("delta_largest_relative_error", 0.002))
            },
            "strength_ratio": 0.85,
        },
        coords={
            "damping_model": VISCOUS,
            "yield_displacement_ratio": a1,
            "restitution": E,
            "restitution_range": [0.90, 0.96, 1.00],
            "response_length": 8.0,
        },
    )
    return complete(data, "equivalence")


def amplitude():
    release, e = np.linspace(0.05, 0.95, 10), np.array([0.75, 0.85, 0.95])
    slope = by_model(list(DAMPERS), 0.0, CDC=-0.6, CDR=-0.2, SDR=0.3)[:, None, None]
    peaks = (1 + slope * release[:, None]) * (1 - e) / np.pi
    dims = ("damping_model", "release_amplitude", "restitution")
    data = xr.Dataset(
        {
            "damping_ratio": (dims, 1.05 * peaks),
            "damping_ratio_peaks": (dims, peaks),
            "damping_ratio_energy": (dims, peaks * (1 - 0.2 * slope * (1 - e))),
        },
        coords={"damping_model": list(DAMPERS), "release_amplitude": release, "restitution": e},
    )
    return complete(data, "amplitude")


def loss_law():
    """Medians that rise with the amplitude and fall with the exponent."""
    g, at, bands = np.array([0.13, 0.26, 0.39]), np.array([0.1, 0.3, 0.5]), 5
    edges = np.array([0.01, 0.04, 0.1, 0.25, 0.5, 1.0])
    laws = ("wall", "loss_exponent", "reference_amplitude")
    ratio = np.stack([scale * (1 + g[:, None] * (at - 0.3)) for scale in (1.0, 1.02)])
    by_band = ratio[..., None] * np.linspace(0.8, 1.0, bands)
    data = {}
    for name, values, dims in (
        ("median_intensity_ratio", ratio, laws),
        ("missed_collapse_rate", 0.03 * ratio, laws),
        ("added_collapse_rate", 0.05 * ratio, laws),
        ("median_ratio", by_band, (*laws, "band")),
        ("log_error", 0.2 * by_band, (*laws, "band")),
    ):
        data[name] = (dims, values)
        data[f"{name}_interval"] = ((*dims, "bound"), np.stack([0.98 * values, 1.02 * values], -1))
    study = xr.Dataset(
        {**data, "pairs": ((*laws, "band"), np.full(by_band.shape, 40)), "records": 100, "stations": 50},
        coords={
            "wall": ["all", "tested"],
            "loss_exponent": g,
            "reference_amplitude": at,
            "restitution": 0.85,
            "band": np.arange(1, bands + 1),
            "band_start": ("band", edges[:-1]),
            "band_end": ("band", edges[1:]),
            "bound": ["lower", "upper"],
        },
    )
    return complete(study, "loss_law")


def supports():
    """A floor that costs more the softer it is, and other assumptions on either side of one; a wall has no value."""
    period = np.array([0.1, 0.3, 0.6])
    cases = [
        *(name_floor(each) for each in period.tolist()),
        MASS,
        ANALYTICAL,
        IMPULSIVE,
        VERTICAL,
        FIXED,
    ]
    others = [1.12, 1.3, 0.85, 0.98, 1.03]
    whole = np.concatenate([1 - 0.5 * period, others])
    ratio = whole[:, None] * np.array([1.0, 0.95, 1.06])
    ratio[3, 2] = np.nan
    dims = ("assumption", "wall")
    study = xr.Dataset(
        {
            "median_intensity_ratio": (dims, ratio),
            "median_intensity_ratio_interval": ((*dims, "bound"), np.stack([0.97 * ratio, 1.04 * ratio], -1)),
            "stations": ("assumption", np.full(len(cases), 50)),
            "diaphragm_period": ("assumption", [*period, *np.full(len(others), np.nan)]),
            "diaphragm_damping": 0.05,
            "vertical_factor": 0.667,
            "eccentricity_ratio": 0.25,
        },
        coords={"assumption": cases, "wall": ["all", "tested", "veneer"], "bound": ["lower", "upper"]},
    )
    return complete(study, "supports")


def order():
    """Errors that fall with the force in each family, and decays whose force is a narrow hump at the crossing."""
    families = {
        "ECD": (["", "1", "2", "4", "8", "16", "32", "64", "128"], np.geomspace(0.3, 4, 9), 0.015),
        "BAND": (["0.6", "0.4", "0.3", "0.2", "0.1", "0.05"], np.geomspace(0.8, 9, 6), 0.008),
        "CQD": (["0.5", "0.25"], np.array([3.6, 7.2]), 0.1),
    }
    dampers = [f"{family}{width}" for family, (widths, _, _) in families.items() for width in widths]
    force = np.concatenate([forces for _, forces, _ in families.values()])
    error = np.concatenate([at_one / forces for _, forces, at_one in families.values()])
    variations, e = ["e - 0.01", "e + 0.01", "loss - 7 %", "loss + 7 %", "half step", "end of step"], [0.75, 0.85, 0.9]
    error = np.concatenate([error, [0.02, 0.022, 0.021, 0.023, 1e-4, 0.0016]])
    dims, data = ("damper", "restitution"), {}
    for name, factor in (
        ("log_error_median", 1.0),
        ("log_error_90", 4.0),
        ("share_above", 7.0),
        ("missed_collapse_rate", 1.5),
        ("added_collapse_rate", 2.0),
        ("log_error", 8.0),
    ):
        values = factor * error[:, None] * np.array([1.2, 1.0, 0.9])
        data |= statistic(name, dims, values)
    forces = np.full((len(dampers) + len(variations), len(e), 2), np.nan)
    forces[: len(dampers)] = force[:, None, None] * np.array([1.6, 1.0, 0.6])[:, None] * np.array([1.0, 0.7])
    tau = np.linspace(0, 4, 401)
    u = 0.5 * np.cos(1.5 * tau)
    widths = np.array([np.nan, 0.05, 0.06, 0.03])[:, None]
    study = xr.Dataset(
        {
            **data,
            "crossing_force": (("damper", "restitution", "wall"), forces),
            "largest_step": (dims, np.full(forces.shape[:2], 0.05)),
            "displacement": (("crossing_damper", "tau"), np.tile(u, (4, 1))),
            "velocity": (("crossing_damper", "tau"), np.tile(np.gradient(u, tau), (4, 1))),
            "damping_force": (("crossing_damper", "tau"), -0.07 / widths * np.exp(-((u / widths) ** 2))),
            "crossing_restitution": 0.85,
            "records": 100,
            "stations": 50,
        },
        coords={
            "damper": [*dampers, *variations],
            "restitution": e,
            "wall": ["paper", "tested"],
            "bound": ["lower", "upper"],
            "crossing_damper": ["CR", "ECD16", "BAND0.4", "BAND0.2"],
            "tau": tau,
        },
    )
    return complete(study, "order")
