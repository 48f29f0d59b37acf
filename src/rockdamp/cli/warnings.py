"""The six warnings that commands give: values that are possible and unusual."""

from __future__ import annotations

from math import inf
from typing import SupportsFloat

import click

# By what is told, in order: the least and the greatest value that are usual, and what lies beyond them.
USUAL = {
    "height over thickness": (0.0, 40.0, "tests of walls went to 28"),
    "damping_ratio": (0.0, 0.5, "the damper is near critical"),
    "restitution over that of rigid mechanics": (0.0, 1.1, "tests of walls and blocks gave 0.85 to 1.03"),
    "PGA in g": (0.005, 3.0, "records of earthquakes lie within"),
    "velocity at the end over PGV": (0.0, 0.1, "the ground still moves when the record ends"),
    "peak over a1": (1.0, inf, "the wall does not rock"),
}


def warn(name: str, value: SupportsFloat, where: str = "") -> None:
    """Print a line where a value is unusual."""
    least, most, remark = USUAL[name]
    if not least <= float(value) <= most:
        limit = f"less than {least:g}" if float(value) < least else f"more than {most:g}"
        click.echo(f"warning: {where}{name} is {float(value):.3g}, {limit}: {remark}", err=True)
