"""rockdamp: energy dissipation in rocking masonry walls, and the bridge between its models.

Names are imported when they are first used, so that a part of the package costs only what it needs. Type checkers and
editors, which do not run this, read the same names in `__init__.pyi`.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

__version__ = version("rockdamp")

_HOME = {
    "Wall": "mechanics.wall",
    "Parapet": "mechanics.wall",
    "TrilinearCurve": "mechanics.curve",
    "Damping": "mechanics.damping",
    "solve": "solvers.newmark",
    "stable_step": "solvers.newmark",
    "Reference": "solvers.response",
    "Response": "solvers.response",
    "Histories": "solvers.response",
    "Comparison": "solvers.response",
    "ComparedHistories": "solvers.response",
    "free_decay": "histories.labelled",
    "respond": "histories.labelled",
    "equivalent": "equivalence.one_curve",
    "Equivalent": "equivalence.one_curve",
    "equivalent_dampings": "equivalence.one_curve",
    "damping_ratio_energy": "equivalence.closed_form",
    "damping_ratio_table": "equivalence.tabulated",
    "table_refusal": "equivalence.tabulated",
    "equivalence_factor": "equivalence.closed_form",
    "giannini_masiani": "equivalence.closed_form",
    "Record": "motions.records",
    "read_record": "motions.records",
    "write_record": "motions.records",
    "IntensityMeasures": "motions.intensity",
    "intensity_measures": "motions.intensity",
    "spectral_acceleration": "motions.intensity",
    "GroundMotion": "motions.catalogue",
    "load_records": "motions.catalogue",
    "Fragility": "statistics.fragility",
    "fit_fragility": "statistics.fragility",
    "assess": "assessment.one_wall",
    "calibrate": "identification.calibration",
    "InputError": "errors",
    "InputWarning": "errors",
}
__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"rockdamp.{_HOME[name]}"), name)
    raise AttributeError(f"module 'rockdamp' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
