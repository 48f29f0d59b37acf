"""Modes by Newton's method: of a normal density, at a bound, and of nothing."""

from dataclasses import replace

import numpy as np
import pytest

from rockdamp.identification.modes import _derivatives, _offsets, climb, triangular

CENTRE = np.array([1.0, -2.0, 0.5])
LOWER = np.array([[0.1, 0.0, 0.0], [0.3, 0.02, 0.0], [0.0, 0.01, 1.0]])
BOUNDS = (np.full(3, -9.0), np.full(3, 9.0))


def log_density(points):
    standard = np.linalg.solve(LOWER, (points - CENTRE).T)
    return 7.0 - 0.5 * np.sum(standard**2, axis=0)


def test_the_mode_of_a_normal_density_and_its_covariance_are_found_from_far_away():
    mode = climb(log_density, CENTRE + LOWER @ [20.0, -15.0, 3.0], 0.3 * LOWER, BOUNDS)
    assert mode.log_density == pytest.approx(7.0, abs=0.05)
    assert np.linalg.norm(np.linalg.solve(LOWER, mode.centre - CENTRE)) < 0.3
    np.testing.assert_allclose(mode.lower, LOWER, atol=0.05 * np.abs(LOWER).max())


def test_what_is_not_free_stays_where_it_is():
    mode = climb(log_density, CENTRE + 0.05, LOWER[:2, :2], BOUNDS, free=np.array([0, 1]))
    assert mode.centre[2] == CENTRE[2] + 0.05 and mode.lower.shape == (2, 2)


def test_a_density_that_rises_to_a_bound_has_its_mode_there():
    bounds = (np.array([1.2, -9.0, -9.0]), np.full(3, 9.0))

    def inside(points):
        return np.where(np.all((points > bounds[0]) & (points < bounds[1]), axis=1), log_density(points), -np.inf)

    mode = climb(inside, np.array([1.6, -1.0, 0.5]), LOWER, bounds)
    assert mode.centre[0] == pytest.approx(1.2, abs=0.03)


def test_where_the_density_is_zero_nothing_is_found():
    mode = climb(lambda points: np.full(len(points), -np.inf), CENTRE, LOWER, BOUNDS)
    assert mode.log_density == -np.inf


def test_modes_within_each_others_scale_are_one_but_not_where_something_was_held():
    mode = climb(log_density, CENTRE, LOWER, BOUNDS)
    near, far = (replace(mode, centre=mode.centre + times * LOWER[:, 0]) for times in (0.5, 3.0))
    assert mode.near(near) and not mode.near(far)
    held = climb(log_density, CENTRE, LOWER[:2, :2], BOUNDS, free=np.array([0, 1]))
    assert not held.near(replace(held, centre=CENTRE + [0.0, 0.0, 0.01]))


def test_a_root_of_a_covariance_is_made_triangular_even_if_it_is_nearly_singular():
    root = np.array([[1.0, 2.0, 0.5], [1e-9, 3.0, 1.0], [1.0, 2.0, 0.5 + 1e-12]])
    lower = triangular(root)
    np.testing.assert_allclose(lower @ lower.T, root @ root.T, atol=1e-12)
    assert np.all(np.triu(lower, 1) == 0) and np.all(np.diag(lower) >= 0)


def test_derivatives_of_a_quadratic_are_exact_along_pairs_of_axes_too():
    gradient, curvature = np.array([0.1, -0.2, 0.3]), np.array([[2.0, 0.5, -0.3], [0.5, 1.0, 0.2], [-0.3, 0.2, 3.0]])
    offsets, pairs = _offsets(3)
    around = offsets @ gradient - 0.5 * np.einsum("ni,ij,nj->n", offsets, curvature, offsets)
    found = _derivatives(around, 3, pairs)
    np.testing.assert_allclose(found[0], gradient, atol=1e-12)
    np.testing.assert_allclose(found[1], curvature, atol=1e-12)
