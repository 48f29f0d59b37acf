"""rockdamp: energy dissipation in rocking masonry walls, and the bridge between its models.

Names are imported when they are first used, so that a part of the package costs only what it needs.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("rockdamp")

_HOME = {
    "Wall": "wall",
    "Parapet": "wall",
    "TrilinearCurve": "curve",
    "Damping": "damping",
    "solve": "newmark",
    "Reference": "newmark",
    "Response": "newmark",
    "free_decay": "history",
    "respond": "history",
    "equivalent": "single",
    "equivalent_dampings": "single",
    "damping_ratio_energy": "energy",
    "equivalence_factor": "energy",
    "giannini_masiani": "energy",
    "Record": "records",
    "read_record": "records",
    "calibrate": "calibration",
    "InputError": "errors",
}
__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"rockdamp.{_HOME[name]}"), name)
    raise AttributeError(f"module 'rockdamp' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
