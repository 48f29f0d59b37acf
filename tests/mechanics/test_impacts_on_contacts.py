"""The restitution of two rigid bodies on contacts, by Moreau's time stepping.

Contacts of Newton's law at the corners and supports that hold: the impact takes as much as
`restitution_impulsive` says, and not Eq. (7).
"""

from dataclasses import replace

import numpy as np
import pytest
from contacts import TwoBodiesOnContacts

from rockdamp.mechanics.wall import Wall

# Thickness, height [m] and h1/h.
SHAPES = (
    (0.3, 3.0, 0.5),
    (0.3, 4.5, 0.7),
    (0.4, 4.0, 0.6),
    (0.3, 2.1, 0.62),
    (0.25, 5.0, 0.7),
)
LIGHT = [Wall(t, h, hinge_ratio=r) for t, h, r in SHAPES]
LOADED = [replace(wall, overburden_ratio=2.0) for wall in LIGHT]
STEP = 5e-4  # in tau


def name_wall(wall):
    return f"{wall.thickness} {wall.height} {wall.overburden_ratio}"


def remaining(wall, peaks):
    """Return sqrt(V) of each peak over that of the one before, with V of the rigid law."""
    energy = float(wall.rigid_strength) * peaks - float(wall.rigid_stiffness) * peaks**2 / 2
    return np.sqrt(energy[1:] / energy[:-1])


def release(wall, restitution=0.0):
    """Return the share of sqrt(V) after the first impact, and the largest opening over u_ins."""
    u_ins = float(wall.instability_displacement)
    step = STEP / float(wall.frequency_parameter)
    peaks, opening = TwoBodiesOnContacts(wall).peaks(0.5 * u_ins, step, 1, restitution)
    return remaining(wall, peaks)[0], opening / u_ins


every_wall = pytest.mark.parametrize("wall", LIGHT + LOADED, ids=name_wall)


@every_wall
def test_impact_has_the_impulses_of_all_contacts(wall):
    """Both bodies go on rocking at once, on their new corners: nothing bounces."""
    bodies = TwoBodiesOnContacts(wall)
    after = bodies.after_impact()
    e = -float(bodies.hinge @ after)
    assert e == pytest.approx(float(wall.restitution_impulsive), rel=1e-12)
    np.testing.assert_allclose(after, -e * bodies.rocking(-1), atol=1e-12)


@every_wall
def test_released_wall_has_the_impulsive_restitution(wall):
    e, opening = release(wall)
    assert e == pytest.approx(float(wall.restitution_impulsive), abs=1e-3)
    assert opening < 1e-12
    assert float(wall.restitution_rigid) - e > 0.03  # Eq. (7) is another


@pytest.mark.parametrize("wall", [LIGHT[1], LOADED[2]], ids=["slender", "loaded"])
@pytest.mark.parametrize(("bounce", "least_opening"), [(0.3, 1e-3), (0.6, 5e-3)])
def test_bouncing_corners_lose_hardly_less(wall, bounce, least_opening):
    """The energy of the bounces is lost at the next contacts."""
    e, opening = release(wall, bounce)
    assert opening > least_opening
    assert e == pytest.approx(float(wall.restitution_impulsive), abs=2e-3)
