"""Each argument of each public function refuses what a user may pass by mistake, in an `InputError` that names it."""

import inspect

import numpy as np
import pytest

import rockdamp as rd

CURVE, DAMPING, WALL = rd.TrilinearCurve(0.04, 0.85), rd.Damping("CDR", 0.05), rd.Wall(0.3, 4.5)
TIME = 0.01 * np.arange(100)
MOVING = np.clip(TIME - 0.2, 0.0, None)  # after a rest
RECORD = rd.Record(TIME, 3 * np.sin(2 * np.pi * MOVING), 0.01 * np.sin(MOVING), {"synthetic": "yes"})
BUILDING = rd.Building(0.25, 3, 3)
TEST = rd.FreeRocking([0.0, 0.5], displacement=[0.0, 0.1])
RUN = {"curve": CURVE, "damping": DAMPING, "step": 0.01, "steps": 20}
SHAPE = {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
CLOSED = {"curve": CURVE, "damping_model": "CDR", "restitution": 0.85, "release_amplitude": 0.5}

# Every public function with arguments for which it answers.
CALLS = {
    "Wall": (rd.Wall, {"thickness": 0.3, "height": 4.5}),
    "Parapet": (rd.Parapet, {"thickness": 0.3, "height": 2.0}),
    "OneSidedWall": (rd.OneSidedWall, {"mechanism": WALL}),
    "Wall.rigid_period": (WALL.rigid_period, {"release_amplitude": 0.5}),
    "Wall.rigid_force": (WALL.rigid_force, {"u": 0.1}),
    "Wall.rocking_onset": (WALL.rocking_onset, {"strength_ratio": 0.5}),
    "TrilinearCurve": (rd.TrilinearCurve, SHAPE),
    "TrilinearCurve.preset": (rd.TrilinearCurve.preset, {"name": "new"}),
    "TrilinearCurve.force": (CURVE.force, {"x": 0.3}),
    "TrilinearCurve.energy": (CURVE.energy, {"x": 0.3}),
    "TrilinearCurve.period": (CURVE.period, {"x0": 0.3}),
    "TrilinearCurve.amplitude": (CURVE.amplitude, {"energy": 0.1}),
    "Damping": (rd.Damping, {"model": "ECD", "damping_ratio": 0.05}),
    "Damping.cr": (rd.Damping.cr, {"restitution": 0.8}),
    "Damping.of_restitution": (rd.Damping.of_restitution, {"restitution": 0.8}),
    "Damping.coefficient": (DAMPING.coefficient, {"curve": CURVE, "x": 0.3}),
    "solve": (rd.solve, RUN),
    "Reference": (rd.Reference, {"displacement": np.zeros((2, 21)), "case": 0, "checkpoints": [20]}),
    "stable_step": (rd.stable_step, {"curve": CURVE}),
    "free_decay": (rd.free_decay, {"curve": CURVE, "damping": DAMPING, "length": 1.0, "points": 3}),
    "respond": (rd.respond, {"wall": WALL, "curve": CURVE, "damping": DAMPING, "record": RECORD}),
    "equivalent": (rd.equivalent, {"restitution": 0.85, **SHAPE, "response_length": 4.0}),
    "equivalent_dampings": (rd.equivalent_dampings, {"restitution": 0.85, "curve": CURVE, "response_length": 4.0}),
    "damping_ratio_energy": (rd.damping_ratio_energy, CLOSED),
    "equivalence_factor": (rd.equivalence_factor, {"curve": CURVE, "damping": DAMPING, "release_amplitude": 0.5}),
    "giannini_masiani": (rd.giannini_masiani, {"restitution": 0.85}),
    "Record": (rd.Record, {"elapsed": [0.0, 1.0], "ground_acceleration": [0.0, 1.0]}),
    "read_record": (rd.read_record, {"path": "data/none.csv"}),
    "write_record": (rd.write_record, {"path": "attacked.csv", "record": RECORD}),
    "intensity_measures": (rd.intensity_measures, {"record": RECORD}),
    "load_records": (rd.load_records, {"records": "none.csv"}),
    "fit_fragility": (rd.fit_fragility, {"intensity": [0.2, 0.4, 0.8], "collapses": [0, 3, 9], "runs": 10}),
    "assess": (rd.assess, {"wall": WALL, "curve": CURVE, "records": "none.csv", "pgv": 0.4}),
    "FreeRocking": (rd.FreeRocking, {"elapsed": [0.0, 1.0], "displacement": [0.0, 1.0]}),
    "read_free_rocking": (rd.read_free_rocking, {"path": "data/none.csv"}),
    "write_free_rocking": (rd.write_free_rocking, {"path": "attacked.csv", "test": TEST}),
    "calibrate_free_rocking": (rd.calibrate_free_rocking, {"tests": TEST, "wall": WALL}),
    "calibrate": (rd.calibrate, {"record": RECORD, "wall": WALL}),
    "Building": (rd.Building, {"period": 0.25, "storeys": 3, "storey": 3}),
    "Diaphragm": (rd.Diaphragm, {"period": 0.4}),
    "floor_motions": (rd.floor_motions, {"records": "none.csv", "building": BUILDING}),
}
# What functions return and raise: nobody calls these.
RETURNED = {
    "Response",
    "Histories",
    "Comparison",
    "ComparedHistories",
    "Peaks",
    "ComparedPeaks",
    "Equivalent",
    "IntensityMeasures",
}
RETURNED |= {"GroundMotion", "FloorMotion", "Fragility", "InputError", "InputWarning"}

# What a user may pass by mistake, by what an argument is. None is right where it is the default.
NUMBERS = [None, "0.3", "", True, 1j, np.nan, np.inf, [0.3, np.nan], [[1, 2], [3]], {}]
NUMBERS += [np.ma.masked_array([1.0], [True])]
WRONG = {
    **dict.fromkeys(("curve", "wall", "damping", "record", "reference"), [None, "x", 0.3, RUN, rd.Wall]),
    "mechanism": [None, "x", 0.3, RUN, rd.Wall],
    "building": ["x", 0.3, RUN, rd.Wall],
    **dict.fromkeys(("softening", "model", "damping_model", "scheme", "name"), [None, "", "CDRR", b"CDR", 3, ["CDR"]]),
    **dict.fromkeys(("steps", "substeps", "store_every", "threads", "points"), [None, 0.5, "2", True, [2], -1]),
    **dict.fromkeys(("test", "tests"), [None, "x", 0.3, RECORD, [RECORD], []]),
    "uncertain": ["x", 0.3, ["thickness"], {"x": 0.1}, {"thickness": "a"}, {"thickness": -1}],
    "path": [None, "", "a\0b", 3, ["a"]],
    **dict.fromkeys(("records", "base", "top"), [None, "", 3, [3], [None], {}]),
    "displacement": [None, "a", True, 1j],  # of a reference; finite or not is seen by the solver
    **dict.fromkeys(("case", "checkpoints"), [None, "a", 0.5, [1.5], 1e300]),
}
# Arguments of which any text or truth value is right, and those that a function passes on.
FREE = {"parapet", "peaks_only", "histories", "header", "digest", "unit_of_file", "parameters"}
# What an error calls an argument where it is not by its own name.
CALLED = {
    "name": "preset",
    "x0": "release_amplitude",
    "model": "damping_model",
    "path": "",
    **dict.fromkeys(("records", "base", "top"), "record"),
}


def arguments(name):
    """The arguments of a call by its own signature, with their defaults."""
    parameters = inspect.signature(CALLS[name][0]).parameters.values()
    return {each.name: each.default for each in parameters if each.kind not in (each.VAR_KEYWORD, each.VAR_POSITIONAL)}


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_argument_is_refused_by_its_name(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, right = CALLS[name]
    for argument, default in arguments(name).items():
        for wrong in () if argument in FREE else WRONG.get(argument if name != "Record" else "", NUMBERS):
            if wrong is None and default is None:
                continue
            with pytest.raises(rd.InputError) as caught:
                pytest.fail(f"{argument} = {wrong!r} gives {function(**{**right, argument: wrong})!r}")
            assert CALLED.get(argument, argument) in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_every_public_function_is_attacked():
    assert {name.partition(".")[0] for name in CALLS} == set(rd.__all__) - RETURNED


@pytest.mark.parametrize(
    ("name", "said"),
    [("fit_free_rocking", "did you mean .*calibrate_free_rocking"), ("simulate", r"dir\(rockdamp\) lists its names")],
)
def test_a_name_that_is_none_is_told_those_near_it(name, said):
    with pytest.raises(AttributeError, match=said):
        getattr(rd, name)
