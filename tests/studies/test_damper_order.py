"""ECD of order m against restitution in free decay: what is measured, by another method too, and what it says."""

import numpy as np
import pytest
from configs import changed, configured

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies.damper_order import damper_order

CURVE = TrilinearCurve(0.04, 0.85)


@pytest.fixture(scope="module")
def config():
    """That of the small chain, but for the response length and the solver's step."""
    small, full = configured(minimal=True), configured()
    return changed(small, {"matching.response_length": full.matching.response_length, "solver": full.solver})


@pytest.fixture(scope="module")
def found(config):
    return damper_order(config)


def test_the_dataset_is_what_the_glossary_says(found):
    dataset.check(found, "damper_order")


def test_the_error_falls_with_every_order_at_every_e(found):
    for name in ("rms_error", "duration_error"):
        assert (found[name].diff("order") < 0).all(), name
    assert (found["rms_error"].isel(order=-1) < found["rms_error"].isel(order=0) / 20).all()


def test_the_peaks_are_exact_at_every_order_but_for_the_step(config, found):
    coarse = damper_order(changed(config, {"solver.step": 2 * config.solver.step}))
    ratio = coarse["peak_error"].sel(restitution=0.7) / found["peak_error"].sel(restitution=0.7)
    assert (found["peak_error"] < 2e-4).all() and (found["varied_peak_error"] > 0.01).all()
    assert float(ratio.median()) == pytest.approx(4, rel=0.2)


@pytest.mark.parametrize("e", [0.7, 0.85])
def test_the_measures_are_those_of_the_event_driven_solver(config, found, e):
    tau = config.solver.step * np.arange(1, round(config.matching.response_length / config.solver.step) + 1)
    dampers = {f"order {m:g}": Damping.of_restitution(e, order=m) for m in (0, 1, 4)}
    dampers |= {"lower e": Damping.cr(e - 0.01), "higher e": Damping.cr(e + 0.01)}
    impact = event_driven.history(CURVE, Damping.cr(e), tau, release_amplitude=0.5)
    for name, damping in dampers.items():
        other = event_driven.history(CURVE, damping, tau, release_amplitude=0.5)
        at = {"order": float(name.split()[1])} if name.startswith("order") else {"variation": name}
        varied = "" if name.startswith("order") else "varied_"
        rms, peak, duration = (
            float(found[f"{varied}{measure}"].sel(at | {"restitution": e}))
            for measure in ("rms_error", "peak_error", "duration_error")
        )
        difference = np.abs(other.displacement) - np.abs(impact.displacement)
        assert rms == pytest.approx(np.sqrt(np.mean(difference**2)), abs=2e-5)
        most = min(other.turning_tau.size, impact.turning_tau.size)
        lasting, lasted = (np.diff(one.turning_tau[:most]) for one in (other, impact))
        largest = np.abs(np.append(lasting / lasted, other.turning_tau[0] / impact.turning_tau[0]) - 1).max()
        assert duration == pytest.approx(largest, rel=0.02, abs=2e-5)
        if varied:
            largest = np.abs(other.turning_displacement[:most] / impact.turning_displacement[:most] - 1).max()
            assert peak == pytest.approx(largest, rel=1e-3)


def test_the_histories_are_decays_that_meet_at_their_first_peak(found):
    tau = found["tau"].values
    for m in found["order"].values:
        of_order = found.sel(order=m)
        damping = Damping.of_restitution(float(found["shown_restitution"]), order=m)
        exact = event_driven.history(CURVE, damping, tau, release_amplitude=0.5)
        np.testing.assert_allclose(of_order["shown_displacement"], exact.displacement, atol=5e-5)
        work = np.trapezoid(of_order["shown_damping_force"] * of_order["shown_velocity"], tau)
        energy = [0.5 * v**2 + CURVE.energy(x) for x, v in ((0.5, 0.0), (exact.displacement[-1], exact.velocity[-1]))]
        assert work == pytest.approx(float(energy[0] - energy[1]), rel=2e-3)
