"""The first screen of the report: its numbers are those of the datasets, and it says what they are of."""

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
from rockdamp.constants import RECOMMENDED_SOURCE
from rockdamp.equivalence.programs import REQUIREMENT
from rockdamp.report.answer import (
    COLUMNS,
    OF_PROGRAMS,
    answer,
    by_program,
    order_rows,
    ratios,
    select_e,
    selection,
    shown_ratio,
)
from rockdamp.text import percent


@pytest.fixture
def data(short):
    studies = {"order": made_up_studies.order(), "comparison": made_up.comparison()}
    made = {name: study.assign_attrs(short.datasets[name].attrs) for name, study in studies.items()}
    return {**short.datasets, **made}


def page_of(short, data):
    return " ".join(words(report.build(dataclasses.replace(short, datasets=data))).split())


def words(html):
    return unescape(re.sub(r"<[^>]+>", "", html)).replace("\u00a0", " ")


# --- error against force ----------------------------------------------------------------------------------------------


def test_each_damper_that_is_shown_has_a_row_with_its_force_errors_and_step(data):
    at_e = select_e(data["order"])
    rows = {row["damper"]: row for row in order_rows(at_e)}
    assert list(rows)[:4] == ["ECD", "ECD16", "ECD64", "BAND0.4"] and list(rows)[-2:] == [
        "CR, e - 0.01",
        "CR, e + 0.01",
    ]
    for damper in ("ECD", "BAND0.2", "CQD0.25"):
        one, row = at_e.sel(damper=damper), rows[damper]
        assert float(row["force"]) == pytest.approx(float(one["crossing_force"].sel(wall="paper")), rel=0.06)
        for text, variable in zip(row["errors"], COLUMNS.values(), strict=True):
            assert str(text).startswith(percent(one[variable])) and text.count("to") == 1
        assert row["step"] == "0.05"
    assert rows["CR, e - 0.01"]["force"] == "–"


def test_a_damper_that_converges_at_no_step_and_one_that_is_not_studied(data):
    order = data["order"].sel(damper=["BAND0.2", "e - 0.01", "half step"])
    rows = order_rows(select_e(order.assign(largest_step=np.nan * order["largest_step"])))
    assert [(row["damper"], row["step"]) for row in rows] == [("BAND0.2", "–"), ("CR, e - 0.01", "–")]


def test_the_page_says_how_often_histories_fork_with_the_band_and_with_a_smaller_step(short, data):
    at_e, page = select_e(data["order"]), page_of(short, data)
    band, half = at_e.sel(damper="BAND0.2"), at_e.sel(damper="half step")
    for number in (*(band[name] for name in list(COLUMNS.values())[2:]), half["share_above"]):
        assert percent(number).replace("\u00a0", " ") in page


def test_without_either_study_there_is_no_answer(data):
    for name in ("order", "comparison"):
        assert answer({key: value for key, value in data.items() if key != name}, 0.04) is None


# --- which damper for which program -----------------------------------------------------------------------------------


def test_a_program_s_damper_has_its_errors_with_the_leading_ratio(data):
    leading = data["comparison"].sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    rows = by_program(data["comparison"])
    assert [row["model"] for row in rows] == list(REQUIREMENT)
    for row in rows:
        for errors, name in zip(row["errors"], OF_PROGRAMS, strict=True):
            assert errors == [percent(value) for value in leading[name].sel(damping_model=row["model"]).values]


def test_the_errors_follow_the_slider_over_the_e_of_the_study(short, data):
    rates = xr.DataArray([0.01, 0.02, 0.03], dims="restitution")
    compared = data["comparison"]
    compared["missed_collapse_rate"][:] = xr.zeros_like(compared["missed_collapse_rate"]) + rates
    html = report.build(dataclasses.replace(short, datasets=data))
    answer_at = Page(html).by_id("answer")
    assert json.loads(answer_at["attrs"]["data-e"]) == [f"{e:g}" for e in compared["restitution"].values]
    lists = [json.loads(one["attrs"]["data-by-e"]) for one in Page(html).all("span") if "data-by-e" in one["attrs"]]
    assert lists.count([percent(rate) for rate in rates.values]) == len(REQUIREMENT)
    assert json.loads(answer_at["attrs"]["data-e"]) in lists  # and the e that it is of


def test_the_damping_ratios_are_those_of_least_error_of_the_studys_wall_between_its_e(data):
    told = ratios(data, 0.04)
    fitted = data["equivalence"]
    stored = fitted["damping_ratio"].sel(yield_displacement_ratio=0.04)
    assert list(told["ratio"]) == list(REQUIREMENT)
    for model in REQUIREMENT:
        at = stored.sel(damping_model=model)
        assert float(shown_ratio(told, model, "0.85")) == pytest.approx(
            100 * float(at.sel(restitution=0.85)), abs=0.006
        )
        between = 100 * float(at.sel(restitution=[0.85, 0.9]).mean())
        assert float(shown_ratio(told, model, "0.875")) == pytest.approx(between, abs=0.006)
    alone = {**data, "equivalence": fitted.sel(yield_displacement_ratio=[0.04])}
    assert ratios(alone, 0.04) == told and ratios(alone, 0.05) is None and ratios(data, 0.5) is None
    assert shown_ratio(told, "CDC", "0.5") == shown_ratio(None, "CDC", "0.85") == "–"


def test_the_selection_of_histories_is_stated_at_the_errors(short, data):
    pooled = data["comparison"]["pooled"]
    pooled[:2] = 0
    told = selection(data["comparison"].assign(records=7))
    assert told == "2 walls under 7 earthquake records, peaks of 0.01 to 1 u_ins under restitution"
    data["comparison"] = data["comparison"].assign(records=7)
    assert page_of(short, data).count(told.replace("u_ins", "uins")) == 1


# --- where it ends ----------------------------------------------------------------------------------------------------


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
