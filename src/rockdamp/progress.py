"""Progress of long work: a bar on a terminal, silence elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def track(items: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Iterate over `items` while a bar on standard error shows how far it is."""
    from tqdm import tqdm  # who shows no progress does not wait for it to load

    return tqdm(items, desc=description, total=total, disable=None, leave=False)
