"""The report's section on walls that rock to one side, of a study whose answers are known."""

import pytest
from html_page import words
from made_up_studies import made_up

from rockdamp.report.page import one_sided_finding

STOP, SOFT, PULLING = "stop, 2500 k1", "stop, 400 k1", "pulling stop, 2500 k1"


@pytest.fixture
def study():
    data = made_up()["one_sided"].copy(deep=True)
    data["median_ratio"][:] = 1.0
    for name, (first, last) in {STOP: (0.95, 1.02), SOFT: (0.8, 1.1), PULLING: (0.97, 1.01)}.items():
        data["median_ratio"].loc[{"alternative": name, "restitution": 0.3, "band": 1}] = first
        data["median_ratio"].loc[{"alternative": name, "restitution": 0.7, "band": 2}] = last
    for name, rate in {STOP: 0.05, "CR, e - 0.02": 0.03, "CR, e + 0.02": 0.06, SOFT: 0.2}.items():
        data["false_safe_rate"].loc[{"alternative": name}] = rate
        data["false_collapse_rate"].loc[{"alternative": name}] = 2 * rate
    data["median_intensity_ratio"][:] = 1.5
    data["median_intensity_ratio"].loc[{"alternative": STOP}] = [[0.9, 0.95, 1.0], [1.0, 1.03, 1.0]]
    data["two_sided_intensity_ratio"][:] = 2.0
    data["two_sided_intensity_ratio"].loc[{"restitution": 0.5}] = [[1.03, 0.8], [1.4, 1.1]]
    return data


def test_the_numbers_are_those_of_the_stop_that_the_commands_take(study):
    found = one_sided_finding(study)
    assert (found["taken"], found["peaks"], found["medians"]) == (STOP, "0.95 to 1.02", "0.90 to 1.03")
    assert found["others"] == [(SOFT, "0.80 to 1.10", False), (PULLING, "0.97 to 1.01", True)]


def test_what_is_missed_stands_beside_the_larger_of_both_changes_of_e(study):
    study["false_safe_rate"].loc[{"alternative": "CR, e - 0.02", "restitution": 0.5}] = 0.08
    rates = one_sided_finding(study)["rates"]
    assert [row["e"] for row in rates] == ["0.3", "0.5", "0.7"]
    assert {row["own"].replace("\xa0", " ") for row in rates} == {"5 % and 10 %"}
    assert [row["changed"].replace("\xa0", " ") for row in rates] == ["6 % and 12 %", "8 % and 12 %", "6 % and 12 %"]


def test_the_two_sided_wall_is_named_where_it_is_unsafe(study):
    found = one_sided_finding(study)
    assert found["unsafe"] == "house, 3 m (e = 0.8) and church front, 12 m (e = 0.8 and 0.9)"


def test_a_small_study_has_its_own_stop_and_dashes(study):
    small = study.sel(alternative=[name for name in study["alternative"].values if name != STOP])
    small["median_ratio"][:] = float("nan")
    found = one_sided_finding(small)
    assert (found["taken"], found["peaks"]) == (SOFT, "–")


def test_the_page_says_it_with_the_figure(page, content):
    section = words(page.by_id("one-side")["text"])
    found = one_sided_finding(content.datasets["one_sided"])
    for text in (found["peaks"], found["medians"], found["changed"], found["middle"]):
        assert text in section
    assert words(page.by_id("fig_one_sided")["text"]) in section
