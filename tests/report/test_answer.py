"""The first screen of the report: its numbers are those of the datasets, and it says where they disagree with it."""

import dataclasses

import pytest
from html_page import Page

from rockdamp import report
from rockdamp.mechanics.damping import Damping
from rockdamp.report.answer import NEEDED, answer
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER


@pytest.fixture
def data(content):
    return dict(content.datasets)


def with_errors(data, **errors):
    """The comparison with these errors over all amplitudes, whatever the source of the ratio."""
    compared = data["comparison"].copy(deep=True)
    for model, error in errors.items():
        compared["log_error"].loc[{"damping_model": model, "band": compared["band"][0]}] = error
    return {**data, "comparison": compared}


def test_the_errors_are_those_of_the_datasets_and_the_nearest_of_the_papers_dampers_is_named(data):
    told = answer(with_errors(data, CDC=0.31, CDR=0.152, SDR=0.24, **{RECOMMENDED: 0.0473}))
    assert (told["paper_model"], told["paper_error"], told["error"]) == ("CDR", "0.15", "0.047")
    told = answer(with_errors(data, CDC=0.31, CDR=0.25, SDR=0.24))
    assert (told["paper_model"], told["paper_error"]) == ("SDR", "0.24")


def test_the_damping_ratio_is_the_exact_one_of_its_restitution(data):
    told = answer(data)
    ratio = float(Damping.of_restitution(float(told["e"]), RECOMMENDED).damping_ratio)
    assert float(told["ratio"].split("&")[0]) == pytest.approx(100 * ratio, rel=5e-3)


@pytest.mark.parametrize("found", [RECOMMENDED_ORDER, 4, float("nan")])
def test_a_study_that_finds_another_order_enough_says_so(content, data, found):
    data["natural/orders"] = data["natural/orders"].assign(recommended_order=float(found))
    page = report.build(dataclasses.replace(content, datasets=data))
    assert (f", not {RECOMMENDED_ORDER}.)" in page) == (found != RECOMMENDED_ORDER)


@pytest.mark.parametrize("name", NEEDED)
def test_without_one_of_its_datasets_there_is_no_answer(data, name):
    del data[name]
    assert answer(data) is None


def test_it_stands_before_everything_else_and_names_the_damper(html):
    text = Page(html).all("section")[0]["text"]
    assert RECOMMENDED in text and not any(f"Which damper? {model}" in text for model in PAPER_MODELS)
