"""The damping models' coefficients against the paper's equations, and bad input."""

import copy
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping, damper_classes
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.newmark_kernel import STEPS
from rockdamp.vocabulary import MODELS, PAPER_MODELS, VISCOUS_MODELS

CURVE = TrilinearCurve(0.06, 0.72, 0.9)
X = np.array([-0.95, -0.7, -0.2, -0.06, -0.01, 0.0, 1e-9, 0.03, 0.06, 0.15, 0.28, 0.5, 0.89, 0.9, 1.2])
XI = 0.07


def secant_frequency(x):
    """w over p, Eq. (9), its limit on the first branch included."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.sqrt(np.where(x == 0, CURVE.initial_stiffness, CURVE.force(x) / x))


def test_the_paper_s_three_coefficients_are_eqs_10_11_and_12():
    w, w1 = secant_frequency(X), CURVE.initial_frequency
    expected = {"CDC": 2 * w1 * XI * np.ones_like(X), "CDR": 2 * w * XI, "SDR": 2 * w * (XI * w / w1)}
    for model in PAPER_MODELS:
        np.testing.assert_allclose(Damping(model, XI).coefficient(CURVE, X), expected[model], rtol=1e-14, atol=1e-300)


def test_the_energy_consistent_coefficient_holds_the_force_over_the_root_of_the_stored_energy():
    for x in (0.02, 0.06, 0.2, 0.5, 0.85):
        energy, _ = quad(CURVE.force, 0, x, points=[0.06, 0.28], epsabs=1e-13)
        expected = 2 * XI * CURVE.force(x) / np.sqrt(2 * energy)
        assert Damping("ECD", XI).coefficient(CURVE, x) == pytest.approx(expected, rel=1e-11)
        assert Damping("ECD", XI).coefficient(CURVE, -x) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_a_damper_is_the_linear_oscillator_s_on_the_branches_on_which_it_says_so(model):
    if not Damping(model, XI).linear_branches:
        pytest.skip(f"{model} is no linear oscillator's anywhere")
    inside = CURVE.yield_displacement_ratio * np.array([0.0, 1e-200, 1e-12, 0.3, 1.0])
    expected = 2 * CURVE.initial_frequency * XI
    np.testing.assert_allclose(Damping(model, XI).coefficient(CURVE, inside), expected, rtol=1e-14)


def test_beyond_the_end_of_the_curve_only_the_constant_coefficient_damps():
    for model in (*PAPER_MODELS, "ECD"):
        beyond = Damping(model, XI).coefficient(CURVE, 1.5)
        assert (beyond > 0) == (model == "CDC")


def test_the_restitution_model_has_no_damping_force_in_the_batch_s_shape():
    coefficient = Damping.cr(np.array([0.8, 0.9])).coefficient(CURVE, np.zeros((3, 1)))
    np.testing.assert_array_equal(coefficient, np.zeros((3, 2)))


def test_coefficients_broadcast_curves_ratios_and_displacements():
    curves = TrilinearCurve(np.array([0.02, 0.05])[:, None, None], 0.8)
    ratios = np.array([0.02, 0.05, 0.1])[:, None]
    for damping in (Damping(model, ratios) for model in VISCOUS_MODELS):
        many = damping.coefficient(curves, X)
        assert many.shape == (2, 3, X.size)
        one = damping.replace(damping_ratio=0.05).coefficient(TrilinearCurve(0.05, 0.8), X)
        np.testing.assert_allclose(many[1, 1], one, rtol=1e-14)


def test_the_table_of_names_has_each_damper_s_class_and_each_has_a_title_and_a_colour_alone():
    assert [kind.model for kind in damper_classes().values()] == [*MODELS, "CQD"]
    for texts in (
        [kind.title for kind in damper_classes().values()],
        [kind.colour for kind in damper_classes().values()],
    ):
        assert len({*texts}) == len(texts) and all(texts)


def test_a_damper_is_not_changed_but_made_anew():
    damping = Damping("ECD", XI, order=[1.0, 2.0])
    np.testing.assert_array_equal(damping.map(lambda parameter: 2 * parameter).order, [2.0, 4.0])
    assert damping.replace(order=3.0).parameters == {"damping_ratio": XI, "order": 3.0}
    with pytest.raises(AttributeError, match="damping_ratio cannot be set"):
        damping.damping_ratio = 0.1
    assert damping.parameters["damping_ratio"] == XI and damping.shape == (2,)
    assert copy.copy(damping).shape == pickle.loads(pickle.dumps(damping)).shape == (2,)


BAD = [
    (lambda: Damping("CRD", 0.9), r"damping_model is 'CRD'; it must be one of CR, CDC, CDR, SDR, ECD"),
    (lambda: Damping.cr(-0.1), r"restitution \(e\) is -0\.1; it must be at least 0 and at most 1"),
    (
        lambda: Damping.cr(0.0, exponent=0.2),
        r"restitution \(e\) is 0\.0; it must be greater than 0 .* with an exponent",
    ),
    (lambda: Damping.of_restitution(0.0), r"restitution \(e\) is 0\.0; it must be greater than 0 .*: no damper stops"),
    (lambda: Damping("ECD16", 0.05), r"damping_model is 'ECD16'; it must be ECD, order=16"),
    (lambda: Damping.of_restitution(0.85, "band0.4"), r"damping_model is 'band0\.4'; it must be BAND, width=0\.4"),
    (lambda: Damping.of_restitution([0.5, 0.0], "BAND"), r"restitution \(e\) is 0\.0; it must be greater than 0"),
    (lambda: Damping.cr(np.array([0.9, 1.2])), r"restitution \(e\) is 1\.2; it must be"),
    (lambda: Damping("CDC", -0.01), r"damping_ratio \(xi\) is -0\.01; it must be at least 0"),
    (lambda: Damping.cr(0.9, exponent=-1.0), r"exponent is -1\.0; it must be at least 0"),
    (lambda: Damping("BAND", 0.05, width=0.0), r"width .* is 0\.0; it must be greater than 0"),
    (lambda: Damping("CQD", 0.05, width=1.01), r"width .* is 1\.01; it must be greater than 0 and at most 1"),
    (lambda: Damping("BAND", 1.47), r"damping_ratio \(xi\) is 1\.47; it must be at most 1\.47: e = 0\.01"),
    (lambda: Damping("CQD", 1.47), r"damping_ratio \(xi\) is 1\.47; it must be at most 1\.47: e = 0\.01"),
    (
        lambda: Damping("BAND", 1.0, width=2.0),
        r"damping_ratio \(xi\) is 1\.0; it must be at most 0\.635",
    ),
    (
        lambda: solve(CURVE, Damping("BAND", 0.05, width=0.1), step=0.1, steps=1, release_amplitude=0.1),
        r"step is 0\.1; it must be at most c = t_c/w1 = ",
    ),
    (
        lambda: Damping("CDR", 0.1, 1.0),
        r"CDR takes damping_ratio and nothing else; it was given damping_ratio, another value",
    ),
    (
        lambda: Damping("CDR", 0.1, exponent=1.0),
        r"CDR takes damping_ratio and nothing else; it was given damping_ratio, exponent",
    ),
    (lambda: Damping("ECD"), r"ECD takes damping_ratio, order .*; Damping\.of_restitution\(e, 'ECD'\) makes it of e"),
]


@pytest.mark.parametrize(("make", "message"), BAD, ids=[message.split(";")[0] for _, message in BAD])
def test_bad_damping_is_refused_with_the_name_the_value_and_what_is_allowed(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_every_damper_names_a_step_that_both_schemes_have():
    kinds = {model: damper.step_kind for model, damper in damper_classes().items()}
    assert all({*kinds.values()} == {*steps} for steps in STEPS.values())
    assert (kinds["CR"], kinds["CDC"]) == ("impact", "viscous")
