"""Attacks on what is read from outside: each ends in the right answer, or is refused in one line.

`record_attacks` yields them without end, at random; `ended` runs one in a folder and returns how it ended. A test runs
some, and `tools/hurt.py` as many as it is asked for.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

ANSWER, REFUSED = "answer", "refused"


class Attack(NamedTuple):
    """The name of an attack, and the function that makes it in a folder and returns how it ended."""

    kind: str
    run: Callable[[Path], str]


def ended(attack: Attack, folder: Path) -> str:
    """Return `ANSWER` or `REFUSED`, or what went wrong in its place."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return attack.run(folder)
        except Exception as error:
            return f"{type(error).__name__}: {error}"
