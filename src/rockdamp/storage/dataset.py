"""Write datasets as NetCDF under CF, with what the glossary says of their variables, and read them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import yaml

from rockdamp.errors import InputError
from rockdamp.storage.files import replace_file

if TYPE_CHECKING:  # the Snakefile reads the glossary at every start
    import xarray as xr

PAPER = (
    "Energy dissipation involved in the out-of-plane response of unreinforced masonry walls (conference paper); "
    "equation and figure numbers are its own"
)
LARGE = 10_000  # values; smaller variables are not worth compressing
ATTRIBUTES = ("units", "long_name", "symbol")

Datasets: TypeAlias = "Mapping[str, xr.Dataset]"  # by the name of their file


@cache
def glossary() -> dict[str, dict[str, Any]]:
    """Return the glossary: the entries of all ``names``, and what it says of each kind of ``datasets``."""
    text = Path(__file__).with_name("glossary.yaml").read_text(encoding="utf-8")
    whole: dict[str, dict[str, Any]] = yaml.load(text, yaml.CSafeLoader)
    return whole


def variables(kind: str) -> dict[str, dict[str, Any]]:
    """Return the glossary's entry of each name that a kind of dataset has; ``optional`` ones only some of its files."""
    dataset = glossary()["datasets"][kind]
    optional, meanings = dataset.get("optional", []), dataset.get("says", {})
    entries = {
        name: {**_entry(name), **meanings.get(name, {})}
        for name in [*dataset["variables"], *optional]
    }
    return entries | {name: {**entries[name], "optional": True} for name in optional}


def _entry(name: str) -> dict[str, Any]:
    names = glossary()["names"]
    own = name.removesuffix("_interval")
    if name in names or name == own:
        return dict(names[name])
    return {"units": names[own]["units"], "long_name": f"95 % bootstrap interval of {own}"}


def describe(dataset: xr.Dataset, kind: str) -> xr.Dataset:
    """Add the unit and the meaning that the glossary has for each variable of a kind of dataset."""
    entries = variables(kind)
    for name in entries.keys() & set(map(str, dataset.variables)):
        dataset[name].attrs = {
            key: entries[name][key] for key in ATTRIBUTES if key in entries[name]
        }
    return dataset


def check(dataset: xr.Dataset, kind: str) -> dict[str, dict[str, Any]]:
    """Return the entries of a dataset's names, or raise `InputError` where it has other names than its kind."""
    expected = variables(kind)
    unknown = sorted(set(map(str, dataset.variables)) - set(expected))
    missing = [
        name
        for name, entry in expected.items()
        if name not in dataset.variables and not entry.get("optional")
    ]
    if unknown or missing:
        raise InputError(f"{kind}: not in the glossary: {unknown}; missing: {sorted(missing)}")
    return expected


def write(
    dataset: xr.Dataset,
    path: str | os.PathLike[str],
    kind: str,
    *,
    config: Mapping[str, Any],
    code_version: str,
) -> None:
    """Write a dataset of a `kind` of the glossary as NetCDF-4 under CF-1.11, complete or not at all.

    `config` are the values that it was made with, kept as JSON; `code_version` is that of the sources. Coordinates that
    are printed with few decimals are stored so that ``.sel`` finds what is printed.
    """
    expected, entry_of_kind = check(dataset, kind), glossary()["datasets"][kind]
    dataset = (
        dataset.drop_encoding()
    )  # of a file that it was read from, whose coordinates may be gone
    dataset = dataset.assign_coords(
        {name: _rounded(dataset[name]) for name in dataset.dims if name in dataset.coords}
    )
    encoding: dict[str, dict[str, Any]] = {}
    for name in map(str, dataset.variables):
        entry, variable = expected[name], dataset[name]
        variable.attrs = {key: entry[key] for key in ATTRIBUTES if key in entry}
        encoding[name] = _encoding(variable, entry, is_coordinate=name in dataset.coords)
        if variable.size > LARGE and entry_of_kind.get("compressed", True):
            encoding[name] |= {"zlib": True, "complevel": 1, "shuffle": True}
    dataset.attrs = {
        **dataset.attrs,
        "title": entry_of_kind["title"],
        "source": "rockdamp: numerical simulation",
        "references": PAPER,
        "Conventions": "CF-1.11",
        "config": json.dumps(dict(config), ensure_ascii=False),
        "code_version": code_version,
    }
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with replace_file(path) as temporary:
        dataset.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)


def _rounded(coordinate: xr.DataArray) -> xr.DataArray:
    """Round equal steps, and values that are off a short decimal by noise alone; others keep their bits."""
    if coordinate.dtype.kind != "f":
        return coordinate
    values, steps = coordinate.values, np.diff(coordinate.values)
    short = np.round(values, 12)
    equal = steps.size > 1 and np.allclose(steps, steps[0], rtol=1e-6, atol=0)
    noise = np.abs(values - short) <= 8 * np.spacing(np.abs(values))
    return coordinate.copy(data=short) if equal or noise.all() else coordinate


def _encoding(
    variable: xr.DataArray, entry: Mapping[str, Any], is_coordinate: bool
) -> dict[str, Any]:
    # With a checksum a damaged file is an error, not other numbers. HDF5 has none for single values.
    encoding: dict[str, Any] = {"fletcher32": True} if variable.ndim else {}
    if variable.dtype.kind in "UO":
        # Characters, not strings: the CF checker cannot compare strings.
        return encoding | {"dtype": "S1"}
    if is_coordinate or variable.dtype.kind != "f":
        encoding["_FillValue"] = None  # CF allows none on coordinates
    if "dtype" in entry:
        encoding["dtype"] = entry["dtype"]
    return encoding


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset whole into memory."""
    import xarray as xr

    with xr.open_dataset(path, engine="netcdf4") as dataset:
        return dataset.load()
