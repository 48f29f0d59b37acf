"""Batches: collapses, peaks, Eq. (17), the same bits beside any other lanes, and bad input."""

import signal
import subprocess
import sys
import time
from dataclasses import fields

import numpy as np
import pytest

from rockdamp.constants import MODELS
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import blocks
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import SCHEMES, Load, Reference, peaks, simulate, stable_step

CURVE = TrilinearCurve(0.04, 0.85)  # the wall of Fig. 5
LANES = 150  # three blocks, the last one not full
CURVES = TrilinearCurve(np.linspace(0.03, 0.12, LANES), np.linspace(0.85, 0.6, LANES), 0.95)
SIZES = np.linspace(0.01, 0.15, LANES)


def make_viscous(model, **parameters):
    return lambda size: Damping(model, size, **parameters)


def make_restitution(size):
    return Damping("CR", 1 - 2 * size)


def make_restitution_law(size):
    return Damping("CR", 1 - 2 * size, loss_exponent=np.where(size > 0.05, 0.2, 0.0))


MAKERS = {"CR": make_restitution, "CR, law": make_restitution_law}
MAKERS |= {model: make_viscous(model) for model in (*MODELS[1:], "CQD")}
MAKERS |= {f"ECD{order:g}": make_viscous("ECD", order=order) for order in (2.5, 8, 16)}
MAKERS |= {"ECD, law": make_viscous("ECD", order=4, loss_exponent=0.1)}
every_damper = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)

# The strongest shaking comes last.
ENVELOPE = np.concatenate([np.full(150, 0.2), np.full(300, 0.02), np.full(151, 1.0)])
NOISE = np.random.default_rng(3).normal(size=630)
GROUND = ENVELOPE * np.convolve(NOISE, np.ones(30) / 6, "valid")
STRENGTH = np.random.default_rng(5).permutation(np.geomspace(0.02, 4.0, LANES))
RUNS = {
    "free": {
        "release_amplitude": np.random.default_rng(6).uniform(-0.9, 0.9, LANES),
        "release_velocity": 0.4 * STRENGTH,
        "step": 0.02,
        "steps": 1800,
    },
    "record": {"load": Load(GROUND, STRENGTH, 0.06, 3)},
    "two motions": {
        "load": Load(np.stack([GROUND, GROUND[::-1]]), np.stack([STRENGTH, STRENGTH / 3]), 0.06, 3)
    },
}


def assert_same(result, expected, lanes=slice(None)):
    for field in fields(result):
        values = getattr(result, field.name)
        if values is not None:
            others = getattr(expected, field.name)
            others = others[:, lanes] if field.name == "error" else others[lanes]
            np.testing.assert_array_equal(values, others)


# --- peaks ----------------------------------------------------------------------------------------


@every_scheme
@every_damper
def test_peaks_are_those_of_the_histories_to_the_bit(make, scheme):
    """Walls that stay on the first branch, rock, come near to collapse and fall: many of each."""
    for name, options in RUNS.items():
        full = simulate(CURVES, make(SIZES), store_every=600, scheme=scheme, **options)
        result = peaks(CURVES, make(SIZES), scheme=scheme, **options)
        assert 5 < full.collapsed.sum() < LANES - 20, name
        np.testing.assert_array_equal(result.collapsed, full.collapsed, name)
        np.testing.assert_array_equal(result.peak, np.where(full.collapsed, 0.95, full.peak), name)


@pytest.mark.parametrize(
    "damping",
    [Damping("CR", 1.0), Damping("CDC", 0.001), Damping("ECD", 1e-4, order=16)],
    ids=["CR", "CDC", "ECD16"],
)
@pytest.mark.parametrize("share", [0.02, 0.05, 0.3])
def test_no_lane_leaves_early_at_coarse_steps(share, damping):
    """Lanes may leave up to a twentieth of the limit, where the scheme changes the energy most."""
    curve = TrilinearCurve(0.05, 0.7)
    step = share * float(stable_step(curve))
    options = {"step": step, "steps": 4000, "release_velocity": np.linspace(0.01, 1.1, 40)}
    full = simulate(curve, damping, store_every=4000, **options)
    result = peaks(curve, damping, **options)
    np.testing.assert_array_equal(result.peak, np.where(full.collapsed, 1.0, full.peak))


@every_damper
def test_error_is_eq_17_of_stored_histories(make):
    options = {"step": 0.01, "steps": 1500, "release_amplitude": np.array([0.3, 0.6])[:, None]}
    checkpoints = np.array([1, 128, 999, 1500])
    damping = make(np.linspace(0.01, 0.15, 40))
    decays = simulate(CURVE, Damping("CR", 0.85), **options).displacement[:, 0]
    reference = Reference(decays, np.array([[0], [1]]), checkpoints)
    error = peaks(CURVE, damping, reference=reference, **options).error
    x = simulate(CURVE, damping, **options).displacement
    difference = np.abs(decays[:, None, 1:]) - np.abs(x[..., 1:])
    sums = np.cumsum(difference**2, axis=-1)[..., checkpoints - 1]
    np.testing.assert_allclose(np.moveaxis(error, 0, -1), sums, rtol=1e-12, atol=1e-30)


# --- histories ------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1, -1])
@every_scheme
@pytest.mark.parametrize("model", MODELS)
def test_collapse_ends_the_history_at_its_time(model, scheme, sign):
    damping = Damping(model, 0.9 if model == "CR" else 0.02)
    step = 1e-3
    exact = exact_history(
        CURVE, damping, [4.0], release_amplitude=sign * 0.5, release_velocity=sign * 0.9
    )
    start = {"release_amplitude": [sign * 0.5, 0.5], "release_velocity": [sign * 0.9, 0.0]}
    history = simulate(CURVE, damping, step=step, steps=4000, scheme=scheme, **start)
    assert history.collapsed.tolist() == [True, False]
    # The first step beyond a3, as the scheme is much more accurate than its step here.
    assert 0 < history.end_tau[0] - exact.end_tau < 2 * step
    assert history.end_tau[1] == pytest.approx(4.0, rel=1e-12)
    assert 1 < history.peak[0] < 1.002
    assert history.peak_tau[0] == history.end_tau[0]
    end = round(history.end_tau[0] / step)
    for stored in (history.displacement, history.velocity):
        assert np.isfinite(stored[0, :end]).all()
        assert np.isnan(stored[0, end:]).all()
        assert np.isfinite(stored[1]).all()


def test_rest_is_kept_without_an_impact():
    history = simulate(CURVE, Damping("CR", 0.8), step=0.01, steps=50)
    assert history.impacts == history.peak == history.peak_tau == 0
    assert not history.displacement.any()


def test_release_from_zero_is_no_impact():
    history = simulate(CURVE, Damping("CR", 0.8), release_velocity=0.1, step=0.01, steps=2)
    assert history.impacts == 0
    assert history.displacement[1] == pytest.approx(1e-3, rel=1e-12)


def test_crossing_at_the_end_of_a_step_is_an_impact():
    """All numbers are exact in binary: the load balances the force, so x0 + v0 step = 0."""
    curve = TrilinearCurve(1 / 16, 1 / 2)
    step, x0, v0 = 1 / 32, 1 / 64, -1 / 2
    balance = float(curve.force(x0))
    load = Load(np.ones(5), balance, step)
    damping = Damping("CR", 0.5)
    history = simulate(curve, damping, load=load, release_amplitude=x0, release_velocity=v0)
    assert history.displacement[1] == 0
    assert history.impacts == 1
    # The force fell from balance to nothing over the step: the mean acceleration is half the load.
    assert history.velocity[1] == 0.5 * (v0 + step * balance / 2)
    assert history.displacement[2] == step * (history.velocity[1] + step * balance / 2)


BROADCAST = {
    "curve": TrilinearCurve(np.array([0.03, 0.05])[:, None, None], 0.8),
    "damping": Damping("CDR", [[0.02], [0.05], [0.1]]),
    "release_amplitude": np.array([0.2, 0.3, 0.4, 0.5]),
    "step": np.array([0.01, 0.02, 0.005, 0.01]),
    "steps": 400,
}


def test_inputs_broadcast():
    history = simulate(**BROADCAST)
    assert history.peak.shape == (2, 3, 4)
    alone = simulate(
        TrilinearCurve(0.05, 0.8), Damping("CDR", 0.1), release_amplitude=0.4, step=0.005, steps=400
    )
    lane = type(history)(*(getattr(history, field.name)[1, 2, 2] for field in fields(history)))
    assert_same(alone, lane, ...)


def test_thinned_histories_are_every_nth_state():
    full = simulate(**BROADCAST)
    thin = simulate(**BROADCAST, store_every=7)
    assert thin.displacement.shape == (2, 3, 4, 58)
    np.testing.assert_array_equal(thin.displacement, full.displacement[..., ::7])
    np.testing.assert_array_equal(thin.velocity, full.velocity[..., ::7])


def test_empty_batch_has_an_empty_result():
    options = {"release_amplitude": np.empty(0), "step": 0.01, "steps": 3}
    assert simulate(CURVE, Damping("CR", 0.9), **options).displacement.shape == (0, 4)
    assert peaks(CURVE, Damping("CR", 0.9), **options).peak.shape == (0,)


@pytest.mark.nojit
@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize(("model", "value"), [("CR", 0.8), ("CDC", 0.05), ("BAND", 0.05)])
def test_several_motions_add_up(model, value, substeps):
    motions = np.random.default_rng(5).normal(size=(3, 41))
    factors = np.random.default_rng(6).normal(size=(3, 9)) * [[0.3], [0.1], [0.05]]
    damping = Damping(model, value)
    together = simulate(CURVE, damping, load=Load(motions, factors, 0.04, substeps))
    for lane in (0, 8):
        load = Load(factors[:, lane] @ motions, 1.0, 0.04, substeps)
        alone = simulate(CURVE, damping, load=load)
        np.testing.assert_allclose(together.displacement[lane], alone.displacement, atol=1e-12)


# --- the same bits --------------------------------------------------------------------------------


def run_lanes(make, scheme, lanes, threads=1):
    """Return histories and peaks of some of the lanes."""
    angles = np.arange(LANES)
    step = (0.02 + 1e-4 * angles)[lanes]
    curve = CURVES.map(lambda ratio: ratio[lanes])
    options = {
        "load": Load(GROUND[:200], STRENGTH[lanes], 2 * step, 2),
        "release_amplitude": 0.9 * np.cos(angles)[lanes],
        "release_velocity": 0.3 * np.sin(angles)[lanes],
        "scheme": scheme,
        "threads": threads,
    }
    damping = make(SIZES[lanes])
    reference = Reference(np.zeros((2, 399)), lanes % 2, [1, 100, 398])
    histories = simulate(curve, damping, store_every=3, **options)
    return histories, peaks(curve, damping, reference=reference, **options)


@every_scheme
@every_damper
def test_result_does_not_depend_on_other_lanes(make, scheme):
    expected = run_lanes(make, scheme, np.arange(LANES))
    assert 0 < expected[0].collapsed.sum() < LANES
    order = np.random.default_rng(4).permutation(LANES)
    first_lanes = [np.arange(count) for count in (1, 2, 3, 5, 9, 33, 64, 65, 129)]
    for lanes in (*first_lanes, order, order[::-1], order[:1]):
        histories, result = run_lanes(make, scheme, lanes)
        assert_same(histories, expected[0], lanes)
        assert_same(result, expected[1], lanes)


@every_scheme
@every_damper
def test_result_does_not_depend_on_threads_or_calls(make, scheme, monkeypatch):
    expected = run_lanes(make, scheme, np.arange(LANES))
    monkeypatch.setattr(blocks, "STEPS_PER_CALL", 7)
    for threads in (1, 2):
        histories, result = run_lanes(make, scheme, np.arange(LANES), threads)
        assert_same(histories, expected[0])
        assert_same(result, expected[1])


ENDLESS = """
import numpy as np
import rockdamp as rd
options = {"release_amplitude": np.full(%d, 0.5), "step": 0.001, "threads": %d, "store_every": 10**7}
rd.simulate(rd.TrilinearCurve(0.04, 0.85), rd.Damping("CR", 1.0), steps=1, **options)
print("ready", flush=True)
rd.simulate(rd.TrilinearCurve(0.04, 0.85), rd.Damping("CR", 1.0), steps=10**9, **options)
"""


@pytest.mark.parametrize(("lanes", "threads"), [(1, 1), (1000, 2)])
def test_run_of_hours_can_be_interrupted(lanes, threads):
    command = [sys.executable, "-c", ENDLESS % (lanes, threads)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            _, messages = process.communicate(timeout=30)
            assert "KeyboardInterrupt" in messages
        finally:
            process.kill()


# --- bad input ------------------------------------------------------------------------------------

STILL = np.zeros((2, 101))
BAD_RUNS = [
    ("step", {"step": 0.0}),
    ("step", {"step": 0.44}),
    ("step", {"step": None}),
    ("steps", {"steps": 0}),
    ("steps", {"steps": 1.5}),
    ("steps", {"load": Load(np.zeros(100), 1.0, 0.01)}),
    ("release_amplitude", {"release_amplitude": [0.1, -1.5]}),
    ("release_velocity", {"release_velocity": np.nan}),
    ("threads", {"threads": 0}),
    ("reference", {"reference": Reference(STILL[:, :100], 0, [50])}),
    ("reference", {"reference": Reference(STILL * np.nan, 0, [50])}),
    ("case", {"reference": Reference(STILL, 2, [50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [50, 50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [0, 50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [101])}),
]


@pytest.mark.parametrize(("name", "change"), BAD_RUNS)
def test_bad_run_is_refused_by_name(name, change):
    options = {"step": 0.01, "steps": 100, "release_amplitude": 0.5, **change}
    with pytest.raises(InputError, match=name):
        peaks(CURVE, Damping("CDR", 0.05), **options)


BAD_LOADS = [
    ("ground", ([0.0, np.nan], 1.0, 0.01)),
    ("ground", ([0.0], 1.0, 0.01)),
    ("ground", (np.zeros((2, 0)), np.ones((2, 1)), 0.01)),
    ("ground", (np.zeros((0, 9)), np.ones((0, 1)), 0.01)),
    ("load factor", (np.zeros((2, 200)), 1.0, 0.01)),
    ("load factor", (np.zeros((2, 200)), [1.0, np.inf], 0.01)),
    ("sampling", (np.zeros(200), 1.0, 0.0)),
    ("substeps", (np.zeros(200), 1.0, 0.01, 0)),
]


@pytest.mark.parametrize(("name", "arguments"), BAD_LOADS)
def test_bad_load_is_refused_by_name(name, arguments):
    with pytest.raises(InputError, match=name):
        Load(*arguments)


def test_batch_larger_than_an_array_is_refused():
    with pytest.raises(InputError, match="more than 268435456 values"):
        simulate(CURVE, Damping("CR", 0.9), release_amplitude=0.5, step=0.001, steps=10**9)


def test_stable_step_is_two_over_the_first_frequency():
    a1 = np.array([0.02, 0.2])
    limit = stable_step(TrilinearCurve(a1, 0.5))
    np.testing.assert_allclose(limit, 2 * np.sqrt(a1 / 0.5), rtol=1e-15)


def test_step_beyond_the_limit_of_any_wall_is_refused():
    curves = TrilinearCurve(np.array([0.02, 0.2]), 0.5)
    with pytest.raises(InputError, match="step"):
        simulate(curves, Damping("CDC", 0.0), step=0.5, steps=10)


def test_step_longer_than_half_a_band_is_refused():
    with pytest.raises(InputError, match="two steps in the band"):
        simulate(CURVE, Damping("BAND", 0.05, width=0.1), step=0.1, steps=10)


@pytest.mark.parametrize(
    ("lanes", "count", "width"),
    [(1, 1, 1), (3, 1, 3), (4, 1, 8), (64, 1, 64), (65, 2, 40), (LANES, 3, 56)],
)
def test_blocks_are_few_and_narrow(lanes, count, width):
    layout = blocks.Blocks((lanes,), 1)
    assert (layout.count, layout.width) == (count, width)
