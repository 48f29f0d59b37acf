"""Orders of convergence, measured on ensembles: one history's error is erratic, as its corners fall anywhere in a step.

The error of a lane is the root mean square of its displacement error at the samples of the load. Its order is the slope
of log(error) over log(step); the ensemble's is the mean over the lanes.

Theory: the force is continuous and its slope jumps at the corners, so a corner costs a second-order scheme an error of
order step^2. Explicit Newmark with located impacts is second order for every damper. The printed scheme freezes C over
the step and applies impacts at its end: first order for CR, CDR, SDR and ECD, second for CDC, whose C is constant.

A lane's order scatters by 0.1 to 0.3, so the mean over 10 lanes is known to about 0.05: an order is accepted within
three of these of the theory's.
"""

from functools import cache

import numpy as np
import pytest
from configs import changed

from rockdamp.constants import MODELS, RECOMMENDED
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load, simulate
from rockdamp.studies import convergence

SAMPLES, SAMPLE = 33, 0.2  # of the load, in tau; the histories are compared at them
NEWMARK_SUBSTEPS = 2 ** np.arange(3, 12)
# Finer: the printed scheme's first-order part is small for slight damping and shows late.
PAPER_SUBSTEPS = 2 ** np.arange(8, 14)
CASES = [*MODELS]
FIRST_ORDER_AS_PRINTED = ["CR", "CDR", "SDR", "ECD"]


class Ensemble:
    """Seeded walls, dampers, releases and a shared load; all of a lane's draws come from the first of them."""

    def __init__(self, lanes, model):
        rng = np.random.default_rng(20240607)
        a1, b1, self.release, self.factor, unit, _ = rng.uniform(
            [0.02, 0.5, 0.2, 0.01, 0.0, 0.2], [0.12, 0.85, 0.8, 0.05, 1.0, 3.0], (lanes, 6)
        ).T
        self.curve = TrilinearCurve(a1, b1)
        low, high = {"CR": (0.75, 0.95), "SDR": (0.05, 0.25)}.get(model, (0.03, 0.1))
        self.model, self.parameter = model, low + (high - low) * unit
        frequency, phase = np.random.default_rng(5).uniform([0.3, 0.0], [3.0, 2 * np.pi], (8, 2)).T
        self.load = np.sin(frequency[:, None] * SAMPLE * np.arange(SAMPLES) + phase[:, None]).sum(axis=0)

    def damping(self, lane=slice(None)):
        own = self.parameter[lane]
        return Damping(self.model, own)

    def solve(self, forced, scheme, substeps):
        response = simulate(
            self.curve,
            self.damping(),
            release_amplitude=self.release,
            load=Load(self.load, self.factor if forced else 0.0, SAMPLE, substeps),
            store_every=substeps,
            scheme=scheme,
        )
        assert not response.collapsed.any()
        return response.displacement

    def exact(self, forced):
        found = []
        for i in range(self.release.size):
            load = {"load": self.load * self.factor[i], "sampling": SAMPLE} if forced else {}
            curve = TrilinearCurve(self.curve.yield_displacement_ratio[i], self.curve.strength_ratio[i])
            lane = exact_history(
                curve, self.damping(i), SAMPLE * np.arange(SAMPLES), release_amplitude=self.release[i], **load
            )
            found.append(lane.displacement)
        return np.array(found)


@cache
def exact_ensemble(model, forced):
    """Few lanes with their event-driven solution, good to about 1e-12."""
    ensemble = Ensemble(32 if model in ("CR", "CDC", RECOMMENDED) else 10, model)
    return ensemble, ensemble.exact(forced)


def errors_of(ensemble, reference, forced, scheme, substeps):
    """Return the error of each step and lane."""
    each = [ensemble.solve(forced, scheme, k) - reference for k in substeps.tolist()]
    return np.sqrt(np.mean(np.square(each), axis=-1))


def order_of(substeps, error):
    """Mean slope of log(error) over log(step), and its standard error."""
    slopes = -np.polyfit(np.log(substeps), np.log(error), 1)[0]
    return slopes.mean(), slopes.std() / np.sqrt(slopes.size)


excited = pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])


@pytest.mark.no_cover
@excited
@pytest.mark.parametrize("model", CASES)
def test_explicit_newmark_converges_to_the_exact_solution_at_second_order_for_every_damper(model, forced):
    ensemble, reference = exact_ensemble(model, forced)
    error = errors_of(ensemble, reference, forced, "newmark", NEWMARK_SUBSTEPS)
    order, uncertainty = order_of(NEWMARK_SUBSTEPS, error)
    assert uncertainty < 0.06
    assert order == pytest.approx(2, abs=0.15)
    # At second order from the coarsest step's error the finest would have this; it keeps on to the exact solution.
    assert np.median(error[-1]) < 2 * np.median(error[0]) * (NEWMARK_SUBSTEPS[0] / NEWMARK_SUBSTEPS[-1]) ** 2


@excited
@pytest.mark.parametrize("model", [*FIRST_ORDER_AS_PRINTED, "CDC"])
def test_the_printed_scheme_converges_to_the_exact_solution_at_first_order_and_cdc_at_second(model, forced):
    substeps, theory, most = (NEWMARK_SUBSTEPS, 2, 0.06) if model == "CDC" else (PAPER_SUBSTEPS, 1, 0.08)
    ensemble, reference = exact_ensemble(model, forced)
    order, uncertainty = order_of(substeps, errors_of(ensemble, reference, forced, "paper", substeps))
    assert uncertainty < most
    assert order == pytest.approx(theory, abs=0.15)


@excited
@pytest.mark.parametrize("model", MODELS)
def test_at_equal_steps_explicit_newmark_is_the_more_accurate_scheme(model, forced):
    ensemble, reference = exact_ensemble(model, forced)
    both = [
        np.exp(np.log(errors_of(ensemble, reference, forced, scheme, np.array([64, 256]))).mean(axis=-1))
        for scheme in ("newmark", "paper")
    ]
    assert np.all(both[1] > 1.5 * both[0])


# --- the stage ---


@pytest.fixture(scope="module")
def orders(paper):
    """Of a quarter of the lanes."""
    return convergence.convergence(changed(paper, {"convergence.lanes": 64}))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("excitation", ["free", "forced"])
def test_the_default_scheme_is_second_order_for_every_damper(orders, model, excitation):
    order = float(orders["convergence_order"].sel(scheme="newmark", damping_model=model, excitation=excitation))
    assert order == pytest.approx(2.0, abs=0.1)


def test_the_printed_scheme_is_first_order_but_for_a_constant_coefficient(orders):
    paper = orders.sel(scheme="paper")
    assert (np.abs(paper["convergence_order"].sel(damping_model="CDC") - 2) < 0.1).all()
    # C frozen over the step is a small first-order term, which takes over from the second-order ones at fine steps.
    frozen = paper["finest_convergence_order"].sel(damping_model=["CR", "CDR", "SDR", "ECD"])
    assert ((frozen > 0.75) & (frozen < 1.5)).all()
