"""Made-up datasets of every stage that a figure shows: small, and with numbers that tests know."""

import made_up_earthquakes as earthquakes
import numpy as np
import xarray as xr
from configs import configured
from made_up_earthquakes import by_model, complete, statistic
from made_up_trials import measured_rocking

from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.studies.amplitude import DAMPERS
from rockdamp.studies.mechanism import mechanism as stage
from rockdamp.studies.supports import ANALYTICAL, FIXED, IMPULSIVE, MASS, VERTICAL, name_floor

ALL, VISCOUS = list(MODELS), list(VISCOUS_MODELS)
E = np.linspace(0.7, 0.98, 15)
STEPS = 3200  # k of the made-up matches


def mechanism():
    """Return the stage's own dataset, which takes no time."""
    return stage(configured())


def damping_force():
    tau = np.linspace(0, 30, 3001)
    rates = 0.16 + 0.004 * np.arange(len(ALL))
    displacement = np.stack([0.5 * np.exp(-rate * tau) * np.cos(1.3 * tau) for rate in rates])
    velocity = np.gradient(displacement, tau, axis=1)
    velocity[0] *= 1 + 0.2 * np.sign(displacement[0] * velocity[0])  # CR alone jumps where u changes sign
    ratio = by_model(ALL, 0.056, CR=np.nan, CDC=0.03, CDR=0.045, SDR=0.062, ECD=0.052)
    frequency = np.linspace(0, 1, 21)
    with np.errstate(divide="ignore"):
        known = {"CDC": 1 / frequency, "CDR": np.ones(21), "SDR": frequency}
    law = np.stack([known.get(model, np.full(21, np.nan)) for model in VISCOUS])
    data = xr.Dataset(
        {
            "displacement": (("damping_model", "tau"), displacement),
            "velocity": (("damping_model", "tau"), velocity),
            "damping_force": (
                ("damping_model", "tau"),
                np.nan_to_num(ratio)[:, None] * velocity / (1 + (displacement / 0.1) ** 2),
            ),
            "damping_ratio": ("damping_model", ratio),
            "damping_ratio_law": (("viscous_model", "frequency_ratio"), law),
            "rocking_displacement": (
                ("rocking_model", "tau"),
                np.stack([0.9 * np.exp(-0.06 * tau) * np.cos(w * tau) for w in (0.9, 0.901, 0.88)]),
            ),
        },
        coords={
            "damping_model": ALL,
            "viscous_model": VISCOUS,
            "rocking_model": ["tri-linear", "slender", "large rotation"],
            "tau": tau,
            "frequency_ratio": frequency,
            "restitution": 0.85,
            "release_amplitude": 0.5,
            "rocking_restitution": 0.955,
            "rocking_frequency_parameter": 3.8,
        },
    )
    return complete(data, "damping_force")


def match(parameter, values, *, fixed=False, plateau=None):
    """Matched damping ratios that depend on model, value and e: no two curves are the same."""
    dims = ("damping_model", parameter, "restitution")
    values = np.asarray(values, dtype=float)
    model, value = np.arange(float(len(VISCOUS)))[:, None, None], np.arange(values.size)[None, :, None]
    ratio = (0.26 + 0.03 * model + 0.01 * value) * (1 - E)
    # SDR has the lowest error below e = 0.8 and CDR from there on.
    error = by_model(VISCOUS, 3.0, CDC=9.0, CDR=4.0, SDR=1.0, ECD=2.0)[:, None, None] + 8.0 * (model == 2) * (E > 0.795)
    error = error * (1 - E) * (1 + value)
    shape = np.broadcast_shapes(ratio.shape, error.shape)
    data = {
        "damping_ratio": (dims, ratio),
        "damping_ratio_energy": (dims, 0.9 * ratio),
        "error": (dims, np.broadcast_to(error, shape)),
        "rms_error": (dims, np.broadcast_to(np.sqrt(error / STEPS), shape)),
        "steps": STEPS,
    }
    if fixed:
        data["damping_ratio_fixed_seconds"] = (dims, ratio * (1 + 0.01 * value))
    if plateau is not None:
        data["strength_ratio"] = (parameter, np.asarray(plateau))
    coords = {"damping_model": VISCOUS, parameter: values, "restitution": E, "response_length": 8.0}
    return complete(xr.Dataset(data, coords=coords), "match")


def equivalence():
    a1 = [0.02, 0.04, 0.10]
    dims = ("damping_model", "yield_displacement_ratio", "restitution")
    matched = match("yield_displacement_ratio", a1)["damping_ratio"].values
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


def validation(**attributes):
    elapsed = np.linspace(0, 4, 401)
    motion = 9.0 * np.exp(-(((elapsed - 1.5) / 0.1) ** 2))
    moving = elapsed >= 1.5
    measured = np.where(moving, 0.02 * np.exp(-1.5 * (elapsed - 1.5)) * np.sin(8 * (elapsed - 1.5)), 0.0)
    share = by_model(ALL, 0.75, CR=0.95, CDC=0.9, CDR=0.8, SDR=0.7, ECD=0.85)
    data = xr.Dataset(
        {
            "control_displacement": (("damping_model", "elapsed"), share[:, None] * measured),
            "measured": ("elapsed", measured),
            "ground_acceleration": ("elapsed", motion),
            "damping_ratio": (
                "damping_model",
                by_model(ALL, 0.055, CR=np.nan, CDC=0.03, CDR=0.05, SDR=0.07, ECD=0.06),
            ),
            "collapsed": ("damping_model", np.zeros(len(ALL), dtype=np.int8)),
            "rms_misfit": ("damping_model", 0.001 * (1 + np.arange(float(len(ALL))))),
            "peak_ratio_to_measured": ("damping_model", share),
            "log_decrement": ("damping_model", 0.3 * share),
            "measured_log_decrement": 0.3,
            "measured_peak_displacement": float(np.abs(measured).max()),
            "instability_displacement": 0.075,
            "restitution": 0.835,
            "yield_displacement_ratio": 0.031,
            "strength_ratio": 0.80,
        },
        coords={"damping_model": ALL, "elapsed": elapsed},
        attrs={"record_synthetic": "yes", "record_specimen": "a wall", **attributes},
    )
    return complete(data, "validation")


def convergence():
    step = 0.02 / 2.0 ** np.arange(5)
    printed = by_model(ALL, 1.4, CR=1.0, CDC=2.0, CDR=1.2, SDR=1.3, ECD=1.1)
    slopes = np.array([[np.full(len(ALL), 2.0)] * 2, [printed] * 2])
    scale = 1e-4 * np.arange(1, len(ALL) + 1)[:, None]
    error = scale * (step / step[0]) ** slopes[..., None]
    dims = ("scheme", "excitation", "damping_model")
    data = xr.Dataset(
        {
            "solver_error": ((*dims, "step"), error),
            "convergence_order": (dims, slopes),
            "finest_convergence_order": (dims, slopes + 0.01),
        },
        coords={
            "scheme": ["newmark", "paper"],
            "excitation": ["free", "forced"],
            "damping_model": ALL,
            "step": step,
        },
    )
    return complete(data, "convergence")


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
            "shown_displacement": (("shown_damper", "tau"), np.tile(u, (4, 1))),
            "shown_velocity": (("shown_damper", "tau"), np.tile(np.gradient(u, tau), (4, 1))),
            "shown_damping_force": (("shown_damper", "tau"), -0.07 / widths * np.exp(-((u / widths) ** 2))),
            "shown_restitution": 0.85,
            "records": 100,
            "stations": 50,
        },
        coords={
            "damper": [*dampers, *variations],
            "restitution": e,
            "wall": ["paper", "tested"],
            "bound": ["lower", "upper"],
            "shown_damper": ["CR", "ECD16", "BAND0.4", "BAND0.2"],
            "tau": tau,
        },
    )
    return complete(study, "order")


def made_up():
    return {
        "order": order(),
        "mechanism": mechanism(),
        "damping_force": damping_force(),
        "match/amplitude": match("release_amplitude", [0.1, 0.2, 0.3, 0.5, 0.7, 0.9]),
        "match/slenderness": match("slenderness", [10, 15, 30], fixed=True),
        "match/overburden": match("overburden_ratio", [0, 1, 8], fixed=True),
        "match/cracked_stiffness": match(
            "yield_displacement_ratio", [0.02, 0.04, 0.14, 0.17], plateau=[0.85, 0.85, 0.85, 0.75]
        ),
        "equivalence": equivalence(),
        "validation": validation(),
        "convergence": convergence(),
        "measured_rocking": measured_rocking(),
        "amplitude": amplitude(),
        "loss_law": loss_law(),
        "supports": supports(),
        "earthquakes": earthquakes.earthquakes(),
        "earthquakes/walls": earthquakes.walls(),
        "comparison": earthquakes.comparison(),
    }
