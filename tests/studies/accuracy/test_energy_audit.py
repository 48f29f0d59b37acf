"""The energy audit, of exact histories, of stored ones and in joules."""

import numpy as np
import pytest
from accuracy_cases import CURVE, DAMPINGS

from rockdamp import plausibility
from rockdamp.histories.half_cycles import turning_points
from rockdamp.mechanics import rigid_bodies
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.solvers import event_driven
from rockdamp.studies.accuracy import energy_audit
from rockdamp.studies.decays import study as decay_study
from rockdamp.vocabulary import MODELS, STUDIES, VISCOUS_MODELS

# --- the energy audit ------------------------------------------------------------------------------------------------


LOAD = 0.4 * np.sin(np.arange(31) * 0.2 * 1.7 + 0.4)


def exact_balance(damping, step, forced, wrong=None):
    """Audit an exact history: what is left over is the audit's own error."""
    times = np.linspace(0, 6, round(6 / step) + 1)
    options = {"load": LOAD, "load_step": 0.2} if forced else {"release_amplitude": 0.6}
    history = event_driven.history(CURVE, damping, times, **options)
    load = np.interp(times, 0.2 * np.arange(31), LOAD) if forced else 0.0
    return energy_audit.balance(CURVE, wrong or damping, history.displacement, history.velocity, step, load)


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize("damping", DAMPINGS, ids=MODELS)
def test_the_audit_of_an_exact_history_is_second_order(damping, forced):
    coarse, fine = (exact_balance(damping, step, forced).largest_residual for step in (0.02, 0.0025))
    assert fine < 1e-4
    assert np.log(coarse / fine) / np.log(8) > 1.5 or coarse < 1e-6  # a single history: its corners scatter


@pytest.mark.parametrize("damping", DAMPINGS, ids=MODELS)
def test_a_loss_that_is_2_percent_wrong_shows_as_such(damping):
    if damping.step_kind == "impact":
        wrong = Damping.cr(np.sqrt(1 - 1.02 * (1 - 0.85**2)))
    else:
        wrong = damping.replace(damping_ratio=1.02 * damping.damping_ratio)
    right, false = (exact_balance(damping, 0.0025, False, own) for own in (None, wrong))
    assert false.residual[-1] == pytest.approx(-0.02 * right.lost[-1], rel=0.02)


def test_the_work_of_the_load_is_what_an_undamped_wall_gains():
    sums = exact_balance(Damping.cr(1.0), 0.0025, True)
    assert (sums.lost == 0).all()
    np.testing.assert_allclose(sums.work, sums.energy, atol=1e-5)


def test_the_residual_is_relative_to_the_most_energy_that_was_given():
    sums = energy_audit.Balance(np.array([2.0, 1.0, 0.5]), np.array([0.0, 1.1, 1.5]), np.array([0.0, 0.0, 3.0]))
    np.testing.assert_allclose(sums.residual, [0, -0.1, 3.0])
    assert float(sums.largest_residual) == pytest.approx(3.0 / 5.0)


@pytest.mark.no_cover
def test_the_stage_audits_both_excitations_to_second_order(stage, drawn):
    assert stage["audit_step"].values.tolist() == [0.02, 0.01, 0.005]
    displacement, velocity = drawn.histories("CDR", "forced", 0.01, 1)
    sums = energy_audit.balance(drawn.curve, drawn.damping("CDR"), displacement, velocity, 0.01, drawn.load_at(0.01))
    one = stage.sel(excitation="forced", damping_model="CDR", audit_step=0.01)
    assert float(one["energy_residual"]) == pytest.approx(np.median(sums.largest_residual))
    assert float(one["largest_energy_residual"]) == pytest.approx(sums.largest_residual.max())
    assert (np.abs(stage["energy_order"] - 2) < 0.5).all()  # 2, less the scatter of a few walls
    assert float(stage["largest_energy_residual"].sel(audit_step=0.005).max()) < 1e-3


def test_every_stored_history_is_audited(stage, config, looped):
    one = looped.sel(damping_model="SDR")
    sums = energy_audit.balance(
        config.curve,
        Damping("SDR", float(one["damping_ratio"])),
        one["displacement"].values,
        one["velocity"].values,
        0.01,
    )
    assert float(stage["damping_force_energy_residual"].sel(damping_model="SDR")) == pytest.approx(
        sums.largest_residual
    )
    assert stage["study"].values.tolist() == list(STUDIES)
    # The solver's own residual, at this step, is at most that of the ensemble but for the longer histories.
    assert float(stage["decay_energy_residual"].max()) < 5e-3


def test_a_stored_decay_that_gains_energy_shows(config, studies, looped):
    decayed = decay_study("amplitude", config)
    decayed["velocity"][1, 2, 300:] *= 1.05
    loops = energy_audit.Audited(config.wall, config.curve, 0.85, looped)
    found = energy_audit.stored(loops, {"amplitude": decayed}, studies, 0.01)
    assert float(found["decay_energy_residual"][0]) > 0.01


# --- joules ----------------------------------------------------------------------------------------------------------


UNLIKELY = pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # h/t = 1000, near the slender limit
with plausibility.as_meant():
    SLENDER = Wall(0.3, 300.0, hinge_ratio=0.6, overburden_ratio=1.5, eccentricity=0.05)


def test_mechanical_energy_is_half_of_the_generalised_one():
    """Against the two bodies: both energies, which tend to each other with the square of t/h."""
    bodies, scale = rigid_bodies.TwoBodies(SLENDER), float(SLENDER.instability_displacement)
    speed = 0.7 * float(SLENDER.frequency_parameter) * scale
    assert energy_audit.joules(SLENDER, 0.7**2 / 2) == pytest.approx(bodies.inertia(0.0) * speed**2 / 2, rel=1e-4)
    generalised = float(SLENDER.effective_mass) * speed**2 / 2
    assert energy_audit.joules(SLENDER, 0.7**2 / 2) == pytest.approx(generalised / 2)
    for x in (0.2, 0.6):  # V = x - x^2/2 of the rigid bi-linear law
        gained = bodies.potential(x * scale) - bodies.potential(0.0)
        assert energy_audit.joules(SLENDER, x - x**2 / 2) == pytest.approx(gained, rel=1e-4)


@UNLIKELY
def test_mechanical_energy_is_the_sum_of_eq_13():
    """1/2 sum (I_CM theta'^2 + m v_CM^2) for bodies that turn at u'/h1 and u'/h2, the upper one about its top."""
    wall = Wall(0.3, 300.0, hinge_ratio=0.6)
    speed, total = 0.01, 0.0
    for share, height in ((0.6, 180.0), (0.4, 120.0)):
        mass = share * float(wall.mass)
        rate = speed / height
        centre = np.hypot(height / 2, 0.15) * rate
        total += (mass * (height**2 + 0.3**2) / 12 * rate**2 + mass * centre**2) / 2
    v = speed / float(wall.frequency_parameter * wall.instability_displacement)
    assert energy_audit.joules(wall, v**2 / 2) == pytest.approx(total, rel=1e-4)


@UNLIKELY
def test_a_parapets_energy_is_that_of_a_rod_about_its_base():
    parapet = Parapet(0.3, 300.0)
    v = 0.01 / float(parapet.frequency_parameter * parapet.instability_displacement)
    assert energy_audit.joules(parapet, v**2 / 2) == pytest.approx(float(parapet.mass) / 3 * 0.01**2 / 2)


def test_half_cycles_under_restitution_lose_what_their_impacts_take(stage):
    e, n = stage["audited_restitution"], stage["half_cycle"]
    assert e.values.tolist() == [0.85, 0.835]
    expected = stage["release_energy"] * (1 - e**2) * e ** (2 * (n - 1))
    lost = stage["energy_lost"].sel(damping_model="CR")
    shown = np.isfinite(lost)
    assert shown.sum() >= 8
    np.testing.assert_allclose(lost.values[shown], expected.transpose(*lost.dims).values[shown], rtol=0.01)


def test_dampers_lose_what_leaves_from_peak_to_peak(stage, config, looped):
    wall, curve = config.wall, config.curve
    for model in VISCOUS_MODELS:
        one = looped.sel(damping_model=model)
        at = turning_points(one["velocity"].values)[:7]
        left = -np.diff(energy_audit.joules(wall, curve.energy(one["displacement"].values[at])))
        lost = stage["energy_lost"].sel(audited_wall="reference", damping_model=model).values[: left.size]
        np.testing.assert_allclose(lost, left, atol=2e-3 * float(stage["release_energy"][0]))
