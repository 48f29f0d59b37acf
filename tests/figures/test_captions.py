"""Captions: every number from a dataset."""

import ast
import inspect
import re

import pytest
from figure_functions import CAPTIONS
from made_up_studies import made_up
from report_content import of_name

from rockdamp.pipeline.tables import FIGURES
from rockdamp.text import number


def datasets(name):
    return [of_name(source) for source in FIGURES[name].inputs]


def written(name, *data):
    return " ".join(CAPTIONS[name](*data).split())


@pytest.mark.parametrize("name", FIGURES)
def test_no_number_of_a_caption_is_typed(name):
    tree = ast.parse(inspect.getsource(CAPTIONS[name]))
    texts = [part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values]
    constants = [part.value for part in texts if isinstance(part, ast.Constant) and not re.match(r"\.\d", part.value)]
    typed = " ".join((*constants, FIGURES[name].title, FIGURES[name].alternative))
    typed = re.sub(r"<sub>\w+</sub>|&nbsp;", " ", typed)
    assert re.findall(r"\d", re.sub(r"Fig\. +\d+|Eq\. +\(\d+\)|R²", " ", typed)) == []


def changed(data):
    """The same coordinates, other values."""
    return data.assign({name: data[name] ** 1.3 for name in data.data_vars if data[name].dtype.kind == "f"})


@pytest.mark.parametrize("name", FIGURES)
def test_the_numbers_of_a_caption_follow_its_datasets(name):
    before, after = (written(name, *data) for data in (datasets(name), map(changed, datasets(name))))
    assert re.search(r"\d", before)
    assert before != after


def test_a_caption_has_the_values_of_the_figure():
    (fits,) = datasets("fig7")
    at = fits.sel(restitution=0.85, yield_displacement_ratio=0.04)
    text = written("fig7", fits)
    for model in ("CDC", "CDR", "SDR"):
        assert f"{number(at['damping_ratio_fit'].sel(damping_model=model))} ({model})" in text
    assert number(at["giannini_masiani"]) in text
    assert "a<sub>1</sub>&nbsp;=&nbsp;0.04" in text


def smooth(name):
    """A caption from the datasets that are made up for the figures."""
    return written(name, *(made_up()[source] for source in FIGURES[name].inputs)).replace("\u00a0", " ")


def test_a_caption_states_differences_without_their_sign_and_the_largest_of_either():
    """Medians differ by the square of 0.9 and of 1.08; the closed form by -3 % of the slopes 0.3 and -0.6."""
    assert "19 % and 19 % (SDR)" in smooth("fig_ida") and "17 % and 17 % (CDC)" in smooth("fig_ida")
    assert "0.90 % (SDR)" in smooth("fig_amplitude") and "1.8 % (CDC)" in smooth("fig_amplitude")
    assert "−" not in smooth("fig_ida") + smooth("fig_amplitude")


def test_a_spread_is_that_of_the_largest_and_the_smallest_over_the_mean():
    """Of 0.26, 0.27 and 0.28; in seconds times 1, 1.01 and 1.02."""
    assert "change ξ by 7.5 % at most" in smooth("fig6")
    assert "change it by 9.4 % at most" in smooth("fig6")


def test_a_synthetic_record_is_called_so_and_another_is_not():
    (test,) = datasets("fig8")
    assert "synthetic" in written("fig8", test)
    assert "synthetic" not in written("fig8", test.assign_attrs(record_synthetic="no"))
    del test.attrs["record_synthetic"]
    assert "synthetic" in written("fig8", test)


def test_the_lowest_error_is_named_with_its_range_of_restitution():
    (study,) = datasets("fig6_error")
    study["error"][:] = 1.0
    study["error"].loc[{"damping_model": "CDR", "restitution": [0.85, 0.9]}] = 0.5
    study["error"].loc[{"damping_model": "SDR", "restitution": [0.8, 0.95]}] = 0.5
    assert "CDR at e = 0.85 to 0.90 and SDR at e = 0.80 and 0.95" in written("fig6_error", study)
