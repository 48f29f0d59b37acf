"""The decays that the report's explorer shows."""

import explorer_parts
import numpy as np

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.storage import dataset
from rockdamp.vocabulary import VISCOUS_MODELS


def test_stored_decays_are_those_of_the_solver_at_every_few_steps():
    config, stored = explorer_parts.config(), explorer_parts.stored()
    step = config["solver"]["step"]
    np.testing.assert_allclose(stored["tau"], 0.05 * np.arange(121), atol=1e-12)  # 0.051 rounded down to whole steps
    curve = TrilinearCurve(**config["curve"])
    for model, e, x0 in (("CR", 0.8, 0.9), ("CDC", 0.9, 0.3), ("ECD", 0.85, 0.5)):
        at = {"damping_model": model, "restitution": e, "release_amplitude": x0}
        xi = float(stored["damping_ratio"].sel(at))
        damping = Damping.cr(e) if model == "CR" else Damping(model, xi)
        alone = solve(curve, damping, release_amplitude=x0, step=step, steps=2400, store_every=20)
        np.testing.assert_array_equal(stored["displacement"].sel(at), alone.displacement)


def test_stored_ratios_are_the_matched_ones_and_restitution_has_none():
    matches, stored = explorer_parts.matches(), explorer_parts.stored()
    assert stored["damping_ratio"].sel(damping_model="CR").isnull().all()
    for model in VISCOUS_MODELS:
        np.testing.assert_array_equal(
            stored["damping_ratio"].sel(damping_model=model), matches["damping_ratio"].sel(damping_model=model)
        )


def test_the_stored_decays_fit_the_registry():
    dataset.check(explorer_parts.stored(), "explorer")
