"""Orders of convergence on ensembles: one history's error is erratic, as its corners fall anywhere.

The force is continuous and its slope jumps at the corners, so that a corner costs a second-order
scheme an error of order step^2. Explicit Newmark with located impacts is second order for every
damper. The printed scheme freezes C over the step and applies impacts at its end: first order for
CR, CDR, SDR and ECD, second for CDC, whose C is constant.
"""

import numpy as np
import pytest
from configs import changed

from rockdamp.constants import MODELS
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.studies import convergence as stage
from rockdamp.studies.convergence import convergence, draw, fitted_order, run_ensemble

SAMPLE = 0.2  # in tau; the histories are compared at the samples of the load
SAMPLES = 33
LANES = 32


@pytest.fixture(scope="module")
def ensemble():
    return draw(20240607, LANES, SAMPLES, SAMPLE)


@pytest.fixture(scope="module")
def solve(ensemble):
    """Histories by the event-driven solver, good to about 1e-12."""

    def solve_lane(model, excitation, lane):
        e = ensemble.restitution[lane]
        value = e if model == "CR" else float(Damping.from_restitution(e, "ECD").value)
        load = {}
        if excitation == "forced":
            load = {"load": ensemble.ground * ensemble.load_factor[lane], "sampling": SAMPLE}
        history = exact_history(
            ensemble.curve.map(lambda parameter: parameter[lane]),
            Damping(model, value),
            SAMPLE * np.arange(SAMPLES),
            release_amplitude=ensemble.release_amplitude[lane],
            **load,
        )
        return history.displacement

    def solve_lanes(model, excitation):
        return np.array([solve_lane(model, excitation, lane) for lane in range(LANES)])

    return solve_lanes


@pytest.fixture(scope="module", params=["free", "forced"])
def excitation(request):
    return request.param


@pytest.fixture(scope="module", params=MODELS)
def errors(request, ensemble, solve, excitation):
    """Model, and the errors of each scheme by its steps between samples, shape (steps, lanes)."""
    model = request.param
    exact = solve(model, excitation)
    errors = {}
    # The printed scheme's first-order part is small for slight damping and shows at fine steps
    # alone.
    for scheme, powers in (("newmark", range(3, 12)), ("paper", range(8, 14))):
        runs = [
            run_ensemble(ensemble, model, excitation, scheme, SAMPLE, 2**power) for power in powers
        ]
        rms = np.sqrt(np.mean((np.array(runs) - exact) ** 2, axis=-1))
        errors[scheme] = 2 ** np.array(powers), rms
    return model, errors


def mean_order(substeps, rms):
    survives = np.isfinite(rms).all(axis=0)
    return -np.mean(fitted_order(substeps, rms[:, survives].T))


def test_newmark_is_second_order(errors):
    _, schemes = errors
    assert mean_order(*schemes["newmark"]) == pytest.approx(2, abs=0.15)


def test_printed_scheme_has_the_order_of_the_theory(errors):
    model, schemes = errors
    if model == "BAND":
        pytest.skip("BAND is not of the paper: its order in the printed scheme is not stated")
    expected = 2 if model == "CDC" else 1
    assert mean_order(*schemes["paper"]) == pytest.approx(expected, abs=0.15)


def test_newmark_is_the_more_accurate_scheme(errors):
    """Both with 256 steps between samples."""
    _, schemes = errors
    _, newmark = schemes["newmark"]
    _, printed = schemes["paper"]
    assert np.nanmedian(printed[0]) > 1.5 * np.nanmedian(newmark[5])


# --- stage ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def orders(paper):
    """The stage with a quarter of the lanes."""
    return convergence(changed(paper, {"convergence.lanes": 64}))


def test_stage_finds_newmark_second_order(orders):
    assert (abs(orders["convergence_order"].sel(scheme="newmark") - 2) < 0.1).all()


def test_stage_finds_the_printed_scheme_second_order_for_cdc(orders):
    order = orders["convergence_order"].sel(scheme="paper", damping_model="CDC")
    assert (abs(order - 2) < 0.1).all()


def test_frozen_coefficient_is_first_order_at_fine_steps(orders):
    """A small term, which takes over from those of second order."""
    models = ["CR", "CDR", "SDR", "ECD"]
    order = orders["finest_convergence_order"].sel(scheme="paper", damping_model=models)
    assert ((order > 0.75) & (order < 1.5)).all()


def test_ensemble_is_followed_for_the_length_of_the_config(paper, monkeypatch):
    lengths = []

    def draw_and_note(seed, lanes, samples, sample):
        lengths.append((samples - 1) * sample)
        return draw(seed, lanes, samples, sample)

    monkeypatch.setattr(stage, "draw", draw_and_note)
    convergence(changed(paper, {"convergence.lanes": 16, "convergence.halvings": 1}))
    assert lengths == [pytest.approx(paper.convergence.length)]
