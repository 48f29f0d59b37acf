"""Fig. 8: the measured and the computed decay of a tested wall."""

import numpy as np
import pytest
from figure_functions import FIGURES
from figure_reading import LADDER, all_text, drawn, panel_titled, shows
from made_up_studies import ALL, LADDERS, RUNGS, ladder, made_up, validation

from rockdamp.figures.ladder import ladders, off
from rockdamp.figures.validation import shown


def test_fig8_shows_the_measurement_and_every_model_in_millimetres():
    data = made_up()["validation"].isel(record=0)
    for model in ALL:
        axes = panel_titled(drawn("fig8"), f"{model}")
        assert shows(axes, data["elapsed"], 1000 * data["measured"])
        assert shows(axes, data["elapsed"], 1000 * data["displacement"].sel(damping_model=model))
        number = "0.835" if model == "CR" else f"{float(data['damping_ratio'].sel(damping_model=model)):.4f}"
        assert number in axes.get_title()
    assert shows(panel_titled(drawn("fig8"), "table"), data["elapsed"], data["ground_acceleration"])


def test_fig8_marks_the_peaks_on_the_side_where_they_are():
    data = made_up()["validation"].isel(record=0)
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
    data["collapsed"][0, 3] = 1
    for name in ("rms_misfit", "peak_ratio_to_measured"):
        data[name][0, 3] = np.nan
    data["decay_peak"][0, 3] = np.nan
    data["displacement"][0, 3, 200:] = np.nan
    figure = FIGURES["fig8"](data)
    assert "collapsed" in [text.get_text() for text in panel_titled(figure, "SDR").texts]
    assert "nan" not in all_text(figure)


def test_fig8_marks_a_free_decay_only_where_the_record_holds_one():
    assert "free decay" in all_text(FIGURES["fig8"](validation()))
    pushed = validation()
    pushed["half_cycle_free"][:] = 0
    pushed["free_phase_start"][:] = np.nan
    assert "free decay" not in all_text(FIGURES["fig8"](pushed))


def test_fig8_starts_shortly_before_the_motion_and_ends_after_the_last_peak():
    start, end = shown(validation().isel(record=0))
    # The bell of 0.1 s around 1.5 s first passes a tenth of its peak at 1.5 - 0.1 sqrt(ln 10).
    assert 1.0 < start < 1.5 - 0.1 * np.sqrt(np.log(10)) + 0.01
    assert 1.5 + 3.5 * np.pi / 8 < end < 4


# --- of a ladder


def test_of_several_records_each_model_stands_on_every_rung_beside_the_measurement():
    data, figure = ladder(), drawn(LADDER)
    for model in ALL:
        panels = [axes for axes in figure.axes if model in [text.get_text() for text in axes.texts]]
        assert len(panels) == len(RUNGS)
        for axes, rung in zip(panels, range(len(RUNGS)), strict=True):
            one = data.isel(record=rung)
            largest = float(one["measured_peak_displacement"])
            assert shows(axes, one["elapsed"], one["measured"] / largest)
            assert shows(axes, one["elapsed"], one["displacement"].sel(damping_model=model) / largest)
            ratio = float(one["peak_ratio_to_measured"].sel(damping_model=model))
            assert f"{ratio:.2f}" in [text.get_text() for text in axes.texts]


def test_of_several_records_peaks_and_decrements_stand_over_amplitude_for_whatever_made_them():
    data, figure = ladder(), drawn(LADDER)
    for number, maker in enumerate(LADDERS):
        of_maker = data.isel(record=slice(4 * number, 4 * number + 4))
        (above,) = (axes for axes in figure.axes if axes.get_title() == f"made by {maker}")
        assert shows(above, RUNGS, of_maker["peak_ratio_to_measured"].sel(damping_model="SDR"))
        decrement = of_maker["log_decrement"] / of_maker["measured_log_decrement"]
        below = figure.axes[figure.axes.index(above) + 1]
        assert shows(below, RUNGS, decrement.sel(damping_model="SDR"))
    assert "SYNTHETIC records" in all_text(figure)


def test_rungs_are_drawn_from_the_lowest_up_and_a_model_that_collapsed_has_no_peak():
    data = ladder().isel(record=[3, 0, 2, 1])
    data["collapsed"][0, 3] = 1
    (rungs,) = ladders(data).values()
    assert list(rungs["record"].values) == [f"0 at {height}" for height in RUNGS]
    peaks = off(rungs, "peak").sel(damping_model=ALL[3])
    assert list(np.isnan(peaks.values)) == [False, False, False, True]
    assert "collapsed" in all_text(FIGURES["fig8"](data))
