"""Saving of figures: the same bytes each time, whole or not at all."""

import errno
from pathlib import Path

import matplotlib
import pytest
from figure_reading import draw
from matplotlib.figure import Figure

from rockdamp.figures.output import save


def test_two_saves_of_a_figure_drawn_twice_are_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    formats = ("pdf", "png", "svg")
    for folder in ("one", "two"):
        written = save(draw("fig6_error"), tmp_path / folder / "figure", formats, 100)
        assert written == [tmp_path / folder / f"figure.{suffix}" for suffix in formats]
    for suffix in formats:
        first, second = ((tmp_path / folder / f"figure.{suffix}").read_bytes() for folder in ("one", "two"))
        assert first == second, suffix
        assert b"CreationDate" not in first and b"dc:date" not in first
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == ["figure.pdf", "figure.png", "figure.svg"]


def test_a_failed_save_leaves_the_earlier_file_and_nothing_else(tmp_path, monkeypatch):
    figure = Figure(figsize=(1, 1))
    (path,) = save(figure, tmp_path / "figure", ["png"], 50)
    before = path.read_bytes()

    def break_off(target, content):
        with target.open("wb") as file:
            file.write(content[:4])
        raise OSError(errno.ENOSPC, "disk full")

    monkeypatch.setattr(Path, "write_bytes", break_off)
    with pytest.raises(OSError, match="disk full"):
        save(figure, tmp_path / "figure", ["png"], 50)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_the_users_own_style_changes_nothing(tmp_path):
    (path,) = save(draw("fig6_error"), tmp_path / "plain", ["png"], 80)
    with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "black", "savefig.dpi": 30}):
        (other,) = save(draw("fig6_error"), tmp_path / "styled", ["png"], 80)
        assert matplotlib.rcParams["font.size"] == 20  # and the figures change nothing of the user's
    assert path.read_bytes() == other.read_bytes()


def test_a_figure_is_laid_out_once_for_all_formats_and_within_its_edges(tmp_path, monkeypatch):
    figure = Figure(figsize=(2, 2), layout="constrained")
    panel = figure.subplots()
    panel.set_ylabel("a label\nof two lines")
    engine, times = figure.get_layout_engine(), []
    lay_out = engine.execute
    monkeypatch.setattr(engine, "execute", lambda given: times.append(lay_out(given)))
    save(figure, tmp_path / "figure", ("pdf", "png", "svg"), 50)
    assert len(times) == 1
    assert figure.get_layout_engine() is engine
    assert panel.get_tightbbox().x0 >= 0
