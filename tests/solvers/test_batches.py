"""What a batch reports: collapses, peaks, Eq. (17), the same bits beside any other lanes, and bad input."""

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
DAMPERS = {
    "CR": lambda size: Damping("CR", 1 - 2 * size),
    **{model: lambda size, model=model: Damping(model, size) for model in (*MODELS[1:], "CQD")},
    **{
        f"ECD{order:g}": lambda size, order=order: Damping("ECD", size, order=order)
        for order in (2.5, 8, 16)
    },
    "CR, law": lambda size: Damping(
        "CR", 1 - 2 * size, loss_exponent=np.where(size > 0.05, 0.2, 0.0)
    ),
    "ECD, law": lambda size: Damping("ECD", size, order=4, loss_exponent=0.1),
}
every_damper = pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)
LANES = 150  # of three blocks, the last one not full
CURVES = TrilinearCurve(np.linspace(0.03, 0.12, LANES), np.linspace(0.85, 0.6, LANES), 0.95)
SIZES = np.linspace(0.01, 0.15, LANES)
SHAKES = np.concatenate(
    [np.full(150, 0.2), np.full(300, 0.02), np.full(151, 1.0)]
)  # the strongest comes last
GROUND = SHAKES * np.convolve(np.random.default_rng(3).normal(size=630), np.ones(30) / 6, "valid")
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


def assert_same(found, expected, lanes=slice(None)):
    for field in fields(found):
        if getattr(found, field.name) is not None:
            values, others = getattr(found, field.name), getattr(expected, field.name)
            np.testing.assert_array_equal(
                values, others[:, lanes] if field.name == "error" else others[lanes]
            )


# --- what is reported -------------------------------------------------------------------------------------------------


@every_scheme
@every_damper
@pytest.mark.parametrize("run", RUNS.values(), ids=RUNS)
def test_peaks_are_those_of_the_histories_to_the_bit(run, damper, scheme):
    """Walls that stay on the first branch, that rock, that come near to collapse, and that fall: many of each."""
    full = simulate(CURVES, damper(SIZES), store_every=600, scheme=scheme, **run)
    found = peaks(CURVES, damper(SIZES), scheme=scheme, **run)
    assert 5 < full.collapsed.sum() < LANES - 20
    np.testing.assert_array_equal(found.collapsed, full.collapsed)
    np.testing.assert_array_equal(found.peak, np.where(full.collapsed, 0.95, full.peak))


@pytest.mark.parametrize("share", [0.02, 0.05, 0.3])
def test_without_loss_and_at_coarse_steps_no_lane_leaves_too_early(share):
    """At a twentieth of the limit the scheme changes the energy most where lanes may still leave; beyond none does."""
    curve = TrilinearCurve(0.05, 0.7)
    run = {
        "step": share * float(stable_step(curve)),
        "steps": 4000,
        "release_velocity": np.linspace(0.01, 1.1, 40),
    }
    for damping in (Damping("CR", 1.0), Damping("CDC", 0.001), Damping("ECD", 1e-4, order=16)):
        full, found = (
            simulate(curve, damping, store_every=4000, **run),
            peaks(curve, damping, **run),
        )
        np.testing.assert_array_equal(found.peak, np.where(full.collapsed, 1.0, full.peak))


@every_damper
def test_the_error_is_eq_17_summed_from_stored_histories_at_every_checkpoint(damper):
    run = {"step": 0.01, "steps": 1500, "release_amplitude": np.array([0.3, 0.6])[:, None]}
    decays = simulate(CURVE, Damping("CR", 0.85), **run).displacement[:, 0]
    checkpoints, damping = [1, 128, 999, 1500], damper(np.linspace(0.01, 0.15, 40))
    x = simulate(CURVE, damping, **run).displacement
    found = peaks(
        CURVE, damping, reference=Reference(decays, np.array([[0], [1]]), checkpoints), **run
    ).error
    sums = np.cumsum((np.abs(decays[:, None, 1:]) - np.abs(x[..., 1:])) ** 2, axis=-1)
    np.testing.assert_allclose(
        np.moveaxis(found, 0, -1), sums[..., np.array(checkpoints) - 1], rtol=1e-12, atol=1e-30
    )


@pytest.mark.parametrize("sign", [1, -1])
@every_scheme
@pytest.mark.parametrize("model", MODELS)
def test_a_collapse_is_reported_with_its_time_and_ends_the_history(model, scheme, sign):
    damping, step = Damping(model, 0.9 if model == "CR" else 0.02), 1e-3
    exact = exact_history(
        CURVE, damping, [4.0], release_amplitude=sign * 0.5, release_velocity=sign * 0.9
    )
    start = {"release_amplitude": [sign * 0.5, 0.5], "release_velocity": [sign * 0.9, 0.0]}
    found = simulate(CURVE, damping, step=step, steps=4000, scheme=scheme, **start)
    assert found.collapsed.tolist() == [True, False]
    # The first step beyond a3, as the scheme is much more accurate than its step here.
    assert 0 < found.end_tau[0] - exact.end_tau < 2 * step
    assert found.end_tau[1] == pytest.approx(4.0, rel=1e-12)
    assert 1 < found.peak[0] < 1.002 and found.peak_tau[0] == found.end_tau[0]
    last = round(found.end_tau[0] / step)
    for stored in (found.displacement, found.velocity):
        assert (
            np.isfinite(stored[0, :last]).all()
            and np.isnan(stored[0, last:]).all()
            and np.isfinite(stored[1]).all()
        )


def test_a_start_at_rest_is_no_impact_nor_is_a_release_and_one_at_the_end_of_a_step_is_one():
    still = simulate(CURVE, Damping("CR", 0.8), step=0.01, steps=50)
    assert still.impacts == still.peak == still.peak_tau == 0 and not still.displacement.any()
    kicked = simulate(CURVE, Damping("CR", 0.8), release_velocity=0.1, step=0.01, steps=2)
    assert kicked.impacts == 0 and kicked.displacement[1] == pytest.approx(1e-3, rel=1e-12)
    # All numbers are exact in binary: the load balances the force, so x0 + v0 step = 0 without rounding.
    curve, step, x0, v0 = TrilinearCurve(1 / 16, 1 / 2), 1 / 32, 1 / 64, -1 / 2
    load = float(curve.force(x0))
    start = {"release_amplitude": x0, "release_velocity": v0}
    found = simulate(curve, Damping("CR", 0.5), load=Load(np.ones(5), load, step), **start)
    assert found.displacement[1] == 0 and found.impacts == 1
    # The force fell from balance to nothing over the step: the mean acceleration is half of the load.
    assert found.velocity[1] == 0.5 * (v0 + step * load / 2)
    assert found.displacement[2] == step * (found.velocity[1] + step * load / 2)


def test_shapes_broadcast_and_thinned_histories_are_every_nth_of_the_full_ones():
    curve, damping = (
        TrilinearCurve(np.array([0.03, 0.05])[:, None, None], 0.8),
        Damping("CDR", [[0.02], [0.05], [0.1]]),
    )
    run = {"step": np.array([0.01, 0.02, 0.005, 0.01]), "steps": 400}
    releases = np.array([0.2, 0.3, 0.4, 0.5])
    full, thin = (
        simulate(curve, damping, release_amplitude=releases, store_every=n, **run) for n in (1, 7)
    )
    assert full.peak.shape == (2, 3, 4) and thin.displacement.shape == (2, 3, 4, 58)
    np.testing.assert_array_equal(thin.displacement, full.displacement[..., ::7])
    np.testing.assert_array_equal(thin.velocity, full.velocity[..., ::7])
    alone = simulate(
        TrilinearCurve(0.05, 0.8), Damping("CDR", 0.1), release_amplitude=0.4, step=0.005, steps=400
    )
    assert_same(
        alone, type(full)(*(getattr(full, field.name)[1, 2, 2] for field in fields(full))), ...
    )
    none = {"release_amplitude": np.empty(0), "step": 0.01, "steps": 3}
    assert simulate(CURVE, Damping("CR", 0.9), **none).displacement.shape == (0, 4)
    assert peaks(CURVE, Damping("CR", 0.9), **none).peak.shape == (0,)


@pytest.mark.nojit
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_load_of_several_motions_is_their_sum_each_times_the_lane_s_factor(substeps):
    motions = np.random.default_rng(5).normal(size=(3, 41))
    factors = np.random.default_rng(6).normal(size=(3, 9)) * [[0.3], [0.1], [0.05]]
    for damping in (Damping("CR", 0.8), Damping("CDC", 0.05), Damping("BAND", 0.05)):
        together = simulate(CURVE, damping, load=Load(motions, factors, 0.04, substeps))
        for lane in (0, 8):
            alone = simulate(
                CURVE, damping, load=Load(factors[:, lane] @ motions, 1.0, 0.04, substeps)
            )
            np.testing.assert_allclose(together.displacement[lane], alone.displacement, atol=1e-12)


# --- the same bits ----------------------------------------------------------------------------------------------------


@every_scheme
@every_damper
def test_a_result_does_not_depend_on_other_lanes_threads_or_where_a_run_is_cut(
    damper, scheme, monkeypatch
):
    x0, v0, step = (
        0.9 * np.cos(np.arange(LANES)),
        0.3 * np.sin(np.arange(LANES)),
        0.02 + 1e-4 * np.arange(LANES),
    )

    def run(lanes, **options):
        part = CURVES.map(lambda ratio: ratio[lanes]), damper(SIZES[lanes])
        load = Load(GROUND[:200], STRENGTH[lanes], 2 * step[lanes], 2)
        start = {
            "release_amplitude": x0[lanes],
            "release_velocity": v0[lanes],
            "scheme": scheme,
            **options,
        }
        reference = Reference(np.zeros((2, 399)), lanes % 2, [1, 100, 398])
        return simulate(*part, load=load, store_every=3, **start), peaks(
            *part, load=load, reference=reference, **start
        )

    everything = run(np.arange(LANES), threads=1)
    assert 0 < everything[0].collapsed.sum() < LANES
    order = np.random.default_rng(4).permutation(LANES)
    for lanes in (
        *(np.arange(count) for count in (1, 2, 3, 5, 9, 33, 64, 65, 129)),
        order,
        order[::-1],
        order[:1],
    ):
        for found, expected in zip(run(lanes, threads=1), everything, strict=True):
            assert_same(found, expected, lanes)
    monkeypatch.setattr(blocks, "STEPS_PER_CALL", 7)
    for threads in (1, 2):
        for found, expected in zip(run(np.arange(LANES), threads=threads), everything, strict=True):
            assert_same(found, expected)


ENDLESS = """
import numpy as np
import rockdamp as rd
run = {"release_amplitude": np.full(%d, 0.5), "step": 0.001, "threads": %d, "store_every": 10**7}
rd.simulate(rd.TrilinearCurve(0.04, 0.85), rd.Damping("CR", 1.0), steps=1, **run)
print("ready", flush=True)
rd.simulate(rd.TrilinearCurve(0.04, 0.85), rd.Damping("CR", 1.0), steps=10**9, **run)
"""


@pytest.mark.parametrize(("lanes", "threads"), [(1, 1), (1000, 2)])
def test_a_run_of_hours_can_be_interrupted(lanes, threads):
    command, pipe = [sys.executable, "-c", ENDLESS % (lanes, threads)], subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            assert "KeyboardInterrupt" in process.communicate(timeout=30)[1]
        finally:
            process.kill()


# --- bad input --------------------------------------------------------------------------------------------------------

STILL = np.zeros((2, 101))
BAD = [
    ("step", {"step": 0.0}),
    ("step", {"step": 0.44}),
    ("step", {"step": None}),
    ("steps", {"steps": 0}),
    ("steps", {"steps": 1.5}),
    ("release_amplitude", {"release_amplitude": [0.1, -1.5]}),
    ("release_velocity", {"release_velocity": np.nan}),
    ("steps", {"load": lambda: Load(np.zeros(100), 1.0, 0.01)}),
    ("ground", {"load": lambda: Load([0.0, np.nan], 1.0, 0.01)}),
    ("ground", {"load": lambda: Load([0.0], 1.0, 0.01)}),
    ("ground", {"load": lambda: Load(np.zeros((2, 0)), np.ones((2, 1)), 0.01)}),
    ("ground", {"load": lambda: Load(np.zeros((0, 9)), np.ones((0, 1)), 0.01)}),
    ("load factor", {"load": lambda: Load(np.zeros((2, 200)), 1.0, 0.01)}),
    ("load factor", {"load": lambda: Load(np.zeros((2, 200)), [1.0, np.inf], 0.01)}),
    ("sampling", {"load": lambda: Load(np.zeros(200), 1.0, 0.0)}),
    ("substeps", {"load": lambda: Load(np.zeros(200), 1.0, 0.01, 0)}),
    ("scheme", {"scheme": "explicit"}),
    ("reference", {"reference": Reference(STILL[:, :100], 0, [50])}),
    ("reference", {"reference": Reference(STILL * np.nan, 0, [50])}),
    ("case", {"reference": Reference(STILL, 2, [50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [50, 50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [0, 50])}),
    ("checkpoints", {"reference": Reference(STILL, 0, [101])}),
]


@pytest.mark.parametrize(("name", "change"), BAD)
def test_a_bad_run_is_refused_with_the_name(name, change):
    with pytest.raises(InputError, match=name):
        run = {"step": 0.01, "steps": 100, "release_amplitude": 0.5, "load": lambda: None, **change}
        peaks(CURVE, Damping("CDR", 0.05), **{**run, "load": run["load"]()})


def test_the_step_is_below_2_over_the_first_branch_s_frequency_of_each_wall_and_two_lie_in_a_band():
    curves = TrilinearCurve(np.array([0.02, 0.2]), 0.5)
    np.testing.assert_allclose(
        stable_step(curves), 2 * np.sqrt(np.array([0.02, 0.2]) / 0.5), rtol=1e-15
    )
    for curve, damping, step in (
        (curves, Damping("CDC", 0.0), 0.5),
        (CURVE, Damping("BAND", 0.05, width=0.1), 0.1),
    ):
        with pytest.raises(InputError, match="step"):
            simulate(curve, damping, step=step, steps=10)
