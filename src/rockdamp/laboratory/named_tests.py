"""The measured tests that a config names, checked before a run."""

from __future__ import annotations

from collections.abc import Iterable

from rockdamp.errors import InputError
from rockdamp.laboratory.calibration import require_possible
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import read_record


def require_possible_tests(paths: Iterable[str], wall: Wall | Parapet) -> None:
    """Raise `InputError` where a test's displacement is one that its wall does not come back from."""
    for path in dict.fromkeys(paths):
        try:
            require_possible(read_record(path), wall)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
