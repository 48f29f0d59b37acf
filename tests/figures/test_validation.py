"""Fig. 8 and the test series: the response of a tested wall, and what is right of each model at which amplitude."""

import numpy as np
import pytest
from figure_functions import FIGURES
from figure_reading import SERIES, all_text, drawn, shows
from made_up_studies import ALL, LEVELS, MAKERS, records_of_series, validation

from rockdamp.figures.validation import off, series_by_maker, shown
from rockdamp.vocabulary import PAPER_MODELS

MODELS = ("CR", *PAPER_MODELS)


def panels_of(figure, model):
    return [axes for axes in figure.axes if model in [text.get_text() for text in axes.texts]]


@pytest.mark.parametrize("said, synthetic", [("yes", True), ("no", False), (None, True), ("No idea", True)])
def test_fig8_calls_a_record_synthetic_unless_it_says_that_it_is_not(said, synthetic):
    data = validation(record_synthetic=said)
    if said is None:
        del data.attrs["record_synthetic"]
    text = all_text(FIGURES["fig8"](data))
    assert text.count("SYNTHETIC") == (2 if synthetic else 0)  # the heading and the legend


def test_fig8_marks_a_free_decay_only_where_the_record_holds_one():
    assert "free decay" in all_text(FIGURES["fig8"](validation()))
    pushed = validation()
    pushed["half_cycle_free"][:] = 0
    pushed["free_phase_start"][:] = np.nan
    assert "free decay" not in all_text(FIGURES["fig8"](pushed))


def test_fig8_starts_shortly_before_the_motion_and_ends_after_the_last_peak():
    start, end = shown(validation())
    # The bell of 0.1 s around 1.5 s first passes a tenth of its peak at 1.5 - 0.1 sqrt(ln 10).
    assert 1.0 < start < 1.5 - 0.1 * np.sqrt(np.log(10)) + 0.01
    assert 1.5 + 3.5 * np.pi / 8 < end < 4


# --- of a test series


def test_of_several_records_each_model_stands_on_every_level_beside_the_measurement():
    data, figure = records_of_series(), drawn(SERIES)
    for model in MODELS:
        panels = panels_of(figure, model)
        assert len(panels) == len(LEVELS)
        for axes, level in zip(panels, range(len(LEVELS)), strict=True):
            one = data.isel(record=level)
            largest = float(one["measured_peak_displacement"])
            assert shows(axes, one["elapsed"], one["measured"] / largest)
            assert shows(axes, one["elapsed"], one["control_displacement"].sel(damping_model=model) / largest)
            ratio = float(one["peak_ratio_to_measured"].sel(damping_model=model))
            assert f"peak {ratio:.2f} of the record's" in [text.get_text() for text in axes.texts]


def test_of_several_records_peaks_and_decrements_stand_over_amplitude_for_whatever_made_them():
    data, figure = records_of_series(), FIGURES["fig_test_series"](records_of_series())
    for number, maker in enumerate(MAKERS):
        of_maker = data.isel(record=slice(4 * number, 4 * number + 4))
        (above,) = (axes for axes in figure.axes if axes.get_title() == f"made by {maker}")
        assert shows(above, LEVELS, of_maker["peak_ratio_to_measured"].sel(damping_model="SDR"))
        decrement = of_maker["log_decrement"] / of_maker["measured_log_decrement"]
        below = figure.axes[figure.axes.index(above) + len(MAKERS)]
        assert shows(below, LEVELS, decrement.sel(damping_model="SDR"))
    assert "SYNTHETIC records" in all_text(figure)


def test_levels_are_drawn_from_the_lowest_up_and_a_model_that_collapsed_has_no_peak():
    data = records_of_series().isel(record=[3, 0, 2, 1])
    data["collapsed"][0, 3] = 1
    (levels,) = series_by_maker(data).values()
    assert list(levels["record"].values) == [f"0 at {height}" for height in LEVELS]
    peaks = off(levels, "peak").sel(damping_model=ALL[3])
    assert list(np.isnan(peaks.values)) == [False, False, False, True]
    assert "collapsed" in all_text(FIGURES["fig8"](data))
