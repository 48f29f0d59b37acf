"""Arguments of the public functions: objects keep copies of arrays, and bad values are refused by
name.
"""

import inspect
import re

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.errors import InputError

CURVE = rd.TrilinearCurve(0.04, 0.85)
WALL = rd.Wall(0.3, 4.5)
DAMPING = rd.Damping("CR", 0.85)
ELAPSED = 0.01 * np.arange(100)
RECORD = rd.Record(ELAPSED, np.sin(2 * np.pi * ELAPSED), 0.01 * np.sin(ELAPSED))
MOTION = rd.GroundMotion("sine", "sine", "own", RECORD)
LOAD = rd.Load(RECORD.ground_acceleration, WALL.load_factor, 0.03)
TEST = rd.FreeRocking(ELAPSED, 0.01 * np.cos(ELAPSED))

# Valid values of the parameters without a default, by function.
VALID = {
    rd.Wall: {"thickness": 0.3, "height": 4.5},
    rd.Parapet: {"thickness": 0.3, "height": 1.5},
    rd.OneSidedWall: {"mechanism": WALL},
    rd.TrilinearCurve: {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85},
    rd.TrilinearCurve.preset: {"name": "new"},
    rd.Damping: {"model": "BAND", "value": 0.05},
    rd.Damping.from_restitution: {"e": 0.85},
    rd.Load: {"ground": [0.0, 1.0, 0.0], "factor": -0.1, "sampling": 0.03},
    rd.Building: {"period": 0.3, "storeys": 3, "storey": 2},
    rd.Diaphragm: {"period": 0.3},
    rd.Record: {"elapsed": ELAPSED, "ground_acceleration": np.sin(ELAPSED)},
    rd.FreeRocking: {"elapsed": ELAPSED, "displacement": np.cos(ELAPSED)},
    rd.simulate: {"curve": CURVE, "damping": DAMPING, "step": 0.01, "steps": 10},
    rd.peaks: {"curve": CURVE, "damping": DAMPING, "step": 0.01, "steps": 10},
    rd.damping_coefficient: {"curve": CURVE, "damping": DAMPING, "x": 0.1},
    rd.stable_step: {"curve": CURVE},
    rd.exact_history: {"curve": CURVE, "damping": DAMPING, "times": [1.0, 2.0]},
    rd.free_decay: {"curve": CURVE, "damping": DAMPING},
    rd.respond: {"wall": WALL, "curve": CURVE, "damping": DAMPING, "record": RECORD},
    rd.equivalence_factor: {
        "curve": CURVE,
        "damping": rd.Damping("CDR", 1.0),
        "release_amplitude": 0.5,
    },
    rd.damping_ratio_energy: {
        "curve": CURVE,
        "damping_model": "CDR",
        "restitution": 0.85,
        "release_amplitude": 0.5,
    },
    rd.giannini_masiani: {"restitution": 0.85},
    rd.equivalent: {"restitution": 0.85, "curve": CURVE},
    rd.fit_fragility: {"intensity": [0.2, 0.4, 0.8], "collapses": [0, 3, 9], "runs": 10},
    rd.intensity_measures: {"record": RECORD},
    rd.load_records: {"records": "motion.csv", "step": 0.01, "unit": "g"},
    rd.floor_motions: {"records": RECORD, "building": rd.Building(0.3, 3, 2)},
    rd.assess: {"wall": WALL, "curve": CURVE, "records": [MOTION], "pgv": 0.4},
    rd.calibrate: {"records": RECORD, "wall": WALL},
    rd.fit_free_rocking: {"tests": TEST, "wall": WALL},
    rd.read_record: {"path": "motion.csv", "step": 0.01, "unit": "g"},
    rd.read_free_rocking: {"path": "test.csv"},
    rd.write_record: {"path": "motion.csv", "record": RECORD},
}
NAMES = {"e": "restitution", "value": "damping_ratio", "model": "damping_model", "name": "preset"}
# Returned by functions, or checked by the function that takes them.
UNCHECKED = {"Histories", "Peaks", "Fragility", "GroundMotion", "Reference", "InputError"}
BAD_VALUES = {
    "text": "text",
    "None": None,
    "empty": [],
    "ragged": [[0.1], [0.2, 0.3]],
    "masked": np.ma.masked_greater([0.1, 0.2], 0.15),
}
TEXTS = {"columns", "digest", "path"}  # may be any text; the system checks a path
FLAGS = {"parapet", "one_sided"}  # truth of any value


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "motion.csv").write_text("0.0\n1.0\n0.5\n")
    (tmp_path / "test.csv").write_text("0 0.1\n1 0.1\n2 0.05\n")


PARAMETERS = [
    pytest.param(function, parameter, id=f"{function.__qualname__}-{parameter.name}")
    for function in VALID
    for parameter in inspect.signature(function).parameters.values()
    if parameter.name not in TEXTS | FLAGS and parameter.kind != parameter.VAR_KEYWORD
]


@pytest.mark.parametrize(("function", "parameter"), PARAMETERS)
def test_bad_values_are_refused_by_name(function, parameter):
    name = NAMES.get(parameter.name, parameter.name)
    for label, value in BAD_VALUES.items():
        if value is None and parameter.default is None:
            continue
        try:
            function(**(VALID[function] | {parameter.name: value}))
        except (InputError, TypeError) as error:
            assert re.search(rf"\b{name}\b", str(error)), f"{label}: {error}"
        else:
            pytest.fail(f"{label} is not refused")


def test_sweep_has_every_public_function():
    swept = {function.__qualname__.split(".")[0] for function in VALID}
    assert swept | UNCHECKED == set(rd.__all__)


ARRAYS = [
    (rd.Wall, {"thickness": [0.3, 0.4], "height": [3.0, 4.0], "hinge_ratio": [0.6, 0.7]}),
    (rd.Parapet, {"thickness": [0.3, 0.4], "height": [3.0, 4.0], "eccentricity": [0.1, 0.0]}),
    (rd.TrilinearCurve, {"yield_displacement_ratio": [0.04, 0.05], "strength_ratio": [0.8, 0.9]}),
    (rd.Damping, {"model": "CR", "value": [0.8, 0.9], "loss_exponent": [0.1, 0.2]}),
    (rd.Load, {"ground": [[0.0, 1.0], [1.0, 0.0]], "factor": [0.1, 0.2], "sampling": [0.03]}),
    (
        rd.Record,
        {"elapsed": [0.0, 0.1], "ground_acceleration": [1.0, 2.0], "displacement": [0.0, 3.0]},
    ),
    (rd.FreeRocking, {"elapsed": [0.0, 0.1], "rotation": [0.2, 0.1]}),
]


@pytest.mark.parametrize(("kind", "arguments"), ARRAYS, ids=[kind.__name__ for kind, _ in ARRAYS])
def test_object_keeps_copies_of_arrays(kind, arguments):
    arrays = {name: np.array(value) for name, value in arguments.items() if name != "model"}
    instance = kind(**(arguments | arrays))
    for array in arrays.values():
        array += 1.0
    for name in arrays:
        np.testing.assert_array_equal(getattr(instance, name), arguments[name])


def test_record_keeps_a_copy_of_its_header():
    header = {"source": "here"}
    record = rd.Record([0.0, 0.1], [1.0, 2.0], header=header)
    header["source"] = "elsewhere"
    assert record.header == {"source": "here"}


@pytest.mark.parametrize(
    ("instance", "text"),
    [
        (CURVE, "TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)"),
        (DAMPING, "Damping(model='CR', value=0.85)"),
        (rd.Damping("BAND", [0.04, 0.05]), "Damping(model='BAND', value=[0.04, 0.05])"),
        (rd.Damping("ECD", 0.05, order=16), "Damping(model='ECD', value=0.05, order=16.0)"),
        (
            rd.Record(ELAPSED, ELAPSED, header={"synthetic": "yes"}),
            "Record(elapsed=<array of shape (100,)>, ground_acceleration=<array of shape (100,)>, "
            "header={'synthetic': 'yes'})",
        ),
    ],
    ids=["curve", "damping", "widths", "order", "record"],
)
def test_text_of_an_object_leaves_defaults_out(instance, text):
    assert repr(instance) == text
