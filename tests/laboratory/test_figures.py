"""The picture of a posterior."""

import numpy as np
import pytest
from made_up_posterior import made_up_posterior
from made_up_trials import identification

from rockdamp.laboratory.figures import (
    SYMBOLS,
    confusion,
    fig_identification,
    fig_identification_caption,
    posterior_figure,
)
from rockdamp.vocabulary import CANDIDATES


@pytest.mark.parametrize("compared", [True, False])
def test_a_posterior_is_drawn_in_pairs_below_the_record_in_its_band(compared):
    found = made_up_posterior(compared=compared)
    figure = posterior_figure(found)
    names = [name for name in SYMBOLS if name in found["parameter"].values]
    pairs = len(names) * (len(names) + 1) // 2
    assert len(figure.axes) == 2 + pairs + compared
    titles = [axes.get_title() for axes in figure.axes]
    assert "90.0% of the record inside the band" in titles[0]
    for name in names:
        mean = f"{float(found['mean'].sel(parameter=name)):.4g}"
        assert any(title.startswith(f"{SYMBOLS[name]} = {mean} ") for title in titles)
    assert "SYNTHETIC" in figure.get_suptitle()


def test_the_evidence_of_a_model_is_what_it_lacks_to_the_best_one():
    axes = posterior_figure(made_up_posterior()).axes[-1]
    shown = [text.get_text().strip() for text in axes.texts]
    assert shown == ["not determined", *(f"{below:.1f}" for below in range(len(CANDIDATES) - 2, -1, -1))]
    assert [tick.get_text() for tick in axes.get_yticklabels()] == list(CANDIDATES)


def test_the_table_of_the_study_holds_the_mean_probability_of_each_model_for_each_origin():
    made = identification()
    (table,) = fig_identification(made).axes
    shown = [text.get_text() for text in table.texts]
    expected = confusion(made).stack(row=("record_made_by", "noise_factor")).transpose("row", "damping_model").values
    assert [float(text) for text in shown if text != "not determined"] == [
        round(float(v), 2) for v in expected.ravel() if v == v
    ]
    assert float(confusion(made).sel(record_made_by="CR", noise_factor=1.0, damping_model="CR")) == pytest.approx(
        (1 / (1 + np.exp(-1)) + 1 / (1 + np.exp(0.5))) / 2, abs=1e-6
    )
    assert [tick.get_text() for tick in table.get_yticklabels()] == [
        *("CR; noise × 1 (2)", "CR; noise × 2 (2)", "ECD; noise × 1 (0 of 1)", "ECD; noise × 2 (0 of 1)")
    ]


def test_what_is_not_determined_has_not_the_colour_of_no_probability():
    (table,) = fig_identification(identification()).axes
    (picture,) = table.images
    undetermined = np.ma.getmaskarray(picture.get_array())
    assert undetermined[2:].all() and not undetermined[:2].any()
    assert table.get_facecolor() != picture.cmap(picture.norm(0.0))


def test_the_caption_says_of_how_many_records_a_mean_is():
    said = " ".join(fig_identification_caption(identification()).split())
    assert "is 0.55 (CR, 2 records) and 0.55 (CR, 2 records, noise × 2)" in said
    assert "2 records are left out" in said


def test_the_caption_names_no_mean_where_no_model_of_the_comparison_made_a_record():
    made = identification()
    others = made.assign(record_made_by=made["record_made_by"].copy(data=["CR, degrading"] * made.sizes["record"]))
    said = " ".join(fig_identification_caption(others).split())
    assert said.startswith("The models are equally probable before.")
