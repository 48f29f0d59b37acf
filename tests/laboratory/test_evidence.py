"""Probabilities of models from their evidence."""

import numpy as np

from rockdamp.laboratory.posterior import probabilities


def test_models_are_as_probable_as_their_evidence_says_and_those_without_one_are_left_out():
    found = probabilities(np.array([[-9000.0, -9000.0 - np.log(3.0), np.nan], [np.nan, np.nan, np.nan]]))
    np.testing.assert_allclose(found[0], [0.75, 0.25, np.nan])
    assert np.isnan(found[1]).all()
