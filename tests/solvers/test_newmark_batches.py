"""What a batch of runs reports: outcomes, peaks, Eq. (17), the same bits beside any other lanes, and bad input."""

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import available_threads, solve, stable_step
from rockdamp.solvers.response import (
    ComparedHistories,
    Comparison,
    Histories,
    Reference,
    Response,
)
from rockdamp.vocabulary import MODELS, OUTCOMES, VISCOUS_MODELS

CURVE = TrilinearCurve(0.04, 0.85)  # the wall of Fig. 5
GROUND = np.random.default_rng(11).normal(size=81)


# --- outcomes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("scheme", ["newmark", "paper"])
@pytest.mark.parametrize("model", MODELS)
def test_a_collapse_is_reported_with_its_time_and_ends_the_history(model, scheme, sign):
    damping = Damping(model, 0.9 if model == "CR" else 0.02)
    start = {"release_amplitude": sign * 0.5, "release_velocity": sign * 0.9}
    exact = exact_history(CURVE, damping, [4.0], **start)
    step = 1e-3
    response = solve(
        CURVE,
        damping,
        release_amplitude=[sign * 0.5, 0.5],
        release_velocity=[sign * 0.9, 0.0],
        step=step,
        steps=4000,
        store_every=1,
        scheme=scheme,
        reference=Reference(np.zeros((1, 4001)), 0, [10, 4000]),
    )
    assert [OUTCOMES[code] for code in response.outcome] == ["collapsed", "completed"] and exact.collapsed
    # The first step beyond a3, as the scheme is much more accurate than its step here.
    assert 0 < response.outcome_tau[0] - exact.end_tau < 2 * step
    assert response.outcome_tau[1] == pytest.approx(4.0, rel=1e-12)
    assert response.peak[0] == pytest.approx(1.0, abs=2e-3) and response.peak[0] > 1
    assert response.peak_tau[0] == response.outcome_tau[0]
    last = round(response.outcome_tau[0] / step)
    for stored in (response.displacement, response.velocity):
        assert np.all(np.isfinite(stored[0, :last]))
        assert np.all(np.isnan(stored[0, last:]))
        assert np.all(np.isfinite(stored[1]))
    assert np.all(np.abs(response.displacement[0, :last]) <= 1)
    assert np.all(np.isinf(response.error[:, 0])) and np.all(np.isfinite(response.error[:, 1]))


def test_a_start_at_rest_at_zero_is_no_impact_and_stays_there():
    response = solve(CURVE, Damping.cr(0.8), step=0.01, steps=50, store_every=1)
    assert response.impacts == 0 and response.peak == 0 and response.peak_tau == 0
    np.testing.assert_array_equal(response.displacement, 0.0)
    kicked = solve(CURVE, Damping.cr(0.8), release_velocity=0.1, step=0.01, steps=2, store_every=1)
    assert kicked.impacts == 0
    assert kicked.displacement[1] == pytest.approx(1e-3, rel=1e-12)  # e does not act on the release


def test_an_impact_exactly_at_the_end_of_a_step_is_one_impact():
    # All numbers are exact in binary: the load balances the force, so x0 + v0 step = 0 without rounding.
    curve = TrilinearCurve(1 / 16, 1 / 2)
    step, x0, v0 = 1 / 32, 1 / 64, -1 / 2
    load = float(curve.force(x0))
    response = solve(
        curve,
        Damping.cr(0.5),
        release_amplitude=x0,
        release_velocity=v0,
        load_factor=load,
        ground_acceleration=np.ones(5),
        step=step,
        steps=4,
        store_every=1,
    )
    assert response.displacement[1] == 0
    # The force fell from balance to nothing over the step: the mean acceleration is half of the load.
    assert response.velocity[1] == 0.5 * (v0 + step * load / 2)
    assert response.impacts == 1
    assert response.displacement[2] == step * (response.velocity[1] + step * load / 2)


def test_each_lane_may_have_its_own_step():
    steps = np.array([0.01, 0.02, 0.005])
    given = {"release_amplitude": 0.5, "steps": 300, "store_every": 100}
    together = solve(CURVE, Damping("SDR", 0.1), step=steps, **given)
    np.testing.assert_allclose(together.outcome_tau, 300 * steps, rtol=1e-15)
    for lane, step in enumerate(steps):
        alone = solve(CURVE, Damping("SDR", 0.1), step=step, **given)
        np.testing.assert_array_equal(together.displacement[lane], alone.displacement)
        assert together.peak_tau[lane] == alone.peak_tau


def test_thinned_histories_are_every_nth_of_the_full_ones():
    full, thin = (
        solve(CURVE, Damping("CDR", 0.05), release_amplitude=[0.3, 0.6], step=0.01, steps=400, store_every=n)
        for n in (1, 7)
    )
    assert thin.displacement.shape == (2, 58)
    np.testing.assert_array_equal(thin.displacement, full.displacement[:, ::7])
    np.testing.assert_array_equal(thin.velocity, full.velocity[:, ::7])


def test_the_batch_has_the_shape_that_the_arguments_broadcast_to():
    response = solve(
        TrilinearCurve(np.array([0.03, 0.05])[:, None, None], 0.8),
        Damping("CDR", np.array([0.02, 0.05, 0.1])[:, None]),
        release_amplitude=np.array([0.2, 0.3, 0.4, 0.5]),
        step=0.01,
        steps=30,
        store_every=10,
    )
    assert response.outcome.shape == response.peak.shape == response.impacts.shape == (2, 3, 4)
    assert response.displacement.shape == (2, 3, 4, 4)
    alone = solve(
        TrilinearCurve(0.05, 0.8), Damping("CDR", 0.1), release_amplitude=0.4, step=0.01, steps=30, store_every=10
    )
    assert alone.peak.shape == ()
    np.testing.assert_array_equal(response.displacement[1, 2, 2], alone.displacement)
    none = solve(CURVE, Damping.cr(0.9), release_amplitude=np.empty(0), step=0.01, steps=3, store_every=1)
    assert none.displacement.shape == (0, 4)


@pytest.mark.parametrize("model", ["CR", "CDC", "BAND"])
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_load_of_several_motions_is_their_sum_each_times_the_lanes_factor(model, substeps):
    """Two blocks, the second one not full."""
    motions = np.random.default_rng(5).normal(size=(3, 81))
    factors = np.random.default_rng(6).normal(size=(3, 70)) * [[0.3], [0.1], [0.05]]
    damping = Damping(model, 0.8 if model == "CR" else 0.05)
    run = {"step": 0.04 / substeps, "steps": 80 * substeps, "substeps": substeps, "store_every": 1}
    together = solve(CURVE, damping, load_factor=factors, ground_acceleration=motions, **run).displacement
    for lane in (0, 5, 69):
        alone = solve(CURVE, damping, load_factor=1.0, ground_acceleration=factors[:, lane] @ motions, **run)
        np.testing.assert_allclose(together[lane], alone.displacement, atol=1e-12)
    assert np.ptp(together[:, -1]) > 1e-3


# --- Eq. (17) ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_the_error_is_eq_17_summed_from_stored_histories_at_every_checkpoint(model):
    run = {"step": 0.01, "steps": 1500, "store_every": 1}
    releases = np.array([0.3, 0.6])
    decays = solve(CURVE, Damping.cr(0.85), release_amplitude=releases, **run).displacement
    checkpoints, case = [1, 40, 999, 1500], np.array([[0], [1]])
    ratios = np.linspace(0.01, 0.2, 40)
    given = {"release_amplitude": releases[:, None], **run}
    response = solve(CURVE, Damping(model, ratios), reference=Reference(decays, case, checkpoints), **given)
    assert response.error.shape == (4, 2, 40)
    terms = (np.abs(decays[:, None, 1:]) - np.abs(response.displacement[..., 1:])) ** 2
    expected = np.cumsum(terms, axis=-1)[..., np.array(checkpoints) - 1]
    np.testing.assert_allclose(np.moveaxis(response.error, 0, -1), expected, rtol=1e-12, atol=1e-30)


def test_comparing_and_storing_change_no_result():
    run = {"release_amplitude": [0.3, 0.6], "step": 0.01, "steps": 700}
    plain = solve(CURVE, Damping("SDR", 0.1), **run)
    busy = solve(CURVE, Damping("SDR", 0.1), store_every=3, reference=Reference(np.zeros((1, 701)), 0, [5, 700]), **run)
    assert type(plain) is Response and type(busy) is ComparedHistories
    assert type(solve(CURVE, Damping("SDR", 0.1), store_every=3, **run)) is Histories
    assert type(solve(CURVE, Damping("SDR", 0.1), reference=Reference(np.zeros((1, 701)), 0, [5]), **run)) is Comparison
    for name in ("outcome", "outcome_tau", "peak", "peak_tau", "impacts"):
        np.testing.assert_array_equal(getattr(busy, name), getattr(plain, name))


# --- determinism ------------------------------------------------------------------------------------------------------


def seventy_lanes(model, lanes, threads, scheme):
    """Solve some of 70 different walls under a load, and return everything that a response holds."""
    rng = np.random.default_rng(3)
    a1, b1, x0, v0, factor, unit, _ = rng.uniform(
        [0.02, 0.5, -0.8, -0.8, 0.0, 0.0, 0.0], [0.12, 0.85, 0.8, 0.8, 0.1, 1.0, 3.0], (70, 7)
    )[lanes].T
    # The first lane's xi is 0, so that alone it is a block without a damper.
    parameter = 0.7 + 0.3 * unit if model == "CR" else 0.2 * unit * (lanes > 0)
    response = solve(
        TrilinearCurve(a1, b1),
        Damping.from_values(model, restitution=parameter, damping_ratio=parameter),
        release_amplitude=x0,
        release_velocity=v0,
        load_factor=factor,
        ground_acceleration=GROUND,
        substeps=4,
        step=0.02,
        steps=320,
        store_every=1,
        reference=Reference(np.zeros((1, 321)), 0, [100, 320]),
        threads=threads,
        scheme=scheme,
    )
    return [
        response.displacement,
        response.velocity,
        response.error.T,
        response.peak,
        response.peak_tau,
        response.outcome,
        response.outcome_tau,
        response.impacts,
    ]


@pytest.mark.parametrize(("model", "scheme"), [(m, s) for m in MODELS for s in ("newmark", "paper")])
def test_a_lane_s_result_does_not_depend_on_the_lanes_beside_it_nor_on_the_threads(model, scheme):
    everything = seventy_lanes(model, np.arange(70), 1, scheme)
    assert 0 < everything[5].sum() < 70  # some collapse, some do not
    order = np.random.default_rng(4).permutation(70)
    batches = [np.arange(count) for count in range(1, 70)] + [order, order[::-1], np.array([69]), order[:33]]
    for lanes in batches:
        for found, expected in zip(seventy_lanes(model, lanes, 1, scheme), everything, strict=True):
            np.testing.assert_array_equal(found, expected[lanes])
    for threads in (2, None):
        for found, expected in zip(seventy_lanes(model, np.arange(70), threads, scheme), everything, strict=True):
            np.testing.assert_array_equal(found, expected)


def test_the_number_of_threads_is_numba_s_variable_or_the_processors_of_the_process(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert available_threads() == 3
    monkeypatch.delenv("NUMBA_NUM_THREADS")
    assert available_threads() >= 1


# --- bad input --------------------------------------------------------------------------------------------------------

RUN = {"step": 0.01, "steps": 100, "release_amplitude": 0.5}
STILL = np.zeros((2, 101))
BAD = [
    ({"step": 0.0}, r"step is 0\.0; it must be greater than 0"),
    ({"step": 0.44}, r"step is 0\.44; it must be less than the stability limit .* = 0\.43386"),
    ({"steps": 0}, r"steps is 0; it must be .*at least 1"),
    ({"release_amplitude": [0.1, -1.5]}, r"release_amplitude is -1\.5; it must be less than a3"),
    ({"ground_acceleration": [0.0, np.nan]}, r"ground_acceleration is nan; it must be a finite number"),
    ({"ground_acceleration": np.zeros(100)}, r"steps is 100; it must be at most 99, the record's length"),
    ({"ground_acceleration": np.zeros((200, 1))}, r"at most 0, .*ground_acceleration has shape \(200, 1\)"),
    (
        {"ground_acceleration": np.zeros((2, 0)), "load_factor": [1.0, 1.0]},
        r"number of samples of several motions is 0; it must be at least 1",
    ),
    ({"ground_acceleration": np.zeros((2, 200))}, r"first axis of load_factor is 1; it must be 2, a factor on each"),
    (
        {"ground_acceleration": np.zeros((2, 200)), "load_factor": [1.0, 1.0], "scheme": "paper"},
        r"number of motions is 2; it must be 1 by the scheme 'paper'",
    ),
    ({"scheme": "explicit"}, r"scheme is 'explicit'; it must be one of newmark, paper"),
    ({"reference": Reference(STILL[:, :100], 0, [50])}, r"the reference has 99 steps; it must have at least 100"),
    ({"reference": Reference(STILL * np.nan, 0, [50])}, r"reference.* is nan; it must be a finite number"),
    ({"reference": Reference(STILL, 2, [50])}, r"case is 2; it must be a row of the reference"),
    ({"reference": Reference(STILL, 0, [50, 50])}, r"checkpoints is 50; it must be ascending"),
    ({"reference": Reference(STILL, 0, [0, 50])}, r"checkpoints is 0; it must be within 1 to 100 steps"),
]


@pytest.mark.parametrize(("change", "message"), BAD, ids=[message.split(";")[0] for _, message in BAD])
def test_a_bad_run_is_refused_with_the_name_the_value_and_what_is_allowed(change, message):
    with pytest.raises(InputError, match=message):
        solve(CURVE, Damping("CDR", 0.05), **{**RUN, **change})


def test_the_stability_limit_is_2_over_the_first_branch_s_frequency_for_each_wall():
    curves = TrilinearCurve(np.array([0.02, 0.2]), 0.5)
    np.testing.assert_allclose(stable_step(curves), 2 * np.sqrt(np.array([0.02, 0.2]) / 0.5), rtol=1e-15)
    with pytest.raises(InputError, match="stability limit"):
        solve(curves, Damping("CDC", 0.0), step=0.5, steps=10)  # fine for the second wall only
