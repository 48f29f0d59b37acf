"""The march of peaks alone has the bits of the march that keeps everything, whoever leaves it and whenever."""

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import SCHEMES, solve, stable_step
from rockdamp.solvers.response import COLLAPSED, ComparedPeaks, Peaks, Reference
from rockdamp.vocabulary import MODELS

ORDERS = (1, 3, 8, 2.5)
DAMPERS = (*MODELS, *(f"ECD {order}" for order in ORDERS))
LANES, STEPS, SUBSTEPS = 240, 3000, 3
CURVE = TrilinearCurve(np.linspace(0.03, 0.12, LANES), np.linspace(0.85, 0.6, LANES), 0.95)
SHAKES = np.concatenate([np.full(250, 0.2), np.full(500, 0.02), np.full(251, 1.0)])  # the strongest comes last
GROUND = SHAKES * np.convolve(np.random.default_rng(3).normal(size=1030), np.ones(30) / 6, "valid")


def damping_of(name, lanes=LANES):
    spread = np.linspace(0.01, 0.15, lanes)
    if name == "CR":
        return Damping.cr(1 - 2 * spread)
    model, *order = name.split()
    return Damping("ECD", spread, order=float(order[0])) if order else Damping(model, spread)


def sample(forced):
    """Walls that stay on the first branch, that rock, that come near to collapse, and that fall: many of each."""
    rng = np.random.default_rng(5)
    strength = rng.permutation(np.geomspace(0.02, 4.0, LANES))
    run = {"step": 0.02, "steps": STEPS, "substeps": SUBSTEPS}
    if forced:
        return run | {"load_factor": strength, "ground_acceleration": GROUND}
    return run | {"release_amplitude": rng.uniform(-0.9, 0.9, LANES), "release_velocity": 0.4 * strength}


def assert_same(full, peaks, a3):
    stands = full.outcome != COLLAPSED
    np.testing.assert_array_equal(peaks.outcome, full.outcome)
    np.testing.assert_array_equal(peaks.peak[stands], full.peak[stands])
    np.testing.assert_array_equal(peaks.peak[~stands], np.broadcast_to(a3, stands.shape)[~stands])
    return stands


@pytest.mark.parametrize("forced", [False, True], ids=["free", "record"])
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", DAMPERS)
def test_both_marches_have_the_same_peaks_and_outcomes_to_the_bit(name, scheme, forced):
    run = sample(forced) | {"scheme": scheme}
    full = solve(CURVE, damping_of(name), **run)
    peaks = solve(CURVE, damping_of(name), peaks_only=True, **run)
    assert type(peaks) is Peaks
    stands = assert_same(full, peaks, 0.95)
    classes = np.histogram(full.peak[stands], [0, 0.03, 0.3, 0.6, 0.95])[0]
    assert (~stands).sum() > 10 and (classes > 0).sum() >= 3


@pytest.mark.nojit
@pytest.mark.parametrize("name", ["CR", "CDR", "BAND"])
def test_lanes_alone_and_lanes_of_several_motions_have_the_same_peaks(name):
    motions = np.stack([GROUND[400:501], GROUND[900:1001]])
    run = {"step": 0.02, "steps": 300, "substeps": SUBSTEPS, "ground_acceleration": motions}
    factors = np.stack([np.geomspace(0.05, 3.0, 9), np.geomspace(3.0, 0.05, 9)])
    damping = damping_of(name, 9)
    curve = TrilinearCurve(0.05, 0.7)
    together = solve(curve, damping, load_factor=factors, peaks_only=True, **run)
    assert_same(solve(curve, damping, load_factor=factors, **run), together, 1.0)
    for lane in range(0, 9, 4):
        alone = solve(
            curve,
            damping.map(lambda p, i=lane: np.broadcast_to(p, 9)[i]),
            load_factor=factors[:, lane],
            peaks_only=True,
            **run,
        )
        assert (alone.outcome.shape, alone.peak.item()) == ((), together.peak[lane])


@pytest.mark.parametrize("name", ["CR", "CDC", "BAND"])
def test_eq_17_beside_peaks_has_the_same_bits(name):
    run = sample(forced=True)
    stored = solve(CURVE, Damping.cr(0.9), store_every=1, **run).displacement[::60]
    rng = np.random.default_rng(8)
    reference = Reference(np.nan_to_num(stored), rng.integers(0, len(stored), LANES), [1, 130, 256, 2999])
    full = solve(CURVE, damping_of(name), reference=reference, **run)
    peaks = solve(CURVE, damping_of(name), reference=reference, peaks_only=True, **run)
    assert type(peaks) is ComparedPeaks
    stands = assert_same(full, peaks, 0.95)
    np.testing.assert_array_equal(peaks.error, full.error)
    assert np.isinf(peaks.error[:, ~stands]).all() and np.isfinite(peaks.error[:, stands]).all()


@pytest.mark.parametrize("share", [0.02, 0.05, 0.3])
def test_without_loss_and_at_coarse_steps_no_lane_leaves_too_early(share):
    """At a twentieth of the limit the scheme changes the energy most where lanes may still leave; beyond none does."""
    curve = TrilinearCurve(0.05, 0.7)
    run = {"step": share * float(stable_step(curve)), "steps": 4000, "release_velocity": np.linspace(0.01, 1.1, 64)}
    for damping in (Damping.cr(1.0), Damping("CDC", 0.001), Damping("ECD", 1e-4, order=16)):
        assert_same(solve(curve, damping, **run), solve(curve, damping, peaks_only=True, **run), 1.0)


def test_the_number_of_threads_does_not_change_peaks():
    run = sample(forced=True)
    one, two = (solve(CURVE, damping_of("CDR"), peaks_only=True, threads=threads, **run) for threads in (1, 2))
    assert one == two


def test_peaks_come_without_histories():
    with pytest.raises(InputError, match=r"^store_every is 2 with peaks_only; it must be left out"):
        solve(CURVE, damping_of("CDC"), store_every=2, peaks_only=True, **sample(forced=False))
