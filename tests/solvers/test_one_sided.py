"""Both solvers of walls that rock to one side, by closed forms, by the two-sided solvers, and by each other."""

import numpy as np
import pytest
from scipy.optimize import brentq

import rockdamp as rd
from rockdamp.mechanics.one_sided import CONTACT_STEP, RIGID, OneSidedForce, Stop
from rockdamp.solvers import event_driven, one_sided_events, one_sided_march

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
FORCE = OneSidedForce(CURVE)
K1 = float(CURVE.initial_stiffness)


def tension_energy(force, stretch):
    """Return what a tie that is stretched once has taken."""
    at_yield = force.tie_strength / force.tie_stiffness
    if stretch <= at_yield:
        return force.tie_stiffness * max(stretch, 0.0) ** 2 / 2
    return force.tie_strength * (min(stretch, force.tie_rupture) - at_yield / 2)


def random_load(seed, samples=1500, size=1.0):
    load = np.random.default_rng(seed).normal(size=samples)
    return size * (load - load.mean())


@pytest.mark.nojit
@pytest.mark.parametrize("initial", [0.0, 0.6])
@pytest.mark.parametrize("e", [0.3, 0.7, 0.95])
def test_each_impact_leaves_the_square_of_restitution(initial, e):
    force = OneSidedForce(CURVE, initial)
    history = one_sided_events.history(force, Stop(RIGID, e), [8.0], release_amplitude=0.7)
    energy = force.energy([0.7, *history.of_kind("turn")[:, 1]])
    energy = energy[energy > 1e-9]
    assert len(energy) >= 3
    assert energy[1:] / energy[:-1] == pytest.approx(e**2, rel=1e-7)


@pytest.mark.nojit
def test_under_a_constant_push_the_bounces_are_a_geometric_series():
    e, v, push = 0.6, 0.05, -1.5
    force = OneSidedForce(CURVE, initial=float(CURVE.strength_ratio))  # the plateau from the stop on
    history = one_sided_events.history(
        force, Stop(RIGID, e), [5.0], release_velocity=v, load=[push, push], load_step=10.0
    )
    pull = float(CURVE.strength_ratio) - push
    impacts, rest = history.of_kind("impact"), history.of_kind("rest")
    first = 2 * v / pull
    ends = first * (1 - e ** np.arange(1, 11)) / (1 - e)
    assert impacts[:10, 0] == pytest.approx(ends, rel=1e-9)
    assert rest[0, 0] == pytest.approx(first / (1 - e), abs=2e-6)
    assert rest.shape == (1, 3)


@pytest.mark.nojit
def test_a_wall_at_rest_lifts_when_the_load_exceeds_what_holds_it():
    force = OneSidedForce(CURVE, initial=0.5)
    history = one_sided_events.history(force, Stop(RIGID, 0.5), [0.0, 0.4, 0.6], load=[0.0, 1.0], load_step=1.0)
    assert history.of_kind("lift")[0, 0] == pytest.approx(0.5, abs=1e-9)
    assert history.displacement[:2].tolist() == [0.0, 0.0]
    # x'' = t - 0.5 - k x on the first branch, to third order.
    assert history.displacement[2] == pytest.approx(0.1**3 / 6, rel=0.02)


@pytest.mark.nojit
@pytest.mark.parametrize("load", [0.2, 0.5, 0.7])
@pytest.mark.parametrize("solver", ["events", "march"])
def test_a_step_load_from_rest_goes_to_where_its_work_is_stored(load, solver):
    peak = brentq(lambda x: float(CURVE.energy(x)) - load * x, 1e-6, 0.3)
    if solver == "events":
        found = one_sided_events.history(FORCE, Stop(RIGID, 0.5), [1.5], load=[load, load], load_step=9.0)
        assert found.of_kind("turn")[0, 1] == pytest.approx(peak, rel=1e-12)
        return
    step = 1e-3
    options = {"step": step, "steps": 1500, "substeps": 1500, "ground_acceleration": [load, load], "load_factor": 1.0}
    assert one_sided_march.solve(FORCE, Stop(1e4, 0.5), **options).peak == pytest.approx(peak, rel=2e-5)


@pytest.mark.nojit
@pytest.mark.parametrize(("gap", "rupture"), [(0.0, RIGID), (0.01, RIGID), (0.01, 0.03)])
def test_a_tie_takes_its_part_of_the_energy(gap, rupture):
    force = OneSidedForce(CURVE, 0.2, tie_stiffness=50.0, tie_strength=0.4, tie_gap=gap, tie_rupture=rupture)
    v = 0.4
    history = one_sided_events.history(force, Stop(RIGID, 0.5), [1.3], release_velocity=v)
    peak = history.of_kind("turn")[0, 1]
    assert peak - gap > 0.008  # it yields
    assert float(force.energy(peak)) + tension_energy(force, peak - gap) == pytest.approx(v**2 / 2, abs=1e-13)
    # Back at the stop it has what the curve and the tie's elastic part gave back.
    back = history.of_kind("impact")[0, 2]
    elastic = 0.0 if peak - gap > rupture else 0.4**2 / (2 * 50.0)
    assert back**2 / 2 == pytest.approx(float(force.energy(peak)) + elastic, abs=1e-13)


def test_the_set_of_a_tie_stays():
    force = OneSidedForce(CURVE, tie_stiffness=50.0, tie_strength=0.4)
    first = one_sided_events.history(force, Stop(RIGID, 1.0), [6.0], release_velocity=0.4).of_kind("turn")[:2, 1]
    # The second time it pulls from the set on, and stores no more than it did: without loss at the stop the wall comes
    # to the same place again.
    assert first[1] == pytest.approx(first[0], abs=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("gap", [0.0, 1e-9])
def test_a_tie_without_slack_that_stays_elastic_leaves_the_impact_its_restitution(gap):
    stated = {"tie_gap": gap} if gap else {}  # without one there is no slack
    force = OneSidedForce(CURVE, 0.2, tie_stiffness=50.0, tie_strength=5.0, **stated)
    history = one_sided_events.history(force, Stop(RIGID, 0.5), [1.5], release_velocity=0.3)
    impacts, peaks = history.of_kind("impact"), history.of_kind("turn")[:, 1]
    assert impacts[:, 2] == pytest.approx(-0.3 * 0.5 ** np.arange(len(impacts)), rel=1e-9)
    energy = force.energy(peaks) + force.tie_stiffness * peaks**2 / 2
    assert energy[1:] / energy[:-1] == pytest.approx(0.25, rel=1e-6)
    assert len(peaks) == len(impacts) + 1 == 6


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_in_free_decay_it_is_the_mirrored_two_sided_motion(e):
    times = np.linspace(0, 15, 500)
    one = one_sided_events.history(FORCE, Stop(RIGID, e), times, release_amplitude=0.6)
    two = event_driven.history(CURVE, rd.Damping.cr(e), times, release_amplitude=0.6)
    assert one.displacement == pytest.approx(np.abs(two.displacement), abs=1e-8)
    stepped = rd.solve(CURVE, rd.Damping.cr(e), release_amplitude=0.6, step=0.001, steps=15000, store_every=1)
    mirrored = np.interp(times, 0.001 * np.arange(15001), np.abs(stepped.displacement))
    assert one.displacement == pytest.approx(mirrored, abs=2e-4)  # other code, of second order


def test_a_stop_like_the_wall_is_the_two_sided_motion():
    times = np.linspace(0, 6, 100)
    load = 0.1 * np.sin(3 * np.arange(61) * 0.1)  # the wall stays on its first branch
    options = {"load": load, "load_step": 0.1}
    two = event_driven.history(CURVE, rd.Damping.cr(1.0), times, **options)
    spring = Stop(K1, 1.0)
    assert np.abs(two.displacement).max() < 0.04
    one = one_sided_events.history(FORCE, spring, times, **options)
    assert one.displacement == pytest.approx(two.displacement, abs=1e-12)
    stepped = one_sided_march.solve(
        FORCE, spring, step=0.001, steps=6000, substeps=100, ground_acceleration=load, load_factor=1.0, store_every=1
    )
    assert np.interp(times, 0.001 * np.arange(6001), stepped.displacement) == pytest.approx(two.displacement, abs=1e-5)


@pytest.mark.parametrize("pulls", [True, False])
def test_both_solvers_agree_on_a_stop_that_gives_way(pulls):
    force = OneSidedForce(CURVE, 0.3, tie_stiffness=50.0, tie_strength=0.4, tie_gap=0.01, tie_rupture=0.1)
    stop, dt = Stop(1e4, 0.5, pulls), 0.05
    load = 0.7 * np.sin(0.3 * np.arange(161))
    times = dt * np.arange(160)
    exact = one_sided_events.history(force, stop, times, release_velocity=0.3, load=load, load_step=dt)
    errors = []
    for substeps in (50, 3200):
        stepped = one_sided_march.solve(
            force,
            stop,
            step=dt / substeps,
            steps=159 * substeps,
            substeps=substeps,
            release_velocity=0.3,
            load_factor=1.0,
            ground_acceleration=load,
            store_every=substeps,
        )
        errors.append(np.abs(stepped.displacement - exact.displacement).max())
    assert np.nanmax(exact.displacement) > 0.05
    assert errors[0] < 0.02
    assert errors[1] < 1e-4


@pytest.mark.nojit
@pytest.mark.parametrize("frequency", [1.95, 2.2])  # times the step of the load
@pytest.mark.parametrize("stiffness", [2 * K1, 7 * K1])
def test_a_soft_stop_that_cannot_pull_parts_and_is_met_again_between_two_samples(stiffness, frequency):
    force, stop, dt, substeps = OneSidedForce(CURVE, 0.8), Stop(stiffness, 0.1), 0.1, 1000
    load = 2 * np.sin(frequency * np.arange(40))
    exact = one_sided_events.history(force, stop, dt * np.arange(40), load=load, load_step=dt)
    run = {"step": dt / substeps, "steps": 39 * substeps, "substeps": substeps, "store_every": substeps}
    stepped = one_sided_march.solve(force, stop, load_factor=1.0, ground_acceleration=load, **run)
    assert np.min(exact.displacement) < -0.005
    assert exact.displacement == pytest.approx(stepped.displacement, abs=2e-5)


@pytest.mark.nojit
def test_a_stiff_stop_tends_to_restitution():
    times = np.linspace(0, 4, 200)
    rigid = one_sided_events.history(FORCE, Stop(RIGID, 0.5), times, release_amplitude=0.5).displacement
    stiffness = np.array([1e4, 1e6])
    far = [
        np.abs(one_sided_events.history(FORCE, Stop(kc, 0.5), times, release_amplitude=0.5).displacement - rigid).max()
        for kc in stiffness
    ]
    assert far[1] < 0.2 * far[0]  # the time in contact goes with 1/sqrt(kc)
    assert far[1] < 5e-3


def test_a_stop_takes_its_restitution_by_the_stepper():
    kc = 2500 * K1
    e = np.array([0.3, 0.5, 0.7])
    step = CONTACT_STEP / np.sqrt(kc)
    steps = int(2.2 / step)
    for pulls in (True, False):
        stepped = one_sided_march.solve(
            FORCE, Stop(kc, e, pulls), step=step, steps=steps, release_amplitude=0.3, store_every=1
        )
        at_impact = np.argmax(stepped.displacement < 0, axis=1)
        peak = [x[at:].max() for x, at in zip(stepped.displacement, at_impact, strict=True)]
        assert np.sqrt(CURVE.energy(peak) / CURVE.energy(0.3)) == pytest.approx(e, abs=0.012)


@pytest.mark.parametrize("pulls", [True, False])
def test_under_noise_the_stepper_finds_the_same_collapses_and_peaks(pulls):
    load, dt = random_load(3, size=3.0), 0.05
    factor, kc = np.linspace(0.2, 3.0, 40), 400 * K1
    stop = Stop(kc, np.array([0.3, 0.6])[:, None], pulls)
    substeps = int(np.ceil(dt * np.sqrt(kc) / CONTACT_STEP))
    exact = one_sided_events.ends(
        FORCE, stop, load_factor=factor, ground_acceleration=load, sampling=dt, duration=dt * (load.size - 1)
    )
    stepped = one_sided_march.solve(
        FORCE,
        stop,
        step=dt / substeps,
        steps=substeps * (load.size - 1),
        substeps=substeps,
        load_factor=factor,
        ground_acceleration=load,
    )
    assert 0 < exact.outcome.sum() < exact.outcome.size
    assert (exact.outcome != stepped.outcome).mean() < 0.05
    both = (exact.outcome == 0) & (stepped.outcome == 0)
    assert np.median(np.log(stepped.peak / exact.peak)[both]) == pytest.approx(0, abs=0.01)


def test_intervals_taken_whole_are_those_taken_in_two():
    """With an elastic tie up to the plateau: an interval that holds a time asked for is no whole one."""
    force, dt, noise = (
        OneSidedForce(CURVE, tie_stiffness=5.0, tie_strength=50.0, tie_gap=0.02),
        0.02,
        random_load(1, 500),
    )
    run = {"load": 1.5 * np.sin(1.7 * dt * np.arange(500)) + 0.2 * noise, "load_step": dt}
    end = 499 * dt
    whole, halved = (
        one_sided_events.history(force, Stop(RIGID, 0.6), [*inside, end], **run)
        for inside in ([], dt * (np.arange(499) + 0.5))
    )
    assert halved.displacement.max() > 0.15 and len(whole.of_kind("impact")) > 5
    assert whole.displacement[0] == pytest.approx(halved.displacement[-1], rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_intervals_taken_whole_after_an_impact_are_those_of_dense_times(seed):
    """What is left of an interval after an event is none: a time asked for in each interval has them all in parts."""
    random, dt, samples = np.random.default_rng(seed), 0.03, 300
    sine = random.uniform(0.5, 1.5) * np.sin(random.uniform(0.5, 4) * dt * np.arange(samples))
    run = {"load": sine + 0.3 * random.normal(size=samples), "load_step": dt}
    stop, end = Stop(1e3, random.uniform(0.3, 0.9)), (samples - 1) * dt
    force = OneSidedForce(CURVE, tie_stiffness=5.0, tie_strength=random.uniform(0.2, 2), tie_gap=0.02)
    few, dense = (
        one_sided_events.history(force, stop, [*inside, end], **run)
        for inside in ([], dt * (np.arange(samples - 1) + 0.5))
    )
    assert len(few.of_kind("impact")) == len(dense.of_kind("impact")) > 0
    np.testing.assert_allclose(few.of_kind("turn")[:, 1], dense.of_kind("turn")[:, 1], atol=1e-9)


def test_a_lane_has_its_bits_whatever_runs_beside_it():
    load = random_load(5, 300)
    run = {"step": 1e-3, "steps": 3000, "substeps": 10, "ground_acceleration": load}
    factor = np.linspace(0.5, 2.0, 130)
    together = one_sided_march.solve(FORCE, Stop(1e4, 0.5), load_factor=factor, **run)
    alone = [
        one_sided_march.solve(FORCE, Stop(1e4, 0.5), load_factor=each, **run).peak for each in factor[[0, 70, 129]]
    ]
    assert together.peak[[0, 70, 129]].tolist() == np.array(alone).tolist()
    threaded = one_sided_march.solve(FORCE, Stop(1e4, 0.5), load_factor=factor, threads=2, **run)
    assert threaded.peak.tolist() == together.peak.tolist()


@pytest.mark.nojit
def test_collapse_ends_a_history():
    history = one_sided_events.history(FORCE, Stop(RIGID, 0.5), np.linspace(0, 10, 50), load=[2.0, 2.0], load_step=20.0)
    assert history.outcome == "collapsed"
    assert np.isnan(history.displacement[-1])
    assert np.nanmax(history.displacement) <= 1.0


@pytest.mark.nojit
def test_the_stepper_starts_with_what_the_forces_say_and_stores_nothing_of_a_collapsed_lane():
    """A tie that yields at the start pulls with its strength; beside the lane that moves on another one collapses."""
    force = OneSidedForce(CURVE, tie_stiffness=50.0, tie_strength=0.2)
    run = {
        "step": 0.01,
        "steps": 300,
        "release_amplitude": [0.3, 0.9],
        "release_velocity": [0.0, 2.0],
        "store_every": 1,
    }
    stepped = one_sided_march.solve(force, Stop(1e4, 0.5), **run)
    assert stepped.displacement[0, 1] == pytest.approx(0.3 - 0.01**2 / 2 * (float(CURVE.force(0.3)) + 0.2), rel=1e-12)
    assert stepped.outcome.tolist() == [0, 1]
    last = round(float(stepped.outcome_tau[1]) / 0.01)
    assert np.isfinite(stepped.displacement[0]).all() and np.isnan(stepped.displacement[1, last + 1 :]).all()


def test_bad_input_is_refused():
    with pytest.raises(rd.InputError, match="the stepper has no rigid stop"):
        one_sided_march.solve(FORCE, Stop(RIGID, 0.5), step=1e-3, steps=10)
    with pytest.raises(rd.InputError, match=r"step times sqrt\(kc\) is 2.0; it must be at most 1"):
        one_sided_march.solve(FORCE, Stop(1e4, 0.5), step=0.02, steps=10)
    with pytest.raises(rd.InputError, match="release_amplitude is 1.5; it must be less than a3"):
        one_sided_events.history(FORCE, Stop(RIGID, 0.5), [1.0], release_amplitude=1.5)
    with pytest.raises(rd.InputError, match=r"release_amplitude is -0.1; it must be .* at least 0 at a rigid stop"):
        one_sided_events.history(FORCE, Stop(RIGID, 0.5), [1.0], release_amplitude=-0.1)
