"""A wall, its curve, dampers and ground motions from options; warnings of unusual values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, SupportsFloat

import click

import rockdamp as rd
from rockdamp.constants import STANDARD_GRAVITY, VISCOUS_MODELS

Inputs = Mapping[str, Any]  # values of the options of a command, by their names


def warn(name: str, value: SupportsFloat, least: float, most: float, remark: str) -> None:
    """Print a line if a value is possible but unusual; `remark` says why."""
    number = float(value)
    if least <= number <= most:
        return
    limit = f"below {least:g}" if number < least else f"above {most:g}"
    click.echo(f"warning: {name} is {number:.3g}, {limit}: {remark}", err=True)


def warn_of_rest(peak: SupportsFloat, curve: rd.TrilinearCurve) -> None:
    """Warn of a wall that does not rock."""
    ratio = float(peak) / float(curve.yield_displacement_ratio)
    name = "largest peak divided by u1, where the plateau starts"
    warn(name, ratio, 1.0, inf, "the wall does not rock")


def build_wall(inputs: Inputs) -> Any:
    """Return the wall: a Wall, a Parapet, or one of them against a stop."""
    from rockdamp.assessment.description import make_wall

    wall: Any = make_wall(inputs)
    slenderness = getattr(wall, "mechanism", wall).slenderness
    warn("height/thickness", slenderness, 0.0, 40.0, "tested walls had at most 28")
    warn_of_small_load(wall, "O/W")
    return wall


def warn_of_small_load(wall: Any, name: str) -> None:
    """Warn of an overburden that is negligible, as one of 10 N/m in place of 10 kN/m."""
    body = getattr(wall, "mechanism", wall)
    if body.overburden_ratio > 0:
        load = float(body.overburden / body.width)
        remark = f"the overburden is {load:.3g} N/m; a number without a unit is in N/m"
        warn(name, body.overburden_ratio, 0.01, inf, remark)


def build_curve(inputs: Inputs) -> rd.TrilinearCurve:
    """Return the force-displacement curve."""
    from rockdamp.assessment.description import make_curve

    return make_curve(inputs)


def choose_restitution(wall: Any, restitution: float | str) -> tuple[float, str]:
    """Return e and its rule in words; warn of a number well above that of the rule rigid."""
    from rockdamp.assessment.restitution import find_restitution

    e, reason = find_restitution(wall, restitution)
    if isinstance(restitution, str):
        return e, f'rule "{restitution}": {reason}'
    if hasattr(wall, "restitution_rigid"):  # a wall against a stop has none
        ratio = e / wall.restitution_rigid
        remark = "tests of walls and blocks gave 0.85 to 1.03"
        warn("restitution divided by that of the rule rigid", ratio, 0.0, 1.1, remark)
    return e, reason


def build_dampings(
    inputs: Inputs, curve: rd.TrilinearCurve, e: float | None, **release: float
) -> list[rd.Damping]:
    """Return the damper that the options describe; with --compare, CR and several dampers.

    `release` is the release_amplitude of the decays that `equivalent` matches.
    """
    models = inputs["damping_model"] or [("CR", {})]
    xi = inputs["damping_ratio"]
    if inputs["compare"]:
        if e is None or xi is not None:
            raise click.UsageError("--compare needs --restitution and excludes --damping-ratio")
        return _compared_dampings(inputs["damping_model"], curve, e, **release)
    if len(models) > 1:
        raise click.UsageError("to compare several models of --damping-model, add --compare")
    model, parameters = models[0]
    if (e is None) is (xi is None) or (model == "CR" and xi is not None):
        viscous = f"--damping-ratio with --damping-model {'|'.join(VISCOUS_MODELS)}"
        raise click.UsageError(f"give either --restitution, or {viscous}")
    if e is not None:
        return [rd.Damping.from_restitution(e, model, **parameters)]
    warn("damping_ratio", xi, 0.0, 0.5, "the damper is near critical")
    return [rd.Damping(model, xi, **parameters)]


def _compared_dampings(
    models: Sequence[tuple[str, dict[str, float]]] | None,
    curve: rd.TrilinearCurve,
    e: float,
    **release: float,
) -> list[rd.Damping]:
    """Return CR and the viscous models, or some of them, with equivalent damping ratios."""
    names = [name for name, _ in models] if models else list(VISCOUS_MODELS)
    if models and any(parameters for _, parameters in models):
        raise click.UsageError("--compare takes models without a number, such as CDC,BAND")
    rows = rd.equivalent(e, curve, **release)
    dampers = [rd.Damping(row["damping_model"], row["damping_ratio"]) for row in rows]
    return [rd.Damping("CR", e), *(damper for damper in dampers if damper.model in names)]


def read_motions(inputs: Inputs) -> list[rd.GroundMotion]:
    """Return the ground motions of --records."""
    statements = {name: inputs[name] for name in ("step", "unit", "column")}
    motions = rd.load_records(inputs["records"], **statements)
    for motion in motions:
        measures = rd.intensity_measures(motion.record)
        pga = measures.pga / STANDARD_GRAVITY
        warn(f"{motion.name}: PGA in g", pga, 0.001, 5.0, "unusual for an earthquake")
        velocity_ratio = abs(measures.end_velocity) / measures.pgv
        remark = "the ground is still moving when the record ends:"
        remark += " correct the baseline before you trust the peak"
        warn(f"{motion.name}: velocity at the end divided by PGV", velocity_ratio, 0.0, 0.1, remark)
    return motions


def build_supports(inputs: Inputs) -> dict[str, Any]:
    """Return the building and the flexible floor that the options describe, for `floor_motions`."""
    building = [inputs[name] for name in ("building_period", "storeys", "storey")]
    supports: dict[str, Any] = {}
    if None not in building:
        supports["building"] = rd.Building(*building)
    elif any(value is not None for value in building):
        raise click.UsageError("--building-period, --storeys and --storey must be given together")
    if inputs["diaphragm_period"] is not None:
        supports["diaphragm"] = rd.Diaphragm(inputs["diaphragm_period"])
    return supports


def read_support_motions(inputs: Inputs) -> Sequence[rd.GroundMotion]:
    """Return the motions of the supports: of --records, or of a building and a floor under them."""
    supports = build_supports(inputs)
    if supports and inputs["one_sided"]:
        raise click.UsageError("--one-sided cannot be combined with a building or a flexible floor")
    motions = read_motions(inputs)
    if not supports:
        return motions
    return rd.floor_motions(motions, parapet=inputs["parapet"], **supports)
