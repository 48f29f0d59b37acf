"""Numbers that a page of the documents states, and the datasets of the full build that they are of."""

import re

import pytest
import xarray as xr
from repository import ROOT

from rockdamp.storage import dataset


def read_full(name: str) -> xr.Dataset:
    """Open a dataset of the full build, or skip the test."""
    path = ROOT / f"results/{name}.nc"
    if not path.exists():
        pytest.skip("no full build")
    return dataset.read(path)


def assert_stated(page: str, pattern: str, *values: float) -> None:
    """Assert that a page has a pattern once, with these values in its groups, each to the last digit that it shows."""
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    (found,) = re.finditer(pattern, text)
    for shown, value in zip(found.groups(), values, strict=True):
        digit = 10.0 ** -len(shown.partition(".")[2])
        assert float(shown) == pytest.approx(value, abs=0.51 * digit), (shown, value)


def stated_rows(page: str, first_cell: str) -> list[list[float]]:
    """Return the numbers of the table whose head begins with a cell, row by row."""
    text = (ROOT / page).read_text(encoding="utf-8")
    rows = text.split(f"| {first_cell} |")[1].split("\n\n")[0].splitlines()[2:]
    return [[float(number) for number in re.findall(r"-?\d+\.?\d*", row)] for row in rows]
