"""The answer of `assess` as tables and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import print_table
from rockdamp.units import printed
from rockdamp.vocabulary import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.equivalence.programs import Typed
    from rockdamp.mechanics.wall import Parapet, Wall

SHARE = "collapse_probability"
INTERVAL = "collapse_probability_interval"  # the attribute that names the kind of interval


def values(
    answer: xr.Dataset, wall: Wall | Parapet, typed: list[Typed], frequencies: tuple[float, float]
) -> dict[str, Any]:
    """Return the JSON: numbers for one intensity, lists for several; in SI."""
    from rockdamp.assessment.answers import BY_INTENSITY, BY_RULE, models

    measure = answer.attrs["intensity_measure"]
    asked = answer[measure.lower()].values.tolist()

    def at(values: Any) -> Any:
        return values[0] if len(asked) == 1 else values

    return {
        "rocking_onset": float(answer["rocking_onset"]),
        **hinge(wall),
        "restitution": float(answer["restitution"]),
        "restitution_reason": answer.attrs["restitution_reason"],
        **_uncertainty(answer),
        "intensity_measure": measure,
        "intensity": at(asked),
        "interval": answer.attrs[INTERVAL],
        "tail": float(answer["tail"]),
        "models": [
            row | {name: at(row[name]) for name in (*BY_INTENSITY, *BY_RULE) if name in row} for row in models(answer)
        ],
        "initial_frequency": frequencies[0],
        "initial_period": frequencies[1],
        "damping": typed,
    }


def hinge(wall: Wall | Parapet) -> dict[str, float]:
    """Return the height of a wall's hinge over h, and the one at which it is weakest."""
    names = ("hinge_ratio", "weakest_hinge_ratio") if hasattr(wall, "hinge_ratio") else ()
    return {name: float(getattr(wall, name)) for name in names}


def _uncertainty(answer: xr.Dataset) -> dict[str, Any]:
    """Return how uncertain e is, where it is by the rule measured."""
    if "restitution_deviation" not in answer:
        return {}
    source = answer.attrs["restitution_range"]
    return {"restitution_deviation": float(answer["restitution_deviation"]), "restitution_range": source}


def show(answer: xr.Dataset, wall: Wall | Parapet, units: str) -> None:
    """Print the answer as tables: accelerations in g too, a reason for every dash, and what the step changes."""

    from rockdamp.assessment.answers import AVERAGED, IMPULSIVE, models
    from rockdamp.text import counted

    measure, rows = answer.attrs["intensity_measure"], models(answer)
    unit, size = printed(answer[measure.lower()].attrs["units"], units)
    onset_unit, onset_size = printed("m s-2", units)
    onset, records = float(answer["rocking_onset"]), int(answer["records"])
    stated = f"{onset / STANDARD_GRAVITY:.3g} g ({onset / onset_size:.3g} {onset_unit})"
    click.echo(f"rocking starts at {stated}, by the plateau's strength")
    if heights := hinge(wall):
        taken, weakest = heights.values()
        click.echo(f"hinge at {taken:.3g} of the height; between 0.5 and 0.7 the wall is weakest at {weakest:.3g}")
    if (ratio := float(getattr(wall, "overburden_ratio", 0.0))) > 0:
        load = float(wall.overburden / wall.width) / 1000
        click.echo(f"overburden {ratio:.3g} W = {load:.3g} kN/m")
    click.echo(f"restitution e = {float(answer['restitution']):.4g}: {answer.attrs['restitution_reason']}")
    if uncertain := _uncertainty(answer):
        deviation, source = uncertain.values()
        click.echo(f"e is uncertain by {deviation:.2g} (standard deviation): {source}")
    collapse = "collapses" if records == 1 else "collapse"
    interval = answer.attrs[INTERVAL]
    click.echo(f"share of {counted(records, 'record')} that {collapse} the wall ({interval}):\n")

    def level(name: str, value: float | None) -> dict[str, Any]:
        in_g = {f"{name} in g": None if value is None else value / STANDARD_GRAVITY} if measure == "PGA" else {}
        return {name: None if value is None else value / size, **in_g}

    # Rigid mechanics stands beside the tests where it is the worse.
    larger = any(
        worse > share for row in rows for worse, share in zip(row.get(IMPULSIVE, ()), row[SHARE], strict=False)
    )
    shares = [
        {
            **level(measure, intensity),
            "damping_model": row["damping_model"],
            "collapses": str(row["collapses"][index]),
            "share": row["collapse_probability"][index],
            "interval": _span(row[INTERVAL][index]),
            **({"averaged over e": row[AVERAGED][index]} if AVERAGED in row else {}),
            **({"impulsive": row[IMPULSIVE][index]} if larger else {}),
        }
        for index, intensity in enumerate(answer[measure.lower()].values.tolist())
        for row in rows
    ]
    print_table(shares, {measure: unit})
    if AVERAGED in rows[0]:
        from rockdamp.assessment.table import RULE_WEIGHTS

        rules = ", ".join(f"{rule} {weight:g}" for rule, weight in RULE_WEIGHTS.items())
        error = max(max(row["averaging_error"]) for row in rows)
        click.echo(f"\naveraged over e: about its rules ({rules}, a judgement); the integral errs by some {error:.1g}")
    if larger:
        e = float(answer["restitution_impulsive"])
        click.echo(f"impulsive: with e = {e:.4g} of rigid mechanics, which is worse here than the tests' e")
    click.echo("\nfragility, lognormal, with 95 % bootstrap intervals over stations; record-to-record scatter alone:\n")
    fragilities = [
        {
            "damping_model": row["damping_model"],
            "damping_ratio": row["damping_ratio"],
            **level(f"median {measure}", row["median_intensity"]),
            "interval": _span(row["median_intensity_interval"], size),
            "dispersion": row["dispersion"],
            " interval": _span(row["dispersion_interval"]),
        }
        for row in rows
    ]
    print_table(fragilities, {f"median {measure}": unit})
    click.echo()
    for row in rows:
        if row["reason"]:
            click.echo(f"-, {row['damping_model']}: {row['reason']}")
    click.echo("-, damping_ratio: restitution (CR) has none")
    click.echo(_halving(rows))


def _halving(rows: list[dict[str, Any]]) -> str:
    """Return the error that the solver's step leaves."""
    from rockdamp.text import counted

    changed = []
    for row in rows:
        text = f"{counted(int(row['unsettled']), 'outcome')} at the stripes"
        if row["median_uncertainty"] is not None:
            text += f", the median by {100 * row['median_uncertainty']:.2g} %"
            text += f" and the dispersion by {row['dispersion_uncertainty']:.2g}"
        changed.append(f"{row['damping_model']} {text}")
    return f"the last halving of the solver's step changed: {'; '.join(changed)}"


def show_damping(typed: list[Typed], frequencies: tuple[float, float], restitution: float, units: str = "si") -> None:
    """Print what to type into a program that has viscous damping."""
    from rockdamp.equivalence.programs import advice

    w1, period = frequencies
    unit, size = printed("N s m-1", units)
    click.echo(f"\nviscous damping for e = {restitution:.4g}; w1 = {w1:.4g} rad s-1, T1 = {period:.4g} s:\n")
    table = [
        {
            "damping_model": row["damping_model"],
            "xi": row["damping_ratio"],
            "C": row["damping_coefficient"] and row["damping_coefficient"] / size,
            "xi refers to": row["refers_to"],
        }
        for row in typed
    ]
    print_table(table, {"C": unit})
    click.echo("\n-: C is not constant, and the program must compute it from xi")
    click.echo(advice(restitution))


def _span(bounds: list[float] | None, size: float = 1.0) -> str | None:
    return None if bounds is None else f"{bounds[0] / size:.3g} to {bounds[1] / size:.3g}"
