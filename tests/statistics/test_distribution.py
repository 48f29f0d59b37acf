"""Distributions between two bounds: their quantiles against SciPy's, and what is no distribution."""

import math

import numpy as np
import pytest
from scipy import stats

from rockdamp.errors import InputError
from rockdamp.statistics.distribution import Distribution

P = np.linspace(0, 1, 11)
CASES = [
    (Distribution("uniform", -1.0, 3.0), stats.uniform(-1, 4)),
    (Distribution("loguniform", 0.03, 0.14), stats.loguniform(0.03, 0.14)),
    (Distribution("normal", 0.78, 0.94, 0.86, 0.03), stats.truncnorm(-8 / 3, 8 / 3, 0.86, 0.03)),
]


@pytest.mark.parametrize(("made", "peer"), CASES, ids=lambda case: getattr(case, "distribution", ""))
def test_quantiles_are_scipys_and_reach_from_bound_to_bound(made, peer):
    values = made.quantile(P)
    np.testing.assert_allclose(values, peer.ppf(P), rtol=1e-12)
    np.testing.assert_allclose([values[0], values[-1]], [made.low, made.high], rtol=1e-12)
    np.testing.assert_allclose(made.probability(values), P, atol=1e-12)
    np.testing.assert_array_equal(made.probability([-100.0, 100.0]), [0, 1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("normall", 0, 1), "distribution is 'normall'; it must be one of uniform, loguniform, normal"),
        (("uniform", 1, 1), "high is 1; it must be greater than low, 1"),
        (("uniform", 0, math.nan), "high is nan; it must be a finite number"),
        (("loguniform", 0, 1), "low is 0; it must be greater than 0 for loguniform"),
        (("normal", 0, 1), "distribution is 'normal'; mean and standard_deviation must be stated"),
        (("uniform", 0, 1, 0.5, 0.1), "distribution is 'uniform'; mean and standard_deviation must be stated"),
        (("normal", 0, 1, 0.5, 0), "standard_deviation is 0; it must be greater than 0"),
    ],
)
def test_what_is_no_distribution_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        Distribution(*arguments)
