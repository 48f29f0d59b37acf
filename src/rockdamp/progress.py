"""Progress of long work: a bar on a terminal, and no output elsewhere."""

from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def track(items: Iterable[T], description: str, total: int | None = None) -> Iterable[T]:
    """Iterate over `items`, `total` in number, and show the progress on standard error."""
    from tqdm import tqdm  # slow to load

    return tqdm(items, desc=description, total=total, disable=None, leave=False)
