"""Fig. 8: the response of a tested wall beside the models'."""

import numpy as np
import pytest
from figure_functions import FIGURES
from figure_reading import all_text, drawn, shows
from made_up_studies import validation

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures.validation import shown


@pytest.mark.parametrize("said, synthetic", [("yes", True), ("no", False), (None, True), ("No idea", True)])
def test_fig8_calls_a_record_synthetic_unless_it_says_that_it_is_not(said, synthetic):
    data = validation(record_synthetic=said)
    if said is None:
        del data.attrs["record_synthetic"]
    text = all_text(FIGURES["fig8"](data))
    assert text.count("SYNTHETIC") == (2 if synthetic else 0)  # the heading and the legend


def test_fig8_has_the_motion_above_and_the_papers_models_beside_the_record_below():
    data = validation()
    above, below, *_ = drawn("fig8").axes
    assert shows(above, data["elapsed"], data["ground_acceleration"])
    assert shows(below, data["elapsed"], 1000 * data["measured"])
    for model in ("CR", *PAPER_MODELS):
        assert shows(below, data["elapsed"], 1000 * data["control_displacement"].sel(damping_model=model))
    assert len(below.get_lines()) == 1 + 1 + 4  # zero, the record, the models
    assert not below.texts


def test_fig8_starts_shortly_before_the_motion_and_ends_after_the_decay():
    start, end = shown(validation())
    # The bell of 0.1 s around 1.5 s first passes a tenth of its peak at 1.5 - 0.1 sqrt(ln 10).
    assert 1.0 < start < 1.5 - 0.1 * np.sqrt(np.log(10)) + 0.01
    # The envelope exp(-1.5 t) falls to a tenth of the first peak, at t = 0.17 s, within ln(10)/1.5 s.
    assert 1.5 + 1.2 < end < 1.5 + 0.17 + np.log(10) / 1.5 + 0.3
