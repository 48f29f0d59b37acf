"""Simulated records: what makes them, how their ranks are gathered, and noise that is added to a test_series's."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory.simulated import Judged, gathered
from rockdamp.laboratory.stages import maker_of, noisier, supported
from rockdamp.motions.records import read_record

NAMES = ("yield_displacement_ratio", "strength_ratio", "restitution", "sensor_deviation", "sensor_correlation")


@pytest.fixture(scope="module")
def given():
    return configured()


def test_a_record_is_made_of_parameters_that_rock_and_stand(given):
    maker = maker_of(given)
    record, values = maker.record(np.random.RandomState([7, 0]))
    again, same = maker.record(np.random.RandomState([7, 0]))
    assert record == again and np.array_equal(values, same)
    assert maker.prior.sensor_deviation == given.identification.simulated.sensor_deviation
    inside = maker.prior.points(NAMES, values[None])[0]
    assert np.all((0 < inside) & (inside < 1))
    u_ins = float(given.validation.wall.instability_displacement)
    assert values[0] * u_ins < np.ptp(record.displacement) < 2 * u_ins


def test_an_interval_holds_the_truth_where_its_rank_is_in_the_middle_and_refused_records_do_not_count():
    ranks = np.tile((np.arange(100) + 0.5)[:, None] / 100, (1, 5))
    ranks[:, 1], ranks[:, 2] = 0.97, 0.03
    nothing = np.full(5, np.nan)
    records = [Judged(nothing, rank, nothing, nothing, rank[:3]) for rank in ranks]
    found = gathered(NAMES, [*records, Judged(nothing, nothing, nothing, nothing, np.full(3, np.nan))])
    assert int(found["identified_records"]) == 100
    np.testing.assert_allclose(found["coverage"].sel(level=0.5), [0.5, 0, 0, 0.5, 0.5])
    np.testing.assert_allclose(found["coverage"].sel(level=0.9), [0.9, 0, 0, 0.9, 0.9])
    assert found["rank_p_value"][0] > 0.99 and found["rank_p_value"][1] < 1e-6
    assert np.isnan(found["coverage_by_least_squares"][:, 3:]).all()


def test_noise_is_added_until_it_is_the_multiple_asked_for():
    record = read_record(ROOT / "data/test_series/cr-half.csv")
    more = noisier(record, 3.0, np.random.RandomState(1))
    for name, before in (("ground_acceleration", 0.02), ("displacement", 1.5e-4)):
        added = getattr(more, name) - getattr(record, name)
        assert added.std() == pytest.approx(np.sqrt(8) * before, rel=0.1)
    assert noisier(record, 1.0, np.random.RandomState(1)) == record


def test_a_test_series_of_measured_records_is_refused(given):
    record = read_record(ROOT / "data/test_series/cr-half.csv")
    with pytest.raises(InputError, match="identification.test_series: mine is not synthetic"):
        supported(given, {"mine": replace(record, header={**record.header, "synthetic": "no"})})
