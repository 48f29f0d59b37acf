"""What holds for every figure, on small made-up datasets: labels, units, sizes, colours; never pixels."""

import re
from itertools import combinations

import pytest
from figure_reading import INPUTS, all_text, drawn, texts
from made_up_studies import ALL
from matplotlib import rc_params_from_file
from matplotlib.colors import to_rgb
from minimal_build import PAPER_FIGURES

from rockdamp.constants import PAPER_MODELS
from rockdamp.figures import style
from rockdamp.figures.style import DOUBLE_COLUMN, INCH, SINGLE_COLUMN, style_of

LINES = rc_params_from_file(style.STYLE, use_default_template=False)
SMALLEST_TEXT = 7  # [pt], the house's limit for print


# --- every figure ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", INPUTS)
def test_every_axis_has_a_label_with_its_unit(name):
    for axes in drawn(name).axes:
        if not axes.axison:
            continue
        for axis in (axes.xaxis, axes.yaxis):
            ticks = [label.get_text() for label in axis.get_ticklabels() if label.get_visible()]
            # Ticks that are no numbers name categories, which have no unit.
            has_ticks = any(re.match(r"[\d−]|\$\\mathdefault", tick) for tick in ticks)
            label = axis.get_label_text()
            assert not label or not has_ticks or re.search(r"\[.+\]", label), f"{name}: no unit in {label!r}"
            # Of panels that share an axis, one may speak for all.
            peers = axes.get_shared_x_axes() if axis is axes.xaxis else axes.get_shared_y_axes()
            which = "xaxis" if axis is axes.xaxis else "yaxis"
            spoken = [getattr(peer, which).get_label_text() for peer in peers.get_siblings(axes)]
            assert not has_ticks or any(spoken), f"{name}: an axis with numbers and no label"


@pytest.mark.parametrize("name", INPUTS)
def test_text_is_large_enough_for_print_and_inside_the_figure(name):
    figure = drawn(name)
    page = figure.bbox
    for text in texts(figure):
        assert text.get_fontsize() >= SMALLEST_TEXT, text.get_text()
        box = text.get_window_extent()
        within = (
            page.x0 <= box.x0 + 0.5 and box.x1 <= page.x1 + 0.5 and page.y0 <= box.y0 + 0.5 and box.y1 <= page.y1 + 0.5
        )
        assert within, f"{name}: {text.get_text()!r} is cut off"


@pytest.mark.parametrize("name", INPUTS)
def test_no_text_lies_on_another(name):
    figure = drawn(name)
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts(figure)]
    for (one, a), (other, b) in combinations(boxes, 2):
        overlap = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(overlap) < 2, f"{name}: {one!r} lies on {other!r}"


@pytest.mark.parametrize("name", INPUTS)
def test_legends_do_not_cover_data(name):
    for axes in drawn(name).axes:
        legend = axes.get_legend()
        if legend is not None:
            box = legend.get_window_extent()
            for line in axes.get_lines():
                path = line.get_transform().transform_path(line.get_path())
                guide = len(line.get_xdata()) == 2  # lines along an axis, slopes
                assert guide or not path.intersects_bbox(box, filled=False), f"{name}: {line.get_label()!r}"


@pytest.mark.parametrize("name", INPUTS)
def test_figures_have_the_width_of_one_or_two_columns(name):
    width, height = drawn(name).get_size_inches() * INCH
    assert width == pytest.approx(SINGLE_COLUMN) or width == pytest.approx(DOUBLE_COLUMN)
    assert height <= 240  # a page's text


@pytest.mark.parametrize("name", ["fig3", "fig4", "fig6_error", "fig7", "fig8", "fig_convergence"])
def test_a_model_has_one_colour_line_and_marker_everywhere(name):
    seen = set()
    for axes in drawn(name).axes:
        for line in axes.get_lines():
            model = re.match(rf"({'|'.join(ALL)})\b", str(line.get_label()))
            model = model[1] if model else None
            if model:
                assert to_rgb(line.get_color()) == to_rgb(style_of(model).colour)
                assert line.get_marker() in ("None", style_of(model).marker)
                seen.add(model)
    papers = {"fig4": {"CR", "CDR"}, "fig8": {"CR", *PAPER_MODELS}}
    assert seen == (papers.get(name, set(PAPER_MODELS)) if name in PAPER_FIGURES else set(ALL))


def strokes(linestyle):
    """A line as the eye takes it in: its dots, short and long strokes, and the gaps as wide as a stroke."""
    if isinstance(linestyle, str):
        pattern = LINES.get(f"lines.{linestyle}_pattern", ())
    else:
        pattern = linestyle[1]
    seen = [
        ("dot" if stroke < 2 else "short" if stroke < 4.5 else "long") + (" wide" if gap > 2.5 else "")
        for stroke, gap in zip(pattern[::2], pattern[1::2], strict=True)
    ]
    return min((tuple(seen[i:] + seen[:i]) for i in range(len(seen))), default=())  # wherever the line begins


def test_models_are_told_apart_without_colour_those_without_a_chosen_style_too(monkeypatch):
    spare = ["one more", "another", "a third"]
    monkeypatch.setattr(style, "MODELS", (*ALL, *spare))
    monkeypatch.setattr(style, "COLOURS", style.COLOURS | dict.fromkeys(spare, style.COLOURS["CR"]))
    for one, other in combinations([style_of(model) for model in (*ALL, *spare)], 2):
        assert one.linestyle != other.linestyle and one.marker != other.marker
        assert strokes(one.linestyle) != strokes(other.linestyle)


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_a_figure_of_the_paper_shows_the_papers_models_alone(name):
    assert not re.search(r"\bECD", all_text(drawn(name)))
