"""ECD of order m against restitution: what is measured, by other methods too, and what it says."""

import numpy as np
import pytest
from configs import changed, configured
from experimental_style import WALL
from repository import ROOT

from rockdamp.equivalence.equivalent import equivalent
from rockdamp.histories.loads import Forcing
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import pulse
from rockdamp.motions.records import read_record
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies.damper_order import (
    Dampers,
    damper_order,
    measured,
    ratio_before_impact,
)
from rockdamp.vocabulary import PAPER_MODELS, VISCOUS_MODELS

CURVE = TrilinearCurve(0.04, 0.85)
CELLS = ("pulse", "pulse_frequency", "load_ratio")
EXACT = (0, 1, 2, 4, 8)  # orders at which the histories of the event-driven solver are looked at


@pytest.fixture(scope="module")
def config():
    """That of the small chain, but for the response length and the solver's step."""
    order = {"damper_order": {"restitution": [0.7, 0.85], "release_share": [0.3, 0.5, 0.9]}}
    small, full = configured(order, minimal=True), configured()
    return changed(small, {"matching.response_length": full.matching.response_length, "solver": full.solver})


@pytest.fixture(scope="module")
def found(config):
    return damper_order(config, read_record(ROOT / config.validation.record))


def test_the_dataset_is_what_the_glossary_says(found):
    dataset.check(found, "damper_order")
    assert found["case"].size == len(set(found["case"].values)) > 8


# --- free decay ------------------------------------------------------------------------------------------------------


def test_the_error_falls_with_every_order_on_every_curve_from_every_release_at_every_e(found):
    for name in ("rms_error", "curve_rms_error", "duration_error", "curve_duration_error"):
        assert (found[name].diff("order") < 0).all(), name
    assert (found["curve_rms_error"].isel(order=-1) < found["curve_rms_error"].isel(order=0) / 20).all()


def test_the_peaks_are_exact_at_every_order_but_for_the_step():
    e, response_length = np.array([0.85, 0.6]), 6.0
    dampers = Dampers(np.array([0, 4, 32]), e, 0.01)
    coarse, fine = (
        measured(CURVE, np.array([0.5, 0.3]), dampers, response_length=response_length, step=step, scheme="newmark")[
            "peak_error"
        ]
        for step in (0.004, 0.002)
    )
    assert np.all(fine[:3] < 2e-4) and np.all(fine[3:] > 0.01)
    assert np.median(coarse[:3] / fine[:3]) == pytest.approx(4, rel=0.2)


def test_the_measures_are_those_of_the_event_driven_solver():
    e, step, x0 = 0.8, 0.0025, 0.5
    tau = step * np.arange(1, 3201)
    dampers = Dampers(np.array(EXACT), np.array([e]), 0.01)
    by_steps = measured(CURVE, np.array([x0]), dampers, response_length=8.0, step=step, scheme="newmark")
    impact, *others = [
        event_driven.history(CURVE, damping, tau, release_amplitude=x0)
        for damping in (Damping.cr(e), *dampers.each(lambda damping: damping.map(np.squeeze)))
    ]
    for row, other in enumerate(others):
        rms = np.sqrt(np.mean((np.abs(other.displacement) - np.abs(impact.displacement)) ** 2))
        assert by_steps["rms_error"][row, 0] == pytest.approx(rms, abs=2e-5)
        most = min(other.turning_tau.size, impact.turning_tau.size)
        lasting, lasted = (np.diff(one.turning_tau[:most]) for one in (other, impact))
        largest = np.abs(np.append(lasting / lasted, other.turning_tau[0] / impact.turning_tau[0]) - 1).max()
        assert by_steps["duration_error"][row, 0] == pytest.approx(largest, rel=0.02, abs=2e-5)
        largest = np.abs(other.turning_displacement[:most] / impact.turning_displacement[:most] - 1).max()
        assert (
            largest < 1e-8 if row < len(EXACT) else by_steps["peak_error"][row, 0] == pytest.approx(largest, rel=1e-3)
        )


def test_the_fitted_dampers_are_the_published_ones(found):
    for row in equivalent(0.85, 0.04, 0.85):
        own = found.sel(damping_model=row["damping_model"], restitution=0.85)
        assert float(own["fitted_damping_ratio"]) == pytest.approx(row["damping_ratio"], rel=1e-3)
    assert list(found["damping_model"].values) == list(VISCOUS_MODELS)


def test_from_order_1_on_the_error_is_less_than_that_of_any_fitted_damper(found):
    fitted = found["fitted_rms_error"].sel(damping_model=[*PAPER_MODELS, "ECD"]).min("damping_model")
    assert (found["curve_rms_error"].sel(order=slice(1, None)) < fitted).all()
    # Order 0 is ECD: fitted it can only be better, by Err, than with its exact ratio.
    assert (found["fitted_rms_error"].sel(damping_model="ECD") <= found["curve_rms_error"].sel(order=0)).all()


def test_the_histories_are_decays_that_meet_at_their_first_peak(found):
    tau = found["tau"].values
    for m in found["order"].values:
        of_order = found.sel(order=m)
        damping = Damping.of_restitution(float(found["shown_restitution"]), order=m)
        exact = event_driven.history(CURVE, damping, tau, release_amplitude=0.5)
        np.testing.assert_allclose(of_order["shown_displacement"], exact.displacement, atol=5e-5)
        work = np.trapezoid(of_order["shown_damping_force"] * of_order["shown_velocity"], tau)
        energy = [0.5 * v**2 + CURVE.energy(x) for x, v in ((0.5, 0.0), (exact.displacement[-1], exact.velocity[-1]))]
        assert work == pytest.approx(float(energy[0] - energy[1]), rel=2e-3)


# --- a change of e ---------------------------------------------------------------------------------------------------


def test_the_lower_e_comes_first_and_loses_more(found):
    e = np.array([0.7, 0.85])
    lower, higher = Dampers(np.array([]), e, 0.01).each(lambda damping: damping.restitution)
    np.testing.assert_allclose([lower, higher], [e - 0.01, e + 0.01])
    assert found["variation"].values.tolist() == ["lower e", "higher e"]
    ratio = found["varied_pulse_ratio"].where(abs(found["varied_pulse_ratio"] - 1) > 1e-9)
    below = (ratio < 1).sum(CELLS) / ratio.count(CELLS)
    assert (below.sel(variation="lower e") > 0.5).all() and (below.sel(variation="higher e") < 0.5).all()


# --- under load ------------------------------------------------------------------------------------------------------


def test_before_the_first_impact_restitution_plays_no_part(found):
    before = found["varied_pulse_ratio_before_impact"]
    assert int(before.count()) > 20 and (before.fillna(1.0) == 1.0).all()
    assert (found["varied_pulse_before_impact_log_error"] == 0).all()
    assert (abs(found["pulse_before_impact_log_error"].sel(order=0)) > 0.05).all()


def test_a_viscous_damper_takes_energy_before_the_first_impact_the_less_the_higher_its_order(found):
    assert (found["pulse_before_impact_log_error"].diff("order") < 0).all()
    assert (found["pulse_before_impact_median_ratio"] < 1).all()


def test_a_ratio_under_a_pulse_is_that_of_the_event_driven_solver(found, config):
    grid = config.damper_order.pulses
    one = found.isel(pulse=0, pulse_frequency=1, load_ratio=1).sel(order=4, restitution=0.85)
    step = grid.step
    wave = 0.85 * float(one["load_ratio"]) * pulse("Ricker", float(one["pulse_frequency"]), step)
    times = [step * (wave.size - 1) + grid.tail]
    peaks = [
        np.abs(event_driven.history(CURVE, damping, times, load=wave, load_step=step).turning_displacement).max()
        for damping in (Damping.of_restitution(0.85, order=4), Damping.cr(0.85))
    ]
    assert 0.01 < peaks[1] < 0.8
    # The error of the step of 0.005 reaches 6e-3 near a crossing of the pulse.
    assert float(one["pulse_ratio"]) == pytest.approx(peaks[0] / peaks[1], rel=6e-3)


def test_under_the_record_the_peak_tends_to_that_of_restitution(found, config):
    away = abs(found["record_peak"] / found["record_reference_peak"] - 1)
    assert (away.diff("order") < 0).all() and float(away[0]) > 0.2 and float(away[-1]) < 0.002
    record = read_record(ROOT / config.validation.record)
    forcing = Forcing.from_record(WALL, record)
    curve, end = TrilinearCurve(0.03, 0.80), float(forcing.sampling) * forcing.intervals
    exact = event_driven.history(curve, Damping.cr(0.835), [end], **forcing.event_driven())
    peak = float(WALL.instability_displacement) * np.abs(exact.turning_displacement).max()
    assert float(found["record_reference_peak"]) == pytest.approx(peak, rel=1e-3)
    assert float(found["record_restitution"]) == 0.835


def test_the_peak_up_to_the_first_impact_is_seen_alone_and_a_collapse_before_it_has_none():
    reference = np.array([[0.0, 0.1, 0.4, 0.2, -0.1, -0.9, -0.2], [0.0, 0.1, 0.4, np.nan, np.nan, np.nan, np.nan]])
    damped = np.array([[0.0, 0.1, 0.2, 0.1, 0.3, 0.5, 0.6], [0.0, 0.1, 0.2, 0.1, -0.1, -0.5, -0.2]])
    assert ratio_before_impact(reference, damped)[0] == pytest.approx(0.5)
    assert np.isnan(ratio_before_impact(reference, damped)[1])
    assert np.isnan(ratio_before_impact(damped[1], reference[1]))
