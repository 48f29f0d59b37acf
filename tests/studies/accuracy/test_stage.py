"""The accuracy stage: errors of the solver, the dataset and its figures, on small real runs."""

import numpy as np
import pytest
from figure_functions import FIGURES

from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies.accuracy import convergence
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

# --- the solver ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("excitation", ["free", "forced"])
def test_the_error_of_a_history_is_against_the_exact_one(stage, drawn, excitation):
    case, e = 1, 0
    forced = excitation == "forced"
    curve, damping = drawn.curve.map(lambda p: p[case, 0]), Damping("CDC", drawn.ratio["CDC"][case, e])
    length = (drawn.load.shape[1] - 1) * drawn.sample
    times = np.linspace(0, length, round(length / 0.02) + 1)
    load = {"load": drawn.factor[case, e] * drawn.load[case], "load_step": drawn.sample} if forced else {}
    release = 0.0 if forced else drawn.release_amplitude[case, 0]
    expected = event_driven.history(curve, damping, times, release_amplitude=release, **load).displacement
    found = drawn.histories("CDC", excitation, 0.01, 2)[0][case, e]
    rms = np.sqrt(np.mean((found - expected) ** 2))
    one = stage.sel(excitation=excitation, damping_model="CDC")
    assert float(one["solver_error"].sel(step=0.01)[case, e]) == pytest.approx(rms, rel=1e-6)
    assert float(one["largest_history_error"]) >= np.abs(found - expected).max() * (1 - 1e-6) > rms
    assert float(one["largest_displacement"][case, e]) >= np.abs(expected).max()


def test_medians_and_largest_errors_are_over_walls_and_restitutions(stage):
    error = (
        stage["solver_error"]
        .transpose("excitation", "damping_model", "step", ...)
        .values.reshape(2, len(MODELS), 4, -1)
    )
    np.testing.assert_allclose(stage["median_solver_error"], np.median(error, axis=-1))
    np.testing.assert_allclose(stage["largest_solver_error"], error.max(axis=-1))
    np.testing.assert_allclose(
        stage["convergence_order"], convergence.fitted_order(stage["step"], stage["median_solver_error"])
    )


# --- the dataset and its figures -------------------------------------------------------------------------------------


def test_the_stage_returns_what_the_glossary_says(stage):
    dataset.check(stage, "accuracy")
    assert {str(name) for name in stage.variables} == set(dataset.variables("accuracy"))


def test_fig_accuracy_does_not_round_a_share_up_to_all(stage):
    nearly = stage.copy(deep=True)
    nearly["share_within_thousandth"][:] = 0.9996
    legend = FIGURES["fig_accuracy"](nearly).axes[2].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"{model}: 99.9 %" for model in VISCOUS_MODELS]
