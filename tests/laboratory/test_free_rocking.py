"""Fits of free-rocking tests: the truth of simulated ones is found, impossible ones are refused."""

import calibration_check
import numpy as np
import pytest
from repository import ROOT
from rocking_decays import (
    CURVE,
    NOISE,
    STEP,
    U_INS,
    WALL,
    E,
    P,
    decay,
    free_motion,
    make_test,
    white_noise,
)
from rounded_texts import assert_shipped

import rockdamp as rd
from rockdamp.histories.respond import free_decay
from rockdamp.laboratory.record_fit import strength_bounds
from rockdamp.solvers.exact import exact_history

TRUTH = np.array([0.05, 0.8, E])  # a1, b1, e


@pytest.fixture(scope="module")
def fitted():
    """Two releases in one file to one side, and one in another to the other side."""
    two_decays = np.concatenate([decay(seed=1), decay(seed=2, release=0.3)])
    tests = [make_test(two_decays), make_test(decay(seed=3, sign=-1.0))]
    return rd.fit_free_rocking(tests, WALL)


# --- curve and restitution ------------------------------------------------------------------------


def test_curve_and_restitution_are_found(fitted):
    error = np.abs(fitted["estimate"].values - TRUTH)
    assert (error < 4 * fitted["standard_error"].values).all()
    assert (error < [1e-4, 1e-3, 2e-3]).all()


def test_intervals_of_the_curve_are_of_90_per_cent(fitted):
    reach = (fitted["interval"] - fitted["estimate"]) / fitted["standard_error"]
    np.testing.assert_allclose(reach[:, :2], [[-1.645] * 2, [1.645] * 2], rtol=1e-3)


def test_releases_have_their_side_and_time(fitted):
    released = fitted["release_displacement"].values / U_INS
    np.testing.assert_allclose(released, [0.5, 0.3, -0.5], rtol=2e-3)
    np.testing.assert_allclose(fitted["release_elapsed"][0], 0.5, atol=2e-3)


def test_zero_of_the_sensor_is_found(fitted):
    np.testing.assert_allclose(fitted["sensor_zero"], 0.003, atol=2e-4)


@pytest.mark.parametrize(("release", "seed", "sign"), [(1, 1, 1.0), (3, 3, -1.0)])
def test_measured_history_has_no_zero_and_drift(fitted, release, seed, sign):
    samples = fitted.isel(sample=fitted["sample_release"].values == release)
    elapsed = samples["sample_elapsed"].values
    sensor = fitted.isel(release=release - 1)
    recorded = decay(seed=seed, sign=sign)[np.rint(elapsed / STEP).astype(int)]
    drift = float(sensor["sensor_drift"]) * (elapsed - (elapsed[0] + elapsed[-1]) / 2)
    trend = float(sensor["sensor_zero"]) + drift
    assert np.ptp(drift) > 1e-7
    np.testing.assert_allclose(recorded - samples["measured"], trend, atol=1e-12)


def test_impacts_have_e_within_their_intervals(fitted):
    low, high = fitted["impact_restitution_interval"].values
    assert 0.75 < np.mean((low < E) & (high > E)) <= 1


def test_large_impacts_have_the_e_of_the_wall(fitted):
    is_large = fitted["impact_amplitude"].values > 0.2
    np.testing.assert_allclose(fitted["impact_restitution"].values[is_large], E, atol=5e-3)


def test_residual_is_the_noise_of_the_sensor(fitted):
    assert float(fitted["residual_rms"]) == pytest.approx(NOISE, rel=0.05)


def test_equal_impacts_have_no_scatter(fitted):
    assert float(fitted["restitution_scatter"]) < 0.004


def test_rotation_is_displacement_over_height():
    displacement = decay()
    elapsed = STEP * np.arange(displacement.size)
    rotation = displacement / float(WALL.lower_height)
    by_rotation = rd.fit_free_rocking(rd.FreeRocking(elapsed, rotation=rotation), WALL)
    by_displacement = rd.fit_free_rocking(make_test(displacement), WALL)
    np.testing.assert_allclose(by_rotation["estimate"], by_displacement["estimate"], rtol=1e-6)


@pytest.mark.parametrize(("a3", "softening"), [(0.6, "steeper"), (0.9, "translated")])
def test_curve_with_a_smaller_a3(a3, softening):
    curve = rd.TrilinearCurve(0.05, 0.7, a3, softening)
    free = free_motion(STEP * np.arange(3000), curve=curve, release=0.3)
    displacement = np.concatenate([np.full(250, 0.3 * U_INS), free])
    test = make_test(displacement + white_noise(displacement.size))
    fit = rd.fit_free_rocking(test, WALL, ultimate_displacement_ratio=a3, softening=softening)
    np.testing.assert_allclose(fit["estimate"], [0.05, 0.7, E], rtol=0.01)


@pytest.mark.parametrize(
    ("displacement", "tolerance"),
    [
        (decay(held_samples=0)[150:2400], 3e-3),
        (np.convolve(decay(noise=1e-3), np.full(25, 1 / 25), mode="valid"), 5e-3),
    ],
    ids=["without rest", "filtered noise"],
)
def test_e_of_an_imperfect_test_is_found(displacement, tolerance):
    fit = rd.fit_free_rocking(make_test(displacement), WALL)
    assert float(fit["estimate"].sel(parameter="restitution")) == pytest.approx(E, abs=tolerance)


def test_shipped_examples_are_those_of_their_program():
    for name, text in calibration_check.make_examples().items():
        assert_shipped(text, (ROOT / "examples" / name).read_text(encoding="utf-8"))


# --- uneven times ---------------------------------------------------------------------------------

FRAMES = np.arange(420) / 60


def video(elapsed):
    """Return times and displacements of a release that is held for half a second."""
    is_free = elapsed >= 0.5
    held = np.full(np.count_nonzero(~is_free), 0.5 * U_INS)
    displacement = np.concatenate([held, free_motion(elapsed[is_free] - 0.5)])
    return elapsed, displacement + white_noise(elapsed.size)


@pytest.mark.parametrize(
    ("elapsed", "displacement"),
    [
        pytest.param(*(values.round(4) for values in video(FRAMES.round(2))), id="rounded"),
        pytest.param(
            *video(np.cumsum(np.random.RandomState(3).choice([0.8, 1, 1, 1.6], 400)) / 60),
            id="variable rate",
        ),
        pytest.param(
            *video(np.delete(FRAMES, [*range(90, 95), *range(200, 205)])), id="five frames lost"
        ),
        pytest.param(*video(np.delete(FRAMES, slice(0, None, 25))), id="single frames lost"),
    ],
)
def test_uneven_times_are_fitted(elapsed, displacement):
    fit = rd.fit_free_rocking(rd.FreeRocking(elapsed, displacement), WALL)
    error = np.abs(fit["estimate"].values - TRUTH)
    assert (error < [5e-4, 5e-3, 2e-3]).all()
    assert (error < 4 * fit["standard_error"].values).all()


# --- law of the losses, and dampers ---------------------------------------------------------------


def test_exponent_is_zero_under_restitution(fitted):
    low, high = fitted["loss_exponent_interval"].values
    assert low < 0 < high


@pytest.mark.parametrize(
    ("model", "is_excluded"),
    [("CR", False), ("ECD", False), ("BAND", False), ("CDC", True), ("SDR", True)],
)
def test_dampers_unlike_restitution_are_excluded(fitted, model, is_excluded):
    likelihood = float(fitted["relative_log_likelihood"].sel(damping_model=model))
    assert (likelihood < float(fitted["log_likelihood_threshold"])) == is_excluded


@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR"])
def test_exponent_of_a_damper_follows_its_half_cycles(fitted, model):
    """By the solver, with a small damping ratio, from peaks at which the wall rocks."""
    is_rocking = np.isfinite(fitted["expected_restitution"].sel(damping_model=model).values)
    amplitudes = fitted["impact_amplitude"].values[is_rocking]
    energies = CURVE.energy(amplitudes)
    losses = []
    for energy, amplitude in zip(energies, amplitudes, strict=True):
        end = 1.5 * float(CURVE.period(amplitude))
        damping = rd.Damping(model, 1e-3)
        run = exact_history(CURVE, damping, [end], release_amplitude=float(amplitude))
        losses.append(np.log(energy / CURVE.energy(run.turning_displacement[0])))
    slope, _ = np.polyfit(np.log(energies), np.log(losses), 1)
    exponent = float(fitted["expected_exponent"].sel(damping_model=model))
    assert abs(slope) > 0.05
    assert exponent == pytest.approx(-slope, rel=0.2)


def test_exponent_of_band_is_zero(fitted):
    exponent = float(fitted["expected_exponent"].sel(damping_model="BAND"))
    assert exponent == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("model", "ratio"), [("CDC", 0.03), ("SDR", 0.05)])
def test_damper_of_a_test_is_the_most_likely(model, ratio):
    damping = rd.Damping(model, ratio)
    times = {"length": 6.0 * P, "step": STEP * P}
    history = free_decay(CURVE, damping, wall=WALL, release_amplitude=0.6, **times)
    free = history["control_displacement"].values
    displacement = np.concatenate([np.full(200, 0.6 * U_INS), free])
    test = make_test(displacement + white_noise(displacement.size, seed=4))
    likelihood = rd.fit_free_rocking(test, WALL)
    assert str(likelihood["relative_log_likelihood"].idxmax("damping_model").item()) == model
    restitution = float(likelihood["relative_log_likelihood"].sel(damping_model="CR"))
    assert restitution < float(likelihood["log_likelihood_threshold"])


@pytest.fixture(scope="module")
def fading():
    """A specimen that loses more as it fades: e is 0.86 at 0.3 u_ins, and smaller below."""
    law = rd.Damping("CR", E, loss_exponent=0.26, reference_amplitude=0.3)
    displacements = decay(law, release=0.6, seed=1), decay(law, release=0.6, seed=2, sign=-1.0)
    return rd.fit_free_rocking([make_test(values) for values in displacements], WALL)


def test_restitution_by_amplitude_is_found(fading):
    power = (CURVE.energy(np.array([0.1, 0.3, 0.5])) / CURVE.energy(0.3)) ** -0.26
    expected = (1 - power * (1 - E**0.52)) ** (1 / 0.52)
    np.testing.assert_allclose(fading["restitution_at_amplitude"], expected, atol=3e-3)
    low, high = fading["restitution_at_amplitude_interval"].values
    assert ((low < expected) & (expected < high)).all()
    assert (high - low < 0.02).all()


def simulated_intervals(number):
    """Return the truth of a random test, and its intervals: a1, b1, e at 0.3 u_ins and g."""
    random = np.random.RandomState([11, number])
    thickness = random.uniform(0.1, 0.4)
    a1 = random.uniform(0.02, 0.1)
    b1 = random.uniform(0.65, 0.88)
    e = random.uniform(0.8, 0.93)
    sizes = {"hinge_ratio": random.uniform(0.5, 0.7), "overburden_ratio": random.uniform(0, 6)}
    wall = rd.Wall(thickness, thickness * random.uniform(8, 25), **sizes)
    u_ins = float(wall.instability_displacement)
    scatter = random.uniform(0, 0.03)
    elapsed = STEP * np.arange(2000)
    curve = rd.TrilinearCurve(a1, b1)
    displacement = calibration_check.simulate_free_rocking(
        wall, curve, e, scatter, 0.5, elapsed, 5e-3 * u_ins, random
    )
    noise = 1e-3 * u_ins
    measured = calibration_check.measure(displacement, STEP, 0.4, noise, noise, random)
    fit = rd.fit_free_rocking(make_test(measured), wall)
    e_interval = fit["restitution_at_amplitude_interval"].sel(amplitude=0.3).values
    exponent_interval = fit["loss_exponent_interval"].values
    return (a1, b1, e, 0.0), (*fit["interval"].values.T[:2], e_interval, exponent_interval)


def test_intervals_hold_90_per_cent():
    """Of 24 intervals of 90 %, at least 71 % hold the truth with a probability of 0.999."""
    is_inside = []
    for number in range(6):
        truth, intervals = simulated_intervals(number)
        pairs = zip(truth, intervals, strict=True)
        is_inside += [low <= value <= high for value, (low, high) in pairs]
    assert np.mean(is_inside) >= 0.71


# --- uncertain sizes ------------------------------------------------------------------------------


def test_uncertain_size_adds_its_change_of_estimates():
    """Half of the difference by a thicker and a thinner wall."""
    test = make_test(decay(release=0.4))

    def fit(thickness=0.25, uncertain=None):
        wall = rd.Wall(thickness=thickness, height=3.0, hinge_ratio=0.6)
        return rd.fit_free_rocking(test, wall, least_peak=0.01, uncertain=uncertain)

    exact = fit()
    uncertain = fit(uncertain={"thickness": 0.002})
    change = fit(thickness=0.252)["estimate"] - fit(thickness=0.248)["estimate"]
    added = np.sqrt(uncertain["standard_error"] ** 2 - exact["standard_error"] ** 2)
    np.testing.assert_allclose(added, np.abs(change) / 2, rtol=1e-6)
    widths = [
        float(np.diff(fit["interval"].sel(parameter="strength_ratio").values)[0])
        for fit in (exact, uncertain)
    ]
    assert widths[1] > 5 * widths[0]


# --- tests that are refused -----------------------------------------------------------------------

DISPLACEMENT = decay()


@pytest.mark.parametrize(
    ("measured", "named"),
    [
        pytest.param(
            {"displacement": 1000 * DISPLACEMENT}, "largest peak is [0-9]+ m; ", id="millimetres"
        ),
        pytest.param({"displacement": 100 * DISPLACEMENT}, "largest peak", id="centimetres"),
        pytest.param({"rotation": np.rad2deg(DISPLACEMENT / 1.8)}, "largest peak", id="degrees"),
        pytest.param(
            {"displacement": np.abs(decay(held_samples=0) - 0.003)}, "middle", id="one side"
        ),
        pytest.param({"displacement": DISPLACEMENT[:700]}, "clear peaks", id="too short"),
        pytest.param(
            {"displacement": white_noise(2000, seed=5, noise=1e-4)}, "clear peaks", id="noise"
        ),
        pytest.param(
            {"displacement": DISPLACEMENT[:30]},
            "the test has 30 samples; it must have at least 50",
            id="30 rows",
        ),
    ],
)
def test_impossible_test_is_refused(measured, named):
    (values,) = measured.values()
    elapsed = STEP * np.arange(values.size)
    with pytest.raises(rd.InputError, match=named):
        rd.fit_free_rocking(rd.FreeRocking(elapsed, **measured), WALL)


def test_spike_is_refused_with_its_time():
    """Otherwise a marker lost for one frame would change e by several hundredths."""
    displacement = decay()
    displacement[400] = 0.0
    with pytest.raises(rd.InputError, match="jump of the displacement at 0.8 s"):
        rd.fit_free_rocking(make_test(displacement), WALL)


def test_half_periods_of_another_wall_are_refused():
    elapsed = 0.02 * np.arange(DISPLACEMENT.size)
    with pytest.raises(rd.InputError, match="half periods"):
        rd.fit_free_rocking(rd.FreeRocking(elapsed, DISPLACEMENT), WALL)


@pytest.mark.parametrize("hinge_ratio", [0.5, 0.65])  # that of the test is 0.6
def test_wrong_wall_leaves_a_large_residual(hinge_ratio):
    wall = rd.Wall(thickness=0.25, height=3.0, hinge_ratio=hinge_ratio)
    fit = rd.fit_free_rocking(make_test(DISPLACEMENT), wall)
    assert float(fit["residual_rms"]) > 4 * NOISE


def test_rigid_block_is_refused():
    free = free_motion(STEP * np.arange(3000), curve=rd.TrilinearCurve(0.001, 0.995))
    displacement = np.concatenate([np.full(250, 0.5 * U_INS), free, np.zeros(300)])
    with pytest.raises(rd.InputError, match="b1"):
        rd.fit_free_rocking(make_test(displacement + white_noise(displacement.size)), WALL)


def test_a3_without_any_b1_is_refused():
    with pytest.raises(rd.InputError, match="ultimate_displacement_ratio"):
        strength_bounds(0.3, 0.98, 0.02, "steeper")
