"""Progress of long work: a bar on a terminal, silence elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


def track(items: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Iterate over `items` while a bar on standard error shows how far it is."""
    from tqdm import tqdm  # who shows no progress does not wait for it to load

    return tqdm(items, desc=description, total=total, disable=None, leave=False)


@contextmanager
def counting(total: int, description: str) -> Iterator[Callable[[int], object]]:
    """Show a bar while the body runs; what is yielded moves it on."""
    from tqdm import tqdm

    with tqdm(total=total, desc=description, disable=None, leave=False) as bar:
        yield bar.update
