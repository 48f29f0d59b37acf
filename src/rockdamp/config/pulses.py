"""What the pulses of a config, and the orders of the damper under them, must agree on."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rockdamp.config import Config
from rockdamp.config.schema import KeyPath, Problem, ascending, dotted


def pulse_problems(config: Config) -> Iterator[Problem]:
    """Frequencies, loads, e and bands ascend, and the step is stable."""
    yield from _pulse_grid_problems(config, ("pulses",), config["pulses"])
    for key in ("restitution", "bands"):
        yield from ascending(("pulses", key), config["pulses"][key])


def _pulse_grid_problems(config: Config, path: KeyPath, section: Config) -> Iterator[Problem]:
    """Frequencies and loads ascend, and the step is stable on the reference curve."""
    for key in ("frequency", "load"):
        start, stop = section[key]["start"], section[key]["stop"]
        if not start < stop:
            text = f"is {stop}; it must be greater than {dotted((*path, key, 'start'))}, {start}"
            yield Problem((*path, key, "stop"), text)
    curve = config["curve"]
    limit = 2 / math.sqrt(curve["plateau_ratio"] / curve["cracked_stiffness_ratio"])
    if not section["step"] < limit:
        text = f"is {section['step']}; it must be less than the stability limit 2 sqrt(a1/b1), {limit:.6g} for curve"
        yield Problem((*path, "step"), text)


def damper_order_problems(config: Config) -> Iterator[Problem]:
    """Orders, e and releases ascend, e stays within 0 and 1 where it is changed, and the pulses are runs."""
    section = config["damper_order"]
    for key in ("order", "restitution", "release_share"):
        yield from ascending(("damper_order", key), section[key])
    e = [*section["restitution"], config["validation"]["restitution"]]
    room = min(min(e), 1 - max(e))
    if not section["restitution_change"] < room:
        text = f"is {section['restitution_change']}; it must be less than {room:.6g}, so that e stays within 0 and 1"
        yield Problem(("damper_order", "restitution_change"), text)
    yield from _pulse_grid_problems(config, ("damper_order", "pulses"), section["pulses"])
