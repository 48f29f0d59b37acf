"""Priors: from values to the unit cube and back, and what is no prior."""

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.laboratory.candidates import Prior
from rockdamp.statistics.distribution import Distribution


def test_points_of_the_unit_cube_lead_back_to_values_and_a_logarithm_is_where_it_is_asked_for():
    names, values = ("yield_displacement_ratio", "strength_ratio"), np.array([[0.05, 0.8], [0.1, 0.6]])
    points = Prior().points(names, values)
    of_a1 = np.log(values[:, 0] / 0.015) / np.log(0.20 / 0.015)
    np.testing.assert_allclose(points, np.stack([of_a1, (values[:, 1] - 0.40) / 0.55], axis=1))
    np.testing.assert_allclose(Prior().values(names, points), values)


def test_a_section_changes_what_it_names_and_nothing_else():
    given = {"strength_ratio": {"distribution": "uniform", "low": 0.6, "high": 0.9}, "sensor_zero": 1e-4}
    made = Prior.from_mapping(given)
    assert made.strength_ratio == Distribution("uniform", 0.6, 0.9) and made.sensor_zero == 1e-4
    assert made.restitution == Prior().restitution


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"stiffness": 1}, "prior.stiffness is not a key"),
        ({"restitution": {"distribution": "uniform", "low": 0.9, "high": 1.1}}, "restitution is 1.1"),
        ({"strength_ratio": {"distribution": "uniform", "low": 0.9, "high": 1.0}}, "strength_ratio is 1.0"),
        ({"sensor_correlation": {"distribution": "uniform", "low": 0.0, "high": 1.0}}, "between -1 and 1"),
        ({"sensor_drift": 0}, "sensor_drift is 0.0; it must be greater than 0"),
    ],
)
def test_what_is_no_prior_is_refused_by_its_name(given, message):
    with pytest.raises(InputError, match=message):
        Prior.from_mapping(given)
