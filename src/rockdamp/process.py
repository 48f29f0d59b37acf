"""What a process does that runs one command or one job and ends."""

from __future__ import annotations

import atexit
import gc

OBJECTS = 30_000  # made between two looks for garbage; Python's own number is 700


def collect_rarely() -> None:
    """Let Python look for reference cycles rarely, and not at the end: a third of the time of a short command.

    Importing makes some 100,000 objects that stay, and each look walks through them again. For programs alone: a
    library leaves the settings of its process as they are.
    """
    gc.set_threshold(OBJECTS, *gc.get_threshold()[1:])
    atexit.register(gc.freeze)
