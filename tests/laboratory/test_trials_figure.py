"""The figure of measured free rocking shows what the dataset holds."""

import numpy as np
from figure_reading import drawn, shows
from made_up_studies import made_up

from rockdamp.laboratory.figures import EXPONENTS


def test_each_panel_shows_its_values():
    measured = made_up()["measured_rocking"]
    exponent, by_impact, restitution = drawn("fig_measured_rocking").axes
    for model in ("CR", "CDC", "CDR", "SDR"):
        assert shows(by_impact, measured["impact"], measured["loss_by_impact_of_model"].sel(damping_model=model))
    assert shows(by_impact, measured["impact"], measured["loss_by_impact"])
    assert shows(exponent, measured["amplitude_exponent"], np.arange(4.0))
    assert {line.get_xdata()[0] for line in exponent.get_lines() if len(line.get_xdata()) == 2} >= {*EXPONENTS.values()}
    assert shows(restitution, measured["geometry"], measured["restitution_over_housner"])
