"""Cases for the accuracy stage: a wall with a damper of each model, and matches made up for the studies."""

import numpy as np
import xarray as xr

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.vocabulary import VISCOUS_MODELS

CURVE = TrilinearCurve(0.06, 0.8)
DAMPINGS = [Damping.cr(0.85), *(Damping(model, 0.05) for model in VISCOUS_MODELS)]


def made_up(config, name, models=VISCOUS_MODELS):
    """A match with the closed form's damping ratios; the relative uncertainties and the errors are all different."""
    study, e = config.study(name), config.restitution
    ratio = np.stack(
        [
            damping_ratio_energy(study.curve.map(lambda p: p[:, None]), model, e, study.release_amplitude[:, None])
            for model in models
        ]
    )
    relative = 1e-4 * np.linspace(1, 2, ratio.size).reshape(ratio.shape)
    dims = ("damping_model", study.parameter, "restitution")
    return xr.Dataset(
        {
            "damping_ratio": (dims, ratio),
            "damping_ratio_uncertainty": (dims, relative * ratio),
            "rms_error": (dims, 0.01 * relative / 1e-4),
        },
        coords={
            "damping_model": list(models),
            study.parameter: study.values,
            "restitution": e,
            "response_length": config.matching.response_length,
        },
    )
