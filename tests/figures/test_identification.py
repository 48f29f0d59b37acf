"""The picture of a posterior."""

import pytest
from made_up_posterior import made_up_posterior

from rockdamp.figures.identification import SYMBOLS, posterior_figure
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
