"""Numbers that were written down, in files and on the command line; it imports nothing, so that `--help` is quick."""

from __future__ import annotations


def number(text: str) -> float:
    """Return the number that a text is, finite or not; not 1_0 and not digits beyond ASCII, which Python alone takes.

    Raises
    ------
    ValueError
        If it is none.
    """
    if not text.isascii() or "_" in text:
        raise ValueError(f"{text!r} is no number")
    return float(text)
