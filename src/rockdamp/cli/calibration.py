"""`calibrate`: curve and restitution from a measured record, or from free-rocking tests."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import (
    Command,
    Measured,
    OutputFile,
    Quantity,
    Uncertain,
    concerning,
    known,
    print_json,
    print_table,
    without_unknown,
    write_dataset,
    write_figure,
)
from rockdamp.cli.options import (
    SIZES,
    json_option,
    make_wall,
    refuse_unused,
    softening_options,
    wall_options,
)

if TYPE_CHECKING:
    import xarray as xr


# --- tests without ground motion -------------------------------------------------------------------------------------

FREE_ROCKING_EXAMPLE = (
    "rockdamp calibrate --free-rocking examples/my-free-rocking-1.csv examples/my-free-rocking-2.csv"
    " --thickness 250mm --height 3m --hinge-ratio 0.6 --plot free-rocking.png"
)
RELEASE = ("release_elapsed", "release_displacement", "sensor_zero", "sensor_drift")
HALF_CYCLE = ("half_cycle_release", "peak_elapsed", "peak_displacement", "half_period", "half_period_fitted")
IMPACT = ("impact_release", "impact_elapsed", "impact_amplitude", "impact_rocking", "impact_restitution")
SCALARS = (
    *("restitution_scatter", "loss_exponent", "restitution_rigid", "restitution_impulsive"),
    *("residual_rms", "rest_deviation", "log_likelihood_threshold"),
)
SHOWN = 12  # impacts that are printed


def or_free_rocking(command: Callable[..., None]) -> Callable[..., None]:
    """Give `calibrate` its tests without ground motion: a flag, the files, and the branch that takes them."""

    @click.option("--free-rocking", is_flag=True, help="Fit pull-and-release tests, FILES, in place of a record.")
    @click.option(
        "--least-peak", type=Quantity("m"), help="Smallest peak of FILES to use.  [default: ten times the noise]"
    )
    @click.argument("files", nargs=-1, type=click.Path(path_type=Path))
    @wraps(command)
    def either(free_rocking: bool, least_peak: float | None, files: tuple[Path, ...], **options: Any) -> None:
        if free_rocking:
            _calibrate(files, least_peak, options)
            return
        refuse_unused(("least_peak",), "--free-rocking")
        if files:
            raise click.UsageError(
                f"{str(files[0])!r} stands without an option; it must follow --record or --free-rocking"
            )
        if not options["records"]:
            raise click.UsageError(
                "there must be --record FILE, or --free-rocking FILE for a test without ground motion"
            )
        command(**options)

    return either


def _calibrate(files: tuple[Path, ...], least_peak: float | None, options: dict[str, Any]) -> None:
    from rockdamp.laboratory.free_rocking import fit_free_rocking
    from rockdamp.laboratory.releases import read_free_rocking

    if options["records"]:
        raise click.UsageError("--record belongs to a record with ground motion; --free-rocking must be without it")
    if not files:
        raise click.UsageError("--free-rocking must be followed by a file, or by several of one specimen")
    wall = make_wall(options)
    deviations = {name: getattr(options[name], "deviation", 0.0) for name in (*SIZES, "hinge_ratio")}
    tests = [read_free_rocking(path) for path in files]
    with concerning(", ".join(map(str, files))):
        fitted = fit_free_rocking(
            tests,
            wall,
            ultimate_displacement_ratio=options["a3"],
            softening=options["softening"],
            least_peak=least_peak,
            uncertain={name: deviation for name, deviation in deviations.items() if deviation},
        )
    if options["output"] is not None:
        digest = hashlib.sha256("".join(test.digest for test in tests).encode()).hexdigest()
        write_dataset(fitted, options["output"], "free_rocking", files=digest)
    if options["plot"] is not None:
        from rockdamp.figures.commands import free_rocking_figure

        write_figure(free_rocking_figure(fitted), options["plot"])
    print_json(content(fitted)) if options["as_json"] else _print(
        fitted, "Housner" if options["parapet"] else "Eq. (7)"
    )


def content(fitted: xr.Dataset) -> dict[str, Any]:
    """Return all of a fit but its histories, for JSON; null is not known or not determined."""
    rms, peak = float(fitted["residual_rms"]), float(abs(fitted["peak_displacement"]).max())
    impacts = zip(_rows_along(fitted, "impact", IMPACT), fitted["impact_restitution_interval"].T, strict=True)
    return {
        "parameters": [
            {
                "parameter": str(of_one["parameter"].item()),
                "estimate": float(of_one["estimate"]),
                "standard_error": float(of_one["standard_error"]),
                "interval_90": _numbers(of_one["interval"]),
                "true_value": known(of_one["true_value"]),
            }
            for of_one in (fitted.sel(parameter=name) for name in fitted["parameter"])
        ],
        **{name: known(fitted[name]) for name in SCALARS},
        "loss_exponent_interval_90": _numbers(fitted["loss_exponent_interval"]),
        "restitution_at": [
            {
                "amplitude": float(one["amplitude"]),
                "restitution": float(one["restitution_at_amplitude"]),
                "interval_90": _numbers(one["restitution_at_amplitude_interval"]),
            }
            for one in (fitted.sel(amplitude=at) for at in fitted["amplitude"])
        ],
        "residual_over_peak": rms / peak,
        "residual_over_rest": rms / float(fitted["rest_deviation"]) if known(fitted["rest_deviation"]) else None,
        "damping_models": models(fitted),
        "releases": _rows_along(fitted, "release", RELEASE),
        "half_cycles": _rows_along(fitted, "half_cycle", HALF_CYCLE),
        "impacts": [{**row, "interval_90": _numbers(interval)} for row, interval in impacts],
    }


def models(fitted: xr.Dataset) -> list[dict[str, Any]]:
    """Return how well each damper explains the losses, and whether the likeliest excludes it, with 90 % confidence."""
    least = float(fitted["log_likelihood_threshold"])
    return [
        {
            "damping_model": str(one["damping_model"].item()),
            "expected_exponent": float(one["expected_exponent"]),
            "log_likelihood": float(one["relative_log_likelihood"]),
            "excluded": bool(one["relative_log_likelihood"] < least),
        }
        for one in (fitted.isel(damping_model=index) for index in range(fitted.sizes["damping_model"]))
    ]


def _print(fitted: xr.Dataset, law: str) -> None:
    from rockdamp.laboratory.free_rocking import ASSESSED_AMPLITUDE

    told = content(fitted)
    rows = [{**row, "interval_90": _span(row["interval_90"])} for row in told["parameters"]]
    print_table(without_unknown(rows))
    e, analytical = told["parameters"][-1]["estimate"], told["restitution_rigid"]
    rocking, count = int(fitted["impact_rocking"].sum()), fitted.sizes["release"]
    handed_on = next(row["restitution"] for row in told["restitution_at"] if row["amplitude"] == ASSESSED_AMPLITUDE)
    over = "" if told["residual_over_rest"] is None else f", {told['residual_over_rest']:.3g} times the noise at rest"
    click.echo(
        f"\ne is {e / analytical:.3f} of the analytical {analytical:.4f} ({law}), by {rocking} impacts of {count}"
        f" {'release' if count == 1 else 'releases'}"
        f"\nfrom impact to impact e scatters by {told['restitution_scatter']:.2g} (standard deviation of ln e)"
        f"\nthe fit leaves {1000 * told['residual_rms']:.3g} mm (rms), {told['residual_over_peak']:.2g} of the"
        f" largest peak{over}"
        f"\ne of an impact depends on the peak before it: {_at_amplitudes(told)}"
        f"\nan assessment needs that at {ASSESSED_AMPLITUDE:g} u_ins: assess --restitution {handed_on:.3f}"
        f"\nthe loss per impact goes with the energy to the power -g, g = {told['loss_exponent']:.3f}"
        f" ({_span(told['loss_exponent_interval_90'])}); that of each damper on this curve:\n"
    )
    print_table([{**row, "excluded": "yes" if row["excluded"] else "no"} for row in told["damping_models"]])
    click.echo()
    shown = [row for row in told["impacts"] if row["impact_rocking"]]
    names = {"impact_elapsed": "elapsed", "impact_amplitude": "peak_before", "impact_restitution": "restitution"}
    impacts = [
        {new: row[old] for old, new in names.items()} | {"interval_90": _span(row["interval_90"])} for row in shown
    ]
    print_table(impacts[:SHOWN], {"elapsed": "s", "peak_before": "u/u_ins"})
    if len(impacts) > SHOWN:
        click.echo(f"and {len(impacts) - SHOWN} more impacts; --json prints all")


def _rows_along(fitted: xr.Dataset, dim: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    return [{name: known(fitted[name].isel({dim: index})) for name in names} for index in range(fitted.sizes[dim])]


def _at_amplitudes(told: dict[str, Any]) -> str:
    return ", ".join(
        f"{row['restitution']:.3f} ({_span(row['interval_90'])}) at {row['amplitude']:g} u_ins"
        for row in told["restitution_at"]
    )


def _numbers(values: xr.DataArray) -> list[float | None]:
    return [known(value) for value in values]


def _span(ends: list[float | None]) -> str:
    low, high = ("not determined" if end is None else f"{end:.5g}" for end in ends)
    return f"{low} to {high}"


# --- records ---------------------------------------------------------------------------------------------------------

UNCERTAIN = {"thickness": "m", "height": "m", "hinge_ratio": "", "overburden_ratio": ""}


def _with_uncertain_sizes(command: click.Command) -> click.Command:
    """Let sizes of the wall have a standard deviation."""
    for option in command.params:
        if option.name in UNCERTAIN:
            option.type = Uncertain(UNCERTAIN[option.name], words=getattr(option.type, "words", ()))
    return command


@_with_uncertain_sizes
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
@click.option(
    "--records",
    "--record",
    "records",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Record to fit: CSV of this project; repeatable, for several runs of one wall.",
)
@click.option("--compare", is_flag=True, help="Fit every damper, and say how well each explains the records.")
@wall_options()
@softening_options
@click.option("--output", type=OutputFile(".nc"), help="Write the result and both histories as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw measured against fitted.")
@json_option
def calibrate_command(
    records: tuple[Path, ...], compare: bool, output: Path | None, plot: Path | None, as_json: bool, **options: Any
) -> None:
    """Fit a1, b1 and e to measured records, or with --free-rocking to tests without ground motion, FILES.

    By least squares, with a standard error for each. A record must hold the ground acceleration and the measured
    displacement, with rest before the motion. The wall is taken as known; its thickness, height, hinge and overburden
    may have a standard deviation, as 110mm±2mm or 0.11+-0.002. A record is refused if the best fit leaves far more of
    it than noise. Of free-rocking tests (pull and release) each impact's e, and how the loss depends on the amplitude,
    are printed too; several tests of one specimen go into one estimate.
    """
    from rockdamp.laboratory import calibration, comparison
    from rockdamp.motions.record import read_record

    measured, deviations = [read_record(path) for path in records], _deviations(options)
    wall, curve = make_wall(options), {"ultimate_displacement_ratio": options["a3"], "softening": options["softening"]}
    with concerning(", ".join(map(str, records))):
        fitted = calibration.calibrate(measured, wall, **curve, uncertain=deviations)
        compared = comparison.compare_dampers(measured, wall, **curve) if compare else None
    if output is not None:
        read = {"records": [record.digest for record in measured], "deviations": deviations}
        write_dataset(fitted, output, "calibration", **read)
    if plot is not None:
        from rockdamp.figures.commands import calibration_figure

        write_figure(calibration_figure(fitted), plot)
    names = ("residual_rms", "residual_over_peak", "residual_over_noise")
    rows, misfit = _rows(fitted), {name: known(fitted[name]) for name in names}
    dampers = [] if compared is None else _damper_rows(compared)
    if as_json:
        print_json({"parameters": rows, **misfit} | ({"damping_models": dampers} if dampers else {}))
        return
    noise = misfit["residual_over_noise"]
    click.echo(
        f"the best fit leaves {1000 * fitted['residual_rms'].item():.3g} mm, "
        f"{100 * fitted['residual_over_peak'].item():.2g} % of the peak"
        + ("" if noise is None else f", {noise:.3g} times the sensor's noise at rest")
        + "\n"
    )
    print_table(without_unknown([{**row, "interval_90": _span(row["interval_90"])} for row in rows]))
    if dampers:
        click.echo()
        print_table(dampers, {"residual_rms": "m"})


def _deviations(options: dict[str, Any]) -> dict[str, float]:
    """Return the standard deviations of those sizes of the wall that have one."""
    measured = {name: options[name] for name in UNCERTAIN if isinstance(options[name], Measured)}
    return {name: value.deviation for name, value in measured.items() if value.deviation > 0}


def _rows(fitted: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each parameter, with the true value where it is known."""
    rows = [fitted.sel(parameter=name) for name in fitted["parameter"].values]
    return [
        {
            "parameter": str(row["parameter"].item()),
            **{key: known(row[key]) for key in ("estimate", "standard_error")},
            "interval_90": _numbers(row["interval"]),
            "true_value": known(row["true_value"]),
        }
        for row in rows
    ]


def _damper_rows(compared: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each damper: what its best fit leaves, its weight, and its a1, b1 and e."""
    rows = [compared.sel(damping_model=model) for model in compared["damping_model"].values]
    return [
        {
            "damping_model": str(row["damping_model"].item()),
            **{name: known(row[name]) for name in ("residual_rms", "residual_over_noise", "weight")},
            **{str(one["parameter"].item()): one.item() for one in row["estimate"]},
        }
        for row in rows
    ]
