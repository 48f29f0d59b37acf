"""The figure of measured free rocking shows what the dataset holds."""

import numpy as np
from figure_reading import drawn, shows
from made_up_studies import made_up

from rockdamp.laboratory.figures import EXPONENTS, fig_measured_rocking_caption


def test_each_panel_shows_its_values():
    measured = made_up()["measured_rocking"]
    exponent, by_impact, restitution = drawn("fig_measured_rocking").axes
    for model in ("CR", "CDC", "CDR", "SDR"):
        assert shows(by_impact, measured["impact"], measured["loss_by_impact_of_model"].sel(damping_model=model))
    assert shows(by_impact, measured["impact"], measured["loss_by_impact"])
    assert shows(exponent, measured["amplitude_exponent"], np.arange(4.0))
    assert {line.get_xdata()[0] for line in exponent.get_lines() if len(line.get_xdata()) == 2} >= {*EXPONENTS.values()}
    assert shows(restitution, measured["geometry"], measured["restitution_over_housner"])


def test_the_caption_names_the_most_likely_damper_and_how_far_the_others_are_behind():
    caption = " ".join(fig_measured_rocking_caption(made_up()["measured_rocking"]).split())
    assert "SDR has the largest likelihood" in caption
    assert "134 measured trials" in caption
    assert "no walls, and no earthquakes" in caption
