"""Free-rocking tests: simulated ones give back their truth, and impossible ones are refused."""

import calibration_check
import numpy as np
import pytest
from repository import ROOT
from rounded_texts import assert_shipped

import rockdamp as rd
from rockdamp.histories.respond import free_decay
from rockdamp.laboratory.record_fit import strength_bounds
from rockdamp.laboratory.releases import find_releases, sensor_noise
from rockdamp.solvers.exact import exact_history

WALL = rd.Wall(thickness=0.25, height=3.0, hinge_ratio=0.6)
U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)
CURVE, E = rd.TrilinearCurve(0.05, 0.8), 0.86
ELAPSED = 0.002 * np.arange(3000)


def decay(damping=None, release=0.5, sign=1.0, seed=1, noise=2e-4, before=250):
    """A release of WALL by the event-driven solver, with noise and a zero; held before it."""
    history = exact_history(
        CURVE, damping or rd.Damping("CR", E), P * ELAPSED, release_amplitude=release
    )
    moved = np.concatenate([np.full(before, release), history.displacement, np.zeros(300)])
    random = np.random.RandomState(seed)
    return sign * U_INS * moved + 0.003 + noise * random.standard_normal(moved.size)


def make_test(displacement, **kwargs):
    return rd.FreeRocking(0.002 * np.arange(displacement.size), displacement, **kwargs)


@pytest.fixture(scope="module")
def fitted():
    """Two releases in one file to one side, and one in another to the other side."""
    both = np.concatenate([decay(seed=1), decay(seed=2, release=0.3)])
    return rd.fit_free_rocking([make_test(both), make_test(decay(seed=3, sign=-1.0))], WALL)


def test_releases_of_one_specimen_are_one_estimate(fitted):
    assert fitted.sizes["release"] == 3
    error = np.abs(fitted["estimate"].values - [0.05, 0.8, E])
    assert (error < 4 * fitted["standard_error"].values).all() and (
        error < [1e-4, 1e-3, 2e-3]
    ).all()
    reach = (fitted["interval"].values - fitted["estimate"].values) / fitted[
        "standard_error"
    ].values
    np.testing.assert_allclose(
        reach[:, :2], [[-1.645] * 2, [1.645] * 2], rtol=1e-3
    )  # of a1 and b1, 90 %
    released = fitted["release_displacement"].values / U_INS
    np.testing.assert_allclose(released, [0.5, 0.3, -0.5], rtol=2e-3)
    np.testing.assert_allclose(fitted["release_elapsed"][0], 0.5, atol=2e-3)
    np.testing.assert_allclose(fitted["sensor_zero"], 0.003, atol=2e-4)


@pytest.mark.parametrize(("release", "seed", "sign"), [(1, 1, 1.0), (3, 3, -1.0)])
def test_measured_history_is_the_record_less_zero_and_drift(fitted, release, seed, sign):
    samples = fitted.isel(sample=fitted["sample_release"].values == release)
    elapsed, sensor = samples["sample_elapsed"].values, fitted.isel(release=release - 1)
    shown = decay(seed=seed, sign=sign)[np.rint(elapsed / 0.002).astype(int)]
    drift = float(sensor["sensor_drift"]) * (elapsed - (elapsed[0] + elapsed[-1]) / 2)
    assert np.ptp(drift) > 1e-7
    np.testing.assert_allclose(
        shown - samples["measured"], float(sensor["sensor_zero"]) + drift, atol=1e-12
    )


def test_impacts_have_their_e_within_intervals(fitted):
    low, high = fitted["impact_restitution_interval"].values
    assert 0.75 < np.mean((low < E) & (high > E)) <= 1
    early = fitted["impact_amplitude"].values > 0.2
    np.testing.assert_allclose(fitted["impact_restitution"].values[early], E, atol=5e-3)
    assert float(fitted["residual_rms"]) == pytest.approx(2e-4, rel=0.05)
    assert float(fitted["restitution_scatter"]) < 0.004


def test_exponent_and_dampers_under_restitution(fitted):
    low, high = fitted["loss_exponent_interval"].values
    assert low < 0 < high
    excluded = fitted["relative_log_likelihood"] < fitted["log_likelihood_threshold"]
    assert not excluded.sel(damping_model=["CR", "ECD", "BAND"]).any()
    assert excluded.sel(damping_model=["CDC", "SDR"]).all()


@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR"])
def test_exponent_of_a_damper_is_that_of_its_half_cycles(fitted, model):
    """By the solver, with a small ratio, from the amplitudes before those impacts at which the wall rocks."""
    rocking = np.isfinite(fitted["expected_restitution"].sel(damping_model=model).values)
    amplitudes = fitted["impact_amplitude"].values[rocking]
    energies, losses = CURVE.energy(amplitudes), []
    for energy, x0 in zip(energies, amplitudes, strict=True):
        end = [1.5 * float(CURVE.period(x0))]
        run = exact_history(CURVE, rd.Damping(model, 1e-3), end, release_amplitude=float(x0))
        losses.append(np.log(energy / CURVE.energy(run.turning_displacement[0])))
    expected = -np.polyfit(np.log(energies), np.log(losses), 1)[0]
    assert float(fitted["expected_exponent"].sel(damping_model=model)) == pytest.approx(
        expected, rel=0.2
    )
    assert abs(expected) > 0.05
    assert float(fitted["expected_exponent"].sel(damping_model="BAND")) == pytest.approx(
        0, abs=1e-9
    )


@pytest.mark.parametrize(("model", "ratio"), [("CDC", 0.03), ("SDR", 0.05)])
def test_damper_of_a_test_is_the_most_likely(model, ratio):
    p = float(WALL.frequency_parameter)
    damping, times = rd.Damping(model, ratio), {"length": 6.0 * p, "step": 0.002 * p}
    history = free_decay(CURVE, damping, wall=WALL, release_amplitude=0.6, **times)
    shown = np.concatenate([np.full(200, 0.6 * U_INS), history["control_displacement"].values])
    fit = rd.fit_free_rocking(
        make_test(shown + 2e-4 * np.random.RandomState(4).standard_normal(shown.size)), WALL
    )
    assert str(fit["relative_log_likelihood"].idxmax("damping_model").item()) == model
    assert float(fit["relative_log_likelihood"].sel(damping_model="CR")) < float(
        fit["log_likelihood_threshold"]
    )


def test_restitution_by_amplitude():
    """A specimen that loses more as it fades: e is 0.86 at 0.3 u_ins, smaller below and larger above."""
    law = rd.Damping("CR", E, loss_exponent=0.26, reference_amplitude=0.3)
    tests = [
        make_test(decay(law, release=0.6, seed=1)),
        make_test(decay(law, release=0.6, seed=2, sign=-1.0)),
    ]
    found = rd.fit_free_rocking(tests, WALL)
    power = (CURVE.energy(np.array([0.1, 0.3, 0.5])) / CURVE.energy(0.3)) ** -0.26
    true = (1 - power * (1 - E**0.52)) ** (1 / 0.52)
    np.testing.assert_allclose(found["restitution_at_amplitude"], true, atol=3e-3)
    low, high = found["restitution_at_amplitude_interval"].values
    assert ((low < true) & (true < high)).all() and (high - low < 0.02).all()


def test_rotation_is_displacement_over_height():
    displacement = decay()
    turned = rd.FreeRocking(
        0.002 * np.arange(displacement.size), rotation=displacement / float(WALL.lower_height)
    )
    by_rotation, by_displacement = (
        rd.fit_free_rocking(test, WALL) for test in (turned, make_test(displacement))
    )
    np.testing.assert_allclose(by_rotation["estimate"], by_displacement["estimate"], rtol=1e-6)


def test_intervals_hold_90_per_cent():
    """Of 24 intervals of 90 %, at least 71 % hold the truth with a probability of 0.999."""
    inside = []
    for number in range(6):
        random = np.random.RandomState([11, number])
        thickness, a1, b1, e = (
            random.uniform(*ends) for ends in ((0.1, 0.4), (0.02, 0.1), (0.65, 0.88), (0.8, 0.93))
        )
        sizes = {"hinge_ratio": random.uniform(0.5, 0.7), "overburden_ratio": random.uniform(0, 6)}
        wall = rd.Wall(thickness, thickness * random.uniform(8, 25), **sizes)
        u_ins = float(wall.instability_displacement)
        moved = calibration_check.free_rocking(
            wall,
            rd.TrilinearCurve(a1, b1),
            e,
            random.uniform(0, 0.03),
            0.5,
            ELAPSED[:2000],
            5e-3 * u_ins,
            random,
        )
        fit = rd.fit_free_rocking(
            make_test(
                calibration_check.sensor(moved, 0.002, 0.4, 1e-3 * u_ins, 1e-3 * u_ins, random)
            ),
            wall,
        )
        at = fit["restitution_at_amplitude_interval"].sel(amplitude=0.3).values
        intervals = [*fit["interval"].values.T[:2], at, fit["loss_exponent_interval"].values]
        inside += [
            low <= value <= high
            for value, (low, high) in zip((a1, b1, e, 0.0), intervals, strict=True)
        ]
    assert np.mean(inside) >= 0.71


def test_shipped_examples_are_those_of_their_program():
    for name, text in calibration_check.examples().items():
        assert_shipped(text, (ROOT / "examples" / name).read_text(encoding="utf-8"))


@pytest.mark.parametrize(("a3", "softening"), [(0.6, "steeper"), (0.9, "translated")])
def test_curve_with_a_smaller_a3(a3, softening):
    curve = rd.TrilinearCurve(0.05, 0.7, a3, softening)
    history = exact_history(curve, rd.Damping("CR", E), P * ELAPSED, release_amplitude=0.3)
    shown = U_INS * np.concatenate([np.full(250, 0.3), history.displacement])
    test = make_test(shown + 2e-4 * np.random.RandomState(1).standard_normal(shown.size))
    fit = rd.fit_free_rocking(test, WALL, ultimate_displacement_ratio=a3, softening=softening)
    np.testing.assert_allclose(fit["estimate"], [0.05, 0.7, E], rtol=0.01)
    with pytest.raises(rd.InputError, match="ultimate_displacement_ratio"):
        strength_bounds(0.3, 0.98, 0.02, softening)


SHOWN = decay()
REFUSED = {
    "millimetres": ({"displacement": 1000 * SHOWN}, "largest peak"),
    "centimetres": ({"displacement": 100 * SHOWN}, "largest peak"),
    "degrees": ({"rotation": SHOWN / 1.8 * 180 / np.pi}, "largest peak"),
    "one side": ({"displacement": np.abs(decay(before=0) - 0.003)}, "middle"),
    "too short": ({"displacement": SHOWN[:700]}, "clear peaks"),
    "noise": (
        {"displacement": 1e-4 * np.random.RandomState(5).standard_normal(2000)},
        "clear peaks",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_impossible_test_is_refused(case):
    measured, named = REFUSED[case]
    elapsed = 0.002 * np.arange(next(iter(measured.values())).size)
    with pytest.raises(rd.InputError, match=named):
        rd.fit_free_rocking(rd.FreeRocking(elapsed, **measured), WALL)


def test_half_periods_of_another_wall_are_refused():
    with pytest.raises(rd.InputError, match="half periods"):
        rd.fit_free_rocking(rd.FreeRocking(0.02 * np.arange(SHOWN.size), SHOWN), WALL)


def test_rigid_block_is_refused():
    history = exact_history(
        rd.TrilinearCurve(0.001, 0.995), rd.Damping("CR", E), P * ELAPSED, release_amplitude=0.5
    )
    moved = np.concatenate([np.full(250, 0.5), history.displacement, np.zeros(300)])
    noise = 2e-4 * np.random.RandomState(1).standard_normal(moved.size)
    with pytest.raises(rd.InputError, match="b1"):
        rd.fit_free_rocking(make_test(U_INS * moved + noise), WALL)


def test_a_test_without_rest_is_fitted():
    fit = rd.fit_free_rocking(make_test(decay(before=0)[150:2400]), WALL)
    assert float(fit["estimate"].sel(parameter="restitution")) == pytest.approx(E, abs=3e-3)


def test_releases_and_their_peaks():
    displacement = np.concatenate([decay(), decay(sign=-1.0, release=0.4)])
    first, second = find_releases(0.002 * np.arange(displacement.size), displacement)
    assert np.sign(first.peaks[0]) == 1 and np.sign(second.peaks[0]) == -1
    assert (np.sign(first.peaks[1:]) == -np.sign(first.peaks[:-1])).all()
    assert sensor_noise(displacement) == pytest.approx(2e-4, rel=0.1)
    assert np.abs(first.peaks).min() > 2e-3 and first.crossings.size == first.peaks.size - 1
    few, _ = find_releases(0.002 * np.arange(displacement.size), displacement, least=0.02)
    assert np.abs(few.peaks).min() > 0.02


def test_filtered_noise_makes_no_peaks():
    """White noise that a logger's filter took most of shows at rest, and hardly in differences of samples."""
    displacement = np.convolve(decay(noise=1e-3), np.full(25, 1 / 25), mode="valid")
    (release,) = find_releases(0.002 * np.arange(displacement.size), displacement)
    assert sensor_noise(displacement) > 5e-5
    assert (
        np.abs(release.peaks).min() > 5e-4 and release.elapsed[-1] < 6.6
    )  # the rest begins at 6.5 s
    fit = rd.fit_free_rocking(make_test(displacement), WALL)
    assert float(fit["estimate"].sel(parameter="restitution")) == pytest.approx(E, abs=5e-3)


def test_uncertain_size_adds_its_change_of_the_estimates():
    test = make_test(decay(release=0.4))
    exact, uncertain = (
        rd.fit_free_rocking(test, WALL, least_peak=0.01, uncertain=sizes)
        for sizes in (None, {"thickness": 0.002})
    )
    thick, thin = (
        rd.Wall(thickness=0.25 + side, height=3.0, hinge_ratio=0.6) for side in (0.002, -0.002)
    )
    change = [
        rd.fit_free_rocking(test, wall, least_peak=0.01)["estimate"].values
        for wall in (thick, thin)
    ]
    added = uncertain["standard_error"].values ** 2 - exact["standard_error"].values ** 2
    np.testing.assert_allclose(np.sqrt(added), np.abs(change[0] - change[1]) / 2, rtol=1e-6)
    low, high = uncertain["interval"].sel(parameter="strength_ratio").values
    assert high - low > 5 * float(
        np.diff(exact["interval"].sel(parameter="strength_ratio").values)[0]
    )
