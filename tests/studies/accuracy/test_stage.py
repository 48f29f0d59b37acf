"""The accuracy stage: each number that it publishes, on cases whose answer is known, and on small real runs."""

import numpy as np
import pytest
import xarray as xr
import yaml
from repository import ROOT
from scipy.integrate import quad
from scipy.optimize import brentq

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.figures import FIGURES
from rockdamp.figures.style import MODELS as STYLES
from rockdamp.histories.half_cycles import turning_points
from rockdamp.mechanics import rigid_bodies
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import MODELS, VISCOUS_MODELS, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.solvers import event_driven
from rockdamp.solvers.newmark import solve
from rockdamp.storage import dataset
from rockdamp.studies import damping_loops
from rockdamp.studies.accuracy import energy_audit, ensemble, matched_ratios, small_rotations
from rockdamp.studies.accuracy.stage import accuracy, solver_errors
from rockdamp.studies.decays import describe, make_wall, restitution_grid
from rockdamp.studies.decays import study as decay_study
from rockdamp.vocabulary import STUDIES

CURVE = TrilinearCurve(0.06, 0.8)
DAMPINGS = [Damping.cr(0.85), *(Damping(model, 0.05) for model in VISCOUS_MODELS)]


@pytest.fixture(scope="module")
def config():
    """The paper's config with fewer values, a larger step and shorter responses."""
    small = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))
    small["solver"]["step"] = 0.01
    small["restitution"] = {"start": 0.8, "stop": 0.9, "step": 0.05}
    small["studies"]["amplitude"]["release_amplitude"] = [0.3, 0.5]
    small["studies"]["slenderness"]["slenderness"] = [10, 15]
    small["studies"]["overburden"]["overburden_ratio"] = [0.0, 8.0]
    small["studies"]["cracked_stiffness"]["cracked_stiffness_ratio"] = [0.04, 0.10, 0.20]
    small["matching"] |= {"window": 5.0, "scan": {"smallest": 0.3, "largest": 3.0, "points": 60}}
    small["windows"] = {"start": 3, "stop": 6, "step": 1}
    small["loops"]["window"] = 12
    small["accuracy"] |= {"restitutions": 2, "doublings": 1, "halvings": 2, "minima": 1, "bracket": 0.3}
    small["accuracy"]["rigid"] |= {"slenderness": [8, 20], "hinge_ratio": [0.5], "release_amplitude": [0.5]}
    return small


def made_up(config, name, models=VISCOUS_MODELS):
    """A match whose damping ratios are the closed form's and whose relative uncertainties are all different."""
    study, e = describe(name, config), restitution_grid(config)
    ratio = np.stack(
        [
            damping_ratio_energy(study.curve.map(lambda p: p[:, None]), model, e, study.release_amplitude[:, None])
            for model in models
        ]
    )
    relative = 1e-4 * np.linspace(1, 2, ratio.size).reshape(ratio.shape)
    dims = ("damping_model", study.parameter, "restitution")
    return xr.Dataset(
        {"damping_ratio": (dims, ratio), "damping_ratio_uncertainty": (dims, relative * ratio)},
        coords={
            "damping_model": list(models),
            study.parameter: study.values,
            "restitution": e,
            "window": float(config["matching"]["window"]),
        },
    )


@pytest.fixture(scope="module")
def matches(config):
    return {name: made_up(config, name) for name in STUDIES}


@pytest.fixture(scope="module")
def drawn(config, matches):
    return ensemble.collect(config, matches)


@pytest.fixture(scope="module")
def looped(config):
    return damping_loops.loops(config)


@pytest.fixture(scope="module")
def stage(config, matches, looped):
    decays = [decay_study(name, config) for name in STUDIES]
    return accuracy(config, *matches.values(), looped, *decays)


# --- the ensemble ---------------------------------------------------------------------------------------------------


def test_each_curve_and_release_of_the_studies_is_there_once(drawn):
    rows = zip(
        drawn.curve.cracked_stiffness_ratio[:, 0],
        drawn.curve.plateau_ratio[:, 0],
        drawn.release_amplitude[:, 0],
        strict=True,
    )
    assert sorted(rows) == [(0.04, 0.85, 0.3), (0.04, 0.85, 0.5), (0.10, 0.85, 0.5), (0.20, 0.75, 0.5)]
    assert drawn.restitution.tolist() == [0.8, 0.9]


def test_the_walls_have_their_published_damping_ratios(drawn, matches):
    case = drawn.curve.cracked_stiffness_ratio[:, 0].tolist().index(0.10)
    published = matches["cracked_stiffness"]["damping_ratio"].sel(cracked_stiffness_ratio=0.10, restitution=[0.8, 0.9])
    for model in VISCOUS_MODELS:
        assert drawn.ratio[model][case].tolist() == published.sel(damping_model=model).values.tolist()


def test_loads_are_seeded_of_unit_peak_and_within_their_band():
    load = ensemble.band_limited(3, 2, 4000, 0.2)
    np.testing.assert_array_equal(load, ensemble.band_limited(3, 2, 4000, 0.2))
    assert np.abs(load).max(axis=1).tolist() == [1.0, 1.0]
    assert np.abs(load[0] - load[1]).max() > 0.1
    power = np.abs(np.fft.rfft(load * np.hanning(4000))) ** 2
    frequency = 2 * np.pi * np.fft.rfftfreq(4000, 0.2)
    low, high = ensemble.LOAD_FREQUENCIES
    outside = (frequency < low - 0.05) | (frequency > high + 0.05)
    assert power[:, outside].sum() < 1e-6 * power.sum()


def test_the_forced_peaks_are_the_largest_below_the_releases(drawn, config):
    step = config["solver"]["step"]
    peak = np.max([drawn.forced_peaks(model, step, drawn.factor) for model in MODELS], axis=0)
    assert (peak <= drawn.release_amplitude).all()
    for larger in ensemble.FACTORS[:, None, None] * np.ones_like(drawn.factor):
        beyond = np.max([drawn.forced_peaks(model, step, larger) for model in MODELS], axis=0)
        assert ((larger <= drawn.factor) | (beyond > drawn.release_amplitude)).all()


def test_the_load_at_the_steps_is_linear_between_its_samples(drawn):
    many = round(drawn.sample / 0.01)
    load = drawn.load_at(0.01)
    np.testing.assert_allclose(load[1, 1, ::many], drawn.factor[1, 1] * drawn.load[1])
    np.testing.assert_allclose(np.diff(load[1, 1, : many + 1]), (load[1, 1, many] - load[1, 1, 0]) / many)


def test_histories_are_those_of_the_pipelines_solver(drawn):
    many = round(drawn.sample / 0.01)
    steps = (drawn.load.shape[1] - 1) * many
    options = {"step": 0.01, "steps": steps, "store_every": 2}
    case, e = 2, 1
    curve, damping = drawn.curve.map(lambda p: p[case, 0]), Damping("SDR", drawn.ratio["SDR"][case, e])
    free = solve(curve, damping, release_amplitude=drawn.release_amplitude[case, 0], **options)
    load = {"load_factor": drawn.factor[case, e], "ground_acceleration": drawn.load[case], "substeps": many}
    for excitation, expected in (("free", free), ("forced", solve(curve, damping, **load, **options))):
        displacement, velocity = drawn.histories("SDR", excitation, 0.01, 2)
        np.testing.assert_array_equal(displacement[case, e], expected.displacement)
        np.testing.assert_array_equal(velocity[case, e], expected.velocity)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_order_is_the_slope_of_the_error(power):
    steps = np.array([0.04, 0.02, 0.01])
    error = np.array([[3.0], [0.5]]) * steps**power
    np.testing.assert_allclose(ensemble.fitted_order(steps, error), power)


# --- the solver -----------------------------------------------------------------------------------------------------


def test_the_steps_are_those_of_the_config_with_the_solvers_own(stage, config):
    assert stage["step"].values.tolist() == [0.02, 0.01, 0.005, 0.0025]
    assert float(stage["solver_step"]) == 0.01
    assert float(stage["published_step"]) == 0.01 / config["matching"]["refinement"]


@pytest.mark.parametrize("excitation", ["free", "forced"])
def test_the_error_of_a_history_is_against_the_exact_one(stage, drawn, excitation):
    case, e = 1, 0
    forced = excitation == "forced"
    curve, damping = drawn.curve.map(lambda p: p[case, 0]), Damping("CDC", drawn.ratio["CDC"][case, e])
    length = (drawn.load.shape[1] - 1) * drawn.sample
    times = np.linspace(0, length, round(length / 0.02) + 1)
    load = {"load": drawn.factor[case, e] * drawn.load[case], "load_step": drawn.sample} if forced else {}
    release = 0.0 if forced else drawn.release_amplitude[case, 0]
    expected = event_driven.history(curve, damping, times, release_amplitude=release, **load).displacement
    found = drawn.histories("CDC", excitation, 0.01, 2)[0][case, e]
    rms = np.sqrt(np.mean((found - expected) ** 2))
    one = stage.sel(excitation=excitation, damping_model="CDC")
    assert float(one["solver_error"].sel(step=0.01)[case, e]) == pytest.approx(rms, rel=1e-6)
    assert float(one["largest_difference"]) >= np.abs(found - expected).max() * (1 - 1e-6) > rms
    assert float(one["largest_displacement"][case, e]) >= np.abs(expected).max()


def test_medians_and_largest_errors_are_over_walls_and_restitutions(stage):
    error = stage["solver_error"].transpose("excitation", "damping_model", "step", ...).values.reshape(2, 5, 4, -1)
    np.testing.assert_allclose(stage["median_solver_error"], np.median(error, axis=-1))
    np.testing.assert_allclose(stage["largest_solver_error"], error.max(axis=-1))
    np.testing.assert_allclose(stage["order"], ensemble.fitted_order(stage["step"], stage["median_solver_error"]))


def test_a_solver_that_does_not_converge_shows(config, drawn, stage):
    class Wrong(ensemble.Ensemble):
        def histories(self, *arguments):
            displacement, velocity = super().histories(*arguments)
            return 1.01 * displacement, velocity

    few = {
        "curve": drawn.curve.map(lambda p: p[:1]),
        "load": drawn.load[:1],
        "factor": drawn.factor[:1],
        "release_amplitude": drawn.release_amplitude[:1],
        "ratio": {m: r[:1] for m, r in drawn.ratio.items()},
    }
    found = solver_errors(config, Wrong(**{**drawn.__dict__, **few}))
    assert (found["order"] < 0.5).all()
    assert (stage["order"] > 1.5).all()  # 2, less the scatter of a few walls


# --- the damping ratios ---------------------------------------------------------------------------------------------


def test_uncertainties_of_all_studies_are_summarised_together(config, matches):
    known = {name: match.copy(deep=True) for name, match in matches.items()}
    known["overburden"]["damping_ratio_uncertainty"][0, 1, 2] = 0.002 * known["overburden"]["damping_ratio"][0, 1, 2]
    found = matched_ratios.uncertainty(known)
    count = 3 * (2 + 2 + 2 + 3)
    assert int(found["published_count"]) == count
    np.testing.assert_allclose(found["share_within_thousandth"], [1 - 1 / count, 1, 1, 1])
    largest = found["uncertainty_quantile"].sel(quantile=1.0)
    assert float(largest[0]) == pytest.approx(0.002)
    assert float(found["uncertainty_quantile"].sel(quantile=0.99)[0]) == float(largest[0])  # of 27 values, in doubt
    every = np.concatenate([matched_ratios.relative_uncertainty(match)[1].values.ravel() for match in known.values()])
    middle = float(found["uncertainty_quantile"].sel(viscous_model="CDR", quantile=0.5))
    assert middle in every and np.mean(every <= middle) >= 0.5 >= np.mean(every < middle)


def test_the_sample_holds_the_least_certain_and_drawn_ones(config, matches):
    known = {name: match.copy(deep=True) for name, match in matches.items()}
    known["overburden"]["damping_ratio_uncertainty"][2, 1, 0] = 0.02 * known["overburden"]["damping_ratio"][2, 1, 0]
    own = {**config, "accuracy": {**config["accuracy"], "minima": 5}}
    chosen = matched_ratios.sample(own, known)
    assert [len(chosen[model]) for model in VISCOUS_MODELS] == [5] * 4
    first = chosen["SDR"][0]
    assert (first.restitution, first.bound) == (0.8, pytest.approx(0.02))
    assert first.ratio == float(known["overburden"]["damping_ratio"][2, 1, 0])
    assert [one.bound for one in chosen["SDR"]][:3] == pytest.approx([0.02, 1.75e-4, 1.75e-4], rel=0.01)
    assert len({(one.curve.cracked_stiffness_ratio.item(), one.ratio) for one in chosen["ECD"]}) >= 3
    again = matched_ratios.sample(own, known)["ECD"][4]
    assert (again.ratio, again.restitution) == (chosen["ECD"][4].ratio, chosen["ECD"][4].restitution)


@pytest.fixture(scope="module")
def distance():
    return matched_ratios.Distance(CURVE, "CDC", 0.85, 0.5, 6.0)


def test_the_distance_is_the_integral_of_eq_17(distance):
    """Against 8 times as many samples without nodes at the crossings; each is second order in its spacing."""
    times = np.linspace(0, 6, 8 * 12000 + 1)
    expected, found = (
        np.abs(event_driven.history(CURVE, damping, times, release_amplitude=0.5).displacement)
        for damping in (Damping.cr(0.85), Damping("CDC", 0.03))
    )
    assert distance(0.03) == pytest.approx(np.trapezoid((expected - found) ** 2, times), rel=2e-5)


def test_the_distance_has_no_ripple_where_a_sum_has(distance):
    ratio = 0.032 * (1 + 2e-4 * np.arange(-8, 9))
    times = np.linspace(0, 6, 12001)
    target = np.abs(event_driven.history(CURVE, Damping.cr(0.85), times, release_amplitude=0.5).displacement)

    def summed(xi):
        found = event_driven.history(CURVE, Damping("CDC", xi), times, release_amplitude=0.5)
        return np.trapezoid((target - np.abs(found.displacement)) ** 2, times)

    def ripple(function):
        values = np.array([function(float(xi)) for xi in ratio])
        offset = ratio / 0.032 - 1
        return np.abs(values - np.polyval(np.polyfit(offset, values, 3), offset)).max()

    assert ripple(distance) < 0.1 * ripple(summed)


@pytest.fixture(scope="module")
def minimum(distance):
    """The least distance by brute force: a parabola through three points around the least of a fine scan."""
    scan = np.linspace(0.02, 0.06, 41)
    values = np.array([distance(xi) for xi in scan])
    low, middle, high = values[values.argmin() - 1 : values.argmin() + 2]
    return scan[values.argmin()] + 0.001 * (low - high) / (low - 2 * middle + high) / 2


def test_the_exact_minimum_does_not_depend_on_the_published_value(distance, minimum):
    found = [
        matched_ratios.exact_minimum(
            matched_ratios.Published(CURVE, 0.5, 0.85, "CDC", factor * minimum, 0.0), 6.0, 0.02
        )
        for factor in (0.99, 1.0, 1.01)
    ]
    np.testing.assert_allclose(found, found[1], rtol=2e-5)
    assert found[1] == pytest.approx(minimum, rel=0.01)
    assert distance(found[1]) < min(distance(found[1] * 0.999), distance(found[1] * 1.001))


def test_a_minimum_beyond_the_bracket_is_an_error(minimum):
    far = matched_ratios.Published(CURVE, 0.5, 0.85, "CDC", 1.05 * minimum, 0.0)
    with pytest.raises(InputError, match=r"accuracy.bracket is 0.02; it must be larger: Err of CDC at e = 0.85"):
        matched_ratios.exact_minimum(far, 6.0, 0.02)


def test_the_difference_of_the_sample_is_that_of_the_published_value(config):
    """The same published values, once 0.3 % larger: so are the differences, and nothing else changes."""
    own = {**config, "accuracy": {**config["accuracy"], "minima": 2}}
    plain = {name: made_up(config, name, ["CDC"]) for name in STUDIES}
    more = {name: match.assign(damping_ratio=1.003 * match["damping_ratio"]) for name, match in plain.items()}
    one, other = matched_ratios.minima(own, plain), matched_ratios.minima(own, more)
    np.testing.assert_allclose(other["sample_exact_ratio"], one["sample_exact_ratio"], rtol=2e-5)
    np.testing.assert_allclose(1 + other["sample_difference"], 1.003 * (1 + one["sample_difference"]), rtol=2e-5)
    np.testing.assert_allclose(one["sample_bound"][0, 0], 2e-4)  # the largest of them all


def test_what_is_not_certain_to_a_thousandth_counts_once_its_exact_minimum_agrees(config):
    own = {**config, "accuracy": {**config["accuracy"], "minima": 2}}
    known = {name: made_up(config, name, ["CDC"]) for name in STUDIES}
    exactly = matched_ratios.minima(own, known)["sample_exact_ratio"].values[0, 0]
    ratio = known["amplitude"]["damping_ratio"]  # its last is the least certain of all, and so the sample's first
    for off, share in ((1.0005, 1.0), (1.002, 1 - 1 / 27)):
        ratio[0, -1, -1] = off * exactly
        known["amplitude"]["damping_ratio_uncertainty"][0, -1, -1] = 0.01 * off * exactly
        found = matched_ratios.minima(own, known)
        assert float(found["sample_difference"][0, 0]) == pytest.approx(off - 1, rel=0.05)
        assert float(found["share_converged"][0]) == pytest.approx(share)
        assert float(matched_ratios.uncertainty(known)["share_within_thousandth"][0]) == pytest.approx(1 - 1 / 27)


# --- rotations ------------------------------------------------------------------------------------------------------


def test_features_are_the_first_impact_and_the_peaks_after_it():
    times = np.linspace(0, 9, 3601)
    decaying = 0.8 * np.cos(2 * times) * 0.9 ** np.floor((2 * times + np.pi / 2) / np.pi)
    found = small_rotations.features(times, decaying, 3)
    np.testing.assert_allclose(found, [np.pi / 4, 0.8 * 0.9, 0.8 * 0.81, 0.8 * 0.729], rtol=1e-5)
    short = small_rotations.features(times[:1200], decaying[:1200], 3)
    assert np.isfinite(short).tolist() == [True, True, False, False]


def test_peaks_are_found_between_the_samples():
    """The largest sample is up to (w h)^2/8 = 1.2e-3 too low; a parabola leaves the fourth order."""
    times = 0.05 * np.arange(200)
    found = small_rotations.features(times, np.cos(2 * times), 4)
    np.testing.assert_allclose(found[1:], 1, atol=2e-5)


@pytest.mark.parametrize("hinge", [0.5, 0.7])
@pytest.mark.parametrize("slenderness", [5, 15])
def test_p_falls_by_the_mass_that_the_slender_limit_leaves_out(hinge, slenderness):
    more = (3 - 2 * hinge) / (hinge**2 * (1 - hinge)) / slenderness**2
    wall = Wall(0.4, 0.4 * slenderness, hinge_ratio=hinge)
    assert small_rotations.frequency_difference(wall) == pytest.approx((1 + more) ** -0.5 - 1, rel=1e-9)


def test_differences_are_those_of_the_energy_integrals():
    """First impact: p times the integral of sqrt(M/(2 (U0 - U))); peaks: U falls by e^2 at each impact."""
    wall, e, x0 = Wall(0.4, 2.4, hinge_ratio=0.6), 0.9, 0.7
    bodies, p, scale = rigid_bodies.TwoBodies(wall), float(wall.frequency_parameter), 0.4
    rest, top = bodies.potential(0.0), bodies.potential(x0 * scale)

    def rate(s):  # u = u0 - s^2 takes the singularity away
        u = x0 * scale - s * s
        return 2 * s * np.sqrt(bodies.inertia(u) / (2 * max(top - bodies.potential(u), 1e-300)))

    impact = p * quad(rate, 0, np.sqrt(x0 * scale), epsabs=1e-12)[0] / np.arccosh(1 / (1 - x0)) - 1
    peaks = []
    for n in (1, 2):
        kept = rest + e ** (2 * n) * (top - rest)
        large = brentq(lambda u, kept=kept: bodies.potential(u) - kept, 0, x0 * scale) / scale
        peaks.append(large / (1 - np.sqrt(1 - e ** (2 * n) * x0 * (2 - x0))) - 1)
    found = small_rotations.differences(wall, e, x0, 2)
    assert found[0] == pytest.approx(impact, rel=1e-3)
    assert found[1] == pytest.approx(max(peaks, key=abs), rel=1e-3)
    assert found[2] == small_rotations.frequency_difference(wall)


def test_differences_fall_with_the_square_of_the_slenderness():
    one, other = (small_rotations.differences(Wall(0.4, 0.4 * h, hinge_ratio=0.5), 0.955, 0.5, 2) for h in (40, 80))
    np.testing.assert_allclose(one / other, 4, rtol=0.03)


def test_the_least_slenderness_is_where_the_difference_stays_below():
    h = np.array([4.0, 8.0, 16.0, 32.0])
    law = 4 / h**2  # within 5 % from sqrt(80) on, within 1 % from 20 on
    assert small_rotations.least_slenderness(h, law, 0.05) == pytest.approx(np.sqrt(80))
    assert small_rotations.least_slenderness(h, -law, 0.01) == pytest.approx(20)
    assert np.isnan(small_rotations.least_slenderness(h, law, 0.001))
    assert small_rotations.least_slenderness(h, law, 0.5) == 4
    back = np.array([0.001, 0.02, 0.005, 0.005])  # below once is not staying below
    assert 8 < small_rotations.least_slenderness(h, back, 0.01) < 16


def test_fig4_is_compared_with_both_references(config, looped):
    tau = looped["tau"].values
    histories = {"tri-linear": np.cos(tau), "slender": np.cos(1.02 * tau), "large rotation": 0.9 * np.cos(tau)}
    known = looped.copy(deep=True)
    for name, history in histories.items():
        known["rocking_displacement"].loc[{"rocking_model": name}] = history
    found = small_rotations.rotations(config, known)["fig4_difference"]
    np.testing.assert_allclose(found.sel(rocking_reference="slender"), [0.02, 0, 0], atol=1e-4)
    np.testing.assert_allclose(found.sel(rocking_reference="large rotation")[:2], [0, 1 / 0.9 - 1], atol=1e-4)
    wall = Wall(0.4, 4.0, hinge_ratio=0.5)
    ratio = 1 / (1 + small_rotations.frequency_difference(wall))
    assert float(found.sel(rocking_reference="large rotation", rocking_feature="p")) == pytest.approx(ratio - 1)


# --- the energy audit -----------------------------------------------------------------------------------------------

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
    if damping.model == "CR":
        wrong = Damping.cr(np.sqrt(1 - 1.02 * (1 - 0.85**2)))
    else:
        wrong = Damping(damping.model, 1.02 * damping.parameter)
    right, false = (exact_balance(damping, 0.0025, False, own) for own in (None, wrong))
    assert false.residual[-1] == pytest.approx(-0.02 * right.lost[-1], rel=0.02)


def test_impacts_take_the_energy_that_restitution_says():
    sums = exact_balance(Damping.cr(0.85), 0.0025, False)
    levels = np.unique(np.round(sums.lost, 4))
    first = float(CURVE.energy(0.6))
    np.testing.assert_allclose(levels, first * (1 - 0.85 ** (2 * np.arange(levels.size))), atol=1e-4)
    assert levels.size >= 4


def test_the_work_of_the_load_is_what_an_undamped_wall_gains():
    sums = exact_balance(Damping.cr(1.0), 0.0025, True)
    assert (sums.lost == 0).all()
    np.testing.assert_allclose(sums.work, sums.energy, atol=1e-5)


def test_the_residual_is_relative_to_the_most_energy_that_was_given():
    sums = energy_audit.Balance(np.array([2.0, 1.0, 0.5]), np.array([0.0, 1.1, 1.5]), np.array([0.0, 0.0, 3.0]))
    np.testing.assert_allclose(sums.residual, [0, -0.1, 3.0])
    assert float(sums.largest_residual) == pytest.approx(3.0 / 5.0)


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
        TrilinearCurve(**config["curve"]),
        Damping("SDR", float(one["damping_ratio"])),
        one["displacement"].values,
        one["velocity"].values,
        0.01,
    )
    assert float(stage["loops_energy_residual"].sel(damping_model="SDR")) == pytest.approx(sums.largest_residual)
    assert stage["study"].values.tolist() == list(STUDIES)
    # The solver's own residual, at this step, is at most that of the ensemble but for the longer histories.
    assert float(stage["decay_energy_residual"].max()) < 5e-3


def test_a_stored_decay_that_gains_energy_shows(config, looped):
    decayed = decay_study("amplitude", config)
    decayed["velocity"][1, 2, 300:] *= 1.05
    found = energy_audit.stored(config, looped, {"amplitude": decayed})
    assert float(found["decay_energy_residual"][0]) > 0.01


# --- joules ---------------------------------------------------------------------------------------------------------

SLENDER = Wall(0.3, 300.0, hinge_ratio=0.6, overburden_ratio=1.5, eccentricity=0.05)  # h/t = 1000


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


def test_the_release_holds_the_energy_of_the_curve_in_joules(stage, config):
    wall = make_wall(config["validation"]["wall"])
    energy = TrilinearCurve(**config["validation"]["curve"]).energy(0.5)
    expected = float(wall.rigid_strength * wall.instability_displacement * energy / 2)  # F0 = K0 u_ins
    assert float(stage["release_energy"].sel(audited_wall="Fig. 8")) == pytest.approx(expected)


def test_dampers_lose_what_leaves_from_peak_to_peak(stage, config, looped):
    wall, curve = make_wall(config["wall"]), TrilinearCurve(**config["curve"])
    for model in VISCOUS_MODELS:
        one = looped.sel(damping_model=model)
        at = turning_points(one["velocity"].values)[:7]
        left = -np.diff(energy_audit.joules(wall, curve.energy(one["displacement"].values[at])))
        lost = stage["energy_lost"].sel(audited_wall="reference", damping_model=model).values[: left.size]
        np.testing.assert_allclose(lost, left, atol=2e-3 * float(stage["release_energy"][0]))


def test_the_audited_walls_are_matched_as_the_loops_are(stage, looped):
    matched = stage["audited_damping_ratio"].sel(audited_wall="reference")
    np.testing.assert_array_equal(matched, looped["damping_ratio"])
    first = stage["energy_lost"].sum("half_cycle")
    for wall in first["audited_wall"].values:
        of_cr = float(first.sel(audited_wall=wall, damping_model="CR"))
        for model in VISCOUS_MODELS:  # over many half cycles matched decays lose alike
            assert float(first.sel(audited_wall=wall, damping_model=model)) == pytest.approx(of_cr, rel=0.1)


# --- the dataset and its figures ------------------------------------------------------------------------------------


def test_the_stage_returns_what_the_registry_says(stage):
    dataset.check(stage, "accuracy")
    assert {str(name) for name in stage.variables} == set(dataset.variables("accuracy", "slenderness"))


def test_fig_accuracy_shows_errors_orders_and_uncertainties(stage):
    figure = FIGURES["fig_accuracy"](stage)
    free, forced, shares, sample = figure.axes
    for axes, excitation in ((free, "free"), (forced, "forced")):
        for model in MODELS:
            one = stage.sel(excitation=excitation, damping_model=model)
            (line,) = (line for line in axes.get_lines() if str(line.get_label()).startswith(f"{model}:"))
            np.testing.assert_array_equal(line.get_ydata(), one["median_solver_error"])
            assert line.get_label() == f"{model}: {float(one['order']):.2f}"
            (marks,) = (line for line in axes.get_lines() if line.get_marker() == STYLES[model].marker)
            np.testing.assert_array_equal(marks.get_ydata(), one["largest_solver_error"])
    for model in VISCOUS_MODELS:
        one = stage.sel(viscous_model=model)
        (line,) = (line for line in shares.get_lines() if str(line.get_label()).startswith(f"{model}:"))
        np.testing.assert_array_equal(line.get_xdata(), one["uncertainty_quantile"])
        np.testing.assert_allclose(line.get_ydata(), 1 - one["quantile"])
        (marks,) = (line for line in sample.get_lines() if line.get_label() == model)
        np.testing.assert_allclose(marks.get_ydata(), np.clip(np.abs(one["sample_difference"]), 1e-6, None))


def test_fig_accuracy_does_not_round_a_share_up_to_all(stage):
    nearly = stage.copy(deep=True)
    nearly["share_within_thousandth"][:] = 0.9996
    legend = FIGURES["fig_accuracy"](nearly).axes[2].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"{model}: 99.9 %" for model in VISCOUS_MODELS]


def test_fig_rigid_shows_every_difference_with_1_and_5_percent(stage):
    figure = FIGURES["fig_rigid"](stage)
    (axes,) = figure.axes
    lines = axes.get_lines()
    assert sorted(line.get_ydata()[0] for line in lines if len(set(line.get_ydata())) == 1) == [0.01, 0.05]
    for feature in stage["rocking_feature"].values:
        values = np.abs(stage["rocking_difference"].sel(rocking_feature=feature).values[0, 0])
        assert any(np.array_equal(line.get_ydata(), values) for line in lines)
