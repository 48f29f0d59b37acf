"""The first screen of the report: its numbers are those of the datasets, and it says where they disagree with it."""

import dataclasses

import numpy as np
import pytest
from html_page import Page, words

from rockdamp import report
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.report.answer import NEEDED, answer, under_pulses
from rockdamp.vocabulary import RECOMMENDED, RECOMMENDED_ORDER, VISCOUS_MODELS

CURVE = TrilinearCurve(0.04, 0.85)


@pytest.fixture
def data(short):
    return dict(short.datasets)


def with_errors(data, **errors):
    """The comparison with these errors over all amplitudes, whatever the source of the ratio."""
    compared = data["comparison"].copy(deep=True)
    for model, error in errors.items():
        compared["log_error"].loc[{"damping_model": model, "band": compared["band"][0]}] = error
    return {**data, "comparison": compared}


def test_the_errors_are_those_of_the_datasets_and_the_nearest_of_the_papers_dampers_is_named(data):
    told = answer(with_errors(data, CDC=0.31, CDR=0.152, SDR=0.24, **{RECOMMENDED: 0.0473}), CURVE)
    assert (told["paper_model"], told["paper_error"], told["error"]) == ("CDR", "16\u00a0%", "4.8\u00a0%")
    told = answer(with_errors(data, CDC=0.31, CDR=0.25, SDR=0.24), CURVE)
    assert (told["paper_model"], told["paper_error"]) == ("SDR", "27\u00a0%")


@pytest.mark.parametrize(("own", "within"), [(0.09, True), (0.02, False)])
def test_that_no_test_tells_them_apart_is_said_only_within_restitutions_own_sensitivity(short, data, own, within):
    data = with_errors(data, **{RECOMMENDED: 0.0473})
    data["comparison"]["varied_log_error"][:] = own
    page = report.build(dataclasses.replace(short, datasets=data))
    assert ("no test could tell the two apart" in page) == within


def test_the_damping_ratios_are_those_of_the_package_the_recommended_one_first(data):
    told = answer(data, CURVE)
    assert [row["model"] for row in told["ratios"]][0] == RECOMMENDED
    assert sorted(row["model"] for row in told["ratios"]) == sorted(VISCOUS_MODELS)
    for row in told["ratios"]:
        if row["exact"]:
            ratio = Damping.of_restitution(float(told["e"]), row["model"]).damping_ratio
        else:
            ratio = damping_ratio_energy(CURVE, row["model"], float(told["e"]), 0.5)
        assert float(row["ratio"]) == pytest.approx(100 * float(ratio), abs=0.5001e-2)


def test_errors_under_pulses_are_those_of_the_slowest_and_the_quickest_that_stand(data):
    pulses = data["pulses"].copy(deep=True)
    for name in ("collapsed", "reference_collapsed"):
        pulses[name] = pulses[name] * 0
    pulses["peak_ratio"] = pulses["reference_peak"] * np.exp(0.1 * (1 + pulses["pulse_frequency"]))
    told = under_pulses(pulses)
    slowest, quickest = (0.1 * (1 + float(end)) for end in pulses["pulse_frequency"][[0, -1]])
    for text, error in ((told["slow"], slowest), (told["quick"], quickest)):
        assert float(text.split("\u00a0")[0]) == pytest.approx(100 * np.expm1(error), rel=0.05)
    pulses["collapsed"] = pulses["collapsed"] + 1
    assert under_pulses(pulses)["slow"] == "–"


@pytest.mark.parametrize("found", [RECOMMENDED_ORDER, 4, float("nan")])
def test_a_study_that_finds_another_order_enough_says_so(short, data, found):
    data["natural/orders"] = data["natural/orders"].assign(recommended_order=float(found))
    page = report.build(dataclasses.replace(short, datasets=data))
    assert (f", not {RECOMMENDED_ORDER}.</p>" in page) == (found != RECOMMENDED_ORDER)


@pytest.mark.parametrize("name", NEEDED)
def test_without_one_of_its_datasets_there_is_no_answer(data, name):
    del data[name]
    assert answer(data, CURVE) is None


def test_it_stands_before_everything_else_and_names_the_damper(html):
    page = Page(html)
    text = words(page.all("section")[0]["text"])
    assert f"Which damper {RECOMMENDED} " in text
    assert [one["text"] for one in page.all("h3")[:4]] == [
        "How much damping",
        "Which damper",
        "Beware",
        "The paper's claims",
    ]
