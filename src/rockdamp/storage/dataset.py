"""Write datasets as NetCDF under CF, with the glossary's units and meanings, and read them."""

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
    "Energy dissipation involved in the out-of-plane response of unreinforced masonry walls"
    " (conference paper); equation and figure numbers are its own"
)

Entry: TypeAlias = dict[str, Any]
Datasets: TypeAlias = "Mapping[str, xr.Dataset]"  # by the name of their file


# --- the glossary ---------------------------------------------------------------------------------


@cache
def glossary() -> dict[str, dict[str, Any]]:
    """Return the glossary: the entries of ``names``, and the names of each of ``datasets``."""
    text = Path(__file__).with_name("glossary.yaml").read_text(encoding="utf-8")
    entries: dict[str, dict[str, Any]] = yaml.load(text, yaml.CSafeLoader)
    return entries


def variables(kind: str) -> dict[str, Entry]:
    """Return the glossary's entries of the variables of a kind of dataset.

    Parameters
    ----------
    kind : str
        A key of ``datasets`` in the glossary.

    Returns
    -------
    dict
        Entries by name. Those that only some of its files have are ``optional``.
    """
    dataset = glossary()["datasets"][kind]
    meanings = dataset.get("says", {})
    entries = {}
    for name in dataset["variables"]:
        entries[name] = _find_entry(name, meanings)
    for name in dataset.get("optional", []):
        entries[name] = _find_entry(name, meanings) | {"optional": True}
    return entries


def _find_entry(name: str, meanings: Mapping[str, Entry]) -> Entry:
    """Return the entry of a name, with its meaning in this kind in place of the usual one."""
    names = glossary()["names"]
    meaning = meanings.get(name, {})
    statistic = name.removesuffix("_interval")
    if name in names or name == statistic:
        entry = dict(names[name])
    else:
        long_name = f"95 % bootstrap interval of {statistic}"
        entry = {"units": names[statistic]["units"], "long_name": long_name}
    if "long_name" in meaning:
        entry.pop("comment", None)  # it belongs to the usual meaning
    return entry | meaning


def _select_attributes(entry: Entry) -> Entry:
    return {key: entry[key] for key in ("units", "long_name", "comment", "symbol") if key in entry}


def describe(dataset: xr.Dataset, kind: str) -> xr.Dataset:
    """Add the glossary's unit and meaning to each variable of a dataset, and return the dataset."""
    for name, entry in variables(kind).items():
        if name in dataset.variables:
            dataset[name].attrs = _select_attributes(entry)
    return dataset


def check(dataset: xr.Dataset, kind: str) -> dict[str, Entry]:
    """Return the entries of a kind of dataset.

    Raises
    ------
    InputError
        If the dataset has a variable that its kind has not, or lacks one that is not optional.
    """
    expected = variables(kind)
    required = {name for name, entry in expected.items() if not entry.get("optional")}
    names = set(map(str, dataset.variables))
    unknown = sorted(names - set(expected))
    missing = sorted(required - names)
    if unknown or missing:
        raise InputError(f"{kind}: not in the glossary: {unknown}; missing: {missing}")
    return expected


# --- writing --------------------------------------------------------------------------------------


def write(
    dataset: xr.Dataset,
    path: str | os.PathLike[str],
    kind: str,
    *,
    config: Mapping[str, Any],
    code_version: str,
) -> None:
    """Write a dataset as NetCDF-4 under CF-1.11, complete or not at all.

    Coordinates that are printed with few decimals are stored so that ``.sel`` finds the printed
    values. An integer variable with a ``missing`` value in the glossary has it as its fill value,
    which xarray reads as NaN.

    Parameters
    ----------
    dataset : xarray.Dataset
        Variables without attributes.
    path : str or path
        The file; its folder is made.
    kind : str
        A key of ``datasets`` in the glossary.
    config : mapping
        Values that the dataset was computed from, stored as JSON.
    code_version : str
        Version of the code that computed it.

    Raises
    ------
    InputError
        If the variables are not those of the glossary.
    """
    expected = check(dataset, kind)
    entry_of_kind = glossary()["datasets"][kind]
    # A dataset that was read has the encoding of its file, whose coordinates it may have lost.
    dataset = dataset.drop_encoding()
    indexed = [name for name in dataset.dims if name in dataset.coords]
    dataset = dataset.assign_coords({name: _round_coordinate(dataset[name]) for name in indexed})
    encoding = {}
    for name in map(str, dataset.variables):
        variable = dataset[name]
        variable.attrs = _select_attributes(expected[name])
        encoding[name] = _encode(variable, expected[name], name in dataset.coords)
        # Compressing smaller variables saves nothing.
        if variable.size > 10_000 and entry_of_kind.get("compressed", True):
            encoding[name] |= {"zlib": True, "complevel": 1, "shuffle": True}
    dataset.attrs |= {
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


def _round_coordinate(coordinate: xr.DataArray) -> xr.DataArray:
    """Round equal steps, and values that only noise separates from short decimals."""
    if coordinate.dtype.kind != "f":
        return coordinate
    values = coordinate.values
    short = np.round(values, 12)
    steps = np.diff(values)
    has_equal_steps = steps.size > 1 and np.allclose(steps, steps[0], rtol=1e-6, atol=0)
    is_short = np.abs(values - short) <= 8 * np.spacing(np.abs(values))
    if has_equal_steps or is_short.all():
        return coordinate.copy(data=short)
    return coordinate


def _encode(variable: xr.DataArray, entry: Entry, is_coordinate: bool) -> dict[str, Any]:
    encoding: dict[str, Any] = {}
    if variable.ndim > 0:
        # With a checksum, a damaged file cannot be read. HDF5 has none for single values.
        encoding["fletcher32"] = True
    if variable.dtype.kind in "UO":
        encoding["dtype"] = "S1"  # characters, as the CF checker cannot compare strings
        return encoding
    if "dtype" in entry:
        encoding["dtype"] = entry["dtype"]
    if "missing" in entry:
        encoding["_FillValue"] = entry["missing"]
    elif is_coordinate or variable.dtype.kind != "f":
        # xarray's default would be NaN, which CF forbids on coordinates.
        encoding["_FillValue"] = None
    return encoding


# --- reading --------------------------------------------------------------------------------------


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset whole into memory.

    Integers with a fill value stay integers, and missing ones have the fill value, as before they
    were written.
    """
    import xarray as xr

    with xr.open_dataset(path, engine="netcdf4") as dataset:
        dataset.load()
    for name, variable in dataset.data_vars.items():
        stored_type = variable.encoding["dtype"]
        if variable.dtype.kind == "f" and stored_type.kind == "i":
            filled = variable.fillna(variable.encoding["_FillValue"])
            dataset[name] = filled.astype(stored_type)
    return dataset
