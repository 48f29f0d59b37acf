"""Fig. 8: the measured and the computed decay of a tested wall."""

import numpy as np
import pytest
from figure_functions import FIGURES
from figure_reading import all_text, drawn, panel_titled, shows
from made_up_studies import ALL, made_up, validation

from rockdamp.figures.validation import shown


def test_fig8_shows_the_measurement_and_every_model_in_millimetres():
    data = made_up()["validation"]
    for model in ALL:
        axes = panel_titled(drawn("fig8"), f"{model}")
        assert shows(axes, data["elapsed"], 1000 * data["measured"])
        assert shows(axes, data["elapsed"], 1000 * data["displacement"].sel(damping_model=model))
        number = "0.835" if model == "CR" else f"{float(data['damping_ratio'].sel(damping_model=model)):.4f}"
        assert number in axes.get_title()
    assert shows(panel_titled(drawn("fig8"), "table"), data["elapsed"], data["ground_acceleration"])


def test_fig8_marks_the_peaks_on_the_side_where_they_are():
    data = made_up()["validation"]
    axes = panel_titled(drawn("fig8"), "SDR")
    marks = [line for line in axes.get_lines() if line.get_linestyle() == "None"]
    sides = np.array([1, -1, 1, -1])
    for line, peaks in zip(
        marks, (data["measured_decay_peak"], data["decay_peak"].sel(damping_model="SDR")), strict=True
    ):
        assert line.get_ydata() == pytest.approx(1000 * sides * peaks.values)


@pytest.mark.parametrize("said, synthetic", [("yes", True), ("no", False), (None, True), ("No idea", True)])
def test_fig8_calls_a_record_synthetic_unless_it_says_that_it_is_not(said, synthetic):
    data = validation(record_synthetic=said)
    if said is None:
        del data.attrs["record_synthetic"]
    text = all_text(FIGURES["fig8"](data))
    assert text.count("SYNTHETIC") == (2 if synthetic else 0)  # the heading and the legend


def test_fig8_says_where_a_model_collapsed():
    data = validation()
    data["collapsed"][3] = 1
    for name in ("rms_misfit", "peak_ratio_to_measured"):
        data[name][3] = np.nan
    data["decay_peak"][3] = np.nan
    data["displacement"][3, 200:] = np.nan
    figure = FIGURES["fig8"](data)
    assert "collapsed" in [text.get_text() for text in panel_titled(figure, "SDR").texts]
    assert "nan" not in all_text(figure)


def test_fig8_marks_a_free_decay_only_where_the_record_holds_one():
    assert "free decay" in all_text(FIGURES["fig8"](validation()))
    pushed = validation()
    pushed["half_cycle_free"][:] = 0
    pushed["free_phase_start"] = np.nan
    assert "free decay" not in all_text(FIGURES["fig8"](pushed))


def test_fig8_starts_shortly_before_the_motion_and_ends_after_the_last_peak():
    start, end = shown(validation())
    # The bell of 0.1 s around 1.5 s first passes a tenth of its peak at 1.5 - 0.1 sqrt(ln 10).
    assert 1.0 < start < 1.5 - 0.1 * np.sqrt(np.log(10)) + 0.01
    assert 1.5 + 3.5 * np.pi / 8 < end < 4
