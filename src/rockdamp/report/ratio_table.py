"""The part of the table of damping ratios that the page holds: walls of a3 = 1, and all of translated softening.

With translated softening a3 drops out of xi. That part needs no other nodes of a3, and is a fifth of the whole.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockdamp.equivalence import tabulated
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH

A3 = tabulated.AXES.index(3)  # among the refusals
NOT_1 = "1 with steeper softening, on this page; the command `rockdamp equivalent` has others"


def data(response_length: float) -> dict[str, Any] | None:
    """Return what the page's script reads, or None where the response is of another length than the table's."""
    if not np.isclose(response_length, DEFAULT_RESPONSE_LENGTH):
        return None
    tables = {model: tabulated.shipped(model) for model in tabulated.NODES}
    refusals = [f"{name} must be {allowed}" for name, allowed in tabulated.REFUSALS]
    refusals[A3] = f"{tabulated.REFUSALS[A3][0]} must be {NOT_1}"
    return {
        "models": {
            model: {
                "nodes": [*nodes[:3], nodes[4]],
                "units": _text(np.round(tables[model].log_ratio[:, :, :, -1] / tabulated.UNIT).astype("<i2")),
                "refused": _text(np.packbits(tables[model].refused[:, :, :, -1])),
            }
            for model, nodes in tabulated.NODES.items()
        },
        "unit": tabulated.UNIT,
        "rounding": tabulated.ROUNDING,
        "e": tabulated.RESTITUTION,
        "b1": tabulated.STRENGTH_RATIO,
        "least_a1": tabulated.LEAST_A1,
        "room": tabulated.ROOM,
        "release": [tabulated.LEAST_RELEASE, tabulated.BEYOND_A1, tabulated.LARGEST_RELEASE],
        "refusals": refusals,
    }


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(values.tobytes()).decode("ascii")
