"""Rules for every figure of the minimal build: labels, units, sizes, places of text, bytes."""

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
RESOLUTION = 80  # dots per inch in config/minimal.yaml


def draw(name, results):
    module, sources = FIGURES[name]
    draw_figure = getattr(import_module(f"rockdamp.{module}"), name)
    return draw_figure(*(dataset.read(results / f"{source}.nc") for source in sources))


@pytest.fixture(scope="module", params=FIGURES)
def figure(request, minimal):
    """A figure with everything in its final place."""
    figure = draw(request.param, minimal)
    figure.draw_without_rendering()
    return figure


def visible_ticks(axis):
    """Return the ticks of an axis that lie within its view."""
    low, high = sorted(axis.get_view_interval())
    slack = 1e-6 * (high - low)
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    return [tick for tick in ticks if low - slack <= tick.get_loc() <= high + slack]


def visible_texts(figure):
    """Return every text that is seen: the labels of ticks, and all others."""
    tick_labels = set()
    texts = []
    for axis in figure.findobj(Axis):
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            tick_labels |= {tick.label1, tick.label2}
        if axis.axes.axison:
            for tick in visible_ticks(axis):
                texts += [tick.label1, tick.label2]
    texts += [text for text in figure.findobj(Text) if text not in tick_labels]
    hidden = {axis.label for axis in figure.findobj(Axis) if not axis.axes.axison}
    return [text for text in texts if text.get_text() and text.get_visible() and text not in hidden]


def shared_labels(axes, name):
    """Return the labels of an axis and of those that share it."""
    peers = getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)
    return [getattr(peer, f"{name}axis").get_label_text() for peer in peers]


@pytest.mark.parametrize("name", ["x", "y"])
def test_axis_with_numbers_has_a_label_with_its_unit(figure, name):
    for axes in figure.axes:
        axis = getattr(axes, f"{name}axis")
        ticks = [label.get_text() for label in axis.get_ticklabels() if label.get_visible()]
        has_numbers = any(re.match(r"[\d−]|\$\\mathdefault", tick) for tick in ticks)
        if axes.axison and has_numbers:
            labels = shared_labels(axes, name)
            assert any(re.search(r"\[.+\]", label) for label in labels), labels


def test_text_is_large_enough(figure):
    for text in visible_texts(figure):
        assert text.get_fontsize() >= SMALLEST_TEXT, text.get_text()


def test_text_lies_inside_the_figure(figure):
    for text in visible_texts(figure):
        box = text.get_window_extent()
        assert figure.bbox.x0 <= box.x0 + 1, text.get_text()
        assert box.x1 - 1 <= figure.bbox.x1, text.get_text()
        assert figure.bbox.y0 <= box.y0 + 1, text.get_text()
        assert box.y1 - 1 <= figure.bbox.y1, text.get_text()


def test_no_text_lies_on_another(figure):
    boxes = [(text.get_text(), text.get_window_extent()) for text in visible_texts(figure)]
    for (first, a), (second, b) in combinations(boxes, 2):
        width = min(a.x1, b.x1) - max(a.x0, b.x0)
        height = min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(width, height) < 2, f"{first!r} lies on {second!r}"


def test_no_text_and_no_legend_covers_a_curve(figure):
    texts = visible_texts(figure)
    artists = [text for text in texts if text.axes is None or text in text.axes.texts]
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    artists += [legend for legend in legends if legend]
    for axes in figure.axes:
        extents = [artist.get_window_extent().padded(-1) for artist in artists]
        boxes = [Bbox.intersection(extent, axes.bbox) for extent in extents]
        boxes = [box for box in boxes if box is not None]
        for line in axes.get_lines():
            is_guide = len(line.get_xdata()) <= 3
            path = line.get_transform().transform_path(line.get_path())
            for box in boxes:
                assert is_guide or not path.intersects_bbox(box, filled=False), line.get_label()


def test_figure_fits_in_columns_and_page(figure):
    width, height = figure.get_size_inches() * 25.4
    assert any(width == pytest.approx(allowed, abs=1e-9) for allowed in (COLUMN, WIDTH))
    assert height <= 160


@pytest.mark.parametrize("name", FIGURES)
def test_same_data_give_the_same_bytes(name, minimal, tmp_path):
    figure = draw(name, minimal)
    files = [tmp_path / f"{name}.{suffix}" for suffix in ("png", "pdf")]
    save(figure, files, RESOLUTION)
    for file in files:
        assert file.read_bytes() == (minimal / "figures" / file.name).read_bytes()
    width = int.from_bytes(files[0].read_bytes()[16:20], "big")
    assert width == int(RESOLUTION * figure.get_size_inches()[0])


# --- looks -------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", ["linestyle", "marker"])
def test_models_differ_without_colour(key):
    for first, second in combinations(LOOK, 2):
        assert look(first)[key] != look(second)[key]


def test_many_walls_differ():
    pairs = {(line["color"], line["marker"]) for line in map(series, range(24))}
    assert len(pairs) == 24
