"""The stage that measures the orders of convergence."""

import numpy as np
import pytest

from rockdamp.studies.accuracy import convergence
from rockdamp.vocabulary import MODELS


@pytest.fixture(scope="module")
def orders(paper):
    return convergence.convergence(paper)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("excitation", ["free", "forced"])
def test_the_default_scheme_is_second_order_for_every_damper(orders, model, excitation):
    order = float(orders["order"].sel(scheme="newmark", damping_model=model, excitation=excitation))
    assert order == pytest.approx(2.0, abs=0.1)


def test_the_printed_scheme_is_first_order_but_for_a_constant_coefficient(orders):
    paper = orders.sel(scheme="paper")
    assert (np.abs(paper["order"].sel(damping_model="CDC") - 2) < 0.1).all()
    # C frozen over the step is a small first-order term, which takes over from the second-order ones at fine steps.
    frozen = paper["finest_order"].sel(damping_model=["CR", "CDR", "SDR", "ECD"])
    assert ((frozen > 0.75) & (frozen < 1.5)).all()
