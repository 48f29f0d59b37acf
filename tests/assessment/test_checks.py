"""The checks in the engineer's words, from the histories of one wall."""

from dataclasses import replace

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.checks import FIRST_DIAPHRAGM, checks, sensitivity


def test_the_checks_state_what_the_histories_did(answer, wall, curve, motions):
    u_ins = float(wall.instability_displacement)
    low, high = checks(answer, wall, curve, motions)
    cr = answer.sel(damping_model="CR")
    for index, check in enumerate((low, high)):
        peaks = np.nan_to_num(cr["peak"].isel(intensity=index).values, nan=np.inf)
        # Half, and 84 %, of the records do not pass these peaks, and fewer do not pass the next smaller ones.
        assert np.mean(u_ins * peaks <= check.median_peak) >= 0.5 > np.mean(u_ins * peaks < check.median_peak)
        assert check.rocking_share == np.mean(peaks > float(curve.yield_displacement_ratio))
        assert np.mean(u_ins * peaks <= check.upper_peak) >= 0.84 > np.mean(u_ins * peaks < check.upper_peak)
    assert low.margin == pytest.approx(2 * high.margin) == pytest.approx(float(cr["median_pgv"]) / 0.4)
    shaken = [0.4 / m.pgv * m.pga for m in (rd.intensity_measures(motion.record) for motion in motions)]
    assert low.support_acceleration == pytest.approx(np.median(shaken))


def test_below_the_onset_a_wall_may_rock_as_it_vibrates_and_the_histories_decide(wall):
    """Sines at 0.6 of the onset: two near the frequency of the first branch, and one far above it."""
    curve, elapsed = rd.TrilinearCurve(0.06, 0.72), np.arange(0.0, 6.0, 0.005)
    own = float(wall.frequency_parameter) * np.sqrt(0.72 / 0.06)
    onset = float(wall.rocking_onset(0.72))
    motions = [
        rd.GroundMotion(str(times), str(times), "own", rd.Record(elapsed, np.sin(times * own * elapsed)))
        for times in (0.8, 1.0, 20.0)
    ]
    answer = rd.assess(wall, curve, motions, pga=0.6 * onset, restitution=0.9)  # warnings are errors
    (check,) = checks(answer, wall, curve, motions)
    assert check.support_acceleration < check.rocking_onset
    assert check.rocking_share == pytest.approx(2 / 3) and check.rocks
    assert check.rocking_in_words(3) == "it rocks under 2 of 3, as its first branch vibrates"
    assert check._replace(rocking_share=0.0).rocking_in_words(3) == "it does not rock"
    assert check._replace(rocking_share=1.0, rocking_onset=0.0).rocking_in_words(3) == "it rocks"


def test_a_wall_that_collapses_has_infinite_peaks(wall, motions):
    curve = rd.TrilinearCurve.preset("severe")
    answer = rd.assess(wall, curve, motions, pgv=3.5, restitution=0.85)
    (check,) = checks(answer, wall, curve, motions)
    assert check.rocking_share == 1 and check.median_peak == check.upper_peak == np.inf


def test_inputs_are_changed_by_what_is_left_open_without_a_test_and_a_bare_wall_gets_half_its_weight(
    wall, curve, motions
):
    bare, few = replace(wall, overburden_ratio=0.0), motions[:4]
    tried = sensitivity(bare, curve, 0.85, few, "PGV", 0.8, 3.0)
    values = {
        name: [one.value for one in tried if one.name == name] for name in dict.fromkeys(one.name for one in tried)
    }
    e, hinge, a1, overburden, floor = values.values()
    assert e == pytest.approx([0.80, 0.90]) and overburden == [0.5] and floor == [FIRST_DIAPHRAGM]
    assert hinge == pytest.approx([wall.hinge_ratio - 0.1, wall.hinge_ratio + 0.1])
    assert a1 == pytest.approx([factor * curve.yield_displacement_ratio for factor in (0.5, 2.0)])
    loaded = rd.assess(replace(bare, overburden_ratio=0.5), curve, few, pgv=0.8, restitution=0.85)
    (heavier,) = (one for one in tried if one.value == 0.5 and one.name.startswith("overburden"))
    assert heavier.share == float(loaded["collapse_probability"].sel(damping_model="CR")[0])
    assert not any("mass" in name for name in values)  # what lies on it has none
    assert heavier.median == pytest.approx(float(loaded["median_pgv"].sel(damping_model="CR")))


def test_an_overburden_becomes_a_mass_and_a_mass_becomes_none(wall, curve, motions):
    for mass, other in ((0.0, 1.0), (0.5, 0.0)):
        placed = replace(wall, overburden_ratio=1.0, overburden_mass=mass)
        tried = sensitivity(placed, curve, 0.85, motions, "PGV", 0.8, 3.0)
        (changed,) = (one for one in tried if one.name == "part of the overburden that moves as a mass")
        own = rd.assess(replace(placed, overburden_mass=other), curve, motions, pgv=0.8, restitution=0.85)
        assert changed.value == other
        assert changed.median == pytest.approx(float(own["median_pgv"].sel(damping_model="CR")), rel=1e-9)


def test_a_parapet_in_a_building_moves_with_the_floor_below_it_alone_when_an_input_changes(motions):
    """Of each changed e the share is that of an assessment under the motion of one floor."""
    parapet, curve = rd.Parapet(0.25, 1.0), rd.TrilinearCurve.preset("new")
    building, few = rd.Building(period=0.3, storeys=3, storey=3), motions[:4]
    floors = rd.floor_motions(few, building, parapet=True)
    tried = sensitivity(parapet, curve, 0.85, floors, "PGV", 0.15, 1.0, building)
    own = rd.assess(parapet, curve, floors, pgv=0.15, restitution=0.8, tail=1.0).sel(damping_model="CR")
    (lower, _) = (one for one in tried if one.name.startswith("coefficient of restitution"))
    assert lower.value == pytest.approx(0.8)
    assert lower.median == pytest.approx(float(own["median_pgv"]), rel=1e-9)
