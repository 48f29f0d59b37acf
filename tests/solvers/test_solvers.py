"""Both solvers on the same cases: closed forms, each other, and independent integrations."""

import mpmath
import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, smooth_load
from scipy.integrate import solve_ivp

from rockdamp.constants import MODELS
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load, simulate, stable_step

CURVE = CURVES[0]  # the wall of Fig. 5
W1 = float(CURVE.initial_frequency)
K1 = float(CURVE.initial_stiffness)


def solve(solver, curve, damping, step, steps, load=None, sampling=0.0, **start):
    """Return the displacement at each step."""
    if solver == "exact":
        times = step * np.arange(steps + 1)
        history = exact_history(curve, damping, times, load=load, sampling=sampling, **start)
    elif load is None:
        history = simulate(curve, damping, step=step, steps=steps, **start)
    else:
        substeps = round(sampling / step)
        history = simulate(curve, damping, load=Load(load, 1.0, sampling, substeps), **start)
    return history.displacement


# --- closed forms ---------------------------------------------------------------------------------

STEP = 1e-3
STEPS = 4000
TAU = STEP * np.arange(STEPS + 1)


def oscillate_freely(xi):
    """Return the motion of the linear oscillator from rest at 1."""
    root = np.sqrt(1 - xi**2)
    phase = W1 * root * TAU
    return np.exp(-xi * W1 * TAU) * (np.cos(phase) + xi / root * np.sin(phase))


PUSH = {"load": 0.01 * K1 * np.ones(2), "sampling": 4.0}
RAMP = {"load": np.array([0.0, 0.2]), "sampling": 4.0}
RELEASE = {"release_amplitude": 0.03}
# On the first branch of the curve, where these dampers are that of the linear oscillator. A push
# moves the wall to twice the static displacement.
CLOSED_FORMS = {
    "push": (Damping("CDC", 0.0), PUSH, 0.01 * (1 - oscillate_freely(0.0))),
    "damped push": (Damping("CDC", 0.3), PUSH, 0.01 * (1 - oscillate_freely(0.3))),
    "ramp": (Damping("CDR", 0.0), RAMP, 0.05 * (TAU / W1**2 - np.sin(W1 * TAU) / W1**3)),
}
for xi in (0.0, 0.02, 0.4):
    for model in ("CDC", "CDR", "SDR", "ECD"):
        case = (Damping(model, xi), RELEASE, 0.03 * oscillate_freely(xi))
        CLOSED_FORMS[f"{model} {xi}"] = case


@pytest.mark.parametrize(("solver", "error"), [("newmark", 6e-5), ("exact", 1e-11)])
@pytest.mark.parametrize("case", CLOSED_FORMS.values(), ids=CLOSED_FORMS)
def test_first_branch_is_the_linear_oscillator(case, solver, error):
    """The period of the scheme is off by (w1 step)^2/24: over 18 rad 1.6e-5.

    Damping and load add as much.
    """
    damping, options, expected = case
    displacement = solve(solver, CURVE, damping, STEP, STEPS, **options)
    np.testing.assert_allclose(displacement, expected, atol=error * np.abs(expected).max())


@pytest.mark.parametrize("curve", CURVES)
def test_undamped_period_is_the_closed_form(curve):
    step = 5e-4
    release = np.array([0.015, 0.1, 0.3, 0.5, 0.75])
    history = simulate(
        curve, Damping("CDR", 0.0), release_amplitude=release, step=step, steps=40000
    )
    for x, period in zip(history.displacement, curve.period(release), strict=True):
        index = np.nonzero(x[:-1] * x[1:] < 0)[0]
        crossing_times = step * (index + x[index] / (x[index] - x[index + 1]))
        # Energy is kept to about (w1 step)^2 = 1e-5, and far out the period changes by three times
        # its fraction.
        half_period = np.diff(crossing_times).mean()
        assert 2 * half_period == pytest.approx(period, rel=4e-5)


def test_impact_times_are_those_of_thirty_digits(quarter_period, stored_energy):
    """A decay of CR is known without integration: half periods of amplitudes from the energies."""
    with mpmath.workdps(30):
        e = mpmath.mpf("0.85")
        x0 = mpmath.mpf("0.7")
        corners = [mpmath.mpf(value) for value in ("0", "0.04", "0.15", "1")]
        forces = [mpmath.mpf(value) for value in ("0", "0.85", "0.85", "0")]
        tau = mpmath.mpf(0)
        x = x0
        times = []
        for impact in range(1, 8):
            tau += quarter_period(corners, forces, x)
            times.append(float(tau))
            energy = e ** (2 * impact) * stored_energy(corners, forces, x0)

            def excess(z, energy=energy):
                return stored_energy(corners, forces, z) - energy

            x = mpmath.findroot(excess, (mpmath.mpf("1e-9"), x), solver="anderson")
            tau += quarter_period(corners, forces, x)
    history = exact_history(CURVE, Damping("CR", 0.85), [times[-1] + 0.1], release_amplitude=0.7)
    np.testing.assert_allclose(history.impacts, times, rtol=1e-12)


# --- each other -----------------------------------------------------------------------------------


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize("damping", DAMPERS.values(), ids=DAMPERS)
def test_batched_solver_converges_to_the_exact_one(damping, forced):
    sampling = 0.1
    shares = np.linspace(0.08, 0.7, 6)
    load = smooth_load(2, 41, 0.12) if forced else np.zeros(41)
    errors = {20: 0.0, 80: 0.0}
    for curve in (CURVES[0], CURVES[3]):
        release = shares * float(curve.ultimate_displacement_ratio)
        options = {"load": load, "sampling": sampling}
        exact = [
            solve("exact", curve, damping, sampling, 40, **options, release_amplitude=x0)
            for x0 in release
        ]
        for substeps in errors:
            fine_load = Load(load, 1.0, sampling, substeps)
            batch = simulate(curve, damping, load=fine_load, release_amplitude=release)
            difference = batch.displacement[:, ::substeps] - exact
            errors[substeps] += np.sqrt(np.nanmean(difference**2))
    # The corners of the curve scatter the fall by 16; steps of CR with an impact scatter it more.
    assert errors[80] < 1e-5
    assert errors[20] / errors[80] > 5


@pytest.mark.parametrize("curve", CURVES[:4])
def test_response_tends_to_restitution_as_the_order_grows(curve):
    tau = np.arange(1601) * 0.005
    pulse = np.where(tau < 1.5, 1.1 * np.sin(2 * np.pi * tau / 1.5), 0.0)
    load = Load(pulse, 1.0, 0.005, 4)
    impact = simulate(curve, Damping("CR", 0.85), load=load, store_every=4).displacement
    errors = []
    for order in (8, 64, 512):
        damping = Damping.from_restitution(0.85, "ECD", order=order)
        x = simulate(curve, damping, load=load, store_every=4).displacement
        errors.append(np.sqrt(np.nanmean((x - impact) ** 2)))
    assert errors[0] > 2 * errors[1] > 4 * errors[2] > 0


# --- dimensions -----------------------------------------------------------------------------------


def integrate_si(wall, law, damping_ratio, exponent, release, elapsed, ground):
    """Return u of m_eff u'' + C u' + F(u) = -lambda m_eff a_g, Eq. (16), in SI units by LSODA."""
    strength = float(wall.rigid_strength)
    stiffness = float(wall.rigid_stiffness)
    mass = float(wall.effective_mass)
    u_ins = strength / stiffness
    a1, b1 = law
    corners = np.array([0.0, a1 * u_ins, u_ins - b1 * strength / stiffness, u_ins])
    forces = [0.0, b1 * strength, b1 * strength, 0.0]
    w1 = np.sqrt(b1 * strength / (a1 * u_ins) / mass)

    def rates(t, state):
        u, v = state
        force = np.interp(abs(u), corners, forces)
        w = np.sqrt(force / abs(u) / mass) if abs(u) > 1e-9 * u_ins else w1
        c = 2 * mass * w1 * damping_ratio * (w / w1) ** exponent
        acceleration = -1.5 * np.interp(t, elapsed, ground)
        return v, -(c * v + np.copysign(force, u)) / mass + acceleration

    options = {"t_eval": elapsed, "rtol": 1e-9, "atol": 1e-12, "max_step": 0.03 / w1}
    return solve_ivp(rates, (0, elapsed[-1]), [release * u_ins, 0.0], "LSODA", **options).y[0]


SPECIMEN = {
    "width": 1.438,
    "density": 1835.0,
    "hinge_ratio": 0.57,
    "overburden_ratio": 6.2,
    "eccentricity": 0.02,
}
WALLS = {
    "wall": Wall(0.102, 0.102 * 27, **SPECIMEN),
    "parapet": Parapet(0.25, 1.6, overburden_ratio=0.4, eccentricity=-0.05),
}


@pytest.mark.parametrize("release", [0.6, 0.0], ids=["free", "forced"])
@pytest.mark.parametrize(
    ("model", "exponent", "ratio"), [("CDC", 0, 0.03), ("CDR", 1, 0.05), ("SDR", 2, 0.15)]
)
@pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS)
def test_dimensionless_run_is_the_si_run_of_a_wall(wall, model, exponent, ratio, release):
    law = (0.05, 0.8)
    elapsed = np.arange(161) / 64
    s = (np.pi * float(wall.frequency_parameter) / 20 * (elapsed - 1.0)) ** 2
    ricker = 0.9 * float(wall.rigid_strength / wall.mass) * (1 - 2 * s) * np.exp(-s)
    ground = np.zeros(elapsed.size) if release else ricker
    expected = integrate_si(wall, law, ratio, exponent, release, elapsed, ground)
    load = Load(ground, wall.load_factor, wall.frequency_parameter / 64, 256)
    history = simulate(
        TrilinearCurve(*law),
        Damping(model, ratio),
        load=load,
        release_amplitude=release,
        store_every=256,
    )
    assert 0.1 < history.peak < 1  # far from nothing and from collapse
    u_ins = wall.instability_displacement
    # (w1 step)^2 is 1e-6.
    np.testing.assert_allclose(history.displacement * u_ins, expected, atol=2e-5 * u_ins)


# --- load -----------------------------------------------------------------------------------------

every_scheme = pytest.mark.parametrize("scheme", ["newmark", "paper"])
every_model = pytest.mark.parametrize("model", MODELS)


def make_damping(model):
    return Damping(model, 0.85 if model == "CR" else 0.05)


@every_scheme
@every_model
def test_substeps_interpolate_the_record(model, scheme):
    ground = np.random.default_rng(11).normal(size=81)
    resampled = np.interp(np.arange(401) / 5, np.arange(81), ground)
    options = {"release_amplitude": 0.2, "scheme": scheme}
    inside = simulate(CURVE, make_damping(model), load=Load(ground, 0.02, 0.05, 5), **options)
    outside = simulate(CURVE, make_damping(model), load=Load(resampled, 0.02, 0.01), **options)
    np.testing.assert_allclose(inside.displacement, outside.displacement, atol=1e-12)


@every_scheme
@every_model
def test_record_of_zeros_is_a_free_decay_to_the_bit(model, scheme):
    options = {"release_amplitude": 0.2, "scheme": scheme}
    decay = simulate(CURVE, make_damping(model), step=0.01, steps=400, **options)
    still = simulate(CURVE, make_damping(model), load=Load(np.zeros(41), 0.5, 0.1, 10), **options)
    np.testing.assert_array_equal(still.displacement, decay.displacement)
    np.testing.assert_array_equal(still.velocity, decay.velocity)


@pytest.mark.parametrize("solver", ["newmark", "exact"])
def test_reference_amplitude_beyond_the_wall_is_refused(solver):
    damping = Damping("CR", 0.8, loss_exponent=0.2, reference_amplitude=1.0)
    with pytest.raises(InputError, match="reference_amplitude"):
        solve(solver, CURVE, damping, 0.01, 2)


# --- stability ------------------------------------------------------------------------------------


def test_run_below_the_stability_limit_is_the_discrete_one():
    """Undamped explicit Newmark: x_n = x0 cos(n theta), cos(theta) = 1 - (w1 step)^2/2."""
    step = 0.999 * float(stable_step(CURVE))
    history = simulate(CURVE, Damping("CDR", 0.0), release_amplitude=0.03, step=step, steps=1000)
    theta = np.arccos(1 - 2 * 0.999**2)
    expected = 0.03 * np.cos(theta * np.arange(1001))
    np.testing.assert_allclose(history.displacement, expected, atol=1e-10)


FIRST_BRANCH = TrilinearCurve(0.4, 0.5)
FIRST_BRANCH_W1 = float(FIRST_BRANCH.initial_frequency)
AMPLITUDES = np.linspace(0.2, 0.3, 40)  # so many that crossings meet a step anywhere


def decay_on_first_branch(order, e, step, steps):
    """Return decays at a step times w1 that never leave the first branch."""
    damping = Damping.from_restitution(e, "ECD", order=order)
    return simulate(
        FIRST_BRANCH,
        damping,
        step=step / FIRST_BRANCH_W1,
        steps=steps,
        release_amplitude=AMPLITUDES,
    )


@pytest.mark.parametrize("order", [0, 1, 16, 64])
@pytest.mark.parametrize("e", [0.5, 0.95])
def test_every_order_is_stable_up_to_the_limit(order, e):
    for step in (0.3, 0.8, 1.2, 1.6, 1.98):
        history = decay_on_first_branch(order, e, step, 400)
        assert np.abs(history.displacement).max() < 0.4
        last_peaks = np.abs(history.displacement[:, -60:]).max(axis=1)
        assert (last_peaks <= AMPLITUDES).all()


def largest_decrement_error(order, e):
    """Return the largest error of the decrement of eight half cycles over the step's square.

    The energy is read at the eighth turning point, where the damper takes nothing.
    """
    errors = []
    for step in (0.1, 0.05, 0.025):
        history = decay_on_first_branch(order, e, step, int(8.9 * np.pi / step))
        distances = np.abs(history.displacement)
        sizes = np.hypot(history.displacement, history.velocity / FIRST_BRANCH_W1)
        for distance, size, amplitude in zip(distances, sizes, AMPLITUDES, strict=True):
            inner = distance[1:-1]
            turns = 1 + np.flatnonzero((inner >= distance[:-2]) & (inner > distance[2:]))
            decrement = np.log(size[turns[7]] / amplitude) / (8 * np.log(e))
            errors.append(abs(decrement - 1) / step**2)
    return max(errors)


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_higher_order_needs_a_shorter_step(e):
    errors = [largest_decrement_error(order, e) for order in (0, 1, 4, 16, 32)]
    assert errors[0] == pytest.approx(0.042, abs=0.003)
    assert errors[0] < errors[1] < errors[2] < errors[3]
    assert 0.25 < max(errors) < 0.30
