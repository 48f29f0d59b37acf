"""The first screen of the report: its numbers are those of the datasets, and it says where they disagree with it."""

import dataclasses

import numpy as np
import pytest
import report_content
import xarray as xr

from rockdamp import report
from rockdamp.report.answer import answer
from rockdamp.report.earthquake_criterion import off
from rockdamp.report.programs import OFFERS, by_offer
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
    assert (told["paper_model"], told["paper_error"]) == ("CDR", "16\u00a0%")
    assert told["sizes"]["rms"][0] == "4.8\u00a0%"
    told = answer(with_errors(data, CDC=0.31, CDR=0.25, SDR=0.24))
    assert (told["paper_model"], told["paper_error"]) == ("SDR", "27\u00a0%")


def sized(data, own, changed):
    """The recommendation with median, 90 % and root mean square of the recommended damper and of a change of e."""
    advice = data["recommendation"].copy(deep=True)
    for ending, size, of_change in zip(("_median", "_90", ""), own, changed, strict=True):
        advice[f"log_error{ending}"].loc[{"damping_model": RECOMMENDED}] = size
        advice[f"sensitivity_to_restitution{ending}"][:] = of_change
    return {**data, "recommendation": advice}


def page_of(short, data):
    return " ".join(report.build(dataclasses.replace(short, datasets=data)).replace("\u00a0", " ").split())


@pytest.mark.parametrize(
    ("own", "within"), [((0.006, 0.03, 0.05), True), ((0.02, 0.03, 0.05), False), ((0.006, 0.05, 0.05), False)]
)
def test_the_page_says_that_another_e_moves_more_only_where_every_size_does(short, data, own, within):
    page = page_of(short, sized(data, own, (0.01, 0.04, 0.09)))
    assert (", each of which is more." in page) == within
    assert "restitution's own peaks by 1.0 %, 4.1 % and 9.4 %" in page


def test_false_answers_stand_beside_those_of_the_e_that_makes_them(short, data):
    advice = data["recommendation"].copy(deep=True)
    for name, rate in {"false_safe_rate": 0.012, "false_collapse_rate": 0.009}.items():
        advice[name].loc[{"damping_model": RECOMMENDED}] = rate
    advice["sensitivity_false_safe_rate"][:], advice["sensitivity_false_collapse_rate"][:] = 0.052, 0.071
    page = page_of(short, {**data, "recommendation": advice})
    assert "It misses 1.2 % of the collapses, and overturns 0.90 % of the walls that stand." in page
    assert "A lower e misses 5.2 %, and a higher e overturns 7.1 %." in page


def test_the_caveats_and_the_walls_for_which_the_order_is_not_enough_stand_beside_it(short, data):
    orders = data["earthquakes/orders"].copy(deep=True)
    verdict = xr.zeros_like(orders["wall_verdict"]) + 1
    verdict.loc[{"wall": "church"}], verdict.loc[{"wall": "veneer"}] = -1, 0
    data["earthquakes/orders"] = orders.assign(wall_verdict=verdict)
    data["recommendation"] = data["recommendation"].assign(crossing_force=1.346)
    page = page_of(short, data)
    assert (
        f"order {RECOMMENDED_ORDER} is enough for 1 of 3 walls, by e; the others are undecided or beyond the limit"
        in page
    )
    for caveat in ("one constant e", "u = 0 alone", "one degree of freedom", "no vertical", "supports in phase"):
        assert caveat in page
    assert "reaches 1.35&nbsp;F<sub>0</sub>" in page


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
    assert rows[RECOMMENDED]["error"] == off(exact["log_error"])
    assert rows[RECOMMENDED]["false_safe"] == percent(exact["false_safe_rate"])
    of_cdc = at_e.sel(damping_model="CDC")
    least = of_cdc.isel(damping_ratio_source=int(np.argmin(of_cdc["log_error"].values)))
    assert rows["CDC"]["error"] == off(least["log_error"])
    local = report_content.made_up("local_damping").isel(damping_model=[0, 1, 2])
    local = local.assign_coords(damping_model=["ECD", RECOMMENDED, LOCAL])
    row = by_offer({**data, "local_damping": local})["rows"][-1]
    of_local = local.sel(damping_model=LOCAL)
    assert (row["model"], row["error"]) == (LOCAL, off(of_local["record_log_error"]))
    assert by_offer({}) is None
