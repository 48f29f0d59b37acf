"""The first screen of the report: its numbers are those of the datasets, and it says where they disagree with it."""

import dataclasses
import json
import re
from html import unescape

import made_up_earthquakes as made_up
import made_up_studies
import numpy as np
import pytest
import xarray as xr
from html_page import Page

from rockdamp import report
from rockdamp.equivalence.programs import OFFERS
from rockdamp.report.answer import CERTAINTY, answer, by_program, ratios, selection, shown_ratio
from rockdamp.report.earthquake_criterion import off
from rockdamp.text import percent
from rockdamp.vocabulary import RECOMMENDED, RECOMMENDED_ORDER, RECOMMENDED_SOURCE, VISCOUS_MODELS


@pytest.fixture
def data(short):
    return dict(short.datasets)


def page_of(short, data):
    return " ".join(words(report.build(dataclasses.replace(short, datasets=data))).split())


def words(html):
    return unescape(re.sub(r"<[^>]+>", "", html)).replace("\u00a0", " ")


def costed(data, cost, changed):
    """The recommendation with these numbers of the recommended damper at each e, and of a change of e."""
    advice = data["recommendation"].copy(deep=True)
    for (_, name, of_change, _), own, other in zip(CERTAINTY, cost, changed, strict=True):
        advice[name].loc[{"damping_model": RECOMMENDED, "damping_ratio_source": RECOMMENDED_SOURCE}] = own
        advice[of_change][:] = other
    return {**data, "recommendation": advice}


@pytest.mark.parametrize(
    ("cost", "within"),
    [
        ((0.05, 0.006, 0.03, 0.012, 0.009), True),
        ((0.05, 0.02, 0.03, 0.012, 0.009), False),
        ((0.05, 0.006, 0.05, 0.012, 0.009), False),
        ((0.05, 0.006, 0.03, 0.06, 0.009), False),
    ],
)
def test_every_cost_stands_beside_that_of_the_change_of_e_which_is_more_only_where_every_one_is(
    short, data, cost, within
):
    page = page_of(short, costed(data, cost, (0.09, 0.01, 0.04, 0.052, 0.071)))
    assert (", which is more in each row." in page) == within
    for name, own, other in zip(("missed", "added"), cost[3:], ("5.2", "7.1"), strict=True):
        assert f"collapses {name}{percent(own)}{other} %".replace("\u00a0", " ") in page
    assert "root mean square5.1 %9.4 %" in page
    assert f"1 in 10 exceeds{off(cost[2])}4.1 %".replace("\u00a0", " ") in page


def test_the_errors_follow_the_slider_over_the_e_of_the_study(short, data):
    errors = [0.01 * (1 + i) for i in range(data["recommendation"].sizes["restitution"])]
    html = report.build(dataclasses.replace(short, datasets=costed(data, (errors,) * 5, (1.0,) * 5)))
    answer_at = Page(html).by_id("answer")
    assert json.loads(answer_at["attrs"]["data-e"]) == [f"{e:g}" for e in data["recommendation"]["restitution"].values]
    lists = [json.loads(one["attrs"]["data-by-e"]) for one in Page(html).all("span") if "data-by-e" in one["attrs"]]
    assert [off(error) for error in errors] in lists  # the error of the peak, which the page's script shows by e
    assert json.loads(answer_at["attrs"]["data-e"]) in lists  # and the e that it is of


def test_the_caveats_and_the_walls_for_which_it_is_not_shown_stand_beside_it(short, data):
    orders = data["earthquakes/orders"].copy(deep=True)
    verdict = xr.zeros_like(orders["wall_verdict"]) + 1
    verdict.loc[{"wall": "church"}], verdict.loc[{"wall": "veneer"}] = -1, 0
    enough = xr.zeros_like(orders["drawn_wall_count"]) + 1
    data["earthquakes/orders"] = orders.assign(wall_verdict=verdict, drawn_wall_count=enough)
    data["recommendation"] = data["recommendation"].assign(crossing_force=1.346)
    page = page_of(short, data)
    assert (
        "enough for 1 of 3 walls, by e and by the drawing of the bootstrap; the others are undecided or beyond" in page
    )
    for caveat in (
        "one constant e",
        "one degree of freedom",
        "no vertical",
        "1.35 F0 where u = 0",
        "no constant damping",
    ):
        assert caveat in page


def test_the_damping_ratios_are_those_of_least_error_of_the_studys_wall_between_its_e(data):
    told = ratios(data, 0.04)
    fitted = data["equivalence"]
    stored = fitted["damping_ratio"].sel(yield_displacement_ratio=0.04)
    assert sorted(told["ratio"]) == sorted(VISCOUS_MODELS)
    for model in VISCOUS_MODELS:
        at = stored.sel(damping_model=model)
        assert float(shown_ratio(told, model, "0.85")) == pytest.approx(
            100 * float(at.sel(restitution=0.85)), abs=0.006
        )
        between = 100 * float(at.sel(restitution=[0.85, 0.9]).mean())
        assert float(shown_ratio(told, model, "0.875")) == pytest.approx(between, abs=0.006)
    alone = {**data, "equivalence": fitted.sel(yield_displacement_ratio=[0.04])}
    assert ratios(alone, 0.04) == told and ratios(alone, 0.05) is None and ratios(data, 0.5) is None
    assert shown_ratio(told, "CDC", "0.5") == shown_ratio(None, "CDC", "0.85") == "–"


def test_an_error_that_is_not_known_is_a_dash(data):
    advice = data["recommendation"]
    unknown = advice.assign(near_collapse_log_error=np.nan * advice["near_collapse_log_error"])
    assert set(answer({**data, "recommendation": unknown}, 0.04)["large_error"]) == {"–"}


def test_the_page_says_at_which_amplitude_e_is_meant(short, data):
    """A wall that survives 1/1.25, 1/1.10 and 1/1.50 of what the constant e says: it overstates by 25, 10 and 50 %."""
    study = made_up_studies.loss_law().assign_attrs(data["loss_law"].attrs)
    ratio = 1 / xr.DataArray(
        [[1.10, 1.0, 1.0], [1.25, 1.02, 0.98], [1.50, 1.0, 0.97]], dims=study["median_intensity_ratio"].dims[1:]
    )
    study["median_intensity_ratio"][:] = ratio
    page = page_of(short, {**data, "loss_law": study})
    assert "e is that of releases from 0.3 to 0.5 uins" in page
    assert "within 3.0 %. Measured at 0.1 u" in page and "by 10 % to 50 % with g = 0.13 to 0.39" in page
    del data["loss_law"]
    assert "Measured at 0.1" not in page_of(short, data)


@pytest.mark.parametrize("order", [RECOMMENDED_ORDER, 4, float("nan")])
def test_a_study_that_needs_another_order_says_so(short, data, order):
    data["recommendation"] = data["recommendation"].assign(recommended_order=float(order))
    page = report.build(dataclasses.replace(short, datasets=data))
    assert (f", not {RECOMMENDED_ORDER}.</p>" in page) == (order != RECOMMENDED_ORDER)


def test_without_the_recommendation_there_is_no_answer(data):
    del data["recommendation"]
    assert answer(data, 0.04) is None


def test_a_program_s_damper_has_its_cost_with_the_leading_ratio(data):
    whole = data["recommendation"]
    leading = whole.sel(damping_ratio_source=RECOMMENDED_SOURCE)
    rows = by_program(data)
    assert sorted(row["model"] for row in rows) == sorted(OFFERS) == sorted(VISCOUS_MODELS)
    errors = [float(row["log_error"][whole.sizes["restitution"] // 2]) for row in rows]
    assert errors == sorted(errors)
    for row in rows:
        one = leading.sel(damping_model=row["model"])
        assert row["error"] == [off(error) for error in one["log_error"].values]
        assert row["missed"] == [percent(rate) for rate in one["false_safe_rate"].values]


def test_of_errors_that_read_the_same_the_damper_that_misses_less_comes_first(data):
    advice = data["recommendation"].copy(deep=True)
    at = {"damping_ratio_source": RECOMMENDED_SOURCE}
    for model, error, missed in (("ECD", 0.1514, 0.028), ("CDR", 0.1513, 0.040), ("SDR", 0.12, 0.5)):
        advice["log_error"].loc[{**at, "damping_model": model}] = error
        advice["false_safe_rate"].loc[{**at, "damping_model": model}] = missed
    order = [row["model"] for row in by_program({**data, "recommendation": advice})]
    assert order.index("SDR") < order.index("ECD") < order.index("CDR")


def test_the_selection_of_histories_is_stated_at_the_errors(short, data):
    data["recommendation"] = data["recommendation"].assign(records=7)
    pooled = made_up.comparison()["pooled"].copy()
    pooled[:2] = 0
    data["comparison"] = made_up.comparison().assign(pooled=pooled).assign_attrs(data["comparison"].attrs)
    told = selection(data)
    assert told == "2 walls under 7 earthquake records, peaks of 0.01 to 1 u_ins under restitution"
    assert page_of(short, data).count(told.replace("u_ins", "uins")) == 2
    del data["comparison"]
    assert selection(data) == "7 earthquake records"
