"""The figure of the pulses: what collapses, with which of both, and shades that are told apart in grey."""

import re

import numpy as np
import pytest
import xarray as xr
from figure_functions import FIGURES
from made_up_studies import ALL, VISCOUS, pulses

from rockdamp.figures.pulses import ONLY_CR, ONLY_DAMPER, fig_pulses_caption


@pytest.fixture(scope="module")
def data():
    return pulses()


@pytest.fixture(scope="module")
def at_e(data):
    return data.sel(restitution=0.85, damping_ratio_source="least error").transpose(
        ..., "load_ratio", "pulse_frequency"
    )


@pytest.fixture(scope="module")
def maps(data):
    """The panels of the contours, a row for each pulse."""
    return np.reshape(panels_of_maps(FIGURES["fig_pulses"](data)), (2, len(ALL)))


def panels_of_maps(figure):
    return [axes for axes in figure.axes if len(axes.collections) == 2 and axes.get_label() != "<colorbar>"]


def neighbours(values, at):
    """Indices of the values on both sides; of one where it is hit."""
    near = np.flatnonzero(np.isclose(values, at, rtol=1e-9))
    return near if near.size else np.searchsorted(values, at) + np.array([-1, 0])


def test_every_map_shows_where_cr_collapses(maps, data, at_e):
    for row, shape in zip(maps, data["pulse"].values, strict=True):
        cr = at_e["reference_collapsed"].sel(pulse=shape)
        assert 0 < cr.mean() < 1
        borders = [axes.collections[1].get_paths()[0].vertices for axes in row]
        assert all(np.array_equal(borders[0], border) for border in borders[1:])
        for frequency, load in borders[0]:  # between a pulse that collapses the wall and one that does not
            around = cr.isel(
                pulse_frequency=neighbours(cr["pulse_frequency"].values, frequency),
                load_ratio=neighbours(cr["load_ratio"].values, load),
            )
            assert around.min() == 0 and around.max() == 1
    assert [axes.get_title().split("\n")[0] for axes in maps[0]] == ALL


def test_the_pulses_that_one_of_both_survives_are_marked_on_the_damper_s_map_and_no_others(maps, data, at_e):
    marked = 0
    for row, shape in zip(maps, data["pulse"].values, strict=True):
        of_pulse = at_e.sel(pulse=shape)
        reference = of_pulse["reference_collapsed"].values
        assert not row[0].get_lines()
        for axes, model in zip(row[1:], VISCOUS, strict=True):
            damper = of_pulse["collapsed"].sel(damping_model=model).values
            marks = {line.get_marker(): set(zip(*line.get_data(), strict=True)) for line in axes.get_lines()}
            for marker, only in ((ONLY_CR, reference > damper), (ONLY_DAMPER, damper > reference)):
                expected = {
                    (float(data["pulse_frequency"][j]), float(data["load_ratio"][i])) for i, j in np.argwhere(only)
                }
                assert marks.pop(marker, set()) == expected
                marked += len(expected)
            assert not marks
    assert 0 < marked < at_e["collapsed"].size / 2


def test_the_caption_tells_missed_collapses_from_added_ones():
    data = pulses()
    models = range(data.sizes["damping_model"])
    data["false_safe"] = data["false_safe"] * 0 + xr.DataArray([11 + m for m in models], dims="damping_model")
    data["false_collapse"] = data["false_collapse"] * 0 + xr.DataArray([31 + m for m in models], dims="damping_model")
    missed, added = (
        " ".join(fig_pulses_caption(data).split()).split("the dampers miss ")[1].split("survivals they turn ")
    )
    for told, others, first in ((missed, added, 11), (added, missed, 31)):
        for value in (first + m for m in models):
            assert re.search(rf"\b{value}\b", told) and not re.search(rf"\b{value}\b", others)
