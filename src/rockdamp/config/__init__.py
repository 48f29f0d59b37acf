"""The values that the pipeline computes with: their model, the rules between them, and access by dotted keys.

The values stand in config/default.yaml. ``python -m rockdamp.config`` prints the JSON schema, which is
config/schema.json.
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
