"""Check datasets against the glossary, and write and open them as NetCDF."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from rockdamp.errors import printable
from rockdamp.storage import glossary
from rockdamp.storage.atomic import replacing

CONVENTIONS = "CF-1.11"
PAPER = (
    "Energy dissipation involved in the out-of-plane response of unreinforced masonry walls (conference paper); "
    "equation and figure numbers are its own"
)
LARGE = 10_000  # values; smaller variables are not worth compressing
COMPRESSED = {"zlib": True, "complevel": 1, "shuffle": True}
ATTRIBUTES = ("units", "long_name", "symbol")
ADVICE = "; delete it and run again"

Datasets = Mapping[str, xr.Dataset]  # by the name of their file


class DatasetError(ValueError):
    """A dataset that is not what the glossary says, or a file that cannot be read."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


def dataset_names() -> tuple[str, ...]:
    """Return the names of the datasets that the glossary knows."""
    return tuple(glossary.read()["datasets"])


def variables(kind: str) -> dict[str, dict[str, Any]]:
    """Return what the glossary says of each name that a kind of dataset has."""
    if kind not in dataset_names():
        raise DatasetError(f"dataset kind is {kind!r}; it must be one of {', '.join(dataset_names())}")
    return glossary.variables(kind)


def check(dataset: xr.Dataset, kind: str) -> dict[str, dict[str, Any]]:
    """Return the glossary's entries of a dataset, or raise `DatasetError` where it has other names than its kind."""
    expected = variables(kind)
    unknown = sorted(set(map(str, dataset.variables)) - set(expected))
    missing = sorted(
        name for name, entry in expected.items() if name not in dataset.variables and not entry.get("optional")
    )
    if unknown or missing:
        raise DatasetError(f"{kind}: not in the glossary: {unknown}; missing: {missing}")
    return expected


def require_attributes(dataset: xr.Dataset, path: str | os.PathLike[str], expected: Mapping[str, str]) -> None:
    """Raise `DatasetError` unless a dataset that was read has the expected attributes, such as its config's digest."""
    for name, value in expected.items():
        stated = dataset.attrs.get(name)
        if stated != value:
            advice = "delete it and run again"
            raise DatasetError(f"{os.fspath(path)} states {name} {stated}; that of this run is {value}; {advice}")


def write(
    dataset: xr.Dataset,
    path: str | os.PathLike[str],
    kind: str,
    *,
    config: Mapping[str, Any],
    code_version: str,
) -> None:
    """Write a dataset of a `kind` of the glossary as NetCDF-4 under CF-1.11, complete or not at all.

    `config` holds the values of the config that the dataset depends on, by dotted keys. A dataset that is not
    what the glossary says, or a file that cannot be written, raises `DatasetError`.
    """
    expected, of_kind = check(dataset, kind), glossary.read()["datasets"][kind]
    dataset = dataset.drop_encoding()  # of a file that it was read from, whose coordinates may be gone
    encoding: dict[str, dict[str, Any]] = {}
    for name in map(str, dataset.variables):
        entry, variable = expected[name], dataset[name]
        variable.attrs = {key: entry[key] for key in ATTRIBUTES if key in entry}
        encoding[name] = _encoding(variable, entry, is_coordinate=name in dataset.coords)
        if variable.size > LARGE and of_kind.get("compressed", True):
            encoding[name] |= COMPRESSED
    dataset.attrs = {
        **dataset.attrs,
        "title": of_kind["title"],
        "source": "rockdamp: numerical simulation",
        "references": PAPER,
        "Conventions": CONVENTIONS,
        "config": json.dumps(dict(config), ensure_ascii=False),
        "code_version": code_version,
    }
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            dataset.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=encoding)
    except (OSError, RuntimeError) as error:  # netCDF calls a full disk "HDF error", a RuntimeError
        reason = getattr(error, "strerror", None) or error
        allowed = "its folder must be writable and the disk not full"
        raise DatasetError(f"{os.fspath(path)} cannot be written ({reason}); {allowed}") from error


def _encoding(variable: xr.DataArray, entry: Mapping[str, Any], is_coordinate: bool) -> dict[str, Any]:
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


def open(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a result whole into memory; a file that is missing, truncated or no NetCDF raises `DatasetError`."""
    name = os.fspath(path)
    if not os.path.lexists(path):
        raise DatasetError(f"{name}: there is no such file")
    if not Path(path).is_file():  # to open a named pipe would be to wait for who writes to it
        raise DatasetError(f"{name} cannot be read as NetCDF (it is no regular file){ADVICE}")
    try:
        with xr.open_dataset(path, engine="netcdf4") as dataset:
            return dataset.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise DatasetError(f"{name} cannot be read as NetCDF ({error}){ADVICE}") from error
