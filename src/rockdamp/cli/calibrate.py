"""`calibrate`: curve and restitution from measured records, or from free-rocking tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.common import (
    FILE,
    LENGTH,
    NUMBER,
    Quantity,
    describe_records,
    examples,
    json_option,
    known,
    make_wall,
    option,
    output_option,
    plot_option,
    print_json,
    print_table,
    softening_options,
    wall_options,
    write_dataset,
    write_figure,
)
from rockdamp.text import count_noun

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.arrays import Array

RELEASE = ("release_elapsed", "release_displacement", "sensor_zero", "sensor_drift")
HALF_CYCLE = ("half_cycle_release", "peak_elapsed", "peak_displacement", "half_period", "half_period_fitted")
IMPACT = ("impact_release", "impact_elapsed", "impact_amplitude", "impact_rocking", "impact_restitution")
SCALARS = (
    *("restitution_scatter", "loss_exponent", "restitution_rigid", "restitution_impulsive"),
    *("residual_rms", "rest_deviation", "log_likelihood_threshold"),
)
IMPACTS_PRINTED = 12


class Measured(float):
    """A number with its standard deviation, 0 where it is exact."""

    deviation: float = 0.0


class Uncertain(Quantity):
    """A quantity, exact or with its standard deviation, `110mm±2mm`, `0.11+-0.002`; or a word."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        number, _, deviation = value.replace("+-", "±").partition("±")
        measured = Measured(super().convert(number, param, ctx))
        measured.deviation = super().convert(deviation, param, ctx) if deviation else 0.0
        return measured


UNCERTAIN = {
    "thickness": Uncertain("m"),
    "height": Uncertain("m"),
    "hinge_ratio": Uncertain(words=("weakest",)),
    "overburden_ratio": Uncertain(),
}


@click.command(
    "calibrate",
    epilog=examples(
        "rockdamp calibrate --record data/sin-03-00-synthetic.csv --thickness 102mm±1mm \\",
        "    --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --output calibration.nc",
        "rockdamp calibrate --free-rocking examples/my-free-rocking-1.csv --thickness 250mm \\",
        "    --height 3m --hinge-ratio 0.6 --plot free-rocking.png",
    ),
)
@option("--records", "--record", "records", multiple=True, type=FILE, metavar="FILE", help="Record; repeatable.")
@option("--compare", is_flag=True, help="Fit every damper too, and say what each leaves of the records.")
@option("--free-rocking", is_flag=True, help="Fit FILES, pull-and-release tests, in place of records.")
@option("--frame-rate", type=NUMBER, help="Frames a second, where FILES have frame numbers in place of times.")
@option("--pixel", type=LENGTH, help="Size of a pixel, where FILES have pixels in place of metres.")
@option("--least-peak", type=LENGTH, help="Smallest peak of FILES to use.  [default: ten times the noise]")
@click.argument("files", nargs=-1, type=FILE)
@wall_options
@softening_options
@output_option(".nc", help="Write the result and the histories.")
@plot_option
@json_option
def calibrate_command(
    records: tuple[Path, ...],
    free_rocking: bool,
    files: tuple[Path, ...],
    compare: bool,
    least_peak: float | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Fit a1, b1 and e to measured records, or with --free-rocking to tests without ground motion, FILES.

    By least squares, with an interval of 90 % for each. A record must hold the ground acceleration and the measured
    displacement, with rest before the motion. Thickness, height, hinge and O/W may have a standard deviation, as
    110mm±2mm or 0.11+-0.002. Several records or FILES of one wall go into one estimate.
    """
    if free_rocking is not bool(files) or free_rocking is bool(records):
        raise click.UsageError("there must be either --record FILE, or --free-rocking FILE ...")
    video = [least_peak, given["frame_rate"], given["pixel"]]
    if (free_rocking and compare) or (video != [None] * 3 and not free_rocking):
        raise click.UsageError("--compare belongs to --record; --frame-rate, --pixel, --least-peak to --free-rocking")
    how: dict[str, Any] = {"ultimate_displacement_ratio": given["a3"], "softening": given["softening"]}
    deviations = {name: getattr(given[name], "deviation", 0.0) for name in UNCERTAIN}
    how["uncertain"] = {name: deviation for name, deviation in deviations.items() if deviation}
    if free_rocking:
        _fit_free_rocking(files, make_wall(given), {**how, "least_peak": least_peak}, as_json, given)
    else:
        _fit_records(records, make_wall(given), how, compare, as_json, given)


for parameter in calibrate_command.params:
    parameter.type = UNCERTAIN.get(parameter.name or "", parameter.type)


def _write(fitted: xr.Dataset, kind: str, digests: str, figure: str, given: dict[str, Any]) -> None:
    """Write the dataset and the picture that are asked for."""
    if given["output"] is not None:
        write_dataset(fitted, given["output"], kind, given, files=digests)
    if given["plot"] is not None:
        from rockdamp.figures import commands

        write_figure(getattr(commands, figure)(fitted), given["plot"])


def _parameters(fitted: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each parameter; the true value where a synthetic record states it."""
    return [
        {
            "parameter": str(one["parameter"].item()),
            **{name: known(one[name]) for name in ("estimate", "standard_error")},
            "interval_90": [known(bound) for bound in one["interval"]],
            "true_value": known(one["true_value"]),
        }
        for one in (fitted.sel(parameter=name) for name in fitted["parameter"])
    ]


def _print_parameters(rows: Sequence[dict[str, Any]]) -> None:
    print_table([{**row, "interval_90": _span(row["interval_90"])} for row in rows])


def _print_misfit(found: dict[str, Any], over_rest: str) -> None:
    rest = "" if found[over_rest] is None else f", {found[over_rest]:.3g} times the noise at rest"
    rms, share = 1000 * found["residual_rms"], 100 * found["residual_over_peak"]
    click.echo(f"\nthe best fit leaves {rms:.3g} mm (rms), {share:.2g} % of the largest peak{rest}")


def _span(ends: list[float | None]) -> str:
    low, high = ("not determined" if end is None else f"{end:.5g}" for end in ends)
    return f"{low} to {high}"


# --- records ----------------------------------------------------------------------------------------------------------


def _fit_records(
    paths: Sequence[Path], wall: Any, how: dict[str, Any], compare: bool, as_json: bool, given: dict[str, Any]
) -> None:
    from rockdamp.laboratory.calibration import calibrate
    from rockdamp.laboratory.comparison import compare_dampers
    from rockdamp.motions.catalogue import load_record

    motions = [load_record(str(path)) for path in paths]
    records = [motion.record for motion in motions]
    fitted = calibrate(records, wall, **how)
    _write(fitted, "calibration", " ".join(record.digest for record in records), "calibration_figure", given)
    left = {name: known(fitted[name]) for name in ("residual_rms", "residual_over_peak", "residual_over_noise")}
    found: dict[str, Any] = {"parameters": _parameters(fitted), **left}
    if compare:
        curve = {name: how[name] for name in ("ultimate_displacement_ratio", "softening")}
        compared = compare_dampers(records, wall, **curve)
        found["damping_models"] = [
            {
                "damping_model": str(one["damping_model"].item()),
                **{name: known(one[name]) for name in ("residual_rms", "residual_over_noise", "weight")},
                **{str(each["parameter"].item()): each.item() for each in one["estimate"]},
            }
            for one in (compared.sel(damping_model=model) for model in compared["damping_model"])
        ]
    if as_json:
        print_json(found)
        return
    click.echo(describe_records(motions))
    _print_parameters(found["parameters"])
    _print_misfit(found, "residual_over_noise")
    if compare:
        print_table(found["damping_models"])


# --- tests without ground motion --------------------------------------------------------------------------------------


def _fit_free_rocking(
    paths: Sequence[Path], wall: Any, how: dict[str, Any], as_json: bool, given: dict[str, Any]
) -> None:
    from rockdamp.laboratory.free_rocking import fit_free_rocking
    from rockdamp.laboratory.free_rocking_file import read_free_rocking

    tests = [read_free_rocking(path, frame_rate=given["frame_rate"], pixel=given["pixel"]) for path in paths]
    fitted = fit_free_rocking(tests, wall, **how)
    _write(fitted, "free_rocking", " ".join(test.digest for test in tests), "free_rocking_figure", given)
    found = content(fitted)
    if as_json:
        print_json(found)
        return
    for path, test in zip(paths, tests, strict=True):
        click.echo(f"{path.name}: {_describe(test.elapsed)}")
    _print_free_rocking(found)


def _describe(elapsed: Array) -> str:
    """Return what was read of a test, and its gaps: intervals of half a step more than the usual one."""
    intervals = elapsed[1:] - elapsed[:-1]
    gaps = intervals > 1.5 * sorted(intervals)[intervals.size // 2]
    size = f"{elapsed.size:,}".replace(",", " ")
    text = f"{size} samples in {elapsed[-1] - elapsed[0]:.4g} s"
    at = int(intervals.argmax())
    named = f"; {count_noun(int(gaps.sum()), 'gap')}, the longest {intervals[at]:.3g} s after {elapsed[at]:.4g} s"
    return text + named * bool(gaps.any())


def content(fitted: xr.Dataset) -> dict[str, Any]:
    """Return all of a fit but its histories, for JSON; null is not known or not determined."""
    rms, rest, least = (float(fitted[name]) for name in ("residual_rms", "rest_deviation", "log_likelihood_threshold"))
    impacts = zip(_rows_along(fitted, "impact", IMPACT), fitted["impact_restitution_interval"].T, strict=True)
    return {
        "parameters": _parameters(fitted),
        **{name: known(fitted[name]) for name in SCALARS},
        "loss_exponent_interval_90": [known(bound) for bound in fitted["loss_exponent_interval"]],
        "restitution_at": [
            {
                "amplitude": float(one["amplitude"]),
                "restitution": float(one["restitution_at_amplitude"]),
                "interval_90": [known(bound) for bound in one["restitution_at_amplitude_interval"]],
            }
            for one in (fitted.sel(amplitude=at) for at in fitted["amplitude"])
        ],
        "residual_over_peak": rms / float(abs(fitted["peak_displacement"]).max()),
        "residual_over_rest": rms / rest if rest == rest else None,
        "damping_models": [
            {
                "damping_model": str(one["damping_model"].item()),
                "expected_exponent": float(one["expected_exponent"]),
                "log_likelihood": float(one["relative_log_likelihood"]),
                "excluded": bool(one["relative_log_likelihood"] < least),
            }
            for one in (fitted.isel(damping_model=index) for index in range(fitted.sizes["damping_model"]))
        ],
        "releases": _rows_along(fitted, "release", RELEASE),
        "half_cycles": _rows_along(fitted, "half_cycle", HALF_CYCLE),
        "impacts": [{**row, "interval_90": [known(bound) for bound in interval]} for row, interval in impacts],
    }


def _rows_along(fitted: xr.Dataset, dim: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    return [{name: known(fitted[name].isel({dim: index})) for name in names} for index in range(fitted.sizes[dim])]


def _print_free_rocking(found: dict[str, Any]) -> None:
    """Print the parameters, e by amplitude, the dampers that the test excludes, and e of the first impacts."""
    from rockdamp.laboratory.free_rocking import ASSESSED_AMPLITUDE

    _print_parameters(found["parameters"])
    e, rigid = found["parameters"][-1]["estimate"], found["restitution_rigid"]
    at = {row["amplitude"]: row for row in found["restitution_at"]}
    spans = (f"{row['restitution']:.3f} ({_span(row['interval_90'])}) at {x:g} u_ins" for x, row in at.items())
    rocking = [row for row in found["impacts"] if row["impact_rocking"]]
    _print_misfit(found, "residual_over_rest")
    at_assessed, g = at[ASSESSED_AMPLITUDE]["restitution"], found["loss_exponent"]
    click.echo(
        f"e is {e / rigid:.3f} of that of rigid mechanics, {rigid:.4f}, by {len(rocking)} impacts; it scatters by"
        f" {found['restitution_scatter']:.2g} (standard deviation of ln e)"
        f"\ne by the peak before the impact: {', '.join(spans)}"
        f"\nto hand on: assess --restitution {at_assessed:.3f}, that at {ASSESSED_AMPLITUDE:g} u_ins"
        f"\nthe loss goes with the energy to the power -g, g = {g:.3f} ({_span(found['loss_exponent_interval_90'])});"
        f" that of each damper:\n"
    )
    print_table([{**row, "excluded": "yes" if row["excluded"] else "no"} for row in found["damping_models"]])
    click.echo()
    heads = {"impact_elapsed": "elapsed [s]", "impact_amplitude": "u/u_ins before", "impact_restitution": "e"}
    impacts = [
        {head: row[name] for name, head in heads.items()} | {"interval_90": _span(row["interval_90"])}
        for row in rocking
    ]
    print_table(impacts[:IMPACTS_PRINTED])
    if len(impacts) > IMPACTS_PRINTED:
        click.echo(f"and {len(impacts) - IMPACTS_PRINTED} more impacts; --json prints all")
