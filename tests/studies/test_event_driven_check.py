"""The sample solved again event by event: its strata, its draw, and its rates.

`test_earthquakes` checks that the histories themselves are right.
"""

import numpy as np
import pytest
from configs import changed, configured
from made_datasets import make_dataset

from rockdamp.studies import event_driven_check
from rockdamp.studies.earthquakes import HISTORY_DIMS
from rockdamp.studies.event_driven_check import STRATA, check_earthquakes, draw, find_strata, rate


@pytest.fixture(scope="module")
def study():
    """Peaks that grow with the intensity up to a collapse, under CR and CDR.

    CDR has a ratio from the first source only; CR's histories are the same for both sources.
    """
    rng = np.random.default_rng(3)
    shape = (40, 12, 1, 1, 2, 2)
    peak = np.sort(rng.uniform(0, 1.3, shape), axis=1)
    peak[..., 0, :] = peak[..., 0, :1]
    converged = (rng.random(shape) > 0.1).astype(np.int8)
    converged[..., 0, :] = converged[..., 0, :1]
    collapsed = (peak > 1).astype(np.int8)
    collapsed[..., 1, 1] = -1
    converged[..., 1, 1] = -1
    coordinates = {
        "record": [f"r{number}" for number in range(40)],
        "velocity_ratio": np.geomspace(0.2, 5, 12),
        "wall": [configured().earthquakes.walls[0].name],
        "restitution": [0.85],
        "damping_model": ["CR", "CDR"],
        "damping_ratio_source": ["least error", "closed form"],
    }
    stations = [f"s{number // 2}" for number in range(40)]
    study = make_dataset(
        "earthquakes",
        {name: coordinates[name] for name in HISTORY_DIMS},
        peak=peak,
        peak_uncertainty=0.01 * peak,
        collapsed=collapsed,
        converged=converged,
        damping_ratio=0.05,
        scale_factor=(HISTORY_DIMS[:3], np.ones(shape[:3])),
    )
    return study.assign_coords(station=("record", stations))


# --- strata ---------------------------------------------------------------------------------------


def expected_stratum(study, index):
    """Return the stratum of a history, or None if it belongs to none."""
    collapsed = study["collapsed"].values
    peak = study["peak"].values[index]
    record, intensity, *others = index
    if others[-1] == 1:
        return None  # the second source has CR's histories again, and no ratio of CDR
    if study["converged"].values[index] == 0:
        return "unconverged"
    if collapsed[index] == 0:
        return "far" if peak < 0.5 else "near" if peak < 0.8 else "edge"
    if intensity == 0 or collapsed[(record, intensity - 1, *others)] == 0:
        return "just collapsed"
    return None


def test_histories_are_of_the_stratum_of_their_outcome(study):
    strata = find_strata(study)
    for index in np.ndindex(study["peak"].shape):
        names = [name for name, members in zip(STRATA, strata, strict=True) if members[index]]
        expected = expected_stratum(study, index)
        assert names == ([] if expected is None else [expected])


def test_draw_takes_a_share_of_each_stratum(study):
    strata = find_strata(study)
    _, stratum = draw(strata, 200, seed=1)
    assert np.bincount(stratum).tolist() == [min(40, int(members.sum())) for members in strata]


def test_draw_takes_members_once(study):
    strata = find_strata(study)
    places, stratum = draw(strata, 200, seed=1)
    pairs = zip(places, stratum, strict=True)
    assert all(strata[number][tuple(place)] for place, number in pairs)
    assert len(np.unique(places, axis=0)) == len(places)


# --- rates ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rates():
    stratum = np.array([0, 0, 0, 0, 2, 2, 3, 4])
    checked = make_dataset(
        "earthquake_check",
        {"history": 8},
        peak=[0.10, 0.20, 0.30, 0.40, 0.90, 0.95, 1.01, 0.7],
        exact_peak=[0.11, 0.20, 0.30, 0.50, 0.90, 0.99, 0.40, 0.7],
        peak_uncertainty=[0.02, 0.01, 0.01, 0.05, 0.01, 0.01, np.nan, np.nan],
        collapsed=[0, 0, 0, 0, 0, 0, 1, 0],
        exact_collapsed=[0, 0, 0, 0, 0, 1, 1, 0],
    )
    return {name: values for name, (_, values) in rate(stratum, checked).items()}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("otherwise_share", [0, np.nan, 0.5, 0, 0]),
        ("beyond_bound_share", [0.25, np.nan, 0, np.nan, np.nan]),
        ("largest_difference", [0.2, np.nan, 0, np.nan, 0]),
        ("median_difference", [0.5 / 11, np.nan, 0, np.nan, 0]),
    ],
)
def test_rates_count_outcomes_and_errors(rates, name, expected):
    np.testing.assert_allclose(rates[name], expected)


# --- stage ----------------------------------------------------------------------------------------


@pytest.fixture
def check(study, monkeypatch):
    """The stage, with histories that need no time to solve."""
    record_names = study["record"].values.tolist()
    catalogue = event_driven_check.catalogue
    monkeypatch.setattr(catalogue, "record_names", lambda _: record_names)
    monkeypatch.setattr(catalogue, "motion_name", str)
    monkeypatch.setattr(catalogue, "load_record", str)
    monkeypatch.setattr(event_driven_check, "solve_exactly", lambda *_: (0.5, False))

    def check_by(seed):
        return check_earthquakes(changed(configured(), {"earthquakes.check.seed": seed}), study)

    return check_by


def places(checked):
    return {name: checked[name].values.tolist() for name in HISTORY_DIMS}


def test_seed_draws_the_same_histories_again(check):
    assert places(check(1)) == places(check(1))


def test_another_seed_draws_other_histories(check):
    assert places(check(1)) != places(check(2))


def test_checked_histories_are_those_of_the_study(check, study):
    checked = check(1)
    indexers = {name: checked[name] for name in HISTORY_DIMS}
    np.testing.assert_array_equal(study["peak"].sel(indexers), checked["peak"])
    assert (checked["collapsed"] >= 0).all()
    assert len(set(zip(*places(checked).values(), strict=True))) == checked.sizes["history"]
