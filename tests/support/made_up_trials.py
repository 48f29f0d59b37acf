"""Made-up studies of measured tests: small, and with numbers that tests know."""

import numpy as np
import xarray as xr
from made_up_earthquakes import by_model, complete

from rockdamp.constants import PAPER_MODELS
from rockdamp.laboratory.measured_rocking import COMPARED, ERROR_MODELS, MODELS, POWER_LAW

ALL = [*MODELS, POWER_LAW]


def measured_rocking():
    """Return SDR ahead of CR, CDR and CDC, losses that rise a little, and e just below Housner's."""
    impacts, impact, slenderness = [6, 8, 10, 14], np.arange(1, 11), np.arange(4.0, 16.0)
    ahead = by_model(ALL, 196.0, CDC=175.0, CDR=194.0, SDR=200.0)
    exponent = by_model(ALL, 0.0, CDC=-0.06, CDR=-0.01, SDR=0.03)
    loss, ratio, bound = 0.9 + 0.02 * impact, 1.02 - 0.003 * slenderness, np.array([-1.0, 1.0])
    data = xr.Dataset(
        {
            "log_likelihood": (("damping_model", "impacts_used"), np.outer(ahead, [0.98, 1.0, 1.05, 1.1])),
            "amplitude_exponent": ("impacts_used", [-0.2, -0.25, -0.3, -0.2]),
            "amplitude_exponent_interval": (
                ("impacts_used", "bound"),
                np.array([[-0.2], [-0.25], [-0.3], [-0.2]]) + 0.2 * bound,
            ),
            "law_log_likelihood": ("impacts_used", 201.0 * np.array([0.98, 1.0, 1.05, 1.1])),
            "loss_exponent": ("impacts_used", [0.15, 0.2, 0.25, 0.2]),
            "share_beyond_stop": ("impacts_used", [0.05, 0.1, 0.2, 0.1]),
            "measured_impacts": ("trial", [60, 40, 20]),
            "allowed_impacts": ("trial", [50.0, 90.0, 100.0]),
            "noise": 0.019,
            "alternation": 0.016,
            "loss_by_impact": ("impact", loss),
            "loss_by_impact_interval": (("impact", "bound"), loss[:, None] + 0.2 * bound),
            "loss_by_impact_of_model": (("damping_model", "impact"), 1 + np.outer(exponent, impact - 5.5)),
            "restitution_over_housner": ("geometry", ratio),
            "restitution_over_housner_interval": (("geometry", "bound"), ratio[:, None] + 0.01 * bound),
            "trial_over_housner_interval": (("geometry", "bound"), ratio[:, None] + 0.03 * bound),
            "restitution_over_housner_mean": 0.991,
            "trial_deviation": ("geometry", 0.04 - 0.001 * slenderness),
            "deviation_within": 0.023,
            "deviation_between": 0.007,
            "bootstrap_replicates": 60,
            "simulated_choices": (("made_by", "chosen"), 10 * np.eye(len(COMPARED), dtype=int)),
            "held_out_coverage": ("choice", [0.88, 0.92]),
            "trials": 135,
            "duplicates": 1,
            "shown_impacts": 10,
        },
        coords={
            "damping_model": ALL,
            "impacts_used": impacts,
            "impact": impact,
            "trial": [1, 2, 3],
            "geometry": slenderness,
            "viscous_model": list(PAPER_MODELS),
            "yield_displacement_ratio": [0.005, 0.01, 0.02],
            "release_amplitude": [0.2, 0.5, 0.8],
            "error_model": list(ERROR_MODELS),
            "made_by": list(COMPARED),
            "chosen": list(COMPARED),
            "bound": ["lower", "upper"],
        },
    )
    return complete(data, "measured_rocking")
