"""`calibrate`: a curve and a coefficient of restitution from a measured record."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import Command, concerning, print_json, print_table, write_dataset, write_figure
from rockdamp.cli.options import json_option, make_wall, record_option, softening_options, wall_options
from rockdamp.cli.types import OutputFile

if TYPE_CHECKING:
    import xarray as xr


@click.command(
    cls=Command,
    examples=[
        "rockdamp calibrate --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m --hinge-ratio 0.57"
        " --overburden-ratio 6.2 --output calibration.nc --plot calibration.png",
    ],
)
@record_option
@wall_options()
@softening_options
@click.option("--output", type=OutputFile(".nc"), help="Estimates, covariance and both histories, as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="A picture: measured against fitted.")
@json_option
def calibrate(
    record: Path, a3: float, softening: str, output: Path | None, plot: Path | None, as_json: bool, **options: Any
) -> None:
    """Fit a1, b1 and e to a measured record.

    By least squares, with a standard error for each. The record must hold the ground acceleration and the measured
    displacement, with rest before the motion. The wall is taken as known.
    """
    wall = make_wall(**options)
    from rockdamp.motions.records import read_record
    from rockdamp.studies.calibration import calibrate as compute

    measured = read_record(record)
    with concerning(record):
        fit = compute(measured, wall, ultimate_ratio=a3, softening=softening)
    if output is not None:
        write_dataset(fit, output, "calibration", "rockdamp.studies.calibration", record=measured.digest)
    if plot is not None:
        from rockdamp.figures.single import calibration_figure

        write_figure(calibration_figure(fit), plot)
    rows = [_row(fit.sel(parameter=name)) for name in map(str, fit["parameter"].values)]
    if as_json:
        print_json(rows)
        return
    if all(row["true_value"] is None for row in rows):
        rows = [{key: value for key, value in row.items() if key != "true_value"} for row in rows]
    print_table(rows)


def _row(fitted: xr.Dataset) -> dict[str, Any]:
    true = float(fitted["true_value"])
    return {
        "parameter": str(fitted["parameter"].item()),
        "estimate": float(fitted["estimate"]),
        "standard_error": float(fitted["standard_error"]),
        "true_value": None if math.isnan(true) else true,
    }
