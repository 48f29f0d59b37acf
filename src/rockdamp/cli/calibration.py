"""`calibrate`: a curve and a damper from a measured record, by least squares or as a posterior."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import (
    Command,
    Measured,
    OutputFile,
    Whole,
    concerning,
    known,
    print_json,
    print_table,
    quantity,
    uncertain,
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
    with_default,
)
from rockdamp.vocabulary import ANY_ORDER, CANDIDATES, REFERENCE

if TYPE_CHECKING:
    import xarray as xr


# --- tests without ground motion -------------------------------------------------------------------------------------

FREE_ROCKING_EXAMPLE = (
    "rockdamp calibrate --free-rocking examples/my-free-rocking-2.csv --thickness 250mm --height 3m"
    " --hinge-ratio 0.6 --plot free-rocking.png"
)
OF_RECORDS = ("record", "records", "posterior", "damping_model", "evidence", "loss_by_run", "priors", "seed")
RELEASE = ("release_elapsed", "release_displacement", "sensor_zero", "sensor_drift")
HALF_CYCLE = ("half_cycle_release", "peak_elapsed", "peak_displacement", "half_period", "half_period_fitted")
IMPACT = ("impact_release", "impact_elapsed", "impact_amplitude", "impact_rocking", "impact_restitution")
SCALARS = (
    *("restitution_scatter", "loss_exponent", "restitution_rigid", "restitution_impulsive"),
    *("residual_rms", "rest_deviation", "log_likelihood_threshold", "restitution_unlike_releases"),
)
SHOWN = 12  # impacts that are printed


def or_free_rocking(command: Callable[..., None]) -> Callable[..., None]:
    """Give `calibrate` its tests without ground motion: a flag, the files, and the branch that takes them."""

    @click.option("--free-rocking", is_flag=True, help="Fit pull-and-release tests, FILES, in place of a record.")
    @click.option(
        "--least-peak", type=quantity("m"), help="Smallest peak of FILES to use.  [default: ten times the noise]"
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
        if not any(options.get(name) for name in ("record", "records")):
            raise click.UsageError(
                "there must be --record FILE, or --free-rocking FILE for a test without ground motion"
            )
        command(**options)

    return either


def _calibrate(files: tuple[Path, ...], least_peak: float | None, options: dict[str, Any]) -> None:
    from rockdamp.cli.options import was_given
    from rockdamp.laboratory.free_rocking import calibrate_free_rocking
    from rockdamp.laboratory.releases import read_free_rocking

    for parameter in click.get_current_context().command.params:
        if parameter.name in OF_RECORDS and was_given(parameter.name):
            option = parameter.opts[0]
            raise click.UsageError(
                f"{option} belongs to a record with ground motion; --free-rocking must be without it"
            )
    if not files:
        raise click.UsageError("--free-rocking must be followed by a file, or by several of one specimen")
    wall = make_wall(options)
    deviations = {name: getattr(options[name], "deviation", 0.0) for name in (*SIZES, "hinge_ratio")}
    tests = [read_free_rocking(path) for path in files]
    with concerning(", ".join(map(str, files))):
        fitted = calibrate_free_rocking(
            tests,
            wall,
            ultimate_displacement_ratio=options["a3"],
            softening=options["softening"],
            least_peak=least_peak,
            uncertain={name: deviation for name, deviation in deviations.items() if deviation},
        )
    if options["output"] is not None:
        digest = hashlib.sha256("".join(test.digest for test in tests).encode()).hexdigest()
        module = "rockdamp.laboratory.free_rocking"
        write_dataset(fitted, options["output"], "free_rocking", module, files=digest)
    if options["plot"] is not None:
        from rockdamp.laboratory.figures import free_rocking_figure

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
    from rockdamp.laboratory.free_rocking import HANDED_ON

    told = content(fitted)
    rows = [{**row, "interval_90": _span(row["interval_90"])} for row in told["parameters"]]
    print_table(without_unknown(rows))
    e, analytical = told["parameters"][-1]["estimate"], told["restitution_rigid"]
    rocking, count = int(fitted["impact_rocking"].sum()), fitted.sizes["release"]
    handed_on = next(row["restitution"] for row in told["restitution_at"] if row["amplitude"] == HANDED_ON)
    over = "" if told["residual_over_rest"] is None else f", {told['residual_over_rest']:.3g} times the noise at rest"
    click.echo(
        f"\ne is {e / analytical:.3f} of the analytical {analytical:.4f} ({law}), by {rocking} impacts of {count}"
        f" {'release' if count == 1 else 'releases'}"
        f"\nfrom impact to impact e scatters by {told['restitution_scatter']:.2g} (standard deviation of ln e)"
        f"\nthe fit leaves {1000 * told['residual_rms']:.3g} mm (rms), {told['residual_over_peak']:.2g} of the"
        f" largest peak{over}"
        f"\ne of an impact depends on the peak before it: {_at_amplitudes(told)}"
        f"\nan assessment needs that at {HANDED_ON:g} u_ins: assess --restitution {handed_on:.3f}"
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
REACH = 6.0  # standard deviations that a prior of a size has on either side
MOST_CERTAIN = 0.99  # no probability is printed as 1 while the evidence of a model is missing


def _with_uncertain_sizes(command: click.Command) -> click.Command:
    """Let sizes of the wall have a standard deviation."""
    for option in command.params:
        if option.name in UNCERTAIN:
            option.type = uncertain(UNCERTAIN[option.name], *(["weakest"] if option.name == "hinge_ratio" else []))
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
    "--record",
    "records",
    type=click.Path(path_type=Path),
    multiple=True,
    metavar="FILE",
    help="Record to read: CSV of this project. Several, each with its own --record, are runs of one --posterior.",
)
@wall_options()
@softening_options
@click.option("--posterior", is_flag=True, help="Sample the posterior, with the sensors' errors as unknowns.")
@click.option(
    "--damping-model",
    type=click.Choice(CANDIDATES),
    help=f"Damping model of --posterior; {ANY_ORDER!r} fits m too.  [default: {REFERENCE}]",
)
@click.option("--evidence", is_flag=True, help="Compare all damping models by --posterior.")
@click.option("--loss-by-run", is_flag=True, help="Let e, or xi, differ between the records of --posterior.")
@click.option("--priors", type=click.Path(path_type=Path), help="YAML file with priors of --posterior.")
@with_default("--seed", type=Whole(0, 2**31), default=2017, help="Random seed of --posterior.")
@click.option("--output", type=OutputFile(".nc"), help="Write the result and both histories as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw measured against fitted.")
@json_option
def calibrate_command(
    records: tuple[Path, ...],
    posterior: bool,
    output: Path | None,
    plot: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Fit a1, b1 and e to a measured record, or with --free-rocking to tests without ground motion, FILES.

    By least squares, with a standard error for each; or as a posterior of these, or of xi, and of the damper's order m,
    with the sensors' zero, drift and noise as unknowns. A posterior is refused where it cannot be drawn from. The
    record must hold the ground acceleration and the measured displacement, with rest before the motion. The wall is
    taken as known; its thickness, height, hinge and overburden may have a standard deviation, as 110mm±2mm or
    0.11+-0.002. A record is refused if the best fit leaves far more of it than noise. Of free-rocking tests (pull and
    release) each impact's e, and how the loss depends on the amplitude, are printed too; several tests of one specimen
    go into one estimate.
    """
    from rockdamp.laboratory import calibration
    from rockdamp.laboratory import posterior as sampled
    from rockdamp.motions.records import read_record

    wall = make_wall(options)
    known = {"ultimate_displacement_ratio": options["a3"], "softening": options["softening"]}
    if posterior:
        known |= _posterior_options(options)
    else:
        refuse_unused(("damping_model", "evidence", "loss_by_run", "priors", "seed"), "--posterior")
        if len(records) > 1:
            raise click.UsageError("several --record must be given with --posterior; without it, give one")
        known["uncertain"] = _deviations(options)
    measured = [read_record(path) for path in records]
    with concerning(", ".join(map(str, records))):
        fitted = (
            sampled.posterior(measured, wall, **known)
            if posterior
            else calibration.calibrate(measured[0], wall, **known)
        )
    if output is not None:
        kind, module = ("posterior", "posterior") if posterior else ("calibration", "calibration")
        kind = "joint_posterior" if len(records) > 1 else kind
        read = {"records": [record.digest for record in measured], "deviations": _deviations(options)}
        write_dataset(fitted, output, kind, f"rockdamp.laboratory.{module}", **read)
    if plot is not None:
        from rockdamp.laboratory.figures import calibration_figure, posterior_figure

        write_figure((posterior_figure if posterior else calibration_figure)(fitted), plot)
    if posterior:
        _print_posterior(fitted, known["damping_model"], options["evidence"], as_json)
        return
    rows = _rows(fitted, "estimate", "standard_error")
    if as_json:
        print_json({"parameters": rows, **_misfit(fitted)})
        return
    click.echo(f"{_misfit_in_words(fitted)}\n")
    print_table(without_unknown(rows))


def _deviations(options: dict[str, Any]) -> dict[str, float]:
    """Return the standard deviations of those sizes of the wall that have one."""
    measured = {name: options[name] for name in UNCERTAIN if isinstance(options[name], Measured)}
    return {name: value.deviation for name, value in measured.items() if value.deviation > 0}


def _posterior_options(options: dict[str, Any]) -> dict[str, Any]:
    from dataclasses import replace

    from rockdamp.laboratory.candidates import Prior
    from rockdamp.statistics.distribution import Distribution
    from rockdamp.storage import yaml_file

    prior = Prior()
    if options["priors"] is not None:
        stated = yaml_file.read(options["priors"])
        with concerning(options["priors"]):
            prior = Prior.from_mapping(stated)
    sizes: dict[str, Any] = {}
    for name, deviation in _deviations(options).items():
        middle, reach = float(options[name]), REACH * deviation
        highest = 1 - REACH * 1e-6 if name == "hinge_ratio" else math.inf
        low, high = max(middle - reach, 1e-6), min(middle + reach, highest)
        sizes[name] = Distribution("normal", low, high, middle, deviation)
    return {
        "damping_model": options["damping_model"] or REFERENCE,
        "compared": CANDIDATES if options["evidence"] else (),
        "loss_by_run": options["loss_by_run"],
        "prior": replace(prior, **sizes),
        "seed": options["seed"],
    }


def _misfit(fitted: xr.Dataset) -> dict[str, Any]:
    """Return what the least squares leave: the root mean square [m], over the peak, over the noise at rest."""
    of_record = {name: fitted[name] for name in ("residual_rms", "residual_over_peak", "residual_over_noise")}
    return {name: list(map(known, of)) if of.ndim else known(of) for name, of in of_record.items()}


def _misfit_in_words(fitted: xr.Dataset) -> str:
    """Return the misfit of each record, in millimetres."""
    from rockdamp.laboratory.calibration import Misfit

    rows = [fitted.sel(run=run) for run in fitted["run"]] if "run" in fitted.dims else [fitted]
    misfits = [Misfit(*_misfit(row).values()) for row in rows]
    if len(misfits) == 1:
        return f"the best fit leaves {misfits[0]}"
    return "\n".join(f"record {run}: the best fit leaves {misfit}" for run, misfit in enumerate(misfits, start=1))


def _print_posterior(fitted: xr.Dataset, damping_model: str, evidence: bool, as_json: bool) -> None:
    rows = _rows(fitted, "mean", "standard_deviation")
    for row in rows:
        at_90 = fitted["interval"].sel(level=0.9, parameter=row["parameter"])
        row |= {"interval_90": at_90.values.tolist(), "true_value": row.pop("true_value")}
    compared = [_evidence_row(fitted.sel(damping_model=name)) for name in CANDIDATES] if evidence else []
    if as_json:
        log_evidence = {row["damping_model"]: row["log_evidence"] for row in compared}
        undetermined = {row["damping_model"]: row["reason"] for row in compared if row["reason"]}
        evidences = {"evidence": log_evidence, "undetermined": undetermined}
        print_json({"damping_model": damping_model, "parameters": rows, **_misfit(fitted), **evidences})
        return
    effective = f"{float(fitted['effective_draws']):.0f} effective draws"
    inside = float(fitted["share_inside"].mean())
    click.echo(f"{damping_model}; {inside:.1%} of the record in its band of 90 %; {effective}\n")
    click.echo(f"{_misfit_in_words(fitted)}\n")
    plain = [{**row, "interval_90": "{:.5g} to {:.5g}".format(*row["interval_90"])} for row in rows]
    print_table(without_unknown(plain))
    if compared:
        click.echo()
        print_table(_evidence_in_words(compared))


def _evidence_in_words(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Say which evidence is not determined and why; no model is certain while that of another is missing."""
    missing = any(row["reason"] for row in rows)
    shown = []
    for row in rows:
        probability = row["probability"]
        if row["reason"]:
            probability = f"not determined: {row['reason']}"
        elif missing:
            certain = probability > MOST_CERTAIN
            probability = f"{f'over {MOST_CERTAIN}' if certain else f'{probability:.2g}'}, among those determined"
        numbers = {name: row[name] for name in ("damping_model", "log_evidence", "log_evidence_error")}
        shown.append({**numbers, "probability": probability})
    return shown


def _evidence_row(fitted: xr.Dataset) -> dict[str, Any]:
    """One model; without numbers where the evidence could not be determined."""
    determined = math.isfinite(fitted["log_evidence"])
    names = ("log_evidence", "log_evidence_error", "probability")
    values = {name: float(fitted[name]) if determined else None for name in names}
    return {"damping_model": fitted["damping_model"].item(), **values, "reason": fitted["undetermined"].item()}


def _rows(fitted: xr.Dataset, *names: str) -> list[dict[str, Any]]:
    """Return a row for each parameter, with the true value where it is known."""
    return [
        {"parameter": str(name), **{key: known(fitted[key].sel(parameter=name)) for key in (*names, "true_value")}}
        for name in fitted["parameter"].values
    ]
