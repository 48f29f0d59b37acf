"""Bars on a terminal, and nowhere else."""

import io

import pytest

from rockdamp.progress import counting, track


class Terminal(io.StringIO):
    def isatty(self):
        return True


def work():
    with counting(2, "parts") as done:
        done(2)
    return sum(track([1, 2], "things"))


@pytest.fixture
def shown(monkeypatch):
    def on(screen):
        monkeypatch.setattr("sys.stderr", screen)
        assert work() == 3
        return screen.getvalue()

    return on


def test_a_terminal_shows_what_is_done_and_a_file_nothing(shown):
    told = shown(Terminal())
    assert "things" in told and "parts" in told
    assert shown(io.StringIO()) == ""
