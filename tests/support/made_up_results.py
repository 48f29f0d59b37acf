"""A folder with every result of the minimal config and their checksums, as if a build had made it."""

from pathlib import Path

import xarray as xr
from configs import configured

from rockdamp.motions import catalogue
from rockdamp.pipeline import verification


def minimal():
    """Return the origin of each result of the minimal config."""
    return verification.origins(configured(minimal=True), lambda entries: len(catalogue.listing(entries)))


def make(folder, expected):
    """Write each file, with its name or, in a dataset, its origin in it, and the checksums."""
    for file, origin in expected.items():
        path = Path(folder, file)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".nc":
            xr.Dataset(attrs=origin._asdict()).to_netcdf(path)
        else:
            path.write_text(file, encoding="utf-8")
    verification.write_checksums(folder, expected)
