"""`calibrate`: curve and restitution from measured records, or from free-rocking tests."""

from __future__ import annotations

from math import inf, isnan
from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp.cli import inputs as build
from rockdamp.cli import options, printing
from rockdamp.cli.command import command, examples
from rockdamp.cli.inputs import Inputs
from rockdamp.cli.options import LENGTH, NUMBER, MeasuredQuantity, option
from rockdamp.cli.printing import span
from rockdamp.text import count_noun

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.arrays import Array

IMPACTS_PRINTED = 12
# Tests that the model explains leave 1 to 2 times the noise at rest; wrong sizes left 7 times and
# more, over 1 % of the peak. A clean sensor may show less than 0.5 %, which is no wrong size.
MOST_RESIDUAL_OVER_REST = 5.0
LEAST_RESIDUAL_OVER_PEAK = 0.005
FREE_ROCKING_OPTIONS = ("frame_rate", "pixel", "least_peak")
PARAMETER_HEADS = {
    "parameter": "parameter",
    "estimate": "estimate",
    "standard_error": "standard error",
    "interval_90": "90 % interval",
    "true_value": "true value (synthetic)",
}
SYMBOLS = {"yield_displacement_ratio": "a1", "strength_ratio": "b1", "restitution": "e"}
DAMPER_HEADS = {
    "damping_model": "damper",
    "residual_over_noise": "residual/noise",
    "expected_exponent": "expected g",
    "relative_log_likelihood": "ln L minus the best",
    "log_likelihood": "ln L minus the best",
    "weight": "relative likelihood",
    **SYMBOLS,
    "excluded": "excluded",
}


@command(
    epilog=examples(
        "rockdamp calibrate --record data/sin-03-00-synthetic.csv --thickness 102mm±1mm \\",
        "    --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --output calibration.nc",
        "rockdamp calibrate --free-rocking examples/my-free-rocking-1.csv --thickness 250mm \\",
        "    --height 3m --hinge-ratio 0.6 --plot free-rocking.png",
    ),
)
@options.records_option(
    "File, pattern or folder, with measured displacements", required=False, section="Measured test"
)
@option(
    "--compare",
    is_flag=True,
    help="Also fit every damper, and print the residual of each.",
    section="Measured test",
)
@option(
    "--free-rocking",
    is_flag=True,
    help="Treat FILES as pull-and-release tests; alternative to --record.",
    section="Measured test",
)
@option(
    "--frame-rate",
    type=NUMBER,
    help="Frames per second, if FILES have frame numbers instead of times.",
    section="Measured test",
)
@option(
    "--pixel",
    type=LENGTH,
    help="Length of one pixel, or other unit, of FILES whose displacements are not in metres.",
    section="Measured test",
)
@option(
    "--least-peak",
    type=LENGTH,
    help="Ignore smaller peaks of FILES.  [default: ten times the noise]",
    section="Measured test",
)
@options.argument(
    "files",
    nargs=-1,
    type=options.INPUT_FILE,
    metavar="[FILES]...",
    section="Measured test",
    help="Free-rocking tests, with --free-rocking.",
)
@options.wall_options(MeasuredQuantity)
@options.softening_options
@options.output_option(".nc", help="Save the results and histories as NetCDF.")
@options.plot_option
@options.json_option
def calibrate(**inputs: Any) -> None:
    """Fit a1, b1 and e to measured records or free-rocking tests.

    The fit is by least squares, with a 90 % interval for each parameter. A record must contain the
    ground acceleration and the measured displacement, and begin with the wall at rest. With
    --free-rocking, FILES are tests without ground motion. Several tests of one wall give one
    estimate. Thickness, height, hinge and O/W may be given with a standard deviation, such as
    110mm±2mm or 0.11+-0.002.
    """
    free_rocking = inputs["free_rocking"]
    if free_rocking is not bool(inputs["files"]) or free_rocking is bool(inputs["records"]):
        raise click.UsageError("give either --record FILE, or --free-rocking FILE ...")
    if free_rocking and inputs["compare"]:
        raise click.UsageError(
            "--compare needs --record; it cannot be combined with --free-rocking"
        )
    if not free_rocking and any(inputs[name] is not None for name in FREE_ROCKING_OPTIONS):
        raise click.UsageError("--frame-rate, --pixel and --least-peak need --free-rocking")
    wall = build.build_wall(inputs)
    settings = {
        "ultimate_displacement_ratio": inputs["a3"],
        "softening": inputs["softening"],
        "uncertain": _deviations(inputs),
    }
    if free_rocking:
        description, values = _fit_free_rocking(inputs, wall, settings)
    else:
        description, values = _fit_records(inputs, wall, settings)
    if inputs["as_json"]:
        printing.print_json(values)
        return
    click.echo(description)
    click.echo(printing.describe_sizes(wall))
    _print_fit(values)
    if free_rocking:
        _print_losses(values)
    elif "damping_models" in values:
        caption = "Fit of every damper, each with its own curve:"
        _print_dampers(values["damping_models"], caption)


def _deviations(inputs: Inputs) -> dict[str, float]:
    """Return the standard deviations that sizes of the wall were given with."""
    deviations = {name: getattr(value, "deviation", 0.0) for name, value in inputs.items()}
    return {name: deviation for name, deviation in deviations.items() if deviation}


def _values(fitted: xr.Dataset) -> dict[str, Any]:
    """Return the parameters, and each single number."""
    numbers = {str(name): fitted[name].item() for name in fitted.data_vars if not fitted[name].dims}
    return {"parameters": _rows(fitted, "parameter"), **numbers}


def _rows(dataset: xr.Dataset, dim: str) -> list[dict[str, Any]]:
    """Return a row for each place along a dimension: its variables, and the interval of one."""
    keys = {}
    for name in sorted(map(str, dataset.variables), key=lambda name: name != dim):
        if dataset[name].dims == (dim,):
            keys[name] = name
        elif dataset[name].dims == ("bound", dim):
            keys["interval_90"] = name
    places = [dataset.isel({dim: index}) for index in range(dataset.sizes[dim])]
    return [{key: place[name].values.tolist() for key, name in keys.items()} for place in places]


def _print_fit(values: dict[str, Any]) -> None:
    """Print the parameters, and how far the best fit is from the measured motion."""
    rows = []
    for parameter in values["parameters"]:
        interval = span(parameter["interval_90"], 4)
        symbol = SYMBOLS[parameter["parameter"]]
        row = parameter | {"parameter": symbol, "interval_90": interval}
        rows.append({head: row[name] for name, head in PARAMETER_HEADS.items() if name in row})
    click.echo()
    printing.print_table(rows, "Best fit of the curve (a1, b1) and the restitution e:")
    misfit = (
        f"The best fit differs from the measured motion by {1000 * values['residual_rms']:.3g} mm"
        f" (rms), {100 * values['residual_over_peak']:.2g} % of the largest peak"
    )
    noise_name = "residual_over_rest" if "releases" in values else "residual_over_noise"
    noise_ratio = values[noise_name]
    if not isnan(noise_ratio):
        remark = "the file probably ends before the wall is at rest"
        build.warn("residual over the noise at rest", noise_ratio, 0.5, inf, remark)
        misfit += f", {noise_ratio:.3g} times the noise at rest"
    click.echo(f"{misfit}.")


def _print_dampers(dampers: list[dict[str, Any]], caption: str) -> None:
    """Print a row for each damper."""
    answers = {True: "yes", False: "no"}
    rows = []
    for damper in dampers:
        row = {head: damper[name] for name, head in DAMPER_HEADS.items() if name in damper}
        if "excluded" in row:
            row["excluded"] = answers[bool(row["excluded"])]
        rows.append(row)
    click.echo()
    printing.print_table(rows, caption)


# --- records -----------------------------------------------------------------------------------


def _fit_records(inputs: Inputs, wall: Any, settings: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return a description of the records, and the fitted values."""
    from rockdamp.laboratory.calibration import compare_dampers

    motions = rd.load_records(inputs["records"])
    records = [motion.record for motion in motions]
    fitted = rd.calibrate(records, wall, **settings)
    values = _values(fitted)
    if inputs["compare"]:
        curve = {name: value for name, value in settings.items() if name != "uncertain"}
        compared = compare_dampers(records, wall, **curve)
        estimates = compared["estimate"].to_dataset("parameter")
        dampers = compared.drop_vars("estimate").merge(estimates)
        values["damping_models"] = _rows(dampers, "damping_model")
    digests = printing.digests(motions)
    uncertain = settings["uncertain"]
    printing.write_dataset(fitted, "calibration", inputs, records=digests, uncertain=uncertain)
    if inputs["plot"] is not None:
        from rockdamp.figures.commands import calibration_figure

        printing.save_plot(calibration_figure(fitted), inputs["plot"])
    return printing.describe_records(motions), values


# --- tests without ground motion ---------------------------------------------------------------


def _fit_free_rocking(
    inputs: Inputs, wall: Any, settings: dict[str, Any]
) -> tuple[str, dict[str, Any]]:
    """Return a description of the tests, and the fitted values."""
    video = {name: inputs[name] for name in ("frame_rate", "pixel")}
    tests = [rd.read_free_rocking(path, **video) for path in inputs["files"]]
    lines = []
    for path, test in zip(inputs["files"], tests, strict=True):
        lines.append(f"{path.name}: {test.columns}; {_describe_times(test.elapsed)}")
    fitted = rd.fit_free_rocking(tests, wall, **settings, least_peak=inputs["least_peak"])
    digests = " ".join(test.digest for test in tests)
    uncertain = settings["uncertain"]
    printing.write_dataset(fitted, "free_rocking", inputs, files=digests, uncertain=uncertain)
    if inputs["plot"] is not None:
        from rockdamp.figures.commands import free_rocking_figure

        printing.save_plot(free_rocking_figure(fitted), inputs["plot"])
    return "\n".join(lines), _free_rocking_values(fitted)


def _free_rocking_values(fitted: xr.Dataset) -> dict[str, Any]:
    values = _values(fitted)
    largest_peak = float(abs(fitted["peak_displacement"]).max())
    values["loss_exponent_interval_90"] = fitted["loss_exponent_interval"].values
    values["residual_over_peak"] = values["residual_rms"] / largest_peak
    values["residual_over_rest"] = values["residual_rms"] / values["rest_deviation"]
    for dim in ("release", "half_cycle", "impact"):
        values[f"{dim}s"] = _rows(fitted, dim)
    by_amplitude = fitted.rename(restitution_at_amplitude="restitution")
    values["restitution_at"] = _rows(by_amplitude, "amplitude")
    dampers = _rows(fitted.rename(relative_log_likelihood="log_likelihood"), "damping_model")
    threshold = values["log_likelihood_threshold"]
    values["damping_models"] = [
        damper | {"excluded": damper["log_likelihood"] < threshold} for damper in dampers
    ]
    return values


def _describe_times(elapsed: Array) -> str:
    """Return samples, duration and gaps of a test: intervals of over 1.5 times the median."""
    intervals = elapsed[1:] - elapsed[:-1]
    usual = sorted(intervals)[intervals.size // 2]
    gaps = int((intervals > 1.5 * usual).sum())
    text = f"{elapsed.size} samples in {elapsed[-1] - elapsed[0]:.4g} s"
    if not gaps:
        return text
    place = int(intervals.argmax())
    longest = f"of {intervals[place]:.3g} s at t = {elapsed[place]:.4g} s"
    return f"{text}; {count_noun(gaps, 'gap')}, the longest {longest}"


def _reason_against(values: dict[str, Any]) -> str:
    """Return why e of a test must not be used; empty if it may."""
    over_rest = values["residual_over_rest"]
    is_visible = values["residual_over_peak"] > LEAST_RESIDUAL_OVER_PEAK
    if is_visible and over_rest > MOST_RESIDUAL_OVER_REST:
        return f"the residual is {over_rest:.2g} times the noise"
    if values["parameters"][-1]["interval_90"][1] >= 1:
        return "the interval of e extends beyond 1"
    return ""


def _print_losses(values: dict[str, Any]) -> None:
    """Print e by amplitude, the dampers that the test excludes, and e of the first impacts."""
    from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE

    rigid = values["restitution_rigid"]
    ratio = values["parameters"][-1]["estimate"] / rigid
    impacts = [impact for impact in values["impacts"] if impact["impact_rocking"]]
    click.echo(
        f"e is {ratio:.3f} times that of the rule rigid ({rigid:.3f}), from {len(impacts)} impacts"
        f" (scatter of ln e beyond the noise: {values['restitution_scatter']:.3f})."
    )
    by_amplitude = [
        {
            "peak before the impact [u_ins]": row["amplitude"],
            "e": f"{row['restitution']:.3f}",
            "90 % interval": span(row["interval_90"]),
        }
        for row in values["restitution_at"]
    ]
    click.echo()
    printing.print_table(by_amplitude, "Restitution by amplitude:")
    assessed = next(
        row for row in values["restitution_at"] if row["amplitude"] == REFERENCE_AMPLITUDE
    )
    reason = _reason_against(values)
    if reason:
        click.echo(
            f"The fit is poor ({reason}): do not use this e."
            " Check --thickness, --height, --parapet, --hinge-ratio and --pixel."
        )
    else:
        click.echo(
            f"For an assessment, use --restitution {assessed['restitution']:.3f}"
            f" (e at {REFERENCE_AMPLITUDE:g} u_ins)."
        )
    interval = span(values["loss_exponent_interval_90"], 2)
    click.echo(
        "The relative energy loss at an impact varies as (energy)^-g, with"
        f" g = {values['loss_exponent']:.2g} (90 % interval {interval})."
    )
    threshold = values["log_likelihood_threshold"]
    _print_dampers(
        values["damping_models"],
        "Fit of each damper: the exponent g that it predicts, and its log-likelihood relative to"
        f" the best damper (a damper below {threshold:.3g}, the limit of a 90 % interval of one"
        " parameter, is excluded):",
    )
    _print_impacts(impacts, len(values["releases"]))


def _print_impacts(impacts: list[dict[str, Any]], release_count: int) -> None:
    """Print e of the first impacts; of several releases, each impact with its release."""
    heads = {
        "impact_elapsed": "time [s]",
        "impact_amplitude": "peak before [u_ins]",
        "impact_restitution": "e",
    }
    caption = "Restitution of each impact:"
    if release_count > 1:
        heads = {"impact_release": "release"} | heads
        caption = "Restitution of each impact (releases in the order of FILES):"
    rows = []
    for impact in impacts[:IMPACTS_PRINTED]:
        row = {head: impact[name] for name, head in heads.items()}
        rows.append(row | {"90 % interval": span(impact["interval_90"])})
    click.echo()
    printing.print_table(rows, caption)
    if len(impacts) > IMPACTS_PRINTED:
        click.echo(f"and {len(impacts) - IMPACTS_PRINTED} more impacts; --json prints all")
