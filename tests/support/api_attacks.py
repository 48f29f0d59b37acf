"""Attacks on the public Python functions: a wrong argument ends in an `InputError` that names it, or in an answer.

`attacks(seed)` yields them without end, at random; `outcome(attack)` says how one ended. A test runs
some, and a program may run as many as it likes. Run them in a folder of their own: they write files.
"""

from __future__ import annotations

import inspect
import random
import warnings
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

import rockdamp as rd
from rockdamp.config.settings import Solver

CURVE, DAMPING, WALL = rd.TrilinearCurve(0.04, 0.85), rd.Damping("CDR", 0.05), rd.Wall(0.3, 4.5)
TIME = 0.01 * np.arange(100)
RECORD = rd.Record(TIME, 3 * np.sin(2 * np.pi * TIME), 0.01 * np.sin(TIME), {"synthetic": "yes"})
STILL = np.zeros((2, 21))


class Hostile:
    """Raises whatever it is asked for."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("hostile")

    __array__ = __float__ = __index__ = __len__ = __iter__ = __bool__ = __fspath__ = __str__ = __repr__ = _refuse
    __eq__ = __lt__ = __add__ = __mul__ = _refuse
    __hash__ = None  # type: ignore[assignment]


class Unit(float):
    """A number with a unit, as other packages have."""

    unit = "mm"


OBJECTS: list[Any] = [object(), Hostile(), {}, {"a": 1}, {1, 2}, lambda: 1, rd.Wall, rd, WALL, CURVE, DAMPING, RECORD]
OBJECTS += [Solver("newmark", 0.01), datetime(2020, 1, 1, tzinfo=UTC), pd.Timestamp("2020-01-01"), xr.Dataset({"a": 1})]
NAMES: list[Any] = ["", "x", "0.3", "CDRR", "a\0b", "\ud800", "/", "café", b"CDR", "1" * 300]
NO_NUMBERS: list[Any] = [*OBJECTS, *NAMES, True, False, np.True_, 1j, np.complex64(1), [1, "a"], [[1, 2], [3]], [None]]
NO_NUMBERS += [np.array(["a"]), np.array([True]), np.array([None]), np.array([1j]), xr.DataArray([True], dims="x")]
NO_NUMBERS += [np.ma.masked_array([1.0], [True]), np.ma.masked, Unit(0.3), np.datetime64("2020"), np.timedelta64(1)]
NO_NUMBERS += [
    pd.Series(["a"]),
    pd.Series([pd.NA, 1]),
    np.zeros(2, dtype=[("a", float)]),
    iter([1]),
    Ellipsis,
    slice(1),
]
NOT_FINITE: list[Any] = [np.nan, np.inf, -np.inf, [np.nan], 10**400, -(10**400), np.float32("inf"), [1e308, np.inf]]
NUMBERS: list[Any] = [0, -0.0, -1, 0.3, 1, 2, 1e-3, 5e-324, 1e-308, 1e308, -1e308, 2**63, 1e19, Fraction(1, 3)]
NUMBERS += [np.float32(0.3), np.int8(1), [0.3], (0.3, 0.4), [[0.3], [0.4]], [], np.zeros((2, 0)), np.ones((1, 1, 1))]
NUMBERS += [np.array(0.3), range(3), pd.Series([0.3, 0.4]), np.arange(7.0)[::-2], np.ones(3, ">f8"), np.longdouble(0.3)]
NUMBERS += [xr.DataArray([0.3, 0.4], dims="x"), xr.DataArray(0.3), xr.DataArray([[0.3]], dims=("a", "b"))]
COUNTS: list[Any] = [0, -1, 1, 2, 3, 2**31, 2**63, 2**64, 10**30, np.int64(2), np.array(2)]
NO_COUNTS: list[Any] = [0.5, 2.0, np.nan, "2", True, [2], 1j, Fraction(2), *OBJECTS]

# By what an argument is: what it must refuse, and what it may refuse or take.
POOLS: dict[str, tuple[list[Any], list[Any]]] = {
    "numbers": ([None, *NO_NUMBERS, *NOT_FINITE], NUMBERS),
    "number": ([None, *NO_NUMBERS, *NOT_FINITE, [0.3, 0.4]], NUMBERS),
    "numbers or none": ([*NO_NUMBERS, *NOT_FINITE], [None, *NUMBERS]),
    "number or none": ([*NO_NUMBERS, *NOT_FINITE, [0.3, 0.4]], [None, *NUMBERS]),
    "number or rule": ([None, *OBJECTS, *NAMES, True, 1j, *NOT_FINITE], NUMBERS),
    "count": ([None, *NO_COUNTS], COUNTS),
    "count or none": (NO_COUNTS, [None, *COUNTS]),
    "name": ([None, *OBJECTS, *NAMES, 1, True, 0.5, ["CDR"], np.array(["CDR"])], []),
    "header": ([None, *[one for one in OBJECTS if one is not OBJECTS[2]], 1, 0.5, b"a", [1, 2]], [OBJECTS[2]]),
    "truth": ([], [True, False]),
    "wall": ([None, *[one for one in OBJECTS if one is not WALL], *NAMES, *NUMBERS], []),
    "wall or none": ([*[one for one in OBJECTS if one is not WALL], *NAMES, *NUMBERS], [None]),
    "curve": ([None, *[one for one in OBJECTS if one is not CURVE], *NAMES, *NUMBERS], []),
    "damping": ([None, *[one for one in OBJECTS if one is not DAMPING], *NAMES, *NUMBERS], []),
    "record": ([None, *[one for one in OBJECTS if one is not RECORD], *NAMES, *NUMBERS], []),
    "reference or none": ([*OBJECTS, *NAMES, *NUMBERS], [None]),
    "path": ([None, *OBJECTS, *NAMES, 1, 0.5, True], []),
    "paths": ([None, *OBJECTS, *NAMES, 1, 0.5, True, [1], [None]], [[]]),
}


class Call(NamedTuple):
    """A function of the package, arguments with which it answers, and what each of those is."""

    function: Callable[..., Any]
    given: dict[str, Any]
    kinds: dict[str, str]


class Attack(NamedTuple):
    """A call with some of its arguments replaced; whether it must be refused."""

    name: str
    function: Callable[..., Any]
    given: dict[str, Any]
    changed: tuple[str, ...]
    wrong: bool


def _sizes(**more: str) -> dict[str, str]:
    return (
        dict.fromkeys(("thickness", "height", "width", "density", "overburden_ratio", "eccentricity"), "numbers") | more
    )


SHAPE = {"cracked_stiffness_ratio": 0.04, "plateau_ratio": 0.85, "ultimate_ratio": 1.0, "softening": "steeper"}
SHAPE_KINDS = dict.fromkeys(SHAPE, "numbers") | {"softening": "name"}
RUN = {"curve": CURVE, "damping": DAMPING, "step": 0.01, "steps": 20}
RUN_KINDS = {"curve": "curve", "damping": "damping", "step": "numbers", "steps": "count"}

CALLS: dict[str, Call] = {
    "Wall": Call(rd.Wall, {"thickness": 0.3, "height": 4.5}, _sizes(hinge_ratio="numbers")),
    "Parapet": Call(rd.Parapet, {"thickness": 0.3, "height": 2.0}, _sizes()),
    "Wall.rigid_period": Call(WALL.rigid_period, {"release_amplitude": 0.5}, {"release_amplitude": "numbers"}),
    "Wall.rigid_force": Call(WALL.rigid_force, {"u": 0.1}, {"u": "numbers"}),
    "Wall.rocking_onset": Call(WALL.rocking_onset, {"plateau_ratio": 0.5}, {"plateau_ratio": "numbers"}),
    "TrilinearCurve": Call(rd.TrilinearCurve, SHAPE, SHAPE_KINDS),
    "TrilinearCurve.preset": Call(
        rd.TrilinearCurve.preset, {"name": "new"}, {"name": "name", "ultimate_ratio": "numbers", "softening": "name"}
    ),
    **{
        f"TrilinearCurve.{name}": Call(getattr(CURVE, name), {"x": 0.3}, {"x": "numbers"})
        for name in ("force", "tangent", "secant", "energy")
    },
    "TrilinearCurve.period": Call(CURVE.period, {"x0": 0.3}, {"x0": "numbers"}),
    "TrilinearCurve.amplitude": Call(CURVE.amplitude, {"energy": 0.1}, {"energy": "numbers"}),
    "Damping": Call(
        rd.Damping,
        {"model": "ECD", "damping_ratio": 0.05},
        {"model": "name", "damping_ratio": "numbers", "order": "numbers"},
    ),
    "Damping.cr": Call(rd.Damping.cr, {"restitution": 0.8}, {"restitution": "numbers"}),
    "Damping.power": Call(
        rd.Damping.power, {"exponent": 1.0, "damping_ratio": 0.1}, {"exponent": "numbers", "damping_ratio": "numbers"}
    ),
    "Damping.of_restitution": Call(
        rd.Damping.of_restitution, {"restitution": 0.8}, {"restitution": "numbers", "model": "name", "order": "numbers"}
    ),
    "Damping.from_values": Call(
        rd.Damping.from_values, {"model": "CDR", "damping_ratio": 0.1}, {"model": "name", "damping_ratio": "numbers"}
    ),
    "Damping.replace": Call(DAMPING.replace, {"damping_ratio": 0.1}, {"damping_ratio": "numbers"}),
    "Damping.coefficient": Call(
        DAMPING.coefficient, {"curve": CURVE, "x": 0.3}, {"curve": "curve", "x": "numbers", "v": "numbers"}
    ),
    "Damping.step": Call(DAMPING.step, {"scheme": "newmark"}, {"scheme": "name"}),
    "solve": Call(
        rd.solve,
        RUN,
        RUN_KINDS
        | dict.fromkeys(("release_amplitude", "release_velocity", "load_factor", "ground_acceleration"), "numbers")
        | {"substeps": "count", "store_every": "count or none", "threads": "count or none", "scheme": "name"}
        | {"reference": "reference or none"},
    ),
    "Reference": Call(
        rd.Reference,
        {"displacement": STILL, "case": 0, "checkpoints": [20]},
        {"displacement": "histories", "case": "wholes", "checkpoints": "wholes"},
    ),
    "solve against a reference": Call(
        lambda **given: rd.solve(**RUN, reference=rd.Reference(**given)),
        {"displacement": STILL, "case": 0, "checkpoints": [20]},
        {"displacement": "numbers", "case": "wholes", "checkpoints": "wholes"},
    ),
    "stable_step": Call(rd.stable_step, {"curve": CURVE}, {"curve": "curve"}),
    "free_decay": Call(
        rd.free_decay,
        {"curve": CURVE, "damping": DAMPING, "length": 1.0, "points": 3},
        {"curve": "curve", "damping": "damping", "wall": "wall or none", "release_amplitude": "numbers"}
        | {"length": "number or none", "points": "count", "step": "number or none"},
    ),
    "respond": Call(
        rd.respond,
        {"wall": WALL, "curve": CURVE, "damping": DAMPING, "record": RECORD},
        {"wall": "wall", "curve": "curve", "damping": "damping", "record": "record", "scale": "numbers"}
        | {"tail": "number", "step": "number or none", "histories": "truth"},
    ),
    "equivalent": Call(
        rd.equivalent,
        {"restitution": 0.85, **SHAPE, "release_amplitude": 0.5, "window": 4.0},
        dict.fromkeys(SHAPE, "number")
        | {"softening": "name", "restitution": "numbers", "release_amplitude": "number", "window": "number"},
    ),
    "equivalent_dampings": Call(
        rd.equivalent_dampings,
        {"restitution": 0.85, "curve": CURVE, "window": 4.0},
        {"restitution": "number", "curve": "curve", "release_amplitude": "number", "window": "number"},
    ),
    "damping_ratio_energy": Call(
        rd.damping_ratio_energy,
        {"curve": CURVE, "damping_model": "CDR", "restitution": 0.85, "release_amplitude": 0.5},
        {"curve": "curve", "damping_model": "name", "restitution": "numbers", "release_amplitude": "numbers"}
        | {"exponent": "numbers"},
    ),
    **{
        name: Call(
            function,
            {"curve": CURVE, "damping_model": "CDR", "restitution": 0.85, "release_amplitude": 0.5},
            {"curve": "curve", "damping_model": "name", "restitution": "numbers", "release_amplitude": "numbers"},
        )
        for name, function in (
            ("damping_ratio_table", rd.damping_ratio_table),
            ("table_refusal", rd.table_refusal),
        )
    },
    "equivalence_factor": Call(
        rd.equivalence_factor,
        {"curve": CURVE, "damping": DAMPING, "release_amplitude": 0.5},
        {"curve": "curve", "damping": "damping", "release_amplitude": "numbers"},
    ),
    "giannini_masiani": Call(rd.giannini_masiani, {"restitution": 0.85}, {"restitution": "numbers"}),
    "Record": Call(
        rd.Record,
        {"elapsed": [0.0, 1.0], "ground_acceleration": [0.0, 1.0]},
        {"elapsed": "numbers", "ground_acceleration": "numbers", "displacement": "numbers or none", "header": "header"},
    ),
    "read_record": Call(rd.read_record, {"path": "data/none.csv"}, {"path": "path"}),
    "write_record": Call(
        rd.write_record, {"path": "attacked.csv", "record": RECORD}, {"path": "target", "record": "record"}
    ),
    "intensity_measures": Call(rd.intensity_measures, {"record": RECORD}, {"record": "record"}),
    "spectral_acceleration": Call(
        rd.spectral_acceleration,
        {"record": RECORD, "period": 1.0},
        {"record": "record", "period": "numbers", "damping_ratio": "number"},
    ),
    "load_records": Call(rd.load_records, {"records": "none.csv"}, {"records": "paths"}),
    "fit_fragility": Call(
        rd.fit_fragility,
        {"intensity": [0.2, 0.4, 0.8], "collapses": [0, 3, 9], "runs": 10},
        {"intensity": "numbers", "collapses": "numbers", "runs": "numbers"},
    ),
    "assess": Call(
        rd.assess,
        {"wall": WALL, "curve": CURVE, "records": "none.csv", "pgv": 0.4},  # refused: its answers take seconds
        {"wall": "wall", "curve": "curve", "records": "paths", "pgv": "numbers", "pga": "numbers or none"}
        | {"restitution": "number or rule", "tail": "number", "step": "number"},
    ),
    "calibrate": Call(
        rd.calibrate,
        {"record": RECORD, "wall": WALL},  # refused: there is no rest before the motion
        {"record": "record", "wall": "wall", "ultimate_ratio": "number", "softening": "name", "step": "number"},
    ),
}
# What is returned, and what is raised: nobody calls these.
MADE_BY_OTHERS = {"Response", "Histories", "Comparison", "ComparedHistories", "Equivalent", "IntensityMeasures"}
MADE_BY_OTHERS |= {"GroundMotion", "Fragility", "InputError", "InputWarning", "__version__"}

# What an error calls an argument where it is not the argument's own name.
TOLD_AS = {
    ("TrilinearCurve.preset", "name"): "preset",
    ("TrilinearCurve.period", "x0"): "release_amplitude",
    ("Damping", "model"): "damping_model",
    ("Damping.from_values", "model"): "damping_model",
    ("Damping.of_restitution", "model"): "damping_model",
    ("load_records", "records"): "record",
    ("assess", "records"): "record",
    ("read_record", "path"): "",  # the file itself is named
    ("write_record", "path"): "",
}

POOLS["target"] = (
    [None, *OBJECTS, "", "a\0b", "\ud800", "/", b"CDR", "1" * 300, 1, 0.5, True],
    ["written.csv", "café.csv"],
)
POOLS["histories"] = ([None, *NO_NUMBERS], [*NUMBERS, *NOT_FINITE])  # finite or not is seen by the solver
POOLS["wholes"] = ([None, 0.5, [1.5], 1e300, *NO_NUMBERS, *NOT_FINITE], NUMBERS)


def attacks(seed: int) -> Iterator[Attack]:
    """Yield attacks at random, without end: one wrong argument mostly, two or three at times."""
    rng = random.Random(seed)
    names = sorted(CALLS)
    while True:
        name = rng.choice(names)
        call = CALLS[name]
        chosen = rng.sample(sorted(call.kinds), min(rng.choice((1, 1, 1, 2, 3)), len(call.kinds)))
        given, wrong = dict(call.given), False
        for argument in chosen:
            refused, other = POOLS[call.kinds[argument]]
            bad = bool(refused) and (not other or rng.random() < 0.6)
            given[argument] = rng.choice(refused if bad else other)
            wrong |= bad
        yield Attack(name, call.function, given, tuple(chosen), wrong)


def outcome(attack: Attack) -> str:
    """Return ``answer`` or ``refused``, or what went wrong in its place."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", RuntimeWarning)  # of numbers out of all scale: NumPy tells
        warnings.simplefilter("ignore", rd.InputWarning)
        try:
            attack.function(**attack.given)
        except rd.InputError as error:
            alone = attack.changed[0] if attack.wrong and len(attack.changed) == 1 else ""
            told = TOLD_AS.get((attack.name, alone), alone) in str(error)
            return "refused" if told else f"refused without naming {alone}: {error}"
        except Exception as error:
            return f"{type(error).__name__}: {error}"
    return "answer taken from what is none" if attack.wrong else "answer"


def parameters(name: str) -> set[str]:
    """Return the arguments of a call by its own signature, those by ``**`` left out."""
    given = inspect.signature(CALLS[name].function).parameters.values()
    return {each.name for each in given if each.kind not in (each.VAR_KEYWORD, each.VAR_POSITIONAL)}
