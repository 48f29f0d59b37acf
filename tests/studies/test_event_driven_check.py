"""The sample solved again event by event: what each stratum holds, how it is drawn, and what its rates count.

That the histories are solved right stands in test_earthquakes.
"""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.studies import event_driven_check
from rockdamp.studies.earthquakes import HISTORY_DIMS
from rockdamp.studies.event_driven_check import STRATA, draw, find_strata, rate


@pytest.fixture(scope="module")
def study():
    """Peaks that grow with the intensity up to a collapse, under CR and under CDR with a ratio from one source."""
    rng, shape = np.random.default_rng(3), (40, 12, 1, 1, 2, 2)
    peak = np.sort(rng.uniform(0, 1.3, shape), axis=1)
    peak[..., 0, :] = peak[..., 0, :1]
    converged = (rng.random(shape) > 0.1).astype(np.int8)
    converged[..., 0, :] = converged[..., 0, :1]
    collapsed = (peak > 1).astype(np.int8)
    collapsed[..., 1, 1] = converged[..., 1, 1] = -1
    values = {
        "peak": peak,
        "peak_uncertainty": 0.01 * peak,
        "collapsed": collapsed,
        "converged": converged,
    }
    return xr.Dataset(
        {name: (HISTORY_DIMS, value) for name, value in values.items()}
        | {"damping_ratio": 0.05, "scale_factor": (HISTORY_DIMS[:3], np.ones(shape[:3]))},
        coords={
            "record": [f"r{i}" for i in range(40)],
            "station": ("record", [f"s{i // 2}" for i in range(40)]),
            "velocity_ratio": np.geomspace(0.2, 5, 12),
            "wall": [configured().earthquakes.walls[0].name],
            "restitution": [0.85],
            "damping_model": ["CR", "CDR"],
            "damping_ratio_source": ["least error", "closed form"],
        },
    )


def test_each_history_is_of_the_stratum_that_its_peak_and_outcomes_say(study):
    members = dict(zip(STRATA, find_strata(study), strict=True))
    peak, collapsed, converged = (study[name].values for name in ("peak", "collapsed", "converged"))
    for at in np.ndindex(peak.shape):
        expected, (i, j, *rest) = [], at
        if rest[-1] == 0:  # the second source has CR's histories again, and no ratio of CDR
            if converged[at] == 0:
                expected = ["unconverged"]
            elif collapsed[at] == 0:
                expected = ["far" if peak[at] < 0.5 else "near" if peak[at] < 0.8 else "edge"]
            elif j == 0 or collapsed[(i, j - 1, *rest)] == 0:
                expected = ["just collapsed"]
        assert [name for name, member in members.items() if member[at]] == expected


def test_as_many_are_drawn_of_each_stratum_as_it_has_up_to_its_share(study):
    members = find_strata(study)
    places, stratum = draw(members, 200, seed=1)
    assert np.bincount(stratum).tolist() == [min(40, int(member.sum())) for member in members]
    assert all(members[number][tuple(place)] for place, number in zip(places, stratum, strict=True))
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


def test_a_seed_draws_the_same_histories_of_the_study_again_and_another_draws_others(
    study, monkeypatch
):
    """Where solving one takes no time."""
    names = study["record"].values.tolist()
    for name, function in (
        ("record_names", lambda _: names),
        ("motion_name", str),
        ("load_record", str),
    ):
        monkeypatch.setattr(event_driven_check.catalogue, name, function)
    monkeypatch.setattr(event_driven_check, "solve_exactly", lambda case, *_: (0.5, False))
    drawn = []
    for seed in (1, 1, 2):
        found = event_driven_check.check_earthquakes(
            changed(configured(), {"earthquakes.check.seed": seed}), study
        )
        drawn.append([*zip(*(found[name].values.tolist() for name in HISTORY_DIMS), strict=True)])
        assert len(set(drawn[-1])) == found.sizes["history"] and (found["collapsed"] >= 0).all()
        places = {name: found[name] for name in HISTORY_DIMS}
        np.testing.assert_array_equal(study["peak"].sel(places), found["peak"])
    assert drawn[0] == drawn[1] != drawn[2]
