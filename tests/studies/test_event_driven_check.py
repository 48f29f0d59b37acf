"""The sample solved again event by event: what each stratum holds, how it is drawn, and what its rates count.

That the histories are solved right stands in test_blows.
"""

import made_up_earthquakes as made_up
import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.studies import event_driven_check
from rockdamp.studies.event_driven_check import STRATA, draw, find_strata, rate

AT = ("record", "velocity_ratio", "wall", "restitution", "damping_model", "damping_ratio_source")


@pytest.fixture(scope="module")
def study():
    """Peaks that grow with the intensity, the last axis, up to a collapse; of some the outcome depends on the step."""
    rng = np.random.default_rng(3)
    peak = np.sort(rng.uniform(0, 1.3, (40, 12)), axis=1)
    collapsed = (peak > 1).astype(np.int8)
    converged = (rng.random(peak.shape) > 0.1).astype(np.int8)
    collapsed[0], converged[0] = -1, -1  # without a damping ratio
    collapsed[1], converged[1] = 1, 1
    return peak, collapsed, converged


def test_each_history_is_of_the_stratum_that_its_peak_and_outcomes_say(study):
    peak, collapsed, converged = study
    members = dict(zip(STRATA, find_strata(peak, collapsed, converged, 1), strict=True))
    for i, j in np.ndindex(peak.shape):
        expected = None
        if collapsed[i, j] >= 0 and converged[i, j] == 0:
            expected = "unconverged"
        elif collapsed[i, j] == 0:
            expected = "far" if peak[i, j] < 0.5 else "near" if peak[i, j] < 0.8 else "edge"
        elif collapsed[i, j] == 1 and (j == 0 or collapsed[i, j - 1] == 0):
            expected = "just collapsed"
        assert [name for name, member in members.items() if member[i, j]] == ([expected] if expected else [])
    across = find_strata(peak.T, collapsed.T, converged.T, 0)
    for member, turned in zip(members.values(), across, strict=True):
        np.testing.assert_array_equal(turned, member.T)


def test_as_many_are_drawn_of_each_stratum_as_it_has_up_to_its_share(study):
    members = find_strata(*study, 1)
    places, stratum = draw(members, 100, seed=1)
    assert np.bincount(stratum).tolist() == [min(20, int(member.sum())) for member in members]
    assert all(members[number][*place] for place, number in zip(places, stratum, strict=True))
    assert len(np.unique(places, axis=0)) == len(places)


def test_rates_count_the_outcomes_that_differ_and_the_peaks_beyond_their_bound():
    stratum = np.array([0, 0, 0, 0, 2, 2, 3, 4])
    checked = xr.Dataset(
        {
            "peak": ("history", [0.10, 0.20, 0.30, 0.40, 0.90, 0.95, 1.01, 0.7]),
            "exact_peak": ("history", [0.11, 0.20, 0.30, 0.50, 0.90, 0.99, 0.40, 0.7]),
            "peak_uncertainty": ("history", [0.02, 0.01, 0.01, 0.05, 0.01, 0.01, np.nan, np.nan]),
            "collapsed": ("history", [0, 0, 0, 0, 0, 0, 1, 0]),
            "exact_collapsed": ("history", [0, 0, 0, 0, 0, 1, 1, 0]),
        }
    )
    found = {name: values for name, (_, values) in rate(stratum, checked).items()}
    np.testing.assert_array_equal(found["otherwise_share"], [0, np.nan, 0.5, 0, 0])
    np.testing.assert_array_equal(found["beyond_bound_share"], [0.25, np.nan, 0, np.nan, np.nan])
    np.testing.assert_allclose(found["largest_difference"], [0.2, np.nan, 0, np.nan, 0])
    np.testing.assert_allclose(found["median_difference"], [0.5 / 11, np.nan, 0, np.nan, 0])


# --- those of the study ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def earthquakes():
    return made_up.earthquakes()


@pytest.fixture
def chosen(earthquakes, monkeypatch):
    """The histories that a seed draws, where solving one takes no time."""
    names = earthquakes["record"].values.tolist()
    monkeypatch.setattr(event_driven_check.catalogue, "record_names", lambda _: names)
    monkeypatch.setattr(event_driven_check.catalogue, "motion_name", lambda name: name)
    monkeypatch.setattr(event_driven_check.catalogue, "load_record", lambda name: name)
    monkeypatch.setattr(event_driven_check, "solve_exactly", lambda case, *_: (0.5, False))

    def draw(seed, **given):
        values = {"seed": seed, **given}
        config = changed(configured(), {f"earthquakes.check.{name}": value for name, value in values.items()})
        found = event_driven_check.check_earthquakes(config, earthquakes)
        return list(zip(*(found[name].values.tolist() for name in AT), strict=True)), found

    return draw


def test_a_seed_draws_the_same_histories_again_and_another_seed_draws_others(chosen):
    first, again, other = (chosen(seed)[0] for seed in (1, 1, 2))
    assert first == again and first != other


def test_no_history_is_drawn_twice_and_none_that_was_not_run(chosen, earthquakes):
    for seed in range(3):
        drawn, found = chosen(seed)
        assert len(set(drawn)) == len(drawn) == found.sizes["history"]
        assert (found["collapsed"] >= 0).all()
        for at, peak in zip(drawn, found["peak"].values, strict=True):
            assert float(earthquakes["peak"].sel(dict(zip(AT, at, strict=True)))) == peak
