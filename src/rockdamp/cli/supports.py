"""What holds a wall, a building or a floor: options, checks, and what the commands do with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rockdamp.cli.command import NUMBER, Quantity, Whole, print_table
from rockdamp.cli.options import all_of, refuse_unused, with_default
from rockdamp.cli.warnings import warn
from rockdamp.constants import REFERENCE, STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.assessment.checks import Check
    from rockdamp.mechanics.floors import Building, Diaphragm
    from rockdamp.mechanics.wall import Parapet, Wall
    from rockdamp.motions.catalogue import GroundMotion

OPTIONS = ("storeys", "storey", "building_damping")
UNITS = {"PGA": "m s-2", "PGV": "m s-1"}


building_options = all_of(
    click.option(
        "--building-period",
        type=Quantity("s", several=True),
        help="Period of the building that the wall stands in, as 0.25s; of several the worst counts.",
    ),
    click.option("--storeys", type=Whole(1), help="Number of storeys of the building."),
    click.option("--storey", type=Whole(1), help="Storey of the wall, 1 for the lowest; a parapet is on top of it."),
    with_default("--building-damping", type=NUMBER, default="0.05", help="Damping ratio of the building."),
    click.option(
        "--diaphragm-period",
        type=Quantity("s"),
        help="Period of a flexible floor at the top of the wall, as of timber: 0.4s.",
    ),
    with_default("--diaphragm-damping", type=NUMBER, default="0.05", help="Damping ratio of that floor."),
)


def make_buildings(options: Mapping[str, Any]) -> list[Building]:
    """Return the building that the options describe, once for each period; none without a period."""
    periods = options["building_period"]
    if periods is None:
        refuse_unused(OPTIONS, "--building-period")
        return []
    for name in ("storeys", "storey"):
        if options[name] is None:
            raise click.UsageError(f"--{name} is missing; --building-period must have it")
    from rockdamp.mechanics.floors import Building

    return [Building(period, *(options[name] for name in OPTIONS)) for period in periods]


def make_diaphragm(options: Mapping[str, Any]) -> Diaphragm | None:
    """Return the flexible floor that the options describe; none without a period."""
    if options["diaphragm_period"] is None:
        refuse_unused(("diaphragm_damping",), "--diaphragm-period")
        return None
    from rockdamp.mechanics.floors import Diaphragm

    return Diaphragm(options["diaphragm_period"], options["diaphragm_damping"])


def ground_of(records: Sequence[str]) -> list[GroundMotion]:
    """Return the ground motions that are named."""
    from rockdamp.motions.catalogue import load_records

    return warn_of_motions(load_records(records))


def warn_of_motions(motions: list[GroundMotion]) -> list[GroundMotion]:
    """Warn of records that are unusual, and return them."""
    from rockdamp.motions.intensity import intensity_measures

    for motion in motions:
        measures = intensity_measures(motion.record)
        warn("PGA in g", measures.pga / STANDARD_GRAVITY, f"{motion.name}: ")
        warn("velocity at the end over PGV", abs(measures.end_velocity) / measures.pgv, f"{motion.name}: ")
    return motions


class Placed(NamedTuple):
    """The answer for a wall where it stands, of several periods the worst, and the motions of its supports there.

    `place` says where in words; `values` is what the JSON says of the building, with a row for each period.
    """

    answer: xr.Dataset
    motions: Sequence[GroundMotion]
    place: str = ""
    values: dict[str, Any] | None = None
    building: Building | None = None
    diaphragm: Diaphragm | None = None


def place(
    buildings: Sequence[Building],
    diaphragm: Diaphragm | None,
    ground: Sequence[GroundMotion],
    wall: Wall | Parapet,
    run: Callable[[Sequence[GroundMotion]], xr.Dataset],
) -> Placed:
    """Run a wall in each building, or on the ground where there is none, and return the worst answer."""
    from rockdamp.histories.supports import floor_motions
    from rockdamp.mechanics.wall import Parapet

    parapet = isinstance(wall, Parapet)
    plain = not buildings and diaphragm is None
    places: Sequence[Building | None] = buildings or [None]
    motions = [ground] if plain else [floor_motions(ground, each, parapet, diaphragm) for each in places]
    answers = [run(on_storey) for on_storey in motions]
    worst = max(range(len(answers)), key=lambda index: _severity(answers[index]))
    answer = answers[worst]
    building = buildings[worst] if buildings else None
    floor = "" if diaphragm is None else f"under a flexible floor of {diaphragm.period:g} s"
    if building is None:
        return Placed(answer, motions[worst], floor, diaphragm=diaphragm)
    top = "on top of " if parapet else ""
    words = f"{top}storey {building.storey} of {building.storeys} of a building of {building.period:g} s"
    values = {
        "period": building.period,
        "storeys": building.storeys,
        "storey": building.storey,
        "damping_ratio": building.damping_ratio,
        "periods": [_row(each, one) for each, one in zip(buildings, answers, strict=True)],
    }
    return Placed(answer, motions[worst], f"{words}{floor and ', '}{floor}", values, building, diaphragm)


def supports_of(
    motions: Sequence[GroundMotion], buildings: Sequence[Building], diaphragm: Diaphragm | None, parapet: bool
) -> list[GroundMotion]:
    """Return the motions of a wall's supports in each building; those of the ground where there is none."""
    from rockdamp.histories.supports import floor_motions

    if not buildings:
        return list(motions if diaphragm is None else floor_motions(motions, None, parapet, diaphragm))
    several = len(buildings) > 1
    return [
        replace(motion, name=f"{motion.name}, {building.period:g} s" if several else motion.name)
        for building in buildings
        for motion in floor_motions(motions, building, parapet, diaphragm)
    ]


def _severity(answer: xr.Dataset) -> tuple[int, float]:
    """Return what grows with how bad an answer is: collapses at the highest intensity, then a low median."""
    row = _row(None, answer)
    return row["collapses"], -row["median_intensity"] if row["median_intensity"] is not None else float("-inf")


def _row(building: Building | None, answer: xr.Dataset) -> dict[str, Any]:
    """Return the answer under restitution at the highest intensity, for one period."""
    cr = answer.sel(damping_model=REFERENCE).isel(intensity=-1)
    median = float(cr[f"median_{answer.attrs['intensity_measure'].lower()}"])
    return {
        "building_period": building.period if building else None,
        "collapses": int(cr["collapses"]),
        "collapse_probability": float(cr["collapse_probability"]),
        "median_intensity": median if isfinite(median) else None,
    }


# --- what is printed --------------------------------------------------------------------------------------------------


def check_values(check: Check) -> dict[str, Any]:
    """Return a check for JSON; infinite peaks are null."""
    values = {name: value if isfinite(value) else None for name, value in check._asdict().items()}
    return values | {"rocks": check.rocks}


def in_unit(measure: str, intensity: float) -> str:
    """Return an intensity with its unit: a PGA in g."""
    return f"{intensity / STANDARD_GRAVITY:.3g} g" if measure == "PGA" else f"{intensity:.3g} m s-1"


def counted_runs(answer: xr.Dataset) -> str:
    """Return what a share is of: "22 records", or "44 histories" against a stop, of CR alone and both ways."""
    from rockdamp.text import count_noun

    count = int(answer["records"])
    return f"{count} histories" if answer.sizes["damping_model"] == 1 else count_noun(count, "record")


def _too_few(answer: xr.Dataset) -> bool:
    """Return whether the stations are too few for a probability."""
    from rockdamp.assessment.assess import FEWEST_STATIONS

    return len(set(answer["station"].values.tolist())) < FEWEST_STATIONS


def print_checks(placed: Placed, checks: Sequence[Check]) -> None:
    """Print the answer in a sentence, the onset of rocking and the peaks, for each intensity."""
    from rockdamp.assessment.answers import IMPULSIVE

    answer = placed.answer
    measure = answer.attrs["intensity_measure"]
    if placed.values is not None and len(placed.values["periods"]) > 1:
        click.echo("\nby the period of the building, of which the worst counts:\n")
        print_table(placed.values["periods"], {"building_period": "s", "median_intensity": UNITS[measure]})
    cr = answer.sel(damping_model=REFERENCE)
    verb = "collapses" if int(answer["records"]) == 1 else "collapse"
    for index, check in enumerate(checks):
        where = f" of the ground, {placed.place}" if placed.place else ""
        at = f"at {in_unit(measure, check.intensity)}{where}"
        if _too_few(answer):
            count = int(cr["collapses"][index])
            click.echo(f"\n{count} of {counted_runs(answer)} {verb} the wall {at}: too few stations for a probability")
        else:
            share = f"{float(cr['collapse_probability'][index]):.0%}"
            other = f", {float(cr[IMPULSIVE][index]):.0%} with e by impulsive" if IMPULSIVE in cr else ""
            click.echo(f"\nprobability of collapse {at}: {share}{other}")
        if int(answer["records"]) == 1:  # of which a median says nothing: it exists only where the outcome alternates
            _print_weakest(answer, check.intensity)
        elif isfinite(check.margin):
            click.echo(f"  margin: the median {measure} of collapse is {check.margin:.3g} times this")
        shaken, onset = (value / STANDARD_GRAVITY for value in (check.support_acceleration, check.rocking_onset))
        verdict = check.rocking_in_words(int(answer["records"]))
        click.echo(f"  force: supports peak at {shaken:.3g} g (median), rocking starts at {onset:.3g} g: {verdict}")
        for name, peak in (("median", check.median_peak), ("84 %", check.upper_peak)):
            reached = f"{1000 * peak:.3g} mm" if isfinite(peak) else "collapse"
            click.echo(f"  displacement: {name} peak {reached}")


def _print_weakest(answer: xr.Dataset, intensity: float) -> None:
    """Print how weak the only record still collapses the wall, of the intensities that were tried."""
    measure = answer.attrs["intensity_measure"]
    collapsed = answer["stripe_collapses"].sel(damping_model=REFERENCE).values > 0
    tried = answer[f"stripe_{measure.lower()}"].values
    if collapsed.any():
        weakest = tried[collapsed].min()
        survived = int((~collapsed & (tried > weakest)).sum())
        click.echo(
            f"  margin: the weakest {measure} of {tried.size} tried that collapses it is"
            f" {weakest / intensity:.3g} times this; it survives {survived or 'none'} of the stronger ones;"
            f" respond --to-{measure.lower()} tries others"
        )
