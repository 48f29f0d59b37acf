"""Made-up studies of measured tests: small, and with numbers that tests know."""

import numpy as np
import xarray as xr
from made_up_earthquakes import by_model, complete

from rockdamp.laboratory.measured_rocking import MODELS, POWER_LAW

ALL = [*MODELS, POWER_LAW]


def measured_rocking():
    """Return SDR ahead of CR, CDR and CDC, and e just below Housner's."""
    impacts, slenderness = [6, 8, 10, 14], np.arange(4.0, 16.0)
    ahead = by_model(ALL, 196.0, CDC=175.0, CDR=194.0, SDR=200.0)
    ratio, bound = 1.02 - 0.003 * slenderness, np.array([-1.0, 1.0])
    data = xr.Dataset(
        {
            "log_likelihood": (("damping_model", "impacts_used"), np.outer(ahead, [0.98, 1.0, 1.05, 1.1])),
            "amplitude_exponent": ("impacts_used", [-0.2, -0.25, -0.3, -0.2]),
            "amplitude_exponent_interval": (
                ("impacts_used", "bound"),
                np.array([[-0.2], [-0.25], [-0.3], [-0.2]]) + 0.2 * bound,
            ),
            "restitution_over_housner": ("geometry", ratio),
            "restitution_over_housner_interval": (("geometry", "bound"), ratio[:, None] + 0.01 * bound),
            "trial_over_housner_interval": (("geometry", "bound"), ratio[:, None] + 0.03 * bound),
            "restitution_over_housner_mean": 0.991,
            "trial_deviation": ("geometry", 0.04 - 0.001 * slenderness),
            "deviation_within": 0.023,
            "deviation_between": 0.007,
            "first_ratio_deviation_within": 0.034,
            "noise": 0.019,
            "alternation": 0.016,
            "trials": 135,
            "duplicates": 1,
            "shown_impacts": 10,
        },
        coords={
            "damping_model": ALL,
            "impacts_used": impacts,
            "geometry": slenderness,
            "bound": ["lower", "upper"],
        },
    )
    return complete(data, "measured_rocking")
