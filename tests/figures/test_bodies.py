"""The rigid bodies as they are drawn, at any displacement."""

import numpy as np
import pytest

from rockdamp.figures.mechanism import wall_corners


@pytest.mark.parametrize("offset", [-0.2, 0.05])
def test_the_drawn_bodies_keep_their_shape_and_touch_at_the_hinge(offset):
    lower, upper = wall_corners(0.3, 4.0, 0.7, offset)
    for corners, height in ((lower, 2.8), (upper, 1.2)):
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        np.testing.assert_allclose(sides, [0.3, height, 0.3, height])
    np.testing.assert_allclose(lower[3], upper[3], atol=1e-12)  # the hinge
    side = -1 if offset < 0 else 1
    np.testing.assert_allclose(lower[3, 0], -0.15 * side + offset)
    np.testing.assert_allclose(lower[1], [0.15 * side, 0.0], atol=1e-12)  # the base corner that it turns about
    np.testing.assert_allclose(upper[1, 0], 0.15 * side, atol=1e-12)  # the support holds the top


def test_a_parapet_is_drawn_as_one_body():
    (block,) = wall_corners(0.3, 2.0, float("nan"), -0.1)
    np.testing.assert_allclose(block[3, 0], 0.15 - 0.1)
