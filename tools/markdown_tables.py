"""Tables in Markdown, and the words of their cells."""

from collections.abc import Iterable

import xarray as xr

from rockdamp.text import number


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [list(head), *map(list, rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def percent(fraction: xr.DataArray) -> str:
    return f"{number(100 * fraction, 2)} %"


def models(values: xr.Dataset, dim: str = "damping_model") -> list[tuple[str, xr.Dataset]]:
    """Return each damping model with its part of a dataset."""
    return [(str(model), values.sel({dim: model})) for model in values[dim].values]
