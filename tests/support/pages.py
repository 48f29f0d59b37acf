"""Numbers that a page of the documents states, and their datasets of the full build."""

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
    """Assert that a page has a pattern once, with these values to the last digit of its groups."""
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    (match,) = re.finditer(pattern, text)
    for number, value in zip(match.groups(), values, strict=True):
        digit = 10.0 ** -len(number.partition(".")[2])
        assert float(number) == pytest.approx(value, abs=0.51 * digit), (number, value)


def stated_rows(page: str, first_cell: str) -> list[list[float]]:
    """Return the numbers of the table whose head begins with a cell, row by row."""
    text = (ROOT / page).read_text(encoding="utf-8")
    rows = text.split(f"| {first_cell} |")[1].split("\n\n")[0].splitlines()[2:]
    return [[float(number) for number in re.findall(r"-?\d+\.?\d*", row)] for row in rows]
