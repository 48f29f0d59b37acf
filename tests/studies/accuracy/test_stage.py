"""The accuracy stage: errors of the solver, the dataset and its figures, on small real runs."""

import numpy as np
import pytest
from figure_functions import FIGURES

from rockdamp.figures.style import style_of
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies.accuracy import ensemble
from rockdamp.studies.accuracy.stage import solver_errors
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

# --- the solver ------------------------------------------------------------------------------------------------------


def test_the_steps_are_those_of_the_config_with_the_solvers_own(stage, config):
    assert stage["step"].values.tolist() == [0.02, 0.01, 0.005, 0.0025]
    assert float(stage["solver_step"]) == 0.01
    assert float(stage["published_step"]) == 0.01 / config["matching"]["refinement"]


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
    assert float(one["largest_difference"]) >= np.abs(found - expected).max() * (1 - 1e-6) > rms
    assert float(one["largest_displacement"][case, e]) >= np.abs(expected).max()


def test_medians_and_largest_errors_are_over_walls_and_restitutions(stage):
    error = (
        stage["solver_error"]
        .transpose("excitation", "damping_model", "step", ...)
        .values.reshape(2, len(MODELS), 4, -1)
    )
    np.testing.assert_allclose(stage["median_solver_error"], np.median(error, axis=-1))
    np.testing.assert_allclose(stage["largest_solver_error"], error.max(axis=-1))
    np.testing.assert_allclose(stage["order"], ensemble.fitted_order(stage["step"], stage["median_solver_error"]))


def test_a_solver_that_does_not_converge_shows(drawn, stage):
    class Wrong(ensemble.Ensemble):
        def histories(self, *arguments):
            displacement, velocity = super().histories(*arguments)
            return 1.01 * displacement, velocity

    few = {
        "curve": drawn.curve.map(lambda p: p[:1]),
        "load": drawn.load[:1],
        "factor": drawn.factor[:1],
        "release_amplitude": drawn.release_amplitude[:1],
        "ratio": {m: r[:1] for m, r in drawn.ratio.items()},
    }
    found = solver_errors(Wrong(**{**drawn.__dict__, **few}), step=0.01, refinement=8)
    assert (found["order"] < 0.5).all()
    assert (stage["order"] > 1.5).all()  # 2, less the scatter of a few walls


# --- the dataset and its figures -------------------------------------------------------------------------------------


def test_the_stage_returns_what_the_registry_says(stage):
    dataset.check(stage, "accuracy")
    assert {str(name) for name in stage.variables} == set(dataset.variables("accuracy", "slenderness"))


def test_fig_accuracy_shows_errors_orders_and_uncertainties(stage):
    figure = FIGURES["fig_accuracy"](stage)
    free, forced, shares, sample = figure.axes
    for axes, excitation in ((free, "free"), (forced, "forced")):
        for model in MODELS:
            one = stage.sel(excitation=excitation, damping_model=model)
            (line,) = (line for line in axes.get_lines() if str(line.get_label()).startswith(f"{model}:"))
            np.testing.assert_array_equal(line.get_ydata(), one["median_solver_error"])
            assert line.get_label() == f"{model}: {float(one['order']):.2f}"
            (marks,) = (line for line in axes.get_lines() if line.get_marker() == style_of(model).marker)
            np.testing.assert_array_equal(marks.get_ydata(), one["largest_solver_error"])
    for model in VISCOUS_MODELS:
        one = stage.sel(viscous_model=model)
        (line,) = (line for line in shares.get_lines() if str(line.get_label()).startswith(f"{model}:"))
        np.testing.assert_array_equal(line.get_xdata(), one["uncertainty_quantile"])
        np.testing.assert_allclose(line.get_ydata(), 1 - one["quantile"])
        (marks,) = (line for line in sample.get_lines() if line.get_label() == model)
        np.testing.assert_allclose(marks.get_ydata(), np.clip(np.abs(one["sample_difference"]), 1e-6, None))


def test_fig_accuracy_does_not_round_a_share_up_to_all(stage):
    nearly = stage.copy(deep=True)
    nearly["share_within_thousandth"][:] = 0.9996
    legend = FIGURES["fig_accuracy"](nearly).axes[2].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"{model}: 99.9 %" for model in VISCOUS_MODELS]


def test_fig_rigid_shows_every_difference_with_1_and_5_percent(stage):
    figure = FIGURES["fig_rigid"](stage)
    (axes,) = figure.axes
    lines = axes.get_lines()
    assert sorted(line.get_ydata()[0] for line in lines if len(set(line.get_ydata())) == 1) == [0.01, 0.05]
    for feature in stage["rocking_feature"].values:
        values = np.abs(stage["rocking_difference"].sel(rocking_feature=feature).values[0, 0])
        assert any(np.array_equal(line.get_ydata(), values) for line in lines)
