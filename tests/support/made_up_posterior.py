"""A posterior that nothing drew, for what prints, stores and draws one."""

import numpy as np
import xarray as xr

from rockdamp.vocabulary import CANDIDATES

PARAMETERS = ["yield_displacement_ratio", "strength_ratio", "restitution", "order", "sensor_correlation"]


def made_up_posterior(*, compared: bool = True) -> xr.Dataset:
    """Return a posterior of five parameters; with the evidence of each model, of which one is not determined."""
    random = np.random.RandomState(1)
    centre = np.array([0.033, 0.795, 0.845, 11.0, 0.1])
    draws = centre * (1 + 0.01 * random.standard_normal((200, 5)))
    elapsed = 0.01 * np.arange(100)
    measured = 0.02 * np.sin(12 * elapsed)
    levels = np.array([[0.25, 0.75], [0.05, 0.95]])
    made = xr.Dataset(
        {
            "mean": ("parameter", draws.mean(axis=0)),
            "standard_deviation": ("parameter", draws.std(axis=0)),
            "interval": (("level", "bound", "parameter"), np.quantile(draws, levels, axis=0)),
            "effective_draws": 4100.0,
            "true_value": ("parameter", [0.033, 0.795, 0.845, np.nan, np.nan]),
            "draws": (("draw", "parameter"), draws),
            "sensor_deviation": ("draw", np.full(200, 1.5e-4)),
            "sensor_zero": 1.3e-3,
            "sensor_drift": 6e-5,
            "measured": ("elapsed", measured),
            "predicted": (("bound", "elapsed"), np.stack([measured - 3e-4, measured + 3e-4])),
            "share_inside": 0.9,
            "residual_rms": 1.5e-4,
            "residual_over_peak": 0.0075,
            "residual_over_noise": 1.0,
        },
        coords={"parameter": PARAMETERS, "level": [0.5, 0.9], "bound": ["low", "high"], "elapsed": elapsed}
        | {"draw": np.arange(1, 201)},
        attrs={"record_synthetic": "yes", "record_specimen": "a wall", "identified_model": CANDIDATES[-1]},
    )
    if not compared:
        return made
    count = len(CANDIDATES)
    logarithm = np.append(np.nan, 100.0 + np.arange(count - 1.0))
    probability = np.exp(logarithm - np.nanmax(logarithm))
    return made.assign(
        log_evidence=("damping_model", logarithm),
        log_evidence_error=("damping_model", np.full(count, 0.02)),
        probability=("damping_model", probability / np.nansum(probability)),
        undetermined=("damping_model", ["too near to collapse", *[""] * (count - 1)]),
    ).assign_coords(damping_model=list(CANDIDATES))
