"""`calibrate`: a curve and a damper from a measured record, by least squares or as a posterior."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import Command, concerning, print_json, print_table, write_dataset, write_figure
from rockdamp.cli.free_rocking import FREE_ROCKING_EXAMPLE, or_free_rocking
from rockdamp.cli.options import (
    json_option,
    make_wall,
    optional_record_option,
    refuse_unused,
    softening_options,
    wall_options,
    with_default,
)
from rockdamp.cli.types import OutputFile, Whole
from rockdamp.vocabulary import ANY_ORDER, CANDIDATES, REFERENCE

if TYPE_CHECKING:
    import xarray as xr


@click.command(
    "calibrate",
    cls=Command,
    examples=[
        "rockdamp calibrate --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m --hinge-ratio 0.57"
        " --overburden-ratio 6.2 --output calibration.nc --plot calibration.png",
        FREE_ROCKING_EXAMPLE,
    ],
)
@or_free_rocking
@optional_record_option
@wall_options()
@softening_options
@click.option("--posterior", is_flag=True, help="Sample the posterior, with the sensors' errors as unknowns.")
@click.option(
    "--damping-model",
    type=click.Choice(CANDIDATES),
    help=f"Damping model of --posterior; {ANY_ORDER!r} fits m too.  [default: {REFERENCE}]",
)
@click.option("--evidence", is_flag=True, help="Compare all damping models by --posterior.")
@click.option("--priors", type=click.Path(path_type=Path), help="YAML file with priors of --posterior.")
@with_default("--seed", type=Whole(0, 2**31), default=2017, help="Random seed of --posterior.")
@click.option("--output", type=OutputFile(".nc"), help="Write the result and both histories as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw measured against fitted.")
@json_option
def calibrate_command(
    record: Path, posterior: bool, output: Path | None, plot: Path | None, as_json: bool, **options: Any
) -> None:
    """Fit a1, b1 and e to a measured record, or with --free-rocking to tests without ground motion, FILES.

    By least squares, with a standard error for each; or as a posterior of these, or of xi, and of the damper's order m,
    with the sensors' zero, drift and noise as unknowns. A posterior is refused where it cannot be drawn from. The
    record must hold the ground acceleration and the measured displacement, with rest before the motion. The wall is
    taken as known. Of free-rocking tests (pull and release) each impact's e, and how the loss depends on the amplitude,
    are printed too; several tests of one specimen go into one estimate.
    """
    from rockdamp.identification import calibration, identify
    from rockdamp.motions.records import read_record

    wall = make_wall(options)
    known = {"ultimate_displacement_ratio": options["a3"], "softening": options["softening"]}
    if posterior:
        known |= _posterior_options(options)
    else:
        refuse_unused(("damping_model", "evidence", "priors", "seed"), "--posterior")
    measured = read_record(record)
    with concerning(record):
        fitted = (identify.posterior if posterior else calibration.calibrate)(measured, wall, **known)
    if output is not None:
        kind, module = ("posterior", "identify") if posterior else ("calibration", "calibration")
        write_dataset(fitted, output, kind, f"rockdamp.identification.{module}", record=measured.digest)
    if plot is not None:
        from rockdamp.figures.identification import posterior_figure
        from rockdamp.figures.single import calibration_figure

        write_figure((posterior_figure if posterior else calibration_figure)(fitted), plot)
    if posterior:
        _print_posterior(fitted, known["damping_model"], options["evidence"], as_json)
        return
    rows = [_row(fitted.sel(parameter=name)) for name in map(str, fitted["parameter"].values)]
    print_json(rows) if as_json else print_table(_without_unknown(rows))


def _posterior_options(options: dict[str, Any]) -> dict[str, Any]:
    from rockdamp.identification.prior import Prior
    from rockdamp.storage import yaml_file

    prior = Prior()
    if options["priors"] is not None:
        stated = yaml_file.read(options["priors"])
        with concerning(options["priors"]):
            prior = Prior.of(stated)
    compared = CANDIDATES if options["evidence"] else ()
    model = options["damping_model"] or REFERENCE
    return {"damping_model": model, "compared": compared, "prior": prior, "seed": options["seed"]}


def _print_posterior(fitted: xr.Dataset, damping_model: str, evidence: bool, as_json: bool) -> None:
    rows = [_posterior_row(fitted.sel(parameter=name)) for name in map(str, fitted["parameter"].values)]
    compared = [_evidence_row(fitted.sel(damping_model=name)) for name in CANDIDATES] if evidence else []
    if as_json:
        log_evidence = {row["damping_model"]: row["log_evidence"] for row in compared}
        print_json({"damping_model": damping_model, "parameters": rows, "evidence": log_evidence})
        return
    effective = f"{float(fitted['effective_draws']):.0f} effective draws"
    click.echo(f"{damping_model}; {float(fitted['share_inside']):.1%} of the record in its band of 90 %; {effective}\n")
    plain = [{**row, "interval_90": "{:.5g} to {:.5g}".format(*row["interval_90"])} for row in rows]
    print_table(_without_unknown(plain))
    if compared:
        click.echo()
        print_table(compared)


def _posterior_row(fitted: xr.Dataset) -> dict[str, Any]:
    return {
        "parameter": str(fitted["parameter"].item()),
        "mean": float(fitted["mean"]),
        "standard_deviation": float(fitted["standard_deviation"]),
        "interval_90": fitted["interval"].sel(level=0.9).values.tolist(),
        "true_value": _known(fitted["true_value"]),
    }


def _evidence_row(fitted: xr.Dataset) -> dict[str, Any]:
    """One model; without numbers where the evidence could not be determined."""
    known = math.isfinite(fitted["log_evidence"])
    names = ("log_evidence", "log_evidence_error", "probability")
    values = {name: float(fitted[name]) if known else None for name in names}
    return {"damping_model": str(fitted["damping_model"].item()), **values}


def _without_unknown(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Leave the true values out where none is known."""
    if any(row["true_value"] is not None for row in rows):
        return rows
    return [{key: value for key, value in row.items() if key != "true_value"} for row in rows]


def _known(value: xr.DataArray) -> float | None:
    return float(value) if math.isfinite(value) else None


def _row(fitted: xr.Dataset) -> dict[str, Any]:
    return {
        "parameter": str(fitted["parameter"].item()),
        "estimate": float(fitted["estimate"]),
        "standard_error": float(fitted["standard_error"]),
        "true_value": _known(fitted["true_value"]),
    }
