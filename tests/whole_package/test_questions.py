"""What Python's users mistake: arguments by other names, walls, runs of `solve` and counts, each asked about."""

import inspect
import pickle
import warnings

import numpy as np
import pytest

import rockdamp as rd

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
WALL = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=1.0)
DAMPING = rd.Damping("ECD", 0.05, order=16)
DT, PARTS = 0.01, 20
ELAPSED = DT * np.arange(400)
MOTION = 6 * np.sin(2 * np.pi * ELAPSED / 0.9)  # m s-2


def told(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return [str(each.message) for each in caught if issubclass(each.category, rd.InputWarning)]


def run(**changed):
    usual = {
        "step": WALL.frequency_parameter * DT / PARTS,
        "steps": PARTS * (MOTION.size - 1),
        "load_factor": WALL.load_factor,
        "ground_acceleration": MOTION,
        "substeps": PARTS,
    }
    return lambda: rd.solve(CURVE, DAMPING, **(usual | changed))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: rd.Wall(thickness=0.3, height=3.0, overburden=12e3), r"'overburden': did you mean .*overburden_ratio"),
        (
            lambda: rd.Wall(t=0.3, h=3.0),
            r"Wall\(\) got .* 't': did you mean thickness\?; its arguments are thickness, ",
        ),
        (lambda: rd.Wall(0.3, 3.0, 0.7), r"3 positional arguments but 4 were given; its arguments are thickness, heig"),
        (lambda: rd.TrilinearCurve(a1=0.04, b1=0.85), "'a1': did you mean yield_displacement_ratio"),
        (lambda: rd.Damping.cr(e=0.85), "'e': did you mean restitution"),
        (lambda: rd.free_decay(CURVE, DAMPING, amplitude=0.5), "'amplitude': did you mean release_amplitude"),
        (lambda: rd.solve(CURVE, DAMPING), "missing .* its arguments are curve, damping, step, steps"),
    ],
)
def test_a_call_with_wrong_arguments_is_answered_by_the_near_one_and_all(call, message):
    with pytest.raises(TypeError, match=message):
        call()


def test_public_functions_keep_their_signature_and_are_found_by_pickle():
    assert list(inspect.signature(rd.Wall).parameters)[:2] == ["thickness", "height"]
    assert list(inspect.signature(rd.solve).parameters)[:2] == ["curve", "damping"]
    assert pickle.loads(pickle.dumps(rd.solve)) is rd.solve and rd.solve is rd.solve
    with pytest.raises(TypeError, match=r"^unsupported|^can only"):  # of what is called, as it is
        rd.TrilinearCurve(0.04, 0.85).map(lambda _: [] + 1)


@pytest.mark.parametrize(
    ("sizes", "question"),
    [
        (
            {"thickness": 0.3, "height": 1.5},
            "less than a storey has; was it half of it (3 m), or is the wall a parapet",
        ),
        ({"thickness": [0.3, 0.3], "height": [3.0, 1.5]}, "the height is 1.5 m"),
        ({"thickness": 1.0, "height": 3.0}, "is the thickness right, and not the wall's width?"),
        ({"thickness": 0.3, "height": 9.6}, "was it that of the building, or in feet (2.93 m)?"),
        ({"thickness": 0.3, "height": 3.0, "hinge_ratio": 0.3}, "tests found 0.5 to 0.7"),
        ({"thickness": 0.3, "height": 3.0, "eccentricity": 0.05}, "eccentricity is 0.05 m and has no effect"),
    ],
)
def test_a_wall_is_asked_about_where_it_is_made(sizes, question):
    (asked,) = told(lambda: rd.Wall(**sizes))
    assert question in asked


def test_usual_walls_parapets_and_runs_are_not_asked_about():
    assert told(run()) == told(lambda: rd.Parapet(thickness=0.25, height=1.0)) == []
    assert told(lambda: rd.Wall(thickness=0.8, height=7.0)) == []
    assert told(lambda: rd.fit_fragility([0.2, 0.4, 0.8], [1, 4, 30], 44)) == []


@pytest.mark.parametrize(
    ("changed", "question"),
    [
        ({"ground_acceleration": MOTION / 9.81}, "was ground_acceleration in g? it is in m s-2"),
        ({"ground_acceleration": 100 * MOTION}, "cm s-2 (6 m s-2)"),
        ({"load_factor": 0.0}, "load_factor is 0"),
        ({"step": DT / PARTS}, "a round number as of seconds"),
        ({"step": WALL.frequency_parameter * DT}, "step times substeps, between two samples, is"),
        ({"steps": MOTION.size - 1}, "ends the run early; for the whole record it is 7980"),
        ({"step": 0.2, "steps": 40, "ground_acceleration": (), "release_amplitude": 0.5}, "more than a fifth"),
        ({"ground_acceleration": (), "release_amplitude": 0.03}, "stays on its first branch"),
        ({"ground_acceleration": ()}, "nothing moves the wall"),
        (
            {"ground_acceleration": [MOTION, MOTION], "load_factor": [-0.1, -0.2], "release_amplitude": [0.1, 0.1]},
            "the 2 motions load each wall together",
        ),
    ],
)
@pytest.mark.parametrize("peaks_only", [False, True])
def test_a_run_of_solve_is_asked_about(changed, question, peaks_only):
    assert any(question in each for each in told(run(**changed, peaks_only=peaks_only)))


def test_other_slips_of_arguments_are_asked_about():
    (asked,) = told(lambda: rd.fit_fragility([0.2, 0.4, 0.8], [0.02, 0.1, 0.7], 44))
    assert "collapses is 0.02 of 44 runs, which is no whole number; was it a share (0.88 of them)?" in asked
    (asked,) = told(lambda: rd.fit_fragility([0.2, 0.4, 0.8], [43, 14, 1], 44))
    assert "were survivals counted?" in asked
    (asked,) = told(lambda: rd.fit_fragility([0.2, 0.4], [1, 1], 2))
    assert "collapses hardly depend on the intensity" in asked
    assert "were the two swapped?" in told(lambda: rd.damping_ratio_energy(CURVE, "CDR", 0.5, 0.85))[0]
    assert "was it a damping ratio" in told(lambda: rd.Damping.of_restitution(0.05))[0]
    assert "has no effect: the exponent is 0" in told(lambda: rd.Damping.cr(0.85, at=0.1))[0]
    assert "were a1 and b1 swapped?" in told(lambda: rd.TrilinearCurve(0.8, 0.1))[0]
    with pytest.raises(rd.InputError, match=r"parapet is Diaphragm\(.*; it must be a bool"):
        rd.floor_motions(rd.Record(ELAPSED, MOTION), None, rd.Diaphragm(0.4))


def test_respond_takes_the_motion_of_a_floor():
    (motion,) = rd.floor_motions(rd.Record(ELAPSED, MOTION), rd.Building(period=0.25, storeys=3, storey=3))
    peaks = [rd.respond(WALL, CURVE, DAMPING, each, histories=False).peak.item() for each in (motion, motion.record)]
    assert peaks[0] == peaks[1]
