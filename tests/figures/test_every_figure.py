"""What holds for every figure of the minimal build: labels, units, sizes, places of text, looks, bytes."""

import re
from importlib import import_module
from itertools import combinations

import pytest
from matplotlib.axis import Axis
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from rockdamp.figures import FIGURES
from rockdamp.figures.style import COLUMN, LOOK, WIDTH, look, save, series
from rockdamp.storage import dataset

SMALLEST_TEXT = 7  # [pt], the limit for print


def draw(name, results):
    module, names = FIGURES[name]
    figure = getattr(import_module(f"rockdamp.{module}"), name)
    return figure(*(dataset.read(results / f"{each}.nc") for each in names))


@pytest.fixture(scope="module", params=FIGURES)
def figure(request, minimal):
    """A figure with everything in its final place."""
    drawn = draw(request.param, minimal)
    drawn.draw_without_rendering()
    return drawn


def texts(figure):
    """Every text that is seen: labels of ticks, and all others."""
    on_ticks, seen = set(), []
    for axis in figure.findobj(Axis):
        low, high = sorted(axis.get_view_interval())
        slack = 1e-6 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            on_ticks |= {tick.label1, tick.label2}
            if axis.axes.axison and low - slack <= tick.get_loc() <= high + slack:
                seen += [tick.label1, tick.label2]
    others = [text for text in figure.findobj(Text) if text not in on_ticks]
    hidden = {axis.label for axis in figure.findobj(Axis) if not axis.axes.axison}
    return [
        text
        for text in (*seen, *others)
        if text.get_text() and text.get_visible() and text not in hidden
    ]


def test_every_axis_with_numbers_has_a_label_with_its_unit(figure):
    for axes in figure.axes:
        for name in ("x", "y") if axes.axison else ():
            axis = getattr(axes, f"{name}axis")
            peers = getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)
            labels = [getattr(peer, f"{name}axis").get_label_text() for peer in peers]
            ticks = [label.get_text() for label in axis.get_ticklabels() if label.get_visible()]
            if any(re.match(r"[\d−]|\$\\mathdefault", tick) for tick in ticks):
                assert any(re.search(r"\[.+\]", label) for label in labels), labels


def test_text_is_large_enough_lies_inside_and_on_no_other_text(figure):
    boxes = []
    for text in texts(figure):
        assert text.get_fontsize() >= SMALLEST_TEXT, text.get_text()
        box = text.get_window_extent()
        inside = figure.bbox.x0 <= box.x0 + 1 and box.x1 - 1 <= figure.bbox.x1
        assert inside and figure.bbox.y0 <= box.y0 + 1 and box.y1 - 1 <= figure.bbox.y1, (
            text.get_text()
        )
        boxes.append((text.get_text(), box))
    for (one, a), (other, b) in combinations(boxes, 2):
        overlap = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(overlap) < 2, f"{one!r} lies on {other!r}"


def test_no_text_and_no_legend_covers_a_curve(figure):
    written = [text for text in texts(figure) if text.axes is None or text in text.axes.texts]
    written += [
        legend
        for legend in (*figure.legends, *(axes.get_legend() for axes in figure.axes))
        if legend
    ]
    for axes in figure.axes:
        boxes = [
            Bbox.intersection(artist.get_window_extent().padded(-1), axes.bbox)
            for artist in written
        ]
        for line in axes.get_lines():
            path = line.get_transform().transform_path(line.get_path())
            guide = len(line.get_xdata()) <= 3
            for box in boxes:
                assert guide or box is None or not path.intersects_bbox(box, filled=False), (
                    line.get_label()
                )


def test_a_figure_has_the_width_of_one_or_two_columns_and_fits_on_a_page(figure):
    width, height = figure.get_size_inches() * 25.4
    assert min(abs(width - COLUMN), abs(width - WIDTH)) < 1e-9 and height <= 160


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_has_the_resolution_asked_for_and_the_same_bytes_again(name, minimal, tmp_path):
    figure = draw(name, minimal)
    files = [tmp_path / f"{name}.{suffix}" for suffix in ("png", "pdf")]
    save(figure, files, 80)  # as config/minimal.yaml says
    for file in files:
        assert file.read_bytes() == (minimal / "figures" / file.name).read_bytes()
    assert int.from_bytes(files[0].read_bytes()[16:20], "big") == int(
        80 * figure.get_size_inches()[0]
    )


def test_models_and_walls_differ_without_colour():
    for one, other in combinations(LOOK, 2):
        assert (
            look(one)["linestyle"] != look(other)["linestyle"]
            and look(one)["marker"] != look(other)["marker"]
        )
    assert len({(line["color"], line["marker"]) for line in map(series, range(24))}) == 24
    assert (
        look("ECD16") == look("ECD")
        and look("BAND0.4", marker="")["color"] == look("BAND")["color"]
    )
