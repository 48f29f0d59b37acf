"""Progress of long work: a bar on a terminal, silence elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

# True where a part of longer work, which shows its own bar, would show another; else tqdm looks for a terminal.
_HIDDEN: ContextVar[bool | None] = ContextVar("hidden", default=None)


def track(items: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Iterate over `items` while a bar on standard error shows how far it is."""
    from tqdm import tqdm  # who shows no progress does not wait for it to load

    return tqdm(items, desc=description, total=total, disable=_HIDDEN.get(), leave=False)


@contextmanager
def without_bars() -> Iterator[None]:
    """Show none while the body runs, which is one step of what shows its own."""
    token = _HIDDEN.set(True)
    try:
        yield
    finally:
        _HIDDEN.reset(token)


@contextmanager
def counting(total: int, description: str) -> Iterator[Callable[[int], object]]:
    """Show a bar while the body runs; what is yielded moves it on."""
    from tqdm import tqdm

    with tqdm(total=total, desc=description, disable=_HIDDEN.get(), leave=False) as bar:
        yield bar.update
