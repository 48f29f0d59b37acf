"""The first screen of the report: its numbers are those of the datasets, and it says where they disagree with it."""

import dataclasses

import numpy as np
import pytest
import report_content

from rockdamp import report
from rockdamp.report.answer import answer
from rockdamp.report.programs import OFFERS, by_offer, factor
from rockdamp.text import percent
from rockdamp.vocabulary import LOCAL, RECOMMENDED, RECOMMENDED_ORDER, VISCOUS_MODELS


@pytest.fixture
def data(short):
    return dict(short.datasets)


def with_errors(data, **errors):
    """The recommendation with these errors, whatever the source of the ratio."""
    advice = data["recommendation"].copy(deep=True)
    for model, error in errors.items():
        advice["log_error"].loc[{"damping_model": model}] = error
    return {**data, "recommendation": advice}


def test_the_errors_are_those_of_the_dataset_and_the_nearest_of_the_papers_dampers_is_named(data):
    told = answer(with_errors(data, CDC=0.31, CDR=0.152, SDR=0.24, **{RECOMMENDED: 0.0473}))
    assert (told["paper_model"], told["paper_error"], told["error"]) == ("CDR", "1.16", "1.05")
    told = answer(with_errors(data, CDC=0.31, CDR=0.25, SDR=0.24))
    assert (told["paper_model"], told["paper_error"]) == ("SDR", "1.27")


@pytest.mark.parametrize(("own", "within"), [(0.09, True), (0.02, False)])
def test_the_page_says_where_restitution_itself_moves_more_and_only_there(short, data, own, within):
    data = with_errors(data, **{RECOMMENDED: 0.0473})
    data["recommendation"]["sensitivity_to_restitution"][:] = own
    page = report.build(dataclasses.replace(short, datasets=data))
    assert (", which is more." in page) == within


def test_the_damping_ratios_are_those_of_the_dataset_the_recommended_one_first(data):
    told = answer(data)["ratios"]
    assert told[0]["model"] == RECOMMENDED
    assert sorted(row["model"] for row in told) == sorted(VISCOUS_MODELS)
    advice = data["recommendation"]
    stored = advice["damping_ratio_energy"].isel(restitution=advice.sizes["restitution"] // 2)
    for row in told:
        ratio = float(stored.sel(damping_model=row["model"]))
        assert float(row["ratio"]) == pytest.approx(100 * ratio, abs=0.5001e-2)


def test_an_error_that_is_not_known_is_a_dash(data):
    advice = data["recommendation"]
    unknown = advice.assign(slow_pulse_log_error=np.nan * advice["slow_pulse_log_error"])
    assert answer({**data, "recommendation": unknown})["slow"] == "–"


@pytest.mark.parametrize("order", [RECOMMENDED_ORDER, 4, float("nan")])
def test_a_study_that_needs_another_order_says_so(short, data, order):
    data["recommendation"] = data["recommendation"].assign(recommended_order=float(order))
    page = report.build(dataclasses.replace(short, datasets=data))
    assert (f", not {RECOMMENDED_ORDER}.</p>" in page) == (order != RECOMMENDED_ORDER)


def test_without_the_recommendation_there_is_no_answer(data):
    del data["recommendation"]
    assert answer(data) is None


def test_a_program_s_damper_has_its_cost_from_the_recommendation_and_local_damping_its_own(data):
    whole = data["recommendation"]
    at_e = whole.isel(restitution=whole.sizes["restitution"] // 2)
    rows = {row["model"]: row for row in by_offer(data)["rows"]}
    assert list(rows)[: len(OFFERS)] == list(OFFERS)
    exact = at_e.sel(damping_model=RECOMMENDED, damping_ratio_source="closed form")
    assert rows[RECOMMENDED]["error"] == factor(exact["log_error"])
    assert rows[RECOMMENDED]["false_safe"] == percent(exact["false_safe_rate"])
    of_cdc = at_e.sel(damping_model="CDC")
    least = of_cdc.isel(damping_ratio_source=int(np.argmin(of_cdc["log_error"].values)))
    assert rows["CDC"]["error"] == factor(least["log_error"])
    local = report_content.made_up("local_damping").isel(damping_model=[0, 1, 2])
    local = local.assign_coords(damping_model=["ECD", RECOMMENDED, LOCAL])
    row = by_offer({**data, "local_damping": local})["rows"][-1]
    of_local = local.sel(damping_model=LOCAL)
    assert (row["model"], row["error"]) == (LOCAL, factor(of_local["record_log_error"]))
    assert factor(np.nan) == "–" and by_offer({}) is None
