"""Captions: every number from a dataset."""

import dataclasses
import re

import pytest
from made_up_studies import ladder, made_up

from rockdamp.pipeline.figures import FIGURES
from rockdamp.report import captions, earthquake_captions, further_captions, numbers, paper_captions

MODULES = (paper_captions, further_captions, earthquake_captions)


def test_each_function_of_captions_belongs_to_a_figure():
    assert {name for module in MODULES for name in vars(module) if name.startswith("fig")} == set(captions.NUMBERS)


def test_a_caption_without_numbers_needs_no_function(monkeypatch):
    figure = dataclasses.replace(FIGURES["fig1"], name="fig_new", title="New", caption="What <b>falls</b>.")
    monkeypatch.setitem(FIGURES, "fig_new", figure)
    assert captions.caption("fig_new", {}) == ("New", figure.alternative, "What <b>falls</b>.")


def test_an_alternative_text_is_plain(monkeypatch):
    figure = dataclasses.replace(
        FIGURES["fig1"], name="fig_new", caption="", alternative="At e&nbsp;= <b>0.85</b> &lt; 1."
    )
    monkeypatch.setitem(FIGURES, "fig_new", figure)
    assert captions.caption("fig_new", {}).alternative == "At e\u00a0= 0.85 < 1."


@pytest.mark.parametrize("name", list(FIGURES))
def test_no_number_of_a_caption_is_typed(name):
    figure = FIGURES[name]
    text = " ".join((figure.title, figure.alternative, figure.caption))
    text = re.sub(r"\{\{.*?\}\}|\{%.*?%\}|<sub>\w+</sub>|&nbsp;", " ", text)
    text = re.sub(r"Fig\. +\d+|Eq\. +\(\d+\)|R²", " ", text)
    assert re.findall(r"\d", text) == []


class Watched(dict):
    """Datasets that note which of them are asked for."""

    def __init__(self, *args):
        super().__init__(*args)
        self.asked = set()

    def __getitem__(self, name):
        self.asked.add(name)
        return super().__getitem__(name)


def changed(data):
    """The same coordinates, other values."""
    return data.assign({name: data[name] ** 1.3 for name in data.data_vars if data[name].dtype.kind == "f"})


@pytest.mark.parametrize("name", list(captions.NUMBERS))
def test_the_numbers_of_a_caption_follow_its_datasets(name, content):
    datasets = Watched(content.datasets)
    before = captions.caption(name, datasets)
    after = captions.caption(name, {key: changed(data) for key, data in content.datasets.items()})
    assert datasets.asked
    assert re.search(r"\d", before.text)
    assert before.text != after.text
    assert (before.title, before.alternative) == (after.title, after.alternative)


def test_a_caption_tells_the_values_of_the_figure(content):
    fits = content.datasets["equivalence"]
    at = fits.sel(restitution=0.85, cracked_stiffness_ratio=0.04)
    text = captions.caption("fig7", content.datasets).text
    for model in fits["damping_model"].values:
        assert f"{numbers.number(at['damping_ratio_fit'].sel(damping_model=model))} ({model})" in text
    assert str(numbers.number(at["giannini_masiani"])) in text
    assert "a<sub>1</sub>&nbsp;=&nbsp;0.04" in text


def told(name):
    """A caption from the datasets that are made up for the figures."""
    return captions.caption(name, made_up()).text


def test_a_caption_tells_differences_without_their_sign_and_the_largest_of_either():
    """Medians differ by the square of 0.9 and of 1.08; the closed form by -3 % of the slopes 0.3 and -0.6."""
    assert "19&nbsp;% and 19&nbsp;% (SDR)" in told("fig_ida") and "17&nbsp;% and 17&nbsp;% (CDC)" in told("fig_ida")
    assert "0.90&nbsp;% (SDR)" in told("fig_closed_form") and "1.8&nbsp;% (CDC)" in told("fig_closed_form")
    assert "−" not in told("fig_ida") + told("fig_closed_form")


def test_a_spread_is_that_of_the_largest_and_the_smallest_over_the_mean():
    """Of 0.26, 0.27 and 0.28; in seconds times 1, 1.01 and 1.02."""
    assert "change ξ by 7.4&nbsp;% at most" in " ".join(told("fig6").split())
    assert "change it by 9.4&nbsp;% at most" in " ".join(told("fig6").split())


def test_a_synthetic_record_is_called_so_and_another_is_not(content):
    test = content.datasets["validation"]
    assert "synthetic" in captions.caption("fig8", content.datasets).text
    real = {**content.datasets, "validation": test.assign_attrs(record_synthetic="no")}
    assert "synthetic" not in captions.caption("fig8", real).text
    unlabelled = test.copy()
    del unlabelled.attrs["record_synthetic"]
    assert "synthetic" in captions.caption("fig8", {**content.datasets, "validation": unlabelled}).text


def test_the_lowest_error_is_told_with_its_range_of_restitution(content):
    one = content.datasets["match/amplitude"].copy(deep=True)
    one["error"][:] = 1.0
    one["error"].loc[{"damping_model": "CDR", "restitution": [0.85, 0.9]}] = 0.5
    one["error"].loc[{"damping_model": "SDR", "restitution": [0.8, 0.95]}] = 0.5
    text = captions.caption("fig6_error", {**content.datasets, "match/amplitude": one}).text
    assert "CDR at e = 0.85 to 0.90 and SDR at e = 0.80 and 0.95" in text


def test_text_of_a_dataset_is_escaped_in_a_caption(content):
    test = content.datasets["validation"].assign_attrs(record_specimen="<b>wall</b>")
    assert "&lt;b&gt;wall" in captions.caption("fig8", {**content.datasets, "validation": test}).text


def test_a_ladder_is_told_by_model_and_amplitude_and_what_hangs_on_what_made_it(content):
    """Made up: CR is off by 5 % at rest and by nothing at collapse, SDR by 30 %; each ladder by once more."""
    text = captions.caption("fig8", {**content.datasets, "validation": ladder()}).text
    assert "to 0.06, 0.25, 0.50 and 0.88&nbsp;u<sub>ins</sub>" in text
    assert "right within 10&nbsp;% under CR at 0.06, 0.25, 0.50 and 0.88, CDC at 0.06, 0.25, 0.50 and 0.88" in text
    assert "SDR at 0.88" in text
    assert (
        "the decrement of the free decay, under CR at 0.25, 0.50 and 0.88, CDC at 0.25, 0.50 and 0.88, CDR at none"
        in text
    )
    assert "0.91 to 0.99 (ECD) and 0.86 to 0.98 (CR, degrading)" in text
    assert "leaves CR at 0.95 of the measured peak" in text
