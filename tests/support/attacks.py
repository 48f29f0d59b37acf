"""Attacks on what is read from outside: each ends in the right answer, or is refused in one line.

`record_attacks` yields them without end, at random; `ended` runs one in a folder and returns how it ended. A test runs
some, and `tools/hurt.py` as many as it is asked for.
"""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

ANSWER, REFUSED = "answer", "refused"
PATIENCE = 30  # seconds, after which an attack hangs


class Attack(NamedTuple):
    """The name of an attack, and the function that makes it in a folder and returns how it ended."""

    kind: str
    run: Callable[[Path], str]


class Hangs(Exception):
    """An attack takes longer than `PATIENCE`."""


def ended(attack: Attack, folder: Path) -> str:
    """Return `ANSWER` or `REFUSED`, or what went wrong in its place."""
    with _limited(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return attack.run(folder)
        except Hangs:
            return f"hangs for more than {PATIENCE} s"
        except Exception as error:
            return f"{type(error).__name__}: {error}"


@contextmanager
def _limited() -> Iterator[None]:
    def too_long(*_: Any) -> None:
        raise Hangs

    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
