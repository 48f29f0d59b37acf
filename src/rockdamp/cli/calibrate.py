"""`calibrate`: curve and restitution from measured records, or from free-rocking tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp.cli import common, options
from rockdamp.cli.options import LENGTH, NUMBER, MeasuredQuantity, option
from rockdamp.text import count_noun

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.arrays import Array

IMPACTS_PRINTED = 12


@click.command(
    epilog=common.examples(
        "rockdamp calibrate --record data/sin-03-00-synthetic.csv --thickness 102mm±1mm \\",
        "    --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --output calibration.nc",
        "rockdamp calibrate --free-rocking examples/my-free-rocking-1.csv --thickness 250mm \\",
        "    --height 3m --hinge-ratio 0.6 --plot free-rocking.png",
    ),
)
@options.records_option("File, pattern or folder, with measured displacements", required=False)
@option(
    "--compare", is_flag=True, help="Fit every damper too, and say what each leaves of the records."
)
@option(
    "--free-rocking", is_flag=True, help="Fit FILES, pull-and-release tests, in place of records."
)
@option(
    "--frame-rate",
    type=NUMBER,
    help="Frames a second, where FILES have frame numbers in place of times.",
)
@option(
    "--pixel",
    type=LENGTH,
    help="Size of a pixel, or of another unit, where FILES are not in metres.",
)
@option(
    "--least-peak",
    type=LENGTH,
    help="Smallest peak of FILES to use.  [default: ten times the noise]",
)
@click.argument("files", nargs=-1, type=options.FILE)
@options.wall_options(MeasuredQuantity)
@options.softening_options
@options.output_option(".nc", help="Write the result and the histories.")
@options.plot_option
@options.json_option
def calibrate(**inputs: Any) -> None:
    """Fit a1, b1 and e to records or free-rocking tests.

    By least squares, with an interval of 90 % for each. A record must hold the ground acceleration and the measured
    displacement, with rest before the motion. With --free-rocking FILES are tests without ground motion. Several of
    one wall go into one estimate. Thickness, height, hinge and O/W may have a standard deviation, as 110mm±2mm or
    0.11+-0.002.
    """
    free_rocking, video = inputs["free_rocking"], ("frame_rate", "pixel", "least_peak")
    if free_rocking is not bool(inputs["files"]) or free_rocking is bool(inputs["records"]):
        raise click.UsageError("there must be either --record FILE, or --free-rocking FILE ...")
    if (free_rocking and inputs["compare"]) or (
        not free_rocking and any(inputs[name] is not None for name in video)
    ):
        raise click.UsageError(
            "--compare belongs to --record; --frame-rate, --pixel, --least-peak to --free-rocking"
        )
    wall = common.build_wall(inputs)
    curve = {"ultimate_displacement_ratio": inputs["a3"], "softening": inputs["softening"]}
    deviations = {name: getattr(value, "deviation", 0.0) for name, value in inputs.items()}
    uncertain = {name: deviation for name, deviation in deviations.items() if deviation}
    fit = _fit_free_rocking if free_rocking else _fit_records
    files, found = fit(inputs, wall, **curve, uncertain=uncertain)
    if inputs["as_json"]:
        common.print_json(found)
    else:
        click.echo(files)
        _print(found)


def _values(fitted: xr.Dataset) -> dict[str, Any]:
    """Return the parameters, and each single number."""
    numbers = {str(name): fitted[name].item() for name in fitted.data_vars if not fitted[name].dims}
    return {"parameters": _rows(fitted, "parameter"), **numbers}


def _rows(dataset: xr.Dataset, dim: str) -> list[dict[str, Any]]:
    """Return a row for each place along a dimension: all variables along it, and the interval of one of them."""
    keys: dict[Any, str] = {(dim,): "", ("bound", dim): "interval_90"}
    along = {name: keys[each.dims] for name, each in dataset.variables.items() if each.dims in keys}
    names = {along[name] or str(name): name for name in sorted(along, key=lambda name: name != dim)}
    places = (dataset.isel({dim: index}) for index in range(dataset.sizes[dim]))
    return [{key: one[name].values.tolist() for key, name in names.items()} for one in places]


def _print(found: dict[str, Any]) -> None:
    common.print_table(
        [{**row, "interval_90": common.span(row["interval_90"], 5)} for row in found["parameters"]]
    )
    rest = found["residual_over_rest" if "releases" in found else "residual_over_noise"]
    click.echo(
        f"\nthe best fit leaves {1000 * found['residual_rms']:.3g} mm (rms),"
        f" {100 * found['residual_over_peak']:.2g} % of the largest peak"
        f"{f', {rest:.3g} times the noise at rest' if rest == rest else ''}"
    )
    if "releases" in found:
        _print_losses(found)
    elif "damping_models" in found:
        common.print_table(found["damping_models"])


# --- records ----------------------------------------------------------------------------------------------------------


def _fit_records(inputs: common.Inputs, wall: Any, **how: Any) -> tuple[str, dict[str, Any]]:
    """Return what was read, and what was found."""
    from rockdamp.laboratory.calibration import compare_dampers

    motions = rd.load_records(inputs["records"])
    records = [motion.record for motion in motions]
    fitted = rd.calibrate(records, wall, **how)
    found = _values(fitted)
    if inputs["compare"]:
        compared = compare_dampers(
            records, wall, **{name: how[name] for name in how if name != "uncertain"}
        )
        estimates = compared["estimate"].to_dataset("parameter")
        found["damping_models"] = _rows(
            compared.drop_vars("estimate").merge(estimates), "damping_model"
        )
    digests = common.digests(motions)
    common.write_outputs(
        fitted,
        "calibration",
        inputs,
        "calibration_figure",
        records=digests,
        uncertain=how["uncertain"],
    )
    return common.describe_records(motions), found


# --- tests without ground motion --------------------------------------------------------------------------------------


def _fit_free_rocking(inputs: common.Inputs, wall: Any, **how: Any) -> tuple[str, dict[str, Any]]:
    """Return what was read, and what was found."""
    video = {name: inputs[name] for name in ("frame_rate", "pixel")}
    tests = [rd.read_free_rocking(path, **video) for path in inputs["files"]]
    files = [
        f"{path.name}: {_describe(test.elapsed)}"
        for path, test in zip(inputs["files"], tests, strict=True)
    ]
    fitted = rd.fit_free_rocking(tests, wall, **how, least_peak=inputs["least_peak"])
    digests = " ".join(test.digest for test in tests)
    common.write_outputs(
        fitted,
        "free_rocking",
        inputs,
        "free_rocking_figure",
        files=digests,
        uncertain=how["uncertain"],
    )
    found = _values(fitted)
    found["loss_exponent_interval_90"] = fitted["loss_exponent_interval"].values
    found["residual_over_peak"] = found["residual_rms"] / float(
        abs(fitted["peak_displacement"]).max()
    )
    found["residual_over_rest"] = found["residual_rms"] / found["rest_deviation"]
    found |= {f"{dim}s": _rows(fitted, dim) for dim in ("release", "half_cycle", "impact")}
    found["restitution_at"] = _rows(
        fitted.rename(restitution_at_amplitude="restitution"), "amplitude"
    )
    dampers = _rows(fitted.rename(relative_log_likelihood="log_likelihood"), "damping_model")
    least = found["log_likelihood_threshold"]
    found["damping_models"] = [row | {"excluded": row["log_likelihood"] < least} for row in dampers]
    return "\n".join(files), found


def _describe(elapsed: Array) -> str:
    """Return what was read of a test, and its gaps: intervals of more than 1.5 of the usual one."""
    intervals = elapsed[1:] - elapsed[:-1]
    gaps = int((intervals > 1.5 * sorted(intervals)[intervals.size // 2]).sum())
    text, at = (
        f"{elapsed.size} samples in {elapsed[-1] - elapsed[0]:.4g} s",
        int(intervals.argmax()),
    )
    longest = (
        f"; {count_noun(gaps, 'gap')}, the longest {intervals[at]:.3g} s after {elapsed[at]:.4g} s"
    )
    return text + longest if gaps else text


def _print_losses(found: dict[str, Any]) -> None:
    """Print e by amplitude, the dampers that the test excludes, and e of the first impacts."""
    from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE

    e, rigid, g = (
        found["parameters"][-1]["estimate"],
        found["restitution_rigid"],
        found["loss_exponent"],
    )
    at = {row["amplitude"]: row for row in found["restitution_at"]}
    spans = [
        f"{row['restitution']:.3f} ({common.span(row['interval_90'], 5)}) at {x:g} u_ins"
        for x, row in at.items()
    ]
    rocking = [row for row in found["impacts"] if row["impact_rocking"]]
    click.echo(
        f"e is {e / rigid:.3f} of that of rigid mechanics, {rigid:.4f}, by {len(rocking)} impacts; it scatters by"
        f" {found['restitution_scatter']:.2g} (standard deviation of ln e)"
        f"\ne by the peak before the impact: {', '.join(spans)}"
        f"\nfor an assessment: --restitution {at[REFERENCE_AMPLITUDE]['restitution']:.3f}, that at"
        f" {REFERENCE_AMPLITUDE:g} u_ins"
        f"\nthe loss goes with the energy to the power -g, g = {g:.3f}"
        f" ({common.span(found['loss_exponent_interval_90'], 5)}); that of each damper:\n"
    )
    common.print_table(
        [{**row, "excluded": "yes" if row["excluded"] else "no"} for row in found["damping_models"]]
    )
    click.echo()
    heads = {
        "impact_elapsed": "elapsed [s]",
        "impact_amplitude": "u/u_ins before",
        "impact_restitution": "e",
    }
    impacts = [
        {head: row[name] for name, head in heads.items()}
        | {"interval_90": common.span(row["interval_90"], 5)}
        for row in rocking
    ]
    common.print_table(impacts[:IMPACTS_PRINTED])
    if len(impacts) > IMPACTS_PRINTED:
        click.echo(f"and {len(impacts) - IMPACTS_PRINTED} more impacts; --json prints all")
