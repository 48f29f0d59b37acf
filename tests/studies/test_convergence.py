"""Orders of convergence, measured on ensembles: one history's error is erratic, as its corners fall anywhere in a step.

The force is continuous and its slope jumps at the corners, so a corner costs a second-order scheme an error of order
step^2. Explicit Newmark with located impacts is second order for every damper. The printed scheme freezes C over the
step and applies impacts at its end: first order for CR, CDR, SDR and ECD, second for CDC, whose C is constant.
"""

import numpy as np
import pytest
from configs import changed

from rockdamp.constants import MODELS
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.convergence import convergence, draw, fitted_order, run_ensemble

SAMPLE, SAMPLES, LANES = (
    0.2,
    33,
    32,
)  # in tau; the histories are compared at the samples of the load


@pytest.fixture(scope="module")
def ensemble():
    return draw(20240607, LANES, SAMPLES, SAMPLE)


@pytest.fixture(scope="module")
def exact(ensemble):
    """Of each damper, free and forced, by the event-driven solver, good to about 1e-12."""

    def solve(model, excitation, lane):
        e = ensemble.restitution[lane]
        damping = Damping(
            model, e if model == "CR" else float(Damping.from_restitution(e, "ECD").value)
        )
        load = {"load": ensemble.ground * ensemble.load_factor[lane], "sampling": SAMPLE}
        return exact_history(
            ensemble.curve.map(lambda parameter: parameter[lane]),
            damping,
            SAMPLE * np.arange(SAMPLES),
            release_amplitude=ensemble.release_amplitude[lane],
            **(load if excitation == "forced" else {}),
        ).displacement

    return lambda model, excitation: np.array(
        [solve(model, excitation, lane) for lane in range(LANES)]
    )


@pytest.mark.parametrize("excitation", ["free", "forced"])
@pytest.mark.parametrize("model", MODELS)
def test_both_schemes_tend_to_the_event_driven_solution_at_the_order_of_the_theory(
    ensemble, exact, model, excitation
):
    reference, errors = exact(model, excitation), {}
    # The printed scheme's first-order part is small for slight damping and shows at fine steps alone.
    for scheme, substeps in (("newmark", 2 ** np.arange(3, 12)), ("paper", 2 ** np.arange(8, 14))):
        found = [
            run_ensemble(ensemble, model, excitation, scheme, SAMPLE, int(k)) for k in substeps
        ]
        errors[scheme] = np.sqrt(np.mean((np.array(found) - reference) ** 2, axis=-1))
        expected = 2 if scheme == "newmark" or model == "CDC" else 1
        if model != "BAND" or scheme == "newmark":
            survived = np.isfinite(errors[scheme]).all(axis=0)
            order = -np.mean(fitted_order(substeps, errors[scheme][:, survived].T))
            assert order == pytest.approx(expected, abs=0.15), scheme
    # Both at 256 steps: explicit Newmark is the more accurate scheme.
    assert np.nanmedian(errors["paper"][0]) > 1.5 * np.nanmedian(errors["newmark"][5])


def test_the_stage_finds_the_orders_of_the_theory(paper):
    """Of a quarter of the lanes."""
    found = convergence(changed(paper, {"convergence.lanes": 64}))
    assert (abs(found["convergence_order"].sel(scheme="newmark") - 2) < 0.1).all()
    printed = found.sel(scheme="paper")
    assert (abs(printed["convergence_order"].sel(damping_model="CDC") - 2) < 0.1).all()
    # C frozen over the step is a small first-order term, which takes over from the second-order ones at fine steps.
    frozen = printed["finest_convergence_order"].sel(damping_model=["CR", "CDR", "SDR", "ECD"])
    assert ((frozen > 0.75) & (frozen < 1.5)).all()
