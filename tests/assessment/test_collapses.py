"""Near to collapse the step is finer: which histories that are, and that they are those of the finer step."""

import numpy as np

import rockdamp as rd
from rockdamp.assessment.collapses import HALVINGS, NEAR, near_to_collapse, refined
from rockdamp.histories.loads import run_record
from rockdamp.mechanics.specimen import Specimen


def test_large_peaks_that_stand_and_first_collapses_are_near():
    factor = np.array([[3.0, 1.0, 2.0, -4.0]])  # not in order; the sign turns a record round
    collapsed = np.array([[[True], [False], [False], [True]]])
    peak = np.array([[[9.0], [NEAR - 0.01], [NEAR], [9.0]]])
    assert near_to_collapse(peak, collapsed, factor)[0, :, 0].tolist() == [True, False, True, False]
    again = np.array(
        [[[True], [True], [False], [True]]]
    )  # the weakest collapses it, the next does not
    assert near_to_collapse(peak, again, factor)[0, :, 0].tolist() == [True, True, True, False]


def test_near_collapse_the_answer_is_that_of_the_finest_step_and_elsewhere_of_the_usual(
    motions, curve
):
    walls, record = rd.Wall(np.array([0.25, 0.3]), 3.0), motions[2].record
    factor = np.array([[0.5, 1.0, 2.0, 4.0]] * 2)
    dampings = [rd.Damping("CR", 0.85), rd.Damping.from_restitution(0.85, "ECD")]
    specimens = [Specimen(walls, curve, damping) for damping in dampings]
    options = {"step": 0.2, "tail": 3.0}
    peak, collapsed, coarser = refined(record, specimens, factor, **options)
    runs = []
    for halvings in (0, 1, 2):
        ended = [
            run_record(record, specimen, factor.T, **options, halvings=halvings)
            for specimen in specimens
        ]
        runs.append(
            [
                np.stack([getattr(end, name).T for end in ended], axis=-1)
                for name in ("peak", "collapsed")
            ]
        )
    near = near_to_collapse(*runs[0], factor)
    assert near.any() and not near.all() and HALVINGS == 2
    np.testing.assert_array_equal(collapsed, np.where(near, runs[2][1], runs[0][1]))
    np.testing.assert_array_equal(coarser, np.where(near, runs[1][1], runs[0][1]))
    stands = ~collapsed
    np.testing.assert_array_equal(peak[stands], np.where(near, runs[2][0], runs[0][0])[stands])
