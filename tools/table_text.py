"""Numbers and tables as the tools write them into the documents."""

import re
from collections.abc import Callable, Iterable

import numpy as np
import xarray as xr

from rockdamp.text import number


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [list(head), *map(list, rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def power(value: xr.DataArray) -> str:
    """Two digits and the power of ten: 2.3e-4."""
    return re.sub(r"e-0?", "e-", f"{float(value):.1e}")


def percent(fraction: xr.DataArray) -> str:
    return f"{number(100 * fraction, 2)} %"


def models(values: xr.Dataset, dim: str = "damping_model") -> list[tuple[str, xr.Dataset]]:
    """Return each damping model with its part of a dataset."""
    return [(str(model), values.sel({dim: model})) for model in values[dim].values]


def share(fraction: xr.DataArray) -> str:
    """A percentage in plain digits; a dash where there is none."""
    return f"{float(f'{100 * fraction:.2g}'):g} %" if np.isfinite(fraction) else "–"


def interval(one: xr.Dataset, name: str) -> str:
    """Return a statistic with its interval; rates are percentages."""
    show: Callable[[xr.DataArray], str] = percent if name.endswith("_rate") else number
    low, high = (show(bound) for bound in one[f"{name}_interval"])
    return f"{show(one[name])} ({low} to {high})"
