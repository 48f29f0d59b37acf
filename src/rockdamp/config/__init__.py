"""The values that the pipeline computes with: model, rules between keys, and access by keys.

The values stand in config/default.yaml. ``python -m rockdamp.config`` prints the JSON schema, which
is config/schema.json.
"""

from rockdamp.config.model import (
    Bootstrap,
    Comparison,
    Config,
    Earthquakes,
    GeometricGrid,
    Grid,
    LossLaw,
    Matching,
    NamedWall,
    Order,
    RigidWall,
    Solver,
    Supports,
)

__all__ = [
    "Bootstrap",
    "Comparison",
    "Config",
    "Earthquakes",
    "GeometricGrid",
    "Grid",
    "LossLaw",
    "Matching",
    "NamedWall",
    "Order",
    "RigidWall",
    "Solver",
    "Supports",
]
