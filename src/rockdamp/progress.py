"""Show progress of long work: a bar on a terminal, nothing elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


def track(items: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Iterate over `items` and show the progress on standard error."""
    from tqdm import tqdm  # slow to load

    return tqdm(items, desc=description, total=total, disable=_disabled(), leave=False)


@contextmanager
def counting(total: int, description: str) -> Iterator[Callable[[int], object]]:
    """Show a bar while the body runs; yield the function that advances it."""
    from tqdm import tqdm

    with tqdm(total=total, desc=description, disable=_disabled(), leave=False) as bar:
        yield bar.update


def _disabled() -> bool | None:
    """Return True where standard error is closed, as by `2>&-`; None lets tqdm look for a terminal."""
    return True if sys.stderr is None else None
